"""Flanks displaced by known loads: subtracted from the gaps, no unknown."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

import flankload as fl
from flankload import _core
from flankload.bodies import Body
from flankload.bodies.profile_deviation import deviation_at
from flankload.contact.flank_contact import FlankContact
from flankload.contact.sweep import Sweep, sweep
from flankload.elasticity.compliance import BodyCompliance, Expansion, FlankModes, NearField
from flankload.elasticity.near_field import mode_norms, mode_values
from flankload.mechanisms.elements import compliance_of
from flankload.mechanisms.flank_pair.assembly import build_bodies
from flankload.pairing.body_pair import BodyPair
from tests.support.body_records import parts_of
from tests.support.gear_pair import GEARS, ONE, TWO
from tests.support.sweep_calls import assert_same
from tests.support.tolerances import SOLVER

#: A modified profile against its projection on the modes, relative to its effect (measured 0.8 % of
#: the rotation, of a force and of the peak pressure).
PROFILE_MODEL = 0.01
#: A scaled flank against the part of its motion along its normal: beside it is what the scaling
#: does a second time (measured 0.0013 at a strain of 5e-4).
SCALING_MODEL = 0.002
MODES = 9


@cache
def job(crowning_um: float = 0.0) -> tuple[BodyPair, tuple[BodyCompliance, BodyCompliance]]:
    scene = fl.Scene.from_dict(
        {
            **GEARS,
            "body_1": ONE,
            "body_2": {**TWO, "profile_crowning_um": crowning_um},
            "positions": {"count": 12},
            "accuracy": {"modes": MODES, "flank_element_mm": 0.5},
        }
    )
    pair = build_bodies(scene)
    return pair, (compliance_of(pair.body_1, scene), compliance_of(pair.body_2, scene))


def swept(
    pair: BodyPair,
    compliances: tuple[BodyCompliance, BodyCompliance],
    torque_Nm: float,
    bodies: tuple[Body, Body] | None = None,
) -> Sweep:
    (found,) = sweep(
        FlankContact(
            replace(pair, bodies=bodies or pair.bodies), compliances, pair.discretization.grid
        ),
        pair.position_rad,
        [1000.0 * torque_Nm],
    )
    return found


def projected(body: Body, values: np.ndarray, s: np.ndarray, weights: np.ndarray) -> np.ndarray:
    modes = mode_values(s, body.mode_range_mm, MODES)
    return (modes * weights[:, None]).T @ values / mode_norms(body.mode_range_mm, MODES)


def gauss(body: Body) -> tuple[np.ndarray, np.ndarray]:
    low, high = body.mode_range_mm
    x, weights = np.polynomial.legendre.leggauss(200)
    return 0.5 * (low + high) + 0.5 * (high - low) * x, 0.5 * (high - low) * weights


def shifted(compliance: BodyCompliance, modes: np.ndarray) -> BodyCompliance:
    return replace(compliance, expansion=Expansion(0.0, {"test": np.atleast_2d(modes)}))


@pytest.mark.parametrize("torque", [0.0, 302.0])
def test_an_even_shift_is_metal_that_touches_early(torque: float) -> None:
    """Mode 0 alone equals the deviation of a site."""
    pair, (one, two) = job()
    modes = np.zeros(MODES)
    modes[0] = 0.008
    by_modes = swept(pair, (shifted(one, modes), shifted(two, -0.5 * modes)), torque)
    deviations = tuple(
        np.full(pair.pairing.sites.size, value) for value in (modes[0], -0.5 * modes[0])
    )
    early = replace(pair, pairing=replace(pair.pairing, site_deviations_mm=deviations))
    by_number = swept(early, (one, two), torque)
    plain = swept(pair, (one, two), torque)
    np.testing.assert_allclose(by_modes.rotation_rad, by_number.rotation_rad, rtol=SOLVER)
    np.testing.assert_allclose(
        by_modes.site_force_N, by_number.site_force_N, rtol=0, atol=SOLVER * 9000
    )
    moved = (plain.rotation_rad - by_modes.rotation_rad) * pair.body_1.reference_radius_mm
    np.testing.assert_allclose(moved, 0.5 * modes[0], rtol=0.01)


@pytest.mark.parametrize("torque", [0.0, 100.0, 302.0])
def test_a_flank_shifted_by_its_crowning_is_a_crowned_flank(torque: float) -> None:
    """The other way goes through the profile of the body: other curves, other least gaps."""
    pair, compliances = job()
    crowned, _ = job(10.0)
    s, weights = gauss(crowned.body_2)
    involute = crowned.body_2.involute
    assert involute is not None
    _, deviation = deviation_at(involute, crowned.body_2.curve.point(s))
    modes = projected(crowned.body_2, deviation, s, weights)
    by_shift = swept(pair, (compliances[0], shifted(compliances[1], modes)), torque)
    by_profile = swept(crowned, compliances, torque)
    plain = swept(pair, compliances, torque)
    smooth = (by_profile.site_corner <= 0).all(axis=1) & (by_shift.site_corner <= 0).all(axis=1)
    assert smooth.sum() >= 6
    for name in ("rotation_rad", "site_force_N", "site_peak_N_per_mm"):
        wanted, found = getattr(by_profile, name)[smooth], getattr(by_shift, name)[smooth]
        if torque == 0.0 and name != "rotation_rad":
            continue
        size = np.abs(wanted - getattr(plain, name)[smooth]).max()
        assert size > 0.01 * np.abs(wanted).max()
        np.testing.assert_allclose(found, wanted, rtol=0, atol=PROFILE_MODEL * size, err_msg=name)


def scaled(body: Body, strain: float) -> Body:
    """The body, grown by the same part everywhere."""
    curve = body.curve
    powers = (1.0 + strain) ** (1.0 - np.arange(curve.coefficients.shape[2]))
    grown = replace(
        curve, breaks=curve.breaks * (1.0 + strain), coefficients=curve.coefficients * powers
    )
    low, high = body.mode_range_mm
    return replace(body, curve=grown, mode_range_mm=(low * (1.0 + strain), high * (1.0 + strain)))


def test_a_body_that_grows_turns_its_mate_back() -> None:
    """Shift along the normal against the whole flank scaled, without load."""
    pair, _ = job()
    body = pair.body_2
    s, weights = gauss(body)
    rigid = BodyCompliance(
        np.zeros((1, MODES, MODES)), NearField(0.0), FlankModes(pair.body_1.mode_range_mm)
    )
    mate = replace(rigid, modes=FlankModes(body.mode_range_mm))
    plain = swept(pair, (rigid, mate), 0.0)
    apart = []
    for strain in (5e-4, 1e-3):
        out = strain * (body.curve.point(s) * body.curve.normal(s)).sum(axis=1)
        found = swept(pair, (rigid, shifted(mate, projected(body, out, s, weights))), 0.0)
        grown = swept(pair, (rigid, mate), 0.0, bodies=(pair.body_1, scaled(body, strain)))
        smooth = (grown.site_corner <= 0).all(axis=1) & (found.site_corner <= 0).all(axis=1)
        assert smooth.sum() >= 8
        motion = plain.rotation_rad - grown.rotation_rad
        assert (motion > 0).all()
        apart.append(np.abs(found.rotation_rad - grown.rotation_rad)[smooth].max() / motion.max())
    assert apart[0] < SCALING_MODEL
    assert apart[1] < 3.0 * apart[0]  # of the whole: the difference is of second order


def test_each_flank_has_its_own_shift() -> None:
    """One row for each named flank: that of its tooth, in the order of the sites."""
    _, (one, _) = job()
    rows = np.zeros((3, MODES))
    rows[:, 0] = [0.1, 0.2, 0.3]
    named = replace(one, flanks=(2, 5, 7), expansion=Expansion(0.0, {"a": rows, "b": 10.0 * rows}))
    found = named.shift_of(np.array([5, 2, 7, 5]))
    np.testing.assert_allclose(found[:, 0], [2.2, 1.1, 3.3, 2.2], rtol=1e-15)
    fewer = named.fewer_modes()
    assert fewer.shift_of(np.array([2])).shape == (1, MODES - 1)
    assert one.shift_of(np.arange(3)).shape == (0, MODES)


def test_without_shift_nothing_is_handed_to_the_core(monkeypatch: pytest.MonkeyPatch) -> None:
    """Empty arrays; a shift of zeros changes no bit but the path through the core."""
    pair, (one, two) = job()
    seen: list[list[int]] = []
    shifts = []
    original = _core.flankload_sweep_mesh

    def spied(*arguments: np.ndarray) -> object:
        seen.append([np.size(argument) for argument in arguments])
        shifts.append(sum(parts_of(record)["shift"].size for record in arguments[4:6]))
        return original(*arguments)

    monkeypatch.setattr(_core, "flankload_sweep_mesh", spied)
    plain = swept(pair, (one, two), 302.0)
    zeros = swept(pair, (shifted(one, np.zeros(MODES)), two), 302.0)
    more = [b - a for a, b in zip(*seen, strict=True) if a != b]
    assert more == [pair.pairing.sites.size * MODES]
    assert shifts == [0, *more]
    assert_same(plain, zeros)


def test_a_shift_that_is_no_number_is_refused() -> None:
    pair, (one, two) = job()
    with pytest.raises(fl.errors.InputError, match="flankload_pack_part: values: expected finite"):
        swept(pair, (shifted(one, np.full(MODES, np.nan)), two), 302.0)
