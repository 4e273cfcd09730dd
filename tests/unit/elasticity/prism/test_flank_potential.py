"""Love's rectangle, images and their projections, against sums over cells."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from numpy.polynomial.legendre import leggauss, legvander

from flankload.bodies.tip_modes import Tip
from flankload.elasticity.prism.flank_potential import projected_potential, projected_tangential
from flankload.elasticity.prism.flank_surface import FlankSurface
from tests.support.rectangle_means import line_segment, love_rectangle
from tests.support.tolerances import ROUND_OFF

NONE = (0.0, 0.0)


def _straight(s: np.ndarray) -> np.ndarray:
    return np.zeros_like(s)


def _leaning(s: np.ndarray) -> np.ndarray:
    return 0.02 * np.sqrt(2 * 33.8 * (s + 3.0))


def _surface(slope=_straight, cosine: float = 1.0, *, end=NONE, wedge=NONE) -> FlankSurface:
    return FlankSurface((1.0, 7.0), (-5.0, 4.0), cosine, slope, end, wedge)


def test_rectangle_outside_equals_quadrature() -> None:
    a, b, x, y = 0.4, 1.1, np.array([0.9, -2.0, 0.1, 3.0]), np.array([0.3, 0.5, 1.9, -2.5])
    points, weights = leggauss(40)
    far = np.hypot(x[:, None, None] - a * points[:, None], y[:, None, None] - b * points)
    expected = np.einsum("i,j,kij->k", weights, weights, 1 / far) / 4
    np.testing.assert_allclose(love_rectangle(x, y, a, b), expected, rtol=1e-9)


def test_rectangle_at_its_centre_edges_and_corners() -> None:
    a, b = 0.4, 1.1
    center = (a * np.arcsinh(b / a) + b * np.arcsinh(a / b)) / (a * b)
    assert love_rectangle(0.0, 0.0, a, b) == pytest.approx(center, rel=ROUND_OFF)
    # four rectangles around a corner are one of twice the sides
    assert love_rectangle(a, b, a, b) * 4 == pytest.approx(
        4 * love_rectangle(0.0, 0.0, 2 * a, 2 * b), rel=ROUND_OFF
    )
    assert love_rectangle(a, 0.0, a, b) == pytest.approx(
        love_rectangle(0.0, 0.0, 2 * a, b), rel=ROUND_OFF
    )


def test_rectangle_that_is_thin_far_or_long() -> None:
    assert love_rectangle(0.0, 2.5, 1e-5, 1.0) == pytest.approx(line_segment(2.5, 1.0), rel=1e-9)
    assert line_segment(-2.5, 1.0) == line_segment(2.5, 1.0)
    a, b, x, y = 0.3, 0.5, 8.0, -11.0
    r = np.hypot(x, y)
    far = (1 + (a**2 * (2 * x**2 - y**2) + b**2 * (2 * y**2 - x**2)) / (6 * r**4)) / r
    assert love_rectangle(x, y, a, b) == pytest.approx(far, rel=1e-5)
    assert love_rectangle(x, y, a, b) != pytest.approx(1 / r, rel=1e-5)
    # per length, two places of a long one differ by -2 (ln x1 - ln x2)
    one, two = (2e4 * love_rectangle(place, 0.0, 1e-3, 1e4) for place in (0.5, 3.0))
    assert one - two == pytest.approx(2 * np.log(3.0 / 0.5), rel=1e-6)


def _by_cells(surface: FlankSurface, cells: int) -> np.ndarray:
    """The projection on modes 2 x 2 by the distances of the centres of cells."""
    at = (np.arange(cells) + 0.5) / cells
    x, y = (part.ravel() for part in np.meshgrid(at, at, indexing="ij"))
    s, z = surface.s_mm[0] + surface.length_mm * x, surface.z_mm[0] + surface.width_mm * y
    modes = np.einsum("ka,kb->kab", legvander(2 * x - 1, 1), legvander(2 * y - 1, 1))
    modes = modes.reshape(-1, 4) * (
        surface.length_mm * surface.width_mm / cells**2 / surface.cos_base_helix
    )
    table = surface.potential(s[:, None], z[:, None], s, z)
    own = np.repeat([_own_cell(surface, place, cells) for place in s[::cells]], cells)
    for psi, face in zip(surface.end, surface.z_mm, strict=True):
        own += psi * surface.cos_base_helix / np.abs(2 * (z - face))
    for psi, corner in zip(surface.wedge, surface.s_mm, strict=True):
        own += psi / np.abs(2 * (s - corner))
    np.fill_diagonal(table, own)
    return modes.T @ table @ modes


def _own_cell(surface: FlankSurface, s: float, cells: int) -> float:
    """Mean of 1/R over a cell from its centre, cut into four triangles."""
    points, weights = leggauss(24)
    u, v = 0.5 * surface.length_mm / cells, 0.5 * surface.width_mm / cells
    slope = float(surface.slope(np.array([s]))[0])

    def inverse(one: np.ndarray | float, two: np.ndarray | float) -> np.ndarray:
        return 1 / np.hypot(one - slope * two, two / surface.cos_base_helix)

    sides = (inverse(u, v * points), inverse(-u, v * points))
    ends = (inverse(u * points, v), inverse(u * points, -v))
    return float(0.25 * weights @ (sum(sides) + sum(ends)))


@pytest.mark.parametrize(
    "surface",
    [
        _surface(),
        _surface(end=(1.3, 0.0)),
        _surface(wedge=(0.0, 0.4)),
        _surface(_leaning, 0.95),
        _surface(_leaning, 0.95, end=(0.5, 2.0), wedge=(0.3, 0.4)),
    ],
    ids=["bare", "end", "corner", "helix", "all"],
)
def test_projection_is_the_limit_of_sums_over_cells(surface: FlankSurface) -> None:
    sums = [_by_cells(surface, cells) for cells in (10, 20, 40)]
    first = [2 * fine - coarse for coarse, fine in pairwise(sums)]  # they miss h, then h²
    limit = (4 * first[1] - first[0]) / 3
    found = projected_potential(surface, 2, 1)
    scale = np.sqrt(np.outer(np.diag(found), np.diag(found)))
    assert np.abs((found - limit) / scale).max() < 3e-3


def _tangential_by_cells(surface: FlankSurface, cells: int, image: float) -> np.ndarray:
    """The same under loads along the profile; the cell itself has no field of a half-space."""
    at = (np.arange(cells) + 0.5) / cells
    x, y = (part.ravel() for part in np.meshgrid(at, at, indexing="ij"))
    s, z = surface.s_mm[0] + surface.length_mm * x, surface.z_mm[0] + surface.width_mm * y
    modes = np.einsum("ka,kb->kab", legvander(2 * x - 1, 1), legvander(2 * y - 1, 1))
    modes = modes.reshape(-1, 4) * (
        surface.length_mm * surface.width_mm / cells**2 / surface.cos_base_helix
    )
    apart = z[:, None] - z
    slope = 0.5 * (surface.slope(s)[:, None] + surface.slope(s))
    ahead = s[:, None] - s - slope * apart
    along = apart / surface.cos_base_helix
    np.fill_diagonal(along, 1.0)
    table = -ahead / (ahead**2 + along**2) / np.pi
    np.fill_diagonal(along, 0.0)
    for psi, corner in zip(surface.wedge_along, surface.s_mm, strict=True):
        table += image * psi / np.hypot(np.abs(s[:, None] - corner) + np.abs(s - corner), along)
    return modes.T @ table @ modes


@pytest.mark.parametrize("wedge", [NONE, (0.0, -0.5)], ids=["bare", "corner"])
@pytest.mark.parametrize(
    "surface", [_surface(), _surface(_leaning, 0.95)], ids=["straight", "helix"]
)
def test_loads_along_the_profile_are_the_limit_of_sums(
    surface: FlankSurface, wedge: tuple[float, float]
) -> None:
    surface = replace(surface, wedge_along=wedge)
    sums = [_tangential_by_cells(surface, cells, 0.3) for cells in (10, 20, 40)]
    first = [2 * fine - coarse for coarse, fine in pairwise(sums)]
    limit = (4 * first[1] - first[0]) / 3
    found, finer = (
        projected_tangential(surface, 2, 1, kernel=0.6, jump=1.0, finer=n) for n in (1, 2)
    )
    scale = np.abs(found).max()
    assert np.abs(found - limit).max() < 3e-3 * scale
    assert np.abs(found - finer).max() < 1e-5 * scale
    if not any(wedge):
        np.testing.assert_allclose(found, -found.T, rtol=0.0, atol=ROUND_OFF * scale)


def test_projection_on_the_constant_mode_has_a_closed_form() -> None:
    found = projected_potential(_surface(), 1, 0)[0, 0]
    a, b = 6.0, 9.0
    logs = a**2 * b * np.arcsinh(b / a) + a * b**2 * np.arcsinh(a / b)
    expected = 2 * (logs + (a**3 + b**3 - np.hypot(a, b) ** 3) / 3)
    assert found == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize(
    "surface",
    [_surface(end=(1.3, 1.3)), _surface(_leaning, 0.95, end=(0.5, 2.0), wedge=(0.3, 0.4))],
    ids=["straight", "helix"],
)
def test_twice_as_many_points_change_nothing(surface: FlankSurface) -> None:
    found, finer = (projected_potential(surface, 5, 4, finer=n) for n in (1, 2))
    scale = np.sqrt(np.outer(np.diag(finer), np.diag(finer)))
    assert np.abs((found - finer) / scale).max() < 1e-5
    assert np.linalg.eigvalsh(found).min() > 0
    np.testing.assert_array_equal(found, found.T)


def test_places_of_the_profile_are_looked_at_once() -> None:
    """Once, instead of for each point along the axis (374 400 places)."""
    seen = []

    def watched(s: np.ndarray) -> np.ndarray:
        seen.append(np.size(s))
        return _leaning(s)

    projected_potential(_surface(watched, 0.95, end=(0.5, 2.0)), 5, 4)
    assert sum(seen) < 4_000


#: [P_0, P_1, P_2] of a flank that goes on over its tip, by the modes of flank and tip: with r the
#: part of the flank that the tip is long, P_1(1 + 2 r u) = 1 + 2 r u, P_2 = 1 + 6 r u + 6 r² u².
def _continued(r: float) -> np.ndarray:
    return np.array([[1, 0, 0, 0, 0], [0, 1, 0, 2 * r, 0], [0, 0, 1, 6 * r, 6 * r**2]], dtype=float)


@pytest.mark.parametrize(
    "surface",
    [
        _surface(),
        _surface(end=(1.3, 0.4), wedge=(0.3, 0.0)),
        _surface(_leaning, 0.95, end=(0.5, 2.0), wedge=(0.3, 0.0)),
    ],
    ids=["bare", "images", "helix"],
)
@pytest.mark.parametrize("length", [0.3, 8.0])
def test_a_tip_that_goes_on_like_the_flank_is_a_longer_flank(
    surface: FlankSurface, length: float
) -> None:
    end = 7.0 + length
    longer = replace(surface, s_mm=(1.0, end))
    cosine = surface.cos_base_helix
    tipped = replace(
        surface, tip=Tip(end, 1, 1.0), tip_secant=lambda s: np.full(np.shape(s), 1 / cosine)
    )
    # polynomials of the flank by those of the longer one
    xi, _ = leggauss(3)
    s = 1.0 + (end - 1.0) * 0.5 * (1.0 + xi)
    parts = np.linalg.solve(legvander(xi, 2), legvander((s - 4.0) / 3.0, 2)).T
    onto = _continued(length / 6.0)
    products = parts @ longer.products(3) @ parts.T
    np.testing.assert_allclose(onto @ tipped.products(5) @ onto.T, products, rtol=1e-12)
    onto, parts = np.kron(onto, np.eye(3)), np.kron(parts, np.eye(3))
    found = onto @ projected_potential(tipped, 5, 2) @ onto.T
    expected = parts @ projected_potential(longer, 3, 2, finer=2) @ parts.T
    scale = np.sqrt(np.outer(np.diag(expected), np.diag(expected)))
    assert np.abs((found - expected) / scale).max() < 2e-5


def test_places_of_a_tip_lie_as_far_apart_as_its_own_angle_has_them() -> None:
    surface = replace(
        _surface(cosine=0.95), tip=Tip(7.5, 1, 1.0), tip_secant=lambda s: np.full(np.shape(s), 2.0)
    )
    assert surface.potential(7.2, 1.0, 7.2, 0.0) == pytest.approx(0.5)
    assert surface.potential(6.9, 1.0, 6.9, 0.0) == pytest.approx(0.95)
    area = surface.products(3)[0, 0]  # of the constant mode
    assert area == pytest.approx(6.0 / 0.95 + 2.0 * 0.5)


def test_a_long_contact_line_is_a_line_load() -> None:
    """Along a contact line x = 0: distances are those along it, images behind the ends as well."""
    surface = _surface(_leaning, 0.95, end=(0.5, 2.0))
    z = np.array([-2.0, 1.0])
    # the line through (4, 0): ds/dz = slope(s), followed by small steps
    places = []
    for goal in z:
        s, steps = 4.0, 4000
        for _ in range(steps):
            middle = s + 0.5 * goal / steps * _leaning(np.array([s]))[0]
            s += goal / steps * float(_leaning(np.array([middle]))[0])
        places.append(s)
    found = surface.potential(places[0], z[0], places[1], z[1])
    apart = 3.0 / 0.95
    ends = 0.5 / ((z.sum() + 10.0) / 0.95) + 2.0 / ((8.0 - z.sum()) / 0.95)
    assert found == pytest.approx(1 / apart + ends, rel=1e-6)


def test_an_end_face_doubles_the_displacement_by_a_load_on_it() -> None:
    surface = _surface(end=(0.0, 1.3))
    at_end = surface.potential(2.0, 4.0, 3.0, 4.0)
    assert at_end == pytest.approx(2.3, rel=ROUND_OFF)
    assert surface.potential(2.0, 4.0, 3.0, -5.0) == pytest.approx(2.3 / np.hypot(1, 9))
    np.testing.assert_allclose(
        surface.potential(2.0, 1.0, 3.0, 2.0), surface.potential(3.0, 2.0, 2.0, 1.0), rtol=1e-15
    )
