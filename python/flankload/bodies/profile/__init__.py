"""Profiles of external and internal involute teeth: curves, radii and angles."""
