"""Solved scenes of several kinds of pairs, and the counters of their work."""

from __future__ import annotations

from typing import Any

import flankload as fl
from tests.support.gear_scenes import changed
from tests.support.pair_scenes import RING_PAIR, SPLINE


def counted(result: fl.Result) -> dict[str, int]:
    """All counters of a run."""
    stages = result.cost["stages"]
    return {f"{s}.{key}": n for s in stages for key, n in stages[s]["counters"].items()}


def pairs_in_contact() -> dict[str, dict[str, Any]]:
    """Small runs of several kinds: a pair with corner contact, a ring, a spline."""
    few = {"flank_element_mm": 3.0, "modes": 3, "estimate": False}
    return {
        "external": changed(positions__count=6, accuracy={**few, "strips_per_half_width": 15}),
        "friction": changed(
            positions__count=6, accuracy=few, effects={"friction_coefficient": 0.08}
        ),
        "ring": {
            **RING_PAIR,
            "load": {"torque_Nm": 200},
            "positions": {"count": 4},
            "accuracy": few,
        },
        "spline": {**SPLINE, "load": {"torque_Nm": 80}, "accuracy": few},
    }
