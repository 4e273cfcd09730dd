"""Small tools that every package uses: rounding, atomic file writes, read-only arrays, archives."""
