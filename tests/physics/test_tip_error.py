"""Contacts on tips: forces turned from the flank's normal, of which pressure modes know nothing."""

from __future__ import annotations

from copy import deepcopy
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import flankload as fl
from flankload.analysis.error_rules import Left, peak_of_modes
from flankload.analysis.estimate import Estimate
from tests.support.gear_scenes import example
from tests.support.tolerances import ROUND_OFF

SCENE = example("external_gear")
MODULE = 4.5
ROUNDED = {"tip_radius_mm": 0.08 * MODULE}
#: Positions at which a pair stands on the rounding of the wheel's tip, then of the pinion's.
ANGLES_DEG = [5.6, 5.9, 6.2, 6.6, 15.8, 16.6, 16.9]
#: What forces at nodes 0.0125 mm apart find there, which know neither modes nor half-planes
#: (near_field = "nodes", flank_element_mm = 0.0125, a minute; half as many nodes: 0.1 to 0.25 %).
ROTATION = np.array(
    [0.001278721, 0.001163844, 0.001077682, 0.001007588, 0.0009863419, 0.001086758, 0.001162216]
)
SHARE = np.array([0.89183, 0.77591, 0.68869, 0.6161, 0.42753, 0.3278, 0.2537])


def solved(angles: Any = ANGLES_DEG, size: float = 1.0, **tips: float) -> fl.Result:
    """The FZG type C pair with such tips, larger by `size` at the same stress."""
    tree = deepcopy(SCENE)
    for key in ("body_1", "body_2"):
        body = tree[key] | tips
        lengths = [name for name in body if name.endswith("_mm")]
        tree[key] = body | {name: size * body[name] for name in lengths}
    tree["pair"] = {name: size * value for name, value in tree["pair"].items()}
    tree["load"]["torque_Nm"] *= size**3
    tree["positions"] = {"angles_deg": angles}
    found = fl.solve(fl.Scene.from_dict(tree))
    assert isinstance(found, fl.Result)
    return found


@pytest.fixture(scope="module")
def rounded() -> fl.Result:
    return solved(**ROUNDED)


def errors(found: fl.Result) -> dict[str, float]:
    largest = np.max(ROTATION)
    return {
        "transmission_error": float(np.abs(found.rotation_rad - ROTATION).max() / largest),
        "load_share": float(np.abs(found.load_share[:, 1] - SHARE).max()),
    }


@pytest.mark.parametrize("quantity", ["transmission_error", "load_share"])
def test_a_pair_on_a_small_rounding_is_covered(rounded: fl.Result, quantity: str) -> None:
    """Rotation 1.2 % and share 1.2 points off; without tips 0.5 and 0.2 were estimated."""
    assert rounded.estimate is not None
    true, of_tips = errors(rounded)[quantity], rounded.estimate["by_source"]["tip"][quantity]
    assert rounded.estimate["dominant_source"][quantity] == "tip"
    assert true < rounded.estimate[quantity] < 2 * true
    assert 0.5 * true < of_tips < 2 * true


def test_without_a_pair_on_a_tip_there_is_no_such_source() -> None:
    found = solved([2.0, 11.25], **ROUNDED)
    assert found.estimate is not None
    assert "tip" not in found.estimate["by_source"]


def test_chamfers_and_sharp_corners_have_it_too() -> None:
    for tips in ({"tip_chamfer_mm": 0.08 * MODULE}, {}):
        found = solved(np.arange(4.0, 8.0, 0.5).tolist(), **tips)
        assert found.estimate is not None
        assert found.estimate["by_source"]["tip"]["transmission_error"] > 1e-4


def test_size_changes_no_part_of_it(rounded: fl.Result) -> None:
    small = solved(size=0.02, **ROUNDED)
    assert rounded.estimate is not None
    assert small.estimate is not None
    one, other = (found.estimate["by_source"]["tip"] for found in (rounded, small))
    for quantity, value in one.items():
        assert other[quantity] == pytest.approx(value, rel=1e-3)


def test_dominant_source_may_be_tips() -> None:
    left = {"tip": {"load_share": Left(0.01, 0.004)}, "modes": {"load_share": Left(-0.002, 0.0)}}
    found = Estimate.of(left)
    assert found.dominant_source["load_share"] == "tip"
    assert found.errors["load_share"] == pytest.approx(0.012, rel=ROUND_OFF, abs=0)


def test_peak_of_a_pair_that_has_just_begun_to_carry_may_be_a_multiple() -> None:
    """It goes with the root of the force; the part of a share that is in doubt went with itself."""
    shares = np.array([[1.0 - 1e-4, 1e-4]])

    def sweep(shares: np.ndarray) -> Any:
        return SimpleNamespace(
            site_force_N=shares, site_peak_N_per_mm=np.sqrt(shares), site_corner=np.zeros((1, 2))
        )

    fewer = sweep(np.array([[1.0 - 2e-4, 2e-4]]))
    doubt = np.asarray(peak_of_modes(sweep(shares), sweep(shares), fewer).doubt)
    assert doubt[0, 1] > 0.4 * np.sqrt(2e-4)
    assert doubt[0, 0] == pytest.approx(3e-4, rel=1e-3)
