"""Shared support of the tests: scenes, problems, bodies, oracles, reference solutions, tolerances.

Tests, benches and references import from here; nothing here imports from them.
"""
