"""Steering: a scene that names `accuracy.tolerance` gets the cheapest knobs that meet it.

Knobs are picked by laws of the error estimate (`laws`), the run tells what is left, and what is
dominant is tightened once. Everything here is data; the runs themselves are made by who asks.
"""

from flankload.steering.making import first_scene, solve_to_tolerance
from flankload.steering.pick import Pick, first_pick

__all__ = ["Pick", "first_pick", "first_scene", "solve_to_tolerance"]
