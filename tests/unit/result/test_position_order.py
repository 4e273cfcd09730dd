"""Weights of positions in means over their period, and means of the load over the face width."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from flankload.result.position_order import order_of
from flankload.result.slices import SliceLoads
from flankload.studies.optimisation.figures import MAXIMA
from tests.support.tolerances import ROUND_OFF

PERIOD = 0.8


@pytest.mark.parametrize(
    ("position", "closed", "wanted"),
    [
        ([0.0, 0.2, 0.4, 0.6], True, [0.25, 0.25, 0.25, 0.25]),
        ([0.0, 0.1, 0.2, 0.4, 0.6], True, [0.15 / 0.8, 0.125, 0.15 / 0.8, 0.25, 0.25]),
        # covers the period without being declared closed; the last position repeats the first
        ([0.0, 0.2, 0.4, 0.6, 0.8], False, [0.25, 0.25, 0.25, 0.25, 0.0]),
        # a part of the period: each position for the middle of a cell
        ([0.0, 0.1, 0.2], False, [1 / 3, 1 / 3, 1 / 3]),
        ([0.0, 0.1, 0.3], False, [2 / 9, 3 / 9, 4 / 9]),
        # single positions
        ([0.0, 0.4], False, [0.5, 0.5]),
        ([0.3], False, [1.0]),
    ],
)
def test_weights_of_positions(position: list[float], closed: bool, wanted: list[float]) -> None:
    found = order_of(np.array(position), pitch_rad=PERIOD, period_rad=PERIOD, closed=closed)
    np.testing.assert_allclose(found.weights, wanted, rtol=1e-9, atol=1e-12)


def loads(**changes: object) -> SliceLoads:
    """Two positions with parts of 1/4 and 3/4, two flanks, two slices of 1 and 3 mm."""
    force = np.array([[[4.0, 0.0], [0.0, 12.0]], [[2.0, 2.0], [6.0, 6.0]]])
    fields = {"z_mm": np.array([0.5, 2.5]), "width_mm": np.array([1.0, 3.0]), "force_N": force}
    rest = {"peak_pressure_MPa": force, "tangent_helix_base": 0.0, "cosine_helix_base": 1.0}
    rest["line_load_length_mm"] = 1.0  # those of the slices
    return SliceLoads(**{**fields, **rest, "weights": np.array([0.25, 0.75]), **changes})


def test_load_factors_by_hand() -> None:
    found = loads()
    # line loads 4, 4 at the first position, 8, 8/3 at the second, with means of 4
    np.testing.assert_allclose(found.relative_line_load, [[1.0, 1.0], [2.0, 2.0 / 3.0]])
    assert found.line_load_factor == pytest.approx(2.0, rel=ROUND_OFF)
    # 1/4 of 4 and 3/4 of 8
    assert found.face_load_factor == pytest.approx(7.0 / 4.0, rel=ROUND_OFF)
    zero = loads(force_N=np.zeros((2, 2, 2)))
    assert zero.face_load_factor == zero.line_load_factor == 1.0


def test_a_flank_that_hardly_touches_has_no_face_load_factor() -> None:
    """Regression: it was 21 on a helical pair whose contact line begins with 0.1 % of the load."""
    force = np.array([[[4.0, 0.02], [0.0, 12.0], [0.0, 0.0]], [[2.0, 6.0], [0.05, 0.0], [0, 0]]])
    found = loads(force_N=force).flank_face_load_factor
    first = 4.0 * 4.0 / 4.02
    np.testing.assert_allclose(found, [[first, 4.0 / 3.0, 1.0], [1.0, np.nan, 1.0]])


def test_load_factors_of_a_spline_are_those_of_its_teeth() -> None:
    """Regression: an optimisation had the sums over all teeth in place of single ones."""
    spline = loads(directions=np.zeros((2, 2, 2)))
    # 4 N/mm on one tooth, where 2 teeth of 4 mm carry 16 N; then 6
    assert spline.line_load_factor == pytest.approx(3.0, rel=ROUND_OFF)
    assert spline.face_load_factor == spline.line_load_factor
    for name in ("face_load_factor", "line_load_factor"):
        for numbers in MAXIMA[name]:
            found = numbers(SimpleNamespace(slices=spline))
            assert found.max() == pytest.approx(getattr(spline, name), rel=ROUND_OFF)
