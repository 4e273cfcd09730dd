"""Pairs with sharp tips: what the default leaves beside 12 modes on elements a quarter as long.

Gears and rings of seeded scenes, their roundings and chamfers taken off, without friction; the
largest difference over 32 positions of a period, where a tip corner works and elsewhere.
FLANKLOAD_CORNERS=… sets another number of pairs than ten.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from copy import deepcopy
from typing import Any

import numpy as np

import flankload as fl
from flankload.errors import FlankloadError
from flankload.mechanisms.flank_pair.assembly import build_bodies
from flankload.scene.discretization import DEFAULT
from tests.support.random_scenes import scenes

POSITIONS = 32
#: The finer solution: modes, and elements over those of the default.
MODES, ELEMENTS = 12, 0.25
#: Wanted of rotation (of its largest) and load share, percent and points.
WANTED = 0.1
PAIRS = "10"
Scene = dict[str, Any]


def run() -> str:
    """A line for each pair: its angles, and what is left of rotation and load share."""
    lines = [
        f"{'':34}{'rotation, %':>18}{'share, points':>18}",
        f"{'pair, corners in degrees':34}" + 2 * f"{'corner':>10}{'off':>8}",
    ]
    met = []
    count = int(os.environ.get("FLANKLOAD_CORNERS", PAIRS))
    for name, scene in sharp_pairs(count):
        found = differences(solved(scene), solved(scene, fine=True))
        met.append(max(found) <= WANTED)
        lines.append(
            f"{name:34}" + "".join(f"{k:{w}.3f}" for k, w in zip(found, (10, 8) * 2, strict=True))
        )
    lines.append(f"{sum(met)} of {len(met)} within {WANTED} throughout")
    return "\n".join(lines)


def sharp_pairs(count: int) -> Iterator[tuple[str, Scene]]:
    """So many pairs of gears, or of a gear and a ring, with sharp tips, each with its name."""
    left = count
    for kind, drawn in scenes(3 * count):
        if kind not in ("gears", "ring") or not left:
            continue
        scene = deepcopy(drawn)
        scene.pop("effects", None)
        for body in (scene["body_1"], scene["body_2"]):
            for key in ("tip_radius_mm", "tip_chamfer_mm"):
                body.pop(key, None)
        try:
            build_bodies(fl.Scene.from_dict(scene))
        except FlankloadError:
            continue
        left -= 1
        teeth = [scene[f"body_{z}"]["teeth"] for z in (1, 2)]
        yield f"{kind} {teeth[0]}/{teeth[1]}", scene


def solved(scene: Scene, *, fine: bool = False) -> fl.Result:
    """The scene at the default, or finer."""
    tree = deepcopy(scene)
    tree["positions"] = {"count": POSITIONS}
    tree["accuracy"] = {"estimate": False}
    if fine:
        module = tree["body_1"]["module_mm"]
        length = DEFAULT.flank_element_parts * ELEMENTS * module
        tree["accuracy"] |= {"modes": MODES, "flank_element_mm": length}
    found = fl.solve(fl.Scene.from_dict(tree))
    assert isinstance(found, fl.Result)
    return found


def differences(found: fl.Result, fine: fl.Result) -> tuple[float, float, float, float]:
    """Largest of rotation on corners and off them (%), of load share on corners and off (points).

    Parameters
    ----------
    found, fine : Result
        Of the same positions.

    Returns
    -------
    (float, float, float, float)
    """
    sites = np.union1d(found.sites, fine.sites)

    def shares(one: fl.Result) -> np.ndarray:
        wide = np.zeros((POSITIONS, sites.size))
        wide[:, np.searchsorted(sites, one.sites)] = one.load_share
        return wide

    rotation = 100 * np.abs(found.rotation_rad - fine.rotation_rad) / fine.rotation_rad.max()
    share = 100 * np.abs(shares(found) - shares(fine)).max(axis=1)
    corner = (np.asarray(fine.corner_contact) > 0).any(axis=1)
    one, two, three, four = (
        float(values[at].max(initial=0.0))
        for values in (rotation, share)
        for at in (corner, ~corner)
    )
    return one, two, three, four
