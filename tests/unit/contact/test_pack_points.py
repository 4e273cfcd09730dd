"""Bodies given by points of the flank and tables of compliance between them."""

from __future__ import annotations

import numpy as np
import pytest

from flankload import _core
from tests.support.packed_points import by_curve, by_points, rotation


@pytest.mark.parametrize("mu", [None, 0.1])
def test_a_spline_through_points_converges_to_the_flank(mu: float | None) -> None:
    """The order is at least 3, also with own tables for loads along the flank."""
    errors = [
        abs(rotation(by_points(n), friction=mu) / rotation(by_curve(n), friction=mu) - 1.0)
        for n in (12, 23)
    ]
    assert errors[1] < 1e-4
    assert errors[1] < errors[0] / 8


def test_friction_uses_the_tables() -> None:
    body = by_points(21)
    smooth, rubbing = rotation(body), rotation(body, friction=0.1)
    assert abs(rubbing - smooth) > 1e-7


def test_points_that_are_no_curve_are_refused() -> None:
    points = np.asfortranarray(np.zeros((2, 3)))
    rest = (
        *(np.zeros(3, np.intc), np.zeros((3, 3, 1), order="F"), np.zeros(1), np.zeros(1)),
        *(np.ones((1, 1), np.intc, "F"), 1e-7, np.empty(0)),
    )
    assert _core.flankload_pack_points(points, *rest) == -102
    said = _core.flankload_status_text(-102)
    assert said == b"flankload_pack_points: points: expected neighbours apart from each other"
    one = (points[:, :1], rest[0][:1], np.zeros((1, 1, 1), order="F"), *rest[2:])
    assert _core.flankload_pack_points(*one) == -101
