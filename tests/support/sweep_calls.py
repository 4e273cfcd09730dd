"""Calls of the sweep with lists of torques, for gears and a spline."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache

import numpy as np

import flankload as fl
from flankload.contact.flank_contact import FlankContact, Level
from flankload.contact.sweep import Sweep, sweep
from flankload.elasticity.compliance import BodyCompliance
from flankload.mechanisms.elements import compliance_of
from flankload.mechanisms.flank_pair.assembly import build_bodies
from flankload.pairing.body_pair import BodyPair
from flankload.pairing.pairing import Pairing
from tests.support.gear_pair import GEARS

TORQUES = [40e3, 302e3, 0.0, 900e3]
SPLINE = {
    "body_1": {
        "kind": "spline_shaft",
        "teeth": 24,
        "module_mm": 2.0,
        "tip_diameter_mm": 49.6,
        "root_diameter_mm": 45.2,
        "bore_diameter_mm": 20.0,
    },
    "body_2": {
        "kind": "spline_hub",
        "teeth": 24,
        "module_mm": 2.0,
        "profile_shift": 0.04,
        "tip_diameter_mm": 46.2,
        "root_diameter_mm": 50.8,
        "outer_diameter_mm": 75.0,
    },
    "pair": {"center_offset_mm": 0.003, "face_width_mm": 30},
    "load": {"torque_Nm": 1500},
}


@cache
def job(kind: str, count: int) -> tuple[BodyPair, tuple[BodyCompliance, BodyCompliance]]:
    scene = fl.Scene.from_dict(
        {**(GEARS if kind == "gears" else SPLINE), "positions": {"count": count}}
    )
    pair = build_bodies(scene)
    return pair, (compliance_of(pair.body_1, scene), compliance_of(pair.body_2, scene))


def run(
    torques: list[float],
    *,
    kind: str = "gears",
    count: int = 24,
    level: Level = "pairs",
    keep_pairs: bool = True,
    progress: Callable[[int, int], None] | None = None,
    pairing: Pairing | None = None,
) -> tuple[Sweep, ...]:
    pair, compliances = job(kind, count)
    mesh = replace(pair, pairing=pairing or pair.pairing)
    return sweep(
        FlankContact(mesh, compliances, pair.discretization.grid, level),
        pair.position_rad,
        torques,
        keep_pairs=keep_pairs,
        progress=progress,
    )


def assert_same(one: Sweep, other: Sweep) -> None:
    """Check bitwise equality, pairs included."""
    names = ("status", "rotation_rad", "tangent_rad_per_Nmm", "certificate", "counters", "n_pairs")
    for name in (*names, "site_force_N", "site_peak_N_per_mm", "site_corner"):
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name), err_msg=name)
    for p in range(len(one.n_pairs)):
        for mine, theirs in zip(one.pairs.at(p), other.pairs.at(p), strict=True):
            np.testing.assert_array_equal(mine, theirs)
