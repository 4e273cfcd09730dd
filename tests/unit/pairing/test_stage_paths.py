"""Load sharing of planets on springs: closed forms, and frequencies from the same levers."""

from math import pi, radians, sqrt

import numpy as np
import pytest

import flankload as fl
from flankload.pairing.stage_paths import StagePaths
from tests.support.tolerances import SOLVER

#: Identities of springs.
SPRINGS = 1e-12
#: Stiffnesses of both meshes of each planet, N/mm; torque, N mm.
SUN_MESH, RING_MESH, TORQUE = 1e5, 2e5, 1e5
ANGLES, RADII = (0.4, 0.35), (30.0, 20.0, 70.0)


def paths(n: int) -> StagePaths:
    return StagePaths(2 * pi * np.arange(n) / n, ANGLES, RADII)


def shares(n, tangential, *, radial=None, floating=False, sun=None, pin=None, weight=(0.0, 0.0)):
    """(n,) Shares of planets on springs; stiffnesses in N/mm."""
    p = paths(n)
    compliance = np.diag(np.repeat([1 / SUN_MESH, 1 / RING_MESH], n))
    radial = np.zeros(n) if radial is None else radial
    moved = p.pin_displacements(radial, tangential)
    gaps = -np.einsum("mnx,nx->m", p.planet_rows[:, :, 1:], moved)
    motions = [p.sun_rows[:, 0], *p.planet_rows[:, :, 0].T]
    loads = [TORQUE] + [0.0] * n
    if floating and sun is None:
        motions += [*p.sun_rows[:, 1:].T]
        loads += [*weight]
    elif floating:
        compliance += p.sun_rows[:, 1:] @ p.sun_rows[:, 1:].T / sun
    for j in range(n) if pin else ():
        rows = p.planet_rows[:, j, 1:] @ p.pin_directions()[j].T
        compliance += rows @ np.diag(1 / np.array(pin)) @ rows.T
    state = fl.solve_contact_general(compliance, gaps, np.array(motions).T, np.array(loads))
    return state.normal_forces[:n] / (TORQUE / RADII[0])


def late(n: int, x: float, *, pin=None) -> np.ndarray:
    """(n,) Tangential errors of which the first one is k e/F = x."""
    cosines, sines = np.cos(ANGLES).sum(), np.sin(ANGLES[0]) - np.sin(ANGLES[1])
    path = 1 / SUN_MESH + 1 / RING_MESH
    if pin is not None:
        path += cosines**2 / pin[1] + sines**2 / pin[0]
    errors = np.zeros(n)
    errors[0] = x * (TORQUE / RADII[0]) * path / cosines
    return errors


@pytest.mark.parametrize("n", [3, 4, 5, 6])
def test_floating_sun_shares_by_the_closed_form(n):
    x = 0.15
    j = np.arange(n)
    expected = 1 / n + x * ((j == 0) - (1 + 2 * np.cos(2 * pi * j / n)) / n)
    np.testing.assert_allclose(shares(n, late(n, x), floating=True), expected, atol=SPRINGS)
    assert n * expected.max() == pytest.approx(1 + (n - 3) * x, abs=SPRINGS)


@pytest.mark.parametrize("n", [3, 4, 5, 6])
def test_fixed_sun_and_sun_on_a_spring(n):
    x, stiffness = 0.1, 3e4
    path = 1 / (1 / SUN_MESH + 1 / RING_MESH)
    part = (n * path / 2) / (n * path / 2 + stiffness)
    fixed = n * shares(n, late(n, x)).max()
    sprung = n * shares(n, late(n, x), floating=True, sun=stiffness).max()
    assert fixed == pytest.approx(1 + (n - 1) * x, abs=SPRINGS)
    assert sprung == pytest.approx(1 + (n - 1 - 2 * part) * x, abs=SPRINGS)


