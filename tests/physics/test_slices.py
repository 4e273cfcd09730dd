"""Contact in slices along the face width, against Hertz, the plane and its own symmetries."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest

import flankload as fl
from flankload.contact.flank_contact import FlankContact
from flankload.contact.sweep import Sweep, sweep
from flankload.elasticity.compliance import AxialModes, BodyCompliance
from flankload.errors import InputError
from flankload.mechanisms.elements import compliance_of
from flankload.mechanisms.flank_pair.assembly import build_bodies
from flankload.pairing.body_pair import BodyPair
from flankload.pairing.friction import Friction
from flankload.pairing.gear_mesh import GearMesh
from flankload.pairing.slices import Slices, plane_slice
from flankload.scene.discretization import Grid
from tests.support.crowned_cylinders import axial, cut, hertz_ellipse, press
from tests.support.paths import SCENES
from tests.support.tolerances import SOLVER

TORQUE = 302e3
#: Lines in place of an ellipse: pressure and approach of one 31 (8) times as long as wide.
LINES = {2000.0: (1.5e-3, 1e-3), 200.0: (7e-3, 2.5e-3)}
#: Gaps of involutes beside parabolas: of the pressure; measured 2.03e-3 near a base circle.
PARABOLAS = 3e-3
#: Of body 1, mm.
BASE_RADIUS = 33.828937
#: So long that the width of a contact over it is 3e-7, mm.
WIDTH = 1e6
#: Central differences of a sweep: second order in the step, and the width to which loads are
#: spread, which follows the torque and not the forces.
DIFFERENCES = 1e-3


@cache
def plane() -> tuple[BodyPair, tuple[BodyCompliance, BodyCompliance]]:
    scene = fl.read_scene(SCENES / "external_gear_friction.toml")
    pair = build_bodies(scene)
    return pair, (compliance_of(pair.body_1, scene), compliance_of(pair.body_2, scene))


def run(
    slices: Slices | None,
    compliances: tuple[BodyCompliance, BodyCompliance],
    *,
    width: float = 1.0,
    torque: float = TORQUE,
    mu: float | None = None,
    deviations: tuple[np.ndarray, np.ndarray] | None = None,
    **keywords: Any,
) -> Sweep:
    pair = plane()[0]
    pairing = pair.pairing
    bodies = tuple(
        replace(body, axial=replace(body.axial, twist_rad_per_mm=part.modes.axial.twist))
        for body, part in zip(pair.bodies, compliances, strict=True)
    )
    if deviations is not None:
        pairing = replace(pairing, site_deviations_mm=deviations)
    friction = None if mu is None else rubbing(mu)
    (found,) = sweep(
        FlankContact(
            GearMesh(bodies, pairing, slices or plane_slice(width), friction),
            compliances,
            **{"level": "lumped", "grid": pair.discretization.grid, **keywords},
        ),
        np.linspace(0.0, pair.pairing.period_rad, 8, endpoint=False),
        [torque],
    )
    return found


def rubbing(mu: float) -> Friction:
    """The same coefficient at all sites; body 1 drives."""
    return Friction(np.zeros(1), np.full((1, plane()[0].pairing.sites.size), mu))


def with_axial(compliance: BodyCompliance, axial: AxialModes) -> BodyCompliance:
    """The compliance with other modes along the axis."""
    return replace(compliance, modes=replace(compliance.modes, axial=axial))


def over_width(compliance: BodyCompliance, width: float, count: int = 1) -> BodyCompliance:
    """The plane compliance as one of a wide body: constant along z, soft across it."""
    smooth = compliance.smooth / width
    # a line of length w beside itself: c/w (ln(2 w/x) - 1); so each image
    images = 1.0 + sum(compliance.near.wedge)
    smooth[0, 0, 0] -= images * compliance.near.kernel / width * (np.log(2.0 * width) - 1.0)
    n = smooth.shape[1]
    wide = np.zeros((len(smooth), n * count, n * count))
    wide[:, ::count, ::count] = smooth
    for b in range(1, count):  # each further polynomial: half as soft, on the tooth itself alone
        wide[0, b::count, b::count] = compliance.smooth[0] / width * 0.5**b
    assert compliance.tangential is not None
    along = compliance.tangential / width
    images = sum(compliance.near.wedge_along)
    along[0, 0, 0] -= images * compliance.near.kernel / width * (np.log(2.0 * width) - 1.0)
    rubbed = np.zeros_like(wide)
    for b in range(count):
        rubbed[:, b::count, b::count] = along * 0.5**b
    return replace(compliance, smooth=wide, tangential=rubbed)


@pytest.mark.parametrize("crown_radius", LINES)
@pytest.mark.parametrize("slices", [31, 121])
def test_the_ellipse_of_hertz(crown_radius: float, slices: int) -> None:
    """Crowned flanks, in slices that are wider and thinner than the contact is."""
    force, radius = 3000.0, 8.0
    wanted = hertz_ellipse(force, radius, crown_radius)
    edges = np.linspace(-1.15, 1.15, slices + 1) * wanted.large
    gap = (edges[1:] ** 3 - edges[:-1] ** 3) / np.diff(edges) / (6.0 * crown_radius)
    found = press(force, radius, edges, gap)
    pressure, approach = LINES[crown_radius]
    np.testing.assert_allclose(found.slices.peak_MPa.max(), wanted.pressure, rtol=pressure)
    np.testing.assert_allclose(found.rotation_rad[0] * 1000.0, wanted.approach, rtol=approach)
    np.testing.assert_allclose(found.site_force_N.sum(), force, rtol=SOLVER)
    loaded = np.abs(edges[:-1] + edges[1:])[found.slices.force_N[0, 0] > 0] / 2.0
    np.testing.assert_allclose(loaded.max(), wanted.large, atol=2.0 * np.diff(edges)[0])


@pytest.mark.parametrize("mu", [None, 0.3])
def test_one_long_slice_is_the_plane(mu: float | None) -> None:
    """The same rotation, forces and tangent from the equations of both levels."""
    _, compliances = plane()
    wanted = run(None, compliances, width=WIDTH, mu=mu)
    half = 0.5 * WIDTH
    ends = axial(-half, half)
    one, two = (with_axial(over_width(part, WIDTH), ends) for part in compliances)
    found = run(cut(np.array([-half, half]), (ends, ends)), (one, two), mu=mu)
    for name in ("rotation_rad", "site_force_N", "tangent_rad_per_Nmm"):
        scale = np.abs(getattr(wanted, name)).max()
        np.testing.assert_allclose(
            getattr(found, name), getattr(wanted, name), rtol=0.0, atol=1e-6 * scale
        )
    assert found.slices.force_N.shape == (*found.site_force_N.shape, 1)
    if mu is not None:
        for name in ("sliding", "friction"):
            np.testing.assert_allclose(
                found.pairs.column(name), wanted.pairs.column(name), rtol=0.0, atol=1e-5
            )


def test_cells_of_one_long_slice_are_those_of_the_plane() -> None:
    """The pair has friction, and jumps of half-spaces that change the rotation by 3e-3.

    Cells are as wide as lumped contacts want them, in the plane without friction, and their widths
    differ by 7 %: rotations by 1.5e-6, by 6e-7 with a third of these widths.
    """
    flat = list(plane()[1])
    flat[0] = replace(flat[0], near=replace(flat[0].near, jump=0.0))
    flat[1] = replace(flat[1], near=replace(flat[1].near, jump=3.0 * flat[1].near.jump))
    half = 0.5 * WIDTH
    ends = axial(-half, half)
    one, two = (with_axial(over_width(part, WIDTH), ends) for part in flat)
    keywords: dict[str, Any] = {"mu": 0.3, "level": "pairs", "grid": Grid(30.0, 30.0, 2.5)}
    found = run(cut(np.array([-half, half]), (ends, ends)), (one, two), **keywords)
    wanted = run(None, (flat[0], flat[1]), width=WIDTH, **keywords)
    np.testing.assert_allclose(found.rotation_rad, wanted.rotation_rad, rtol=1e-5)
    for name in ("site_force_N", "tangent_rad_per_Nmm"):
        scale = np.abs(getattr(wanted, name)).max()
        np.testing.assert_allclose(
            getattr(found, name), getattr(wanted, name), rtol=0.0, atol=2e-3 * scale
        )
    assert not found.status.any()


@pytest.mark.parametrize("level", ["lumped", "pairs"])
def test_friction_of_zero_changes_nothing(level: str) -> None:
    """The unsymmetric equations with tangential forces of 0.

    The half-width h of a lumped contact is the distance at which the gap has grown by c F, with c
    the near field of both bodies per length of the slice. A gap is a difference of points up to the
    centre distance a away, rounded to eps a: h changes by h eps a/(2 c F), the near field
    c F ln(2/h) by eps a/2, and the force, whose own compliance is a few c, by less than eps a/c. A
    torque that is larger by one rounding error changes the forces as much.
    """
    pair, compliances = plane()
    for twist in (0.0, 7e-3):
        without, edges = short(twist=twist, level=level)
        found, _ = short(twist=twist, mu=0.0, level=level)
        np.testing.assert_allclose(found.rotation_rad, without.rotation_rad, rtol=1e-12)
        rounding = 1e-12 * without.slices.force_N.max()
        if level == "lumped":
            near = sum(body.near.kernel for body in compliances) / np.diff(edges).max()
            rounding = np.finfo(float).eps * pair.pairing.center_distance_mm / near
        np.testing.assert_allclose(
            found.slices.force_N, without.slices.force_N, rtol=0.0, atol=rounding
        )


def short(
    *,
    twist: float = 0.0,
    gap: np.ndarray | None = None,
    mirrored: bool = False,
    **keywords: Any,
) -> tuple[Sweep, np.ndarray]:
    """FZG pair with the plane's compliance over 14 mm, uneven slices and ends."""
    pair, compliances = plane()
    edges = np.array([-6.0, -5.6, -4.8, -3.5, -2.0, 0.0, 2.0, 4.0, 5.0, 6.5, 7.0])
    ranges = ((-6.0, 7.0), (-7.5, 7.0))
    ends = ((1.3, 1.2), (0.0, 1.3))
    if mirrored:
        edges, twist = -edges[::-1], -twist
        ranges = tuple((-high, -low) for low, high in ranges)
        ends = tuple(end[::-1] for end in ends)
        gap = None if gap is None else gap[::-1]
    teeth = pair.body_1.teeth / pair.body_2.teeth
    along = [
        replace(axial(*ranges[z], twist=twist * (1.0, -teeth)[z], end=ends[z]), degree=2)
        for z in (0, 1)
    ]
    one, two = (
        with_axial(over_width(part, 14.0, 3), modes)
        for part, modes in zip(compliances, along, strict=True)
    )
    return run(cut(edges, (along[0], along[1]), gap), (one, two), **keywords), edges


