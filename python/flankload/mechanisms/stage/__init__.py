"""Planetary stages: a sun, equal planets, and a ring."""
