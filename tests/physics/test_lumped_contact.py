"""Lumped contact: one unknown for each place, against Hertz, differences and contact pairs."""

from __future__ import annotations

import tomllib
from functools import cache
from typing import Any

import numpy as np
import pytest

import flankload as fl
from flankload.contact.core_call import CORE_COUNTERS
from flankload.contact.flank_contact import FlankContact, Level
from flankload.contact.sweep import Sweep, sweep
from flankload.elasticity.compliance import BodyCompliance
from flankload.errors import InputError
from flankload.mechanisms.elements import compliance_of
from flankload.mechanisms.flank_pair.assembly import build_bodies
from flankload.pairing.body_pair import BodyPair
from flankload.scene.discretization import Grid
from tests.support.paths import SCENES
from tests.support.pressed_cylinders import CASE, LEVER, contact
from tests.support.random_scenes import spatial_scenes
from tests.support.tolerances import SOLVER

#: Finer than any default, so that the cells' own error does not count.
FINE = Grid(24.0, 72.0)
#: Largest errors by lumping off corners, roundings and kinks (rotation, share of load, pressure)
#: and, of the rotation, on them. Measured: 0.027 %, 0.03 points, 0.29 %, 0.10 % on the FZG pair;
#: 0.063 %, 0.06 points, 0.83 %, 0.51 % on the ring, whose contacts are three times as wide for
#: their flanks; 0.003 % on the cam.
LIMITS: dict[str, tuple[float, float, float, float]] = {
    "external_gear": (3e-4, 4e-4, 3.5e-3, 1.5e-3),
    "external_gear_compliance": (3e-4, 4e-4, 3.5e-3, 1.5e-3),
    "external_gear_friction": (8e-4, 4e-4, 3.5e-3, 2e-3),
    "external_gear_mesh": (3e-4, 4e-4, 3.5e-3, 1.5e-3),
    "external_gear_mesh_profile": (3e-4, 4e-4, 3.5e-3, 1.5e-3),
    "internal_gear": (8e-4, 8e-4, 1e-2, 7e-3),
    "toothed_sector": (3e-4, 4e-4, 3.5e-3, 1.5e-3),
    "cam": (1e-4, 1e-12, 3.5e-3, 1e-4),
}
#: Differences' own error: second order in the step, rounding of the rotation over the step.
DIFFERENCES, STEP = 1e-7, 1e-4
#: Part of a tangent that a sliding speed which is not linear over the contact leaves at a friction
#: coefficient of 0.3: measured 5.6e-5; a mean sign that follows the width half as much leaves 1e-3.
BENT_SPEED = 1e-4


def scene_of(name: str, **effects: Any) -> fl.Scene:
    tables = tomllib.loads((SCENES / f"{name}.toml").read_text(encoding="utf-8"))
    tables.setdefault("effects", {}).update(effects)
    return fl.Scene.from_dict(tables, file=SCENES / f"{name}.toml")


@cache
def built(name: str, mu: float | None) -> tuple[BodyPair, tuple[BodyCompliance, BodyCompliance]]:
    scene = scene_of(name, **({} if mu is None else {"friction_coefficient": mu}))
    pair = build_bodies(scene)
    return pair, (compliance_of(pair.body_1, scene), compliance_of(pair.body_2, scene))


def swept(
    name: str,
    level: Level,
    *,
    mu: float | None = None,
    torque: float = 1.0,
    position_rad: np.ndarray | None = None,
) -> Sweep:
    """A scene under so many times its torque."""
    scene = scene_of(name)
    pair, compliances = built(name, mu)
    position_rad = pair.position_rad if position_rad is None else position_rad
    contact = FlankContact(pair, compliances, FINE, level)
    (found,) = sweep(contact, position_rad, [1000 * torque * scene.torques_Nm[0]])
    return found


# --- Hertz ----------------------------------------------------------------------------------------
@pytest.mark.parametrize("load", [0.01, 1.0])
def test_a_cylinder_has_the_contact_of_hertz(load: float) -> None:
    """Width, pressure and approach by the closed form; circles are parabolas to (h/R)²."""
    force, scale = load * CASE["line_load_N_per_mm"], np.sqrt(load)
    state = contact(force, Grid(), "lumped")
    _, table = state.pairs.at(0)
    assert len(table) == 1
    bend = 2e-3 * load
    width = CASE["half_width_mm"] * scale
    assert table[0, 8] * 2 / np.pi == pytest.approx(width, rel=bend)
    assert state.site_force_N[0, 0] == pytest.approx(force, rel=bend)
    pressure = scale * CASE["peak_pressure_MPa"]
    assert state.site_peak_N_per_mm[0, 0] == pytest.approx(pressure, rel=bend)
    kernel = 4 * (1 - CASE["poisson_ratio"] ** 2) / (np.pi * CASE["young_modulus_MPa"])
    approach = kernel * force * (0.5 + np.log(2 / width))
    closed = state.rotation_rad[0] - contact(0.0, Grid(), "lumped").rotation_rad[0]
    assert closed * LEVER == pytest.approx(approach, rel=bend)


