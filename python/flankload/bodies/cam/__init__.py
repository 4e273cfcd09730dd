"""Cams and followers."""
