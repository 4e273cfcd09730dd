"""A toothed belt on its pulley."""
