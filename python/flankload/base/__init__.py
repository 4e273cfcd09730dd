"""Small tools shared by all packages: rounding, atomic file writes, read-only arrays, archives."""
