"""The compliance of a body at its flanks from linear finite elements."""
