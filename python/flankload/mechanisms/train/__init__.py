"""Trains of three external gears: an idler, or two pinions on one wheel."""
