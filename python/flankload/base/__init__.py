"""Small tools that every room uses: rounding of ties, atomic files, read-only arrays, archives."""