def test_a_large_torque_closes_slices_that_are_far_from_each_other() -> None:
    """As many slices are loaded as with a search of all slices."""
    heavy, _ = short(twist=7e-3, torque=40.0 * TORQUE)
    loaded = (heavy.slices.force_N > 0).sum(axis=(1, 2))
    np.testing.assert_array_equal(loaded, [21, 22, 20, 20, 20, 20, 20, 21])


@pytest.mark.parametrize(("twist", "mu"), [(0.0, None), (7e-3, None), (7e-3, 0.2)])
def test_mirrored_bodies_carry_mirrored_forces(twist: float, mu: float | None) -> None:
    """z -> -z with the other hand, a helix slope and ends of their own."""
    gap = 0.004 * np.linspace(0.0, 1.0, 10)
    one, _ = short(twist=twist, gap=gap, mu=mu)
    two, _ = short(twist=twist, gap=gap, mu=mu, mirrored=True)
    np.testing.assert_allclose(two.rotation_rad, one.rotation_rad, rtol=1e-10)
    np.testing.assert_allclose(
        two.slices.force_N[..., ::-1],
        one.slices.force_N,
        rtol=0.0,
        atol=1e-9 * one.slices.force_N.max(),
    )


@pytest.mark.parametrize("twist", [0.0, 7e-3])
def test_forces_hold_the_torque(twist: float) -> None:
    """Sum of forces times levers of their normals, which leave the plane of the section."""
    found, _ = short(twist=twist)
    table = found.pairs.table
    for k, (first, count) in enumerate(zip(found.pairs.first, found.pairs.count, strict=True)):
        columns = table[first : first + count]
        normal_lever = np.abs(columns[:, 3] * columns[:, 6] - columns[:, 4] * columns[:, 5])
        cosine = 1.0 / np.hypot(1.0, twist * normal_lever)
        held = columns[:, 7] @ (normal_lever * cosine)
        np.testing.assert_allclose(held, TORQUE, rtol=1e-3 if twist else SOLVER)
        np.testing.assert_allclose(columns[:, 7] @ columns[:, 10], TORQUE, rtol=SOLVER)
        np.testing.assert_allclose(found.site_force_N[k].sum(), columns[:, 7].sum(), rtol=SOLVER)


