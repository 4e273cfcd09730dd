"""Profiles of involute teeth, outwards and inwards: curves, radii and angles, no elements."""
