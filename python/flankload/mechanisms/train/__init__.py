"""Trains of external gears: an idler, two pinions on one wheel, double helical gears."""