@pytest.mark.parametrize("twist", [0.0, 7e-3])
def test_pressures_are_those_of_hertz_in_the_normal_plane(twist: float) -> None:
    """p² = 2 F/(pi² l rho c) on involutes: l = dz/cos(b), rho = rho_t/cos(b)."""
    pair, compliances = plane()
    found, edges = short(twist=twist)
    cosine = 1.0 / np.hypot(1.0, twist * BASE_RADIUS)
    line = pair.pairing.center_distance_mm**2 - (BASE_RADIUS * (1.0 + 24 / 16)) ** 2
    kernel = sum(part.near.kernel for part in compliances)
    compared = 0
    for k in range(len(found.status)):
        sites, columns = found.pairs.at(k)
        radius, force, cell = columns[:, 2], columns[:, 7], columns[:, 8]
        lever = np.abs(columns[:, 3] * columns[:, 6] - columns[:, 4] * columns[:, 5])
        smooth = (force > 20.0) & (np.abs(lever / BASE_RADIUS - 1.0) < 2e-4)
        rho_1 = np.sqrt(radius**2 - BASE_RADIUS**2)
        rho = rho_1 * (np.sqrt(line) - rho_1) / np.sqrt(line)
        slices = found.pairs.slices_at(k)
        length = np.diff(edges)[slices] / cosine
        wanted = np.sqrt(2.0 * force / (np.pi**2 * length * (rho / cosine) * kernel))
        np.testing.assert_allclose(
            (force / (cell * length))[smooth], wanted[smooth], rtol=PARABOLAS
        )
        peak = found.slices.peak_MPa[k][sites, slices]
        np.testing.assert_allclose(peak[smooth], wanted[smooth], rtol=PARABOLAS)
        compared += smooth.sum()
    assert compared > 50