# --- pairs ----------------------------------------------------------------------------------------
def largest(values: np.ndarray, where: np.ndarray) -> float:
    return float(np.max(np.abs(values), initial=0.0, where=where))


@pytest.mark.parametrize("name", LIMITS)
def test_lumped_contact_agrees_with_contact_pairs(name: str) -> None:
    lumped, pairs = swept(name, "lumped"), swept(name, "pairs")
    rotation, share, pressure, anywhere = LIMITS[name]
    even = ((lumped.site_corner == 0) & (pairs.site_corner == 0)).all(axis=1)
    assert even.sum() >= 8
    beside = lumped.rotation_rad / pairs.rotation_rad - 1
    assert largest(beside, even) < rotation
    assert largest(beside, ~even) < anywhere
    parts = [part.site_force_N / part.site_force_N.sum(axis=1)[:, None] for part in (lumped, pairs)]
    assert largest(parts[0] - parts[1], even[:, None]) < share
    carries = (pairs.site_force_N > 0) & (lumped.site_force_N > 0) & even[:, None]
    ratio = np.ones_like(parts[0])
    np.divide(lumped.site_peak_N_per_mm, pairs.site_peak_N_per_mm, out=ratio, where=carries)
    assert largest(ratio - 1, carries) < pressure
    corners = (pairs.site_corner > 0) != (lumped.site_corner > 0)
    # a corner on the very edge of a contact is a matter of a cell
    assert corners.sum() <= 1


def test_friction_has_the_effect_that_it_has_with_pairs() -> None:
    """Rotation -1 %, share 2.5 points: the change itself agrees to 0.08 % and 0.1 points.

    The largest difference is at the pitch point, where the sign turns over: loaded teeth lean, and
    the contact with them, by a hundredth of its width.
    """
    found = {
        (level, mu): swept("external_gear", level, mu=mu)
        for level in ("lumped", "pairs")
        for mu in (None, 0.1)
    }
    change, shares = {}, {}
    for level in ("lumped", "pairs"):
        free, rubs = found[level, None], found[level, 0.1]
        change[level] = rubs.rotation_rad / free.rotation_rad - 1
        one, two = (part.site_force_N for part in (rubs, free))
        shares[level] = one / one.sum(axis=1)[:, None] - two / two.sum(axis=1)[:, None]
    smooth = (found["pairs", None].site_corner == 0).all(axis=1)
    assert np.abs(change["pairs"]).max() > 0.01
    assert largest(change["lumped"] - change["pairs"], smooth) < 8e-4
    assert np.abs(shares["pairs"]).max() > 0.02
    assert largest(shares["lumped"] - shares["pairs"], smooth[:, None]) < 1e-3


def test_the_sign_of_sliding_turns_over_inside_the_contact() -> None:
    """Around the pitch point, pair 0 at position 0: its mean over cells, and no jump."""
    position = np.linspace(-0.02, 0.02, 41)
    means = []
    for level in ("lumped", "pairs"):
        found = swept("external_gear", level, mu=0.1, position_rad=position)
        force = found.pairs.column("force")
        own = found.pairs.sites == np.flatnonzero(built("external_gear", 0.1)[0].pairing.sites == 0)
        summed = [
            np.bincount(found.pairs.position[own], values[own], minlength=41)
            for values in (force * found.pairs.column("friction"), force)
        ]
        means.append(summed[0] / summed[1])
    lumped, pairs = means
    assert lumped.min() == pytest.approx(-0.1, rel=1e-12)
    assert lumped.max() == pytest.approx(0.1, rel=1e-12)
    # loaded teeth lean towards each other, and the contact with them: by 4 % of its half-width
    np.testing.assert_allclose(lumped, pairs, rtol=0, atol=6e-3)
    beside = [
        np.abs(np.interp(position[5:-5] + lean, position, lumped) - pairs[5:-5]).max()
        for lean in np.linspace(0.0, 0.002, 41)
    ]
    assert min(beside) < 5e-4
    assert np.abs(np.diff(lumped)).max() < 0.01


