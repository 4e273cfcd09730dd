"""Load sharing of planets on springs: closed forms."""

from math import pi, sqrt

import numpy as np
import pytest

import flankload as fl
from flankload.pairing.stage_errors import pin_directions, pin_displacements
from tests.support.stage_paths import StagePaths
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
    moved = pin_displacements(p.angles_rad, radial, tangential)
    gaps = -np.einsum("mnx,nx->m", p.planet_rows[:, :, 1:], moved)
    motions = [p.sun_rows[:, 0], *p.planet_rows[:, :, 0].T]
    loads = [TORQUE] + [0.0] * n
    if floating and sun is None:
        motions += [*p.sun_rows[:, 1:].T]
        loads += [*weight]
    elif floating:
        compliance += p.sun_rows[:, 1:] @ p.sun_rows[:, 1:].T / sun
    for j in range(n) if pin else ():
        rows = p.planet_rows[:, j, 1:] @ pin_directions(p.angles_rad)[j].T
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
