"""Overlap of flanks off the path of contact: the search leaves out circles that meet no mate."""

from __future__ import annotations

import numpy as np
import pytest

import flankload as fl
from flankload.mechanisms.flank_pair.assembly import build_bodies
from flankload.pairing.interference import _overlaps, _places, overlaps_of
from tests.support.paths import SCENES


@pytest.mark.parametrize("name", ["external_gear", "internal_gear"])
@pytest.mark.parametrize("nearer", [1.0, 0.99, 0.9, 1.01, 1.1, 1.5])
def test_overlaps_are_those_of_all_circles(name: str, nearer: float) -> None:
    pair = build_bodies(fl.read_scene(SCENES / f"{name}.toml"))
    bodies, distance = (pair.body_1, pair.body_2), nearer * pair.pairing.center_distance_mm
    ratio = pair.body_1.teeth / pair.body_2.teeth
    sense = pair.body_2.outward
    pitch = distance / (1.0 + sense / ratio) * sense, distance / (1.0 + sense * ratio)
    radii = (abs(pitch[0]), abs(pitch[1]))
    (r_1, angle_1, tip_1), (r_2, angle_2, tip_2) = map(_places, bodies, radii)
    depth = _overlaps((r_1[:, None], angle_1[:, None]), (r_2, angle_2), *bodies, distance)
    at_tips = tip_1[:, None] & tip_2
    overlaps = {overlap.at_tips: overlap for overlap in overlaps_of(*bodies, radii, distance)}
    for part in (True, False):
        deepest = np.max(depth[at_tips == part])
        if part in overlaps:
            assert overlaps[part].depth_mm == deepest
        else:
            assert deepest < 1e-3


def test_bodies_out_of_reach_do_not_overlap() -> None:
    pair = build_bodies(fl.read_scene(SCENES / "external_gear.toml"))
    distance = 3.0 * pair.pairing.center_distance_mm
    assert list(overlaps_of(pair.body_1, pair.body_2, (36.6, 54.9), distance)) == []