@pytest.mark.parametrize(
    ("n", "x", "factor"),
    [
        (4, 0.4, 1.4),
        (4, 3.0, 2.0),
        (5, 0.3, 1.6),
        (5, 3.0, sqrt(5)),
        (6, 0.4, 2.2),
        (6, 1.2, 7 / 3 + 0.4),
        (6, 4.0, 3.0),
        (5, -0.2, 1 + 1.618033988749895 * 0.2),
    ],
)
def test_planets_that_lift_off(n, x, factor):
    assert n * shares(n, late(n, x), floating=True).max() == pytest.approx(factor, abs=SOLVER)


def test_soft_pins_soften_their_paths():
    pin, x = (3e5, 1e5), 0.1
    found = shares(4, late(4, x, pin=pin), floating=True, pin=pin)
    assert 4 * found.max() == pytest.approx(1 + x, abs=SPRINGS)


def test_radial_errors_count_by_the_difference_of_the_sines():
    n, x = 4, 0.1
    ratio = (np.sin(ANGLES[0]) - np.sin(ANGLES[1])) / np.cos(ANGLES).sum()
    found = shares(n, np.zeros(n), radial=late(n, x) / ratio, floating=True)
    np.testing.assert_allclose(found, shares(n, late(n, x), floating=True), atol=SPRINGS)


def test_independent_pins_scatter_by_the_closed_form():
    n, x = 5, 0.02
    unit = np.array([shares(n, np.roll(late(n, x), j), floating=True)[0] - 1 / n for j in range(n)])
    assert sqrt((unit**2).sum()) == pytest.approx(x * sqrt(1 - 3 / n), abs=SPRINGS)


def test_weight_of_the_sun():
    n, part = 4, 0.01
    force = part * TORQUE / RADII[0]
    angles = np.linspace(0.0, 2 * pi, 721)
    found = [
        n
        * shares(n, np.zeros(n), floating=True, weight=(force * np.cos(a), force * np.sin(a))).max()
        for a in angles
    ]
    assert max(found) == pytest.approx(1 + 2 * part, abs=1e-6)


def test_natural_frequencies_of_lin_and_parker():
    """Lin and Parker 1999, tables 1 and 2: rigid bodies with the same levers."""
    n, alpha = 3, radians(24.6)
    p = StagePaths(2 * pi * np.arange(n) / n, (alpha, alpha), (1.0, 1.0, 1.0))
    # sun, ring, carrier, planets; rotations as displacements on the base circle
    rows = np.zeros((2 * n, 9 + 3 * n))
    rows[:, :3], rows[:, 3:6] = p.sun_rows, p.ring_rows
    rows[:, 9:] = p.planet_rows.reshape(2 * n, 3 * n)
    stiffness = 5e8 * rows.T @ rows
    for j, angle in enumerate(p.angles_rad):
        pin = np.zeros((2, 9 + 3 * n))
        pin[:, 9 + 3 * j + 1 : 9 + 3 * j + 3] = np.eye(2)
        pin[:, 7:9] = -np.eye(2)
        pin[:, 6] = [np.sin(angle), -np.cos(angle)]
        stiffness += 1e8 * pin.T @ pin
    bearings = np.zeros(9 + 3 * n)
    bearings[[1, 2, 4, 5, 7, 8]] = 1e8
    bearings[3] = 1e9
    masses = [(0.4, 0.39), (2.35, 3.0), (5.43, 6.29)] + [(0.66, 0.61)] * n
    mass = np.concatenate([[about, own, own] for own, about in masses])
    scaled = (stiffness + np.diag(bearings)) / np.sqrt(np.outer(mass, mass))
    found = np.sqrt(np.abs(np.linalg.eigvalsh(scaled))) / (2 * pi)
    single = [0.0, 1475.7, 1930.3, 2658.3, 7462.8, 11775.3]
    double = [743.2, 1102.4, 1896.0, 2276.4, 6986.3, 9647.9]
    np.testing.assert_allclose(found, sorted([*single, *double, *double]), atol=0.1)
