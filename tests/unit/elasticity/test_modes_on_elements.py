"""Pressure modes and the flank elements that bear them."""

from __future__ import annotations

import tomllib
from typing import Any

import pytest

import flankload as fl
from flankload.mechanisms.flank_pair.assembly import build_bodies
from flankload.pairing.body_pair import BodyPair
from flankload.scene.discretization import DEFAULT, elements_for_modes
from tests.support.paths import SCENES

#: Largest pressure of the spline, MPa: 40 strips, elements of 0.05 mm, 8 modes (5 at the default:
#: 1.5 % more; 12: 1.6 % less).
SPLINE_PEAK = 1627.1
#: Its error with elements that carry the modes.
BORNE = 0.03


def scene_of(name: str = "spline", **accuracy: Any) -> fl.Scene:
    tree = tomllib.loads((SCENES / f"{name}.toml").read_text(encoding="utf-8"))
    tree["accuracy"] = {"estimate": False, "tangents": False, **accuracy}
    return fl.Scene.from_dict(tree)


def elements_of(pair: BodyPair) -> list[int]:
    meshes = [body.mesh for body in (pair.body_1, pair.body_2)]
    return [mesh.flank_elements for mesh in meshes if mesh is not None]


def modes_lines(result: fl.Result) -> list[str]:
    return [line for line in result.warnings if "pressure modes on" in line]


def test_as_many_elements_as_half_the_square_of_the_degree() -> None:
    assert [elements_for_modes(modes) for modes in (3, 5, 6, 8, 12)] == [4, 8, 12, 24, 60]


@pytest.mark.parametrize("name", ["external_gear", "internal_gear", "spline", "spline_press_fit"])
def test_the_default_bears_its_modes(name: str) -> None:
    plain = build_bodies(scene_of(name))
    assert min(elements_of(plain)) >= elements_for_modes(DEFAULT.modes)
    assert elements_of(build_bodies(scene_of(name, modes=DEFAULT.modes))) == elements_of(plain)


def test_more_modes_make_the_flank_finer_and_it_alone() -> None:
    plain, fine = build_bodies(scene_of()), build_bodies(scene_of(modes=12))
    assert min(elements_of(fine)) >= elements_for_modes(12)
    for one, two in ((plain.body_1, fine.body_1), (plain.body_2, fine.body_2)):
        assert one.mesh is not None
        assert two.mesh is not None
        finer = two.mesh.flank_elements / one.mesh.flank_elements
        assert len(two.mesh.nodes) < finer * len(one.mesh.nodes) < finer**2 * len(one.mesh.nodes)


def test_elements_that_are_named_stay() -> None:
    named = build_bodies(scene_of(flank_element_mm=0.2))
    assert elements_of(build_bodies(scene_of(flank_element_mm=0.2, modes=12))) == elements_of(named)


def test_many_modes_leave_the_peak_pressure_where_it_is() -> None:
    borne = fl.solve(scene_of(modes=12))
    assert borne.peak_pressure_MPa.max() == pytest.approx(SPLINE_PEAK, rel=BORNE)
    assert modes_lines(borne) == []


def test_a_result_says_how_many_elements_bear_the_modes() -> None:
    scene = scene_of(flank_element_mm=0.2, modes=12)
    result = fl.solve(scene)
    one, two = elements_of(build_bodies(scene))
    assert modes_lines(result) == [
        f"12 pressure modes on the {number} flank elements of body_{z}: they need 60 "
        "elements; fewer increase the error, mainly that of pressures at tip roundings"
        for z, number in ((1, one), (2, two))
    ]
