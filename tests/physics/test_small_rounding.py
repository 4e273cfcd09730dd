"""The pressure where a contact reaches over the start of a small rounding, by half-plane theory.

The profile of a frictionless contact on half-planes, h(x) with its slope h'(x), asks for
c π² p(x) = √((x - l)(r - x)) ∫ h'(t)/(√((t - l)(r - t)) (t - x)) dt between its ends l and r, where
∫ h'/√(…) dt = 0 and c F = ∫ h' t/√(…) dt/π (c: strength of the logarithm, both bodies; N. I.
Muskhelishvili, Singular Integral Equations). Gauss's rules make it exact at points between their
nodes but for the kinks of h'. For a flat punch with rounded edges the ends have a closed form: M.
Ciavarella, D. A. Hills, G. Monno, Proc. Instn Mech. Engrs C 212 (1998), 319.
"""

from __future__ import annotations

from dataclasses import dataclass
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.optimize import brentq

from flankload.contact.flank_contact import FlankContact
from flankload.contact.sweep import sweep
from flankload.elasticity.compliance import BodyCompliance, FlankModes, NearField
from flankload.flank import CurvePiece, fit_flank_curve
from flankload.pairing.gear_mesh import GearMesh
from flankload.pairing.slices import plane_slice
from flankload.scene.discretization import Grid
from tests.support.pressed_cylinders import one_site

#: The contact lies at (LEVER, 0), its normal along y; far from O1, so that levers hardly differ.
LEVER, DISTANCE = 20000.0, 50000.0
KERNEL = 3e-6
#: Nodes of Gauss's rules.
NODES = 20000
#: Error of the largest pressure at the default cells, and at four times as many: the rest is
#: rather that of the circles about O1 and of the curves.
DEFAULT, FINE = 5e-3, 1e-3


class Shape:
    """A rigid body: its slope h' and its flank, from pieces of constant curvature.

    Parameters
    ----------
    ends : sequence of float
        Where the pieces end, mm; they meet without a kink.
    curvatures : sequence of float
        One less; 1/mm.
    """

    def __init__(self, ends: list[float], curvatures: list[float]) -> None:
        self.ends, self.curvatures = np.array(ends), np.array(curvatures)
        slopes = np.concatenate([[0.0], np.cumsum(self.curvatures * np.diff(self.ends))])
        self.slopes = slopes - np.interp(0.0, self.ends, slopes)

    def slope(self, x: np.ndarray) -> np.ndarray:
        return np.interp(x, self.ends, self.slopes)

    def curve(self):
        """Parabolas below y = 0, towards +x: the material lies on the right."""
        heights = np.concatenate(
            [[0.0], np.cumsum(0.5 * (self.slopes[1:] + self.slopes[:-1]) * np.diff(self.ends))]
        )
        k = int(np.searchsorted(self.ends, 0.0)) - 1
        middle = heights[k] - 0.5 * self.curvatures[k] * self.ends[k] ** 2
        middle -= self.ends[k] * (self.slopes[k] - self.curvatures[k] * self.ends[k])
        pieces = []
        for k, curvature in enumerate(self.curvatures):

            def place(u, k=k, curvature=curvature):
                x = u - self.ends[k]
                height = heights[k] - middle + self.slopes[k] * x + 0.5 * curvature * x**2
                slope = self.slopes[k] + curvature * x
                one, zero = np.ones_like(u), np.zeros_like(u)
                return (
                    np.stack([LEVER + u, -height], axis=-1),
                    np.stack([one, -slope], axis=-1),
                    np.stack([zero, -curvature * one], axis=-1),
                )

            pieces.append(CurvePiece("flank", place, self.ends[k], self.ends[k + 1], False))
        return fit_flank_curve(pieces)