# --- derivative, convergence ----------------------------------------------------------------------
@pytest.mark.parametrize("mu", [None, 0.1])
@pytest.mark.parametrize("name", ["external_gear", "internal_gear"])
def test_tangent_is_that_of_the_equations(name: str, mu: float | None) -> None:
    less, here, more = (swept(name, "lumped", mu=mu, torque=1 + side * STEP) for side in (-1, 0, 1))
    found = (more.rotation_rad - less.rotation_rad) / (more.torque_Nmm - less.torque_Nmm)
    beside = np.abs(here.tangent_rad_per_Nmm / found - 1)
    # where a contact just begins, or an edge comes into it, differences span a kink
    assert np.quantile(beside, 0.75) < DIFFERENCES
    assert beside.max() < 1e-3


def test_tangent_follows_the_sign_of_sliding_that_turns_over() -> None:
    """Around the pitch point a wider contact has another mean sign, which few positions see."""
    keys: dict[str, Any] = {"mu": 0.3, "position_rad": np.linspace(-0.012, 0.012, 9)}
    less, here, more = (
        swept("external_gear", "lumped", torque=1 + side * STEP, **keys) for side in (-1, 0, 1)
    )
    found = (more.rotation_rad - less.rotation_rad) / (more.torque_Nmm - less.torque_Nmm)
    np.testing.assert_allclose(here.tangent_rad_per_Nmm, found, rtol=BENT_SPEED, atol=0)


@pytest.mark.parametrize("torque", [1e-3, 1.0, 5.0])
def test_forces_converge_in_few_passes_without_columns(torque: float) -> None:
    found = swept("internal_gear", "lumped", torque=torque)
    counted = dict(zip(CORE_COUNTERS, found.counters.T, strict=True))
    assert not counted["influence_columns"].any()
    assert not counted["influence_columns_tangential"].any()
    assert not counted["contact_passes"].any()
    # estimate, two to six passes, the last one with all derivatives
    assert 3 <= counted["lumped_solutions"].min() <= counted["lumped_solutions"].max() <= 7
    assert found.certificate[:, 0].max() < 1e-14
    scene, (pair, _) = scene_of("internal_gear"), built("internal_gear", None)
    moment = torque * 1000 * scene.torques_Nm[0]
    levers = found.pairs.column("lever") * found.pairs.column("force")
    held = np.bincount(found.pairs.position, levers, minlength=pair.position_rad.size)
    np.testing.assert_allclose(held, moment, rtol=SOLVER, atol=0)


def test_no_torque_needs_no_level() -> None:
    lumped, pairs = (swept("external_gear", level, torque=0.0) for level in ("lumped", "pairs"))
    np.testing.assert_array_equal(lumped.rotation_rad, pairs.rotation_rad)
    np.testing.assert_array_equal(lumped.site_corner, pairs.site_corner)


def test_conforming_flanks_have_no_place() -> None:
    with pytest.raises(InputError, match="here the flanks conform and touch over a length"):
        swept("spline", "lumped")


def test_flanks_that_would_conform_but_stay_open_are_no_obstacle() -> None:
    """A chamfer that is parallel to its mate in one slice, where it does not touch."""
    _, scene = spatial_scenes(44, seed=5512)[43]
    coarse = {"axial_degree": 4, "load_degree_z": 0, "flank_element_mm": 1.0}
    prepared = fl.prepare(
        scene
        | {
            "positions": {"count": 64},
            "accuracy": {"estimate": False, "tangents": False, **coarse},
            "effects": {"dimension": 3, "contact": "lumped"},
        }
    )
    lumped, cells = (prepared.solve({"effects.contact": one}) for one in ("lumped", "pairs"))
    np.testing.assert_allclose(lumped.rotation_rad, cells.rotation_rad, rtol=5e-3)


@pytest.mark.parametrize(
    ("number", "torque"),
    [(11, 1.0), (15, 1.0), (23, 1.0), (11, 0.967), (11, 0.979), (15, 1.015)],
)
def test_contacts_at_jumps_of_their_half_widths_settle(number: int, torque: float) -> None:
    """Internal pairs with a contact that just reaches a corner or another piece of its flank.

    Its forces alternated between both sides, by up to 20 % of a force, in 1 to 6 of 128 states
    each.
    """
    _, scene = spatial_scenes(number + 1, seed=7001)[number]
    scene["load"]["torque_Nm"] *= torque
    beside = {"positions": {"count": 128}, "effects": {"dimension": 3, "contact": "lumped"}}
    accuracy = {"estimate": False, "tangents": False}
    result = fl.solve(fl.Scene.from_dict(scene | beside | {"accuracy": accuracy}))
    assert (result.status == 0).all()
    assert np.abs(result.load_share.sum(axis=1) - 1.0).max() < SOLVER
