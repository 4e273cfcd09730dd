"""The pairing of two bodies: ratio, sites, path of contact, interference, friction, period."""