def theory(shape: Shape, load: float) -> tuple[float, float, float]:
    """Ends of the contact and the largest pressure."""
    angle = (np.arange(NODES) + 0.5) * np.pi / NODES
    nodes = np.cos(angle)

    def centre(half: float) -> float:
        return brentq(
            lambda x: shape.slope(x + half * nodes).mean(), *shape.ends[[0, -1]], xtol=1e-14
        )

    def excess(half: float) -> float:
        t = centre(half) + half * nodes
        return float((shape.slope(t) * t).mean() - KERNEL * load)

    half = brentq(excess, 1e-6, 0.5 * np.ptp(shape.ends), xtol=1e-14)
    middle = centre(half)
    slope = shape.slope(middle + half * nodes)
    between = np.cos(np.arange(1, NODES) * np.pi / NODES)
    some = between[:: NODES // 4000]
    pressure = [np.sqrt(1 - x**2) * (slope / (nodes - x)).mean() / (np.pi * KERNEL) for x in some]
    return middle - half, middle + half, float(max(pressure))


@dataclass(frozen=True)
class Found:
    """The largest pressure; places and widths of the cells."""

    peak: float
    place: np.ndarray
    cell: np.ndarray


def solved(shape: Shape, strips: float) -> Found:
    """The body on a half-plane, by the core."""
    line = fit_flank_curve(
        [
            CurvePiece(
                "flank",
                lambda u: (
                    np.stack([LEVER - DISTANCE - u, 0 * u], axis=-1),
                    np.stack([-np.ones_like(u), 0 * u], axis=-1),
                    np.zeros((*np.shape(u), 2)),
                ),
                -10.0,
                10.0,
                False,
            )
        ]
    )
    bodies = [
        SimpleNamespace(curve=curve, rigid=rigid, teeth=1, active_range_mm=None)
        for curve, rigid in ((shape.curve(), True), (line, False))
    ]
    (found,) = sweep(
        FlankContact(
            GearMesh((bodies[0], bodies[1]), one_site(DISTANCE), plane_slice(1.0)),
            tuple(
                BodyCompliance(
                    np.full((1, 1, 1), 3 * kernel), NearField(kernel), FlankModes((0.0, 1.0))
                )
                for kernel in (0.0, KERNEL)
            ),
            Grid(strips_per_half_width=strips, corner_strips_per_half_width=3 * strips),
        ),
        np.zeros(1),
        [LOAD * LEVER],
    )
    assert found.status[0] == 0
    assert found.site_corner[0, 0] <= 0
    column = found.pairs.column
    return Found(float(found.site_peak_N_per_mm[0, 0]), column("s_1"), column("cell"))


#: Flat over 2 mm; a cylinder that turns into a small arc on one side, or on both; it touches first
#: on the arc; the arc begins outside of the contact.
SHAPES = {
    "punch": Shape([-4.0, -1.0, 1.0, 4.0], [1 / 5, 0.0, 1 / 5]),
    "sharp punch": Shape([-1.5, -1.0, 1.0, 1.5], [4.0, 0.0, 4.0]),
    "one side": Shape([-5.0, 0.4, 2.0], [1 / 100, 2.0]),
    "near the end": Shape([-5.0, 0.8, 2.0], [1 / 100, 2.0]),
    "both sides": Shape([-1.5, -0.7, 0.5, 1.5], [1.0, 1 / 100, 2.0]),
    "on the arc": Shape([-5.0, -0.02, 2.0], [1 / 100, 2.0]),
    "outside": Shape([-5.0, 1.0, 2.0], [1 / 100, 2.0]),
}
LOAD = 1500.0


def test_theory_of_a_rounded_punch() -> None:
    """Ends of the contact by their closed form."""
    radius, half = 5.0, 1.0
    plane_modulus = 2 / (np.pi * KERNEL)

    def missing(angle: float) -> float:
        grown = (np.pi - 2 * angle) / (2 * np.sin(angle) ** 2) - 1 / np.tan(angle)
        return grown - 2 * LOAD * radius / (plane_modulus * half**2)

    end = half / np.sin(brentq(missing, 1e-3, np.pi / 2 - 1e-9))
    low, high, _ = theory(SHAPES["punch"], LOAD)
    assert (-low, high) == pytest.approx((end, end), rel=1e-4)


@pytest.mark.parametrize("name", SHAPES)
def test_pressure_at_a_small_rounding(name: str) -> None:
    exact = theory(SHAPES[name], LOAD)[2]
    assert solved(SHAPES[name], 10.0).peak == pytest.approx(exact, rel=DEFAULT)
    assert solved(SHAPES[name], 40.0).peak == pytest.approx(exact, rel=FINE)


def test_cells_are_few() -> None:
    """Even cells would have to be as narrow everywhere as around the edge."""
    cell = solved(SHAPES["one side"], 10.0).cell
    assert cell.max() > 10 * cell.min()
    assert cell.size < 100


def test_without_a_rounding_in_the_contact_cells_are_even() -> None:
    low, high, _ = theory(SHAPES["outside"], LOAD)
    cell = np.diff(solved(SHAPES["outside"], 10.0).place)
    np.testing.assert_allclose(cell, 0.05 * (high - low), rtol=5e-3)
    np.testing.assert_allclose(cell, cell[0], rtol=1e-9)
