"""Contacts on tips with roundings and chamfers, which have modes."""

from __future__ import annotations

from copy import deepcopy
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import flankload as fl
from flankload.analysis.error_rules import SERIES, RemainingError, peak_of_modes
from flankload.analysis.estimate import Estimate
from tests.support.gear_scenes import example
from tests.support.solving import solve
from tests.support.tolerances import ROUND_OFF

SCENE = example("external_gear")
MODULE = 4.5
ROUNDED = {"tip_radius_mm": 0.08 * MODULE}
#: Forces at nodes are normal to each place of the rounding, those of the core to the contact as a
#: whole: a degree or two over a rounding of 0.08 modules. Along the places' own normals modes leave
#: 0.1 % and 0.2 points.
ROTATION_LEFT, SHARE_LEFT = 5e-3, 4e-3
#: Positions at which the corner of a chamfer works, and by how much the rotation may fall because
#: the force turns over it (0.5 to 1.0 %).
CHAMFER_DEG, TURNED = [6.2, 7.0, 15.8], 0.02
#: Positions at which a pair is on the rounding of the wheel's tip, then of the pinion's.
ANGLES_DEG = [5.6, 5.9, 6.2, 6.6, 15.8, 16.6, 16.9]
#: The same by forces at nodes 0.0125 mm apart, without modes and half-planes
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
    found = solve(fl.Scene.from_dict(tree))
    assert isinstance(found, fl.Result)
    return found


@pytest.fixture(scope="module")
def rounded() -> fl.Result:
    return solved(**ROUNDED)


#: CalculiX (nonlinear contact, six elements on the half-width, small displacements) at ANGLES_DEG
#: of these numbers: rotation, and share of the second pair. With displacements followed in five
#: increments and either body as master, its rotation at 5.9 degrees is 0.0011691 (0.16 % more, as
#: off tips). Forces at nodes, normal to each place of the rounding, turn 0.3 to 0.6 % less.
CALCULIX = {1: (0.001167342, 0.77884), 2: (0.001082220, 0.69212), 5: (0.001093006, 0.32290)}
CALCULIX_LEFT = 1.4e-3, 1.7e-3


def test_a_pair_on_a_small_rounding_turns_as_by_calculix(rounded: fl.Result) -> None:
    at = list(CALCULIX)
    rotation, share = np.array(list(CALCULIX.values())).T
    turn = np.abs(rounded.rotation_rad[at] / rotation - 1)
    apart = np.abs(rounded.load_share[at, 1] - share)
    assert turn.max() < CALCULIX_LEFT[0]
    assert apart.max() < CALCULIX_LEFT[1]
    assert rounded.estimate is not None
    assert turn.max() < rounded.estimate["transmission_error"]
    assert apart.max() < rounded.estimate["load_share"]
    assert np.abs(ROTATION[at] / rotation - 1).min() > 2e-3


def errors(found: fl.Result) -> dict[str, float]:
    largest = np.max(ROTATION)
    return {
        "transmission_error": float(np.abs(found.rotation_rad - ROTATION).max() / largest),
        "load_share": float(np.abs(found.load_share[:, 1] - SHARE).max()),
    }


def test_a_pair_on_a_small_rounding_follows_forces_at_nodes(rounded: fl.Result) -> None:
    """Modes that end before the rounding miss 1.2 % of the rotation and 1.2 points of the share."""
    true = errors(rounded)
    assert true["transmission_error"] < ROTATION_LEFT
    assert true["load_share"] < SHARE_LEFT
    assert rounded.estimate is not None


def test_a_chamfer_begins_like_a_sharp_tip_there() -> None:
    """The same corners touch the same flanks; behind them is a little more metal, and forces that
    turn over them find less compliance. Along the normal of the chamfer it was 10 % less."""
    height = 0.08 * MODULE
    chamfered = solved(CHAMFER_DEG, tip_chamfer_mm=height)
    tree = deepcopy(SCENE)
    for key in ("body_1", "body_2"):
        tree[key]["tip_diameter_mm"] -= 2 * height
    tree["positions"] = {"angles_deg": CHAMFER_DEG}
    sharp = solve(fl.Scene.from_dict(tree))
    assert isinstance(sharp, fl.Result)
    less = 1.0 - chamfered.rotation_rad / sharp.rotation_rad
    assert less.min() > 0.0
    assert less.max() < TURNED


def test_dominant_source_may_have_a_doubt() -> None:
    left = {
        "elements": {"load_share": RemainingError(0.01, 0.004)},
        "modes": {"load_share": RemainingError(-0.002, 0.0)},
    }
    found = Estimate.of(left)
    assert found.dominant_source["load_share"] == "elements"
    assert found.errors["load_share"] == pytest.approx(0.012, rel=ROUND_OFF, abs=0)


def test_peak_of_a_pair_that_has_just_begun_to_carry_may_be_a_multiple() -> None:
    """The peak is proportional to the root of the force, whose share is uncertain."""
    shares = np.array([[1.0 - 1e-4, 1e-4]])

    def sweep(shares: np.ndarray) -> Any:
        return SimpleNamespace(
            site_force_N=shares, site_peak_N_per_mm=np.sqrt(shares), site_corner=np.zeros((1, 2))
        )

    fewer = sweep(np.array([[1.0 - 2e-4, 2e-4]]))
    in_shares = RemainingError(0.4e-4, 2.3e-4)
    peaks = peak_of_modes(SERIES, sweep(shares), sweep(shares), fewer, in_shares)
    doubt = np.asarray(peaks.doubt)
    assert doubt[0, 1] > 0.4 * np.sqrt(2e-4)
    # half of the error of its force, and 0.75 of the change of its own peak
    assert doubt[0, 0] == pytest.approx(np.hypot(0.5 * 2.7e-4, 0.75 * 0.5e-4), rel=1e-3)