def test_helix_slopes_of_both_signs() -> None:
    """More on the side with more metal; a slope to the other side on mirrored bodies."""
    slope = 0.01 * np.linspace(0.0, 1.0, 10)
    even, edges = short()
    sloped, _ = short(gap=slope)
    load = sloped.slices.force_N.sum(axis=1) / np.diff(edges)
    assert (load[:, 1] > load[:, -2]).all()
    assert (sloped.rotation_rad > even.rotation_rad).all()


def test_a_gap_of_all_slices_is_a_pitch_deviation() -> None:
    """Metal removed from all slices, and teeth set back."""
    pair, _ = plane()
    gap = np.full(pair.pairing.sites.size, 0.003)
    found, _ = short(gap=np.full(10, 0.003))
    back = (-gap, np.zeros_like(gap))
    wanted, _ = short(deviations=back)
    np.testing.assert_allclose(found.rotation_rad, wanted.rotation_rad, rtol=SOLVER)
    np.testing.assert_allclose(
        found.slices.force_N, wanted.slices.force_N, rtol=SOLVER, atol=SOLVER
    )


@pytest.mark.parametrize(("twist", "mu"), [(0.0, None), (7e-3, None), (7e-3, 0.2)])
def test_tangent_is_the_derivative(twist: float, mu: float | None) -> None:
    """Derivative of the rotation by the torque, with all dependences on the forces."""
    step = 1e-4
    found, _ = short(twist=twist, mu=mu)
    more, _ = short(twist=twist, mu=mu, torque=TORQUE * (1.0 + step))
    less, _ = short(twist=twist, mu=mu, torque=TORQUE * (1.0 - step))
    slope = (more.rotation_rad - less.rotation_rad) / (2.0 * step * TORQUE)
    np.testing.assert_allclose(found.tangent_rad_per_Nmm, slope, rtol=DIFFERENCES)


def test_finite_forces_in_slices_are_refused() -> None:
    """Influence coefficients of finite forces on cells: their points move in one section alone."""
    _, compliances = plane()
    one, two = (
        with_axial(replace(part, tangential=np.zeros_like(part.smooth)), axial(-1.0, 1.0))
        for part in compliances
    )
    with pytest.raises(InputError, match="slices"):
        run(
            cut(np.array([-1.0, 1.0]), (one.modes.axial, two.modes.axial)),
            (one, two),
            level="pairs",
            finite_steps=2,
        )


def test_slices_beyond_a_body_are_refused() -> None:
    _, compliances = plane()
    one = with_axial(compliances[0], axial(-1.0, 1.0))
    two = with_axial(compliances[1], axial(-1.0, 0.9))
    with pytest.raises(InputError, match="record_2: expected modes over the width of all slices"):
        run(cut(np.array([-1.0, 1.0]), (one.modes.axial, two.modes.axial)), (one, two))
