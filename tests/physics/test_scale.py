"""The same pair at another size, its torque with the cube of that, is the same problem: what has no
dimension stays as it is, corners included.

By a power of two nothing rounds otherwise: curves, meshes, and contact without logarithms of
lengths are the same to the last bit.
"""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest

import flankload as fl
from flankload.mechanisms.flank_pair.assembly import build_bodies
from tests.support.gear_scenes import changed, resized
from tests.support.pair_scenes import RING_PAIR, SPLINE
from tests.support.solving import solve
from tests.support.three_dimensional import SMALL, tree_of
from tests.support.tolerances import ROUND_OFF, SOLVER

#: Peaks at sharp corners and at the edges of conforming flanks are those of the finest cells: up to
#: 4e-9 of rounding, depending on the packages that factorize the stiffness.
EDGE_PEAKS = 5e-8
#: Derivatives of the lumped level are differences over 1e-5 of a force: 2e-8 of rounding.
DIFFERENCES = 2e-7
#: The module of the external pair is 4.5 mm: 0.02 … 50 mm.
SIZES = (0.02 / 4.5, 50 / 4.5)

FEW = {"flank_element_mm": 3.0, "modes": 4, "estimate": False, "tangents": False}
TIPS = {
    f"body_{z}__{key}": value
    for z in (1, 2)
    for key, value in (("tip_radius_mm", 0.4), ("tip_relief_um", 20.0))
} | {"body_1__tip_relief_start_diameter_mm": 79.0, "body_2__tip_relief_start_diameter_mm": 79.0}
PRESS_FIT = {
    "body_1": {**SPLINE["body_1"], "profile_shift": 0.001},
    "body_2": {**SPLINE["body_2"], "profile_shift": 0.0},
    "pair": SPLINE["pair"],
    "effects": {"coast_flank": True},
}
SCENES: dict[str, dict[str, Any]] = {
    "pairs": changed(positions__count=6, accuracy=FEW),
    "lumped": changed(positions__count=6, accuracy=FEW, effects={"contact": "lumped"}),
    "nodes": changed(
        positions__count=2,
        accuracy={"flank_element_mm": 3.0, "estimate": False, "tangents": False},
        effects={"near_field": "nodes"},
    ),
    "friction": changed(
        positions__count=3,
        accuracy=FEW,
        effects={"friction_coefficient": [[-4.0, 0.1], [4.0, 0.06]]},
    ),
    "tips": changed(positions__count=3, accuracy=FEW, **TIPS),
    "ring": {
        **RING_PAIR,
        "load": {"torque_Nm": 200},
        "positions": {"count": 3},
        "accuracy": FEW,
    },
    "spline": {**SPLINE, "load": {"torque_Nm": 80}, "accuracy": FEW},
    "slices": tree_of("internal_helical", SMALL | {"accuracy__tangents": True}),
    "press fit": {**PRESS_FIT, "load": {"torque_Nm": 80}, "accuracy": FEW},
}


@cache
def solved(name: str, size: float = 1.0) -> fl.Result:
    result = solve(fl.Scene.from_dict(resized(SCENES[name], size)))
    assert isinstance(result, fl.Result)
    return result


def without_dimension(result: fl.Result, size: float) -> dict[str, np.ndarray]:
    """Numbers that do not depend on the size."""
    return {
        "rotation": result.rotation_rad,
        "transmission error": result.transmission_error_um / size,
        "share": result.load_share,
        "pressure": result.peak_pressure_MPa,
        "stiffness": result.stiffness_tangent_Nm_per_rad / size**3,
    }


@pytest.mark.parametrize("size", SIZES, ids=["module 0.02", "module 50"])
@pytest.mark.parametrize("name", SCENES)
def test_a_pair_of_another_size_is_the_same_problem(name: str, size: float) -> None:
    one, other = solved(name), solved(name, size)
    assert [table.site.tolist() for table in other.pair_tables] == [
        table.site.tolist() for table in one.pair_tables
    ]
    expected = without_dimension(one, 1.0)
    for key, found in without_dimension(other, size).items():
        tolerance = SOLVER
        if key == "pressure" and name in ("spline", "press fit"):
            tolerance = EDGE_PEAKS
        if key == "stiffness" and name in ("lumped", "slices"):
            tolerance = DIFFERENCES
        scale = np.abs(expected[key]).max()
        if key == "pressure" and name == "pairs":
            corner = one.corner_contact
            np.testing.assert_allclose(
                found[corner], expected[key][corner], rtol=0, atol=EDGE_PEAKS * scale
            )
            found, expected[key] = found[~corner], expected[key][~corner]
        np.testing.assert_allclose(found, expected[key], rtol=0, atol=tolerance * scale)


@pytest.mark.parametrize("name", SCENES)
def test_bodies_of_twice_the_size_are_the_same_to_the_last_bit(name: str) -> None:
    one, two = (
        build_bodies(fl.Scene.from_dict(resized(SCENES[name], size))) for size in (1.0, 2.0)
    )
    for body, larger in ((one.body_1, two.body_1), (one.body_2, two.body_2)):
        np.testing.assert_array_equal(larger.curve.breaks, 2 * body.curve.breaks)
        powers = 2.0 ** (1 - np.arange(body.curve.coefficients.shape[-1]))
        np.testing.assert_array_equal(larger.curve.coefficients, powers * body.curve.coefficients)
        assert body.mesh is not None
        assert larger.mesh is not None
        np.testing.assert_array_equal(larger.mesh.nodes, 2 * body.mesh.nodes)


def test_contact_without_logarithms_of_four_times_the_size_is_the_same_to_rounding() -> None:
    """Products are exact; some BLAS kernels (SkylakeX) sum by where arrays are in memory."""
    one, four = solved("nodes"), solved("nodes", 4.0)
    expected = without_dimension(one, 1.0)
    for key, found in without_dimension(four, 4.0).items():
        np.testing.assert_allclose(found, expected[key], rtol=100 * ROUND_OFF, atol=0)
