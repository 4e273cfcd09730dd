"""Helical pairs beside the three-dimensional finite elements of `benchmarks/solid_elements.py`."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import flankload as fl
from flankload.scene import read_scene
from flankload.studies.benchmark import Case, read_cases
from flankload.studies.benchmark.case import place_of
from tests.support.paths import ROOT
from tests.support.solving import solve

FOLDER = ROOT / "benchmarks"
INTERNAL, CORNER = read_cases(FOLDER, ["helical_internal_pair", "helical_sharp_corner"])
#: Rotations beside the reference: reliefs, whose turned normals polynomials represent on average
#: only, leave 0.2 % on the internal pair.
ON_RELIEFS = 2.5e-3
#: Forces of pairs beside the reference as parts of the load.
SHARES = 1e-3
#: Line loads over 1 mm beside the reference as parts of the mean.
LINE_LOADS = 5e-3


def solved(case: Case, positions: list[int], **effects: Any) -> fl.Result:
    """The scene of a case at some of its positions."""
    scene = read_scene(FOLDER / case.name / "scene.toml")
    pitch = 360.0 / case.inputs["body_1"]["teeth"]
    angles = [pitch * k / case.inputs["positions"] for k in positions]
    changes = {f"effects.{key}": value for key, value in effects.items()}
    found = solve(
        scene.replace({"positions.count": None, "positions.angles_deg": angles, **changes})
    )
    assert isinstance(found, fl.Result)
    return found


def positions_of(case: Case) -> list[int]:
    """Positions with a rotation."""
    places = [place_of(name) for name in case.quantities]
    return sorted(int(place[0]) for kind, place in places if kind == "rotation")


def check_forces(case: Case, found: fl.Result, at: list[int]) -> None:
    total = found.site_force_N.sum(axis=1)
    for name, quantity in case.quantities.items():
        kind, place = place_of(name)
        if kind == "pair_force":
            p, s = at.index(int(place[0])), found.sites.tolist().index(int(place[1]))
            apart = found.site_force_N[p, s] - quantity.value
            assert abs(apart) < SHARES * total[p] + quantity.uncertainty, name


def check_line_loads(case: Case, found: fl.Result, at: list[int]) -> None:
    """Means over 1 mm, of which the reference has those well within the contact lines."""
    slices = found.slices
    assert slices is not None
    edges = np.append(slices.z_mm - 0.5 * slices.width_mm, 0.5 * found.face_width_mm)
    mean = found.site_force_N.sum(axis=1) / found.face_width_mm
    for name, quantity in case.quantities.items():
        kind, place = place_of(name)
        if kind == "line_load_at":
            p, s = at.index(int(place[0])), found.sites.tolist().index(int(place[1]))
            carried = np.append(0.0, np.cumsum(slices.force_N[p, s]))
            load = np.diff(np.interp([place[2] - 0.5, place[2] + 0.5], edges, carried))[0]
            assert abs(load - quantity.value) < LINE_LOADS * mean[p] + quantity.uncertainty, name


@pytest.mark.parametrize("contact", ["lumped", "pairs"])
def test_internal_helical_pair(contact: str) -> None:
    at = positions_of(INTERNAL)
    found = solved(INTERNAL, at, contact=contact)
    for p, k in enumerate(at):
        reference = INTERNAL.quantities[f"rotation[{k}]"].value
        assert found.rotation_rad[p] == pytest.approx(reference, rel=ON_RELIEFS)
    check_forces(INTERNAL, found, at)
    check_line_loads(INTERNAL, found, at)


@pytest.mark.parametrize("contact", ["lumped", "pairs"])
def test_line_that_ends_at_a_sharp_tip(contact: str) -> None:
    """With each flank's own normal, the rotation is 0.25 % larger."""
    at = positions_of(CORNER)
    found = solved(CORNER, at, contact=contact)
    for p, k in enumerate(at):
        reference = CORNER.quantities[f"rotation[{k}]"]
        assert abs(found.rotation_rad[p] - reference.value) < reference.uncertainty
    check_forces(CORNER, found, at)
