"""The compliance of one body at its flanks, from linear finite elements."""
