"""The working flank of a prism between the ends of its modes, for its near field.

Near a free end face a flank is more compliant than a half-space: the near field of a load has a
mirror image of strength psi behind the end. Strengths were determined by finite elements, at an
edge of 90 degrees as a function of Poisson's ratio, and at nu = 0.3 as a function of the angle.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from flankload.base.gauss import leggauss
from flankload.bodies.free_corner import along_strengths, image_strengths
from flankload.elasticity.near_field import mode_norms, mode_values
from flankload.errors import SceneError

if TYPE_CHECKING:
    from collections.abc import Callable

    from flankload.base.arrays import Floats
    from flankload.bodies.body import Body
    from flankload.bodies.tip_modes import Tip
    from flankload.elasticity.prism.compliance import Prism

#: Poisson's ratios, and psi at a right angle.
RIGHT_ANGLE = ((0.0, 0.2, 0.3, 0.4, 0.45), (0.94, 1.13, 1.30, 1.53, 1.69))
#: psi = 1.33 exp(-0.062 (angle - 90)) at nu = 0.3, fitted to angles of at least 57 degrees.
AT_STEEL, STEEL_RATIO, DECAY_PER_DEGREE = 1.33, 0.3, 0.062
#: Least angle, deg; the error of the image is 3.4 % at 57 degrees, and larger below.
LEAST_ANGLE = 50.0
#: Gauss points in directions in which 1/R is smooth, but not a polynomial, besides those for the
#: modes; twice as many change the projections by less than 1e-6.
DIRECTION_POINTS = 16
#: Number of points of a table of directions on flank and tip each; interpolation error 1e-7.
TABLE = 2000


@dataclass(frozen=True, eq=False)
class FlankSurface:
    """Developed flank of a prism between the ends of its modes, and its images.

    Attributes
    ----------
    s_mm, z_mm : (float, float)
        Ranges of arc length and of axial position.
    cos_base_helix : float
        cos(beta_b).
    slope : callable
        Arc lengths -> ds/dz along the straight line through the point, of the same shape.
    end : (float, float)
        Strengths psi of the images behind the end faces at low and high z.
    wedge : (float, float)
        The same behind free corners at low and high s.
    wedge_along : (float, float)
        Strengths psi_nt behind free corners of a force along the profile.
    tip : Tip or None
        Rounding or chamfer behind the flank, to which the last modes belong.
    tip_secant : callable or None
        Arc lengths on the tip -> 1/cos(beta), of the same shape.
    """

    s_mm: tuple[float, float]
    z_mm: tuple[float, float]
    cos_base_helix: float
    slope: Callable[[Floats], Floats]
    end: tuple[float, float]
    wedge: tuple[float, float]
    wedge_along: tuple[float, float] = (0.0, 0.0)
    tip: Tip | None = None
    tip_secant: Callable[[Floats], Floats] | None = None

    @property
    def pieces_mm(self) -> tuple[float, ...]:
        """Arc lengths at the ends of the flank, and at the end of its tip."""
        return self.s_mm if self.tip is None else (*self.s_mm, self.tip.end_mm)

    @property
    def length_mm(self) -> float:
        """Length along the profile, including the tip."""
        return self.pieces_mm[-1] - self.pieces_mm[0]

    @property
    def width_mm(self) -> float:
        """Axial width."""
        return self.z_mm[1] - self.z_mm[0]

    def secant(self, s: Floats) -> Floats:
        """1/cos(beta), the area element over ds dz."""
        flank = np.full(np.shape(s), 1.0 / self.cos_base_helix)
        if self.tip_secant is None:
            return flank
        return np.where(s > self.s_mm[1], self.tip_secant(s), flank)

    def modes(self, s: Floats, count: int) -> Floats:
        """Modes along the profile at arc lengths of any shape, (..., count)."""
        return mode_values(np.ravel(s), self.s_mm, count, tip=self.tip).reshape(*np.shape(s), count)

    def products(self, count: int) -> Floats:
        """Integrals of P_a P_c ds/cos(beta), mm, (count, count)."""
        if self.tip is None:
            return np.diag(mode_norms(self.s_mm, count) / self.cos_base_helix)
        total = np.zeros((count, count))
        at, weights = unit_gauss(count + DIRECTION_POINTS)
        for low, high in pairwise(self.pieces_mm):
            s = low + (high - low) * at
            values = self.modes(s, count)
            total += values.T @ (((high - low) * weights * self.secant(s))[:, None] * values)
        return total

    def potential(self, s: Floats, z: Floats, s_load: Floats, z_load: Floats) -> Floats:
        """Near field of point loads over k, 1/mm; infinite at the load.

        Parameters
        ----------
        s, z, s_load, z_load : arrays that broadcast
            Positions of points and loads, mm.
        """
        z_change = z - z_load
        x = s - s_load - 0.5 * (self.slope(s) + self.slope(s_load)) * z_change
        secant = 0.5 * (self.secant(s) + self.secant(s_load))
        y = z_change * secant
        with np.errstate(divide="ignore"):
            total = 1.0 / np.hypot(x, y)
        for psi, face in zip(self.end, self.z_mm, strict=True):
            total = total + psi / np.hypot(x, (z + z_load - 2.0 * face) * secant)
        for psi, corner in zip(self.wedge, self.s_mm, strict=True):
            total = total + psi / np.hypot(np.abs(s - corner) + np.abs(s_load - corner), y)
        return np.asarray(total)


def flank_surface(body: Body, prism: Prism) -> FlankSurface:
    """The working flank of tooth 0, for its near field; raises SceneError as `edge_angles`."""
    ratio, twist = body.material.poisson_ratio, prism.twist
    low, high = (end_strength(angle, ratio) for angle in edge_angles(body, twist))

    def exact_slope(s: Floats) -> Floats:
        return -_turning(body, twist, s)[0]

    slope: Callable[[Floats], Floats] = exact_slope
    tip_secant = None
    if body.tip is not None:
        slope, tip_secant = _tabled_turning(body, twist)
    return FlankSurface(
        s_mm=body.mode_range_mm,
        z_mm=prism.range_mm,
        cos_base_helix=float(1.0 / np.hypot(1.0, twist * body.normal_lever_mm)),
        slope=slope,
        end=(low, high),
        wedge=image_strengths(body),
        wedge_along=along_strengths(body),
        tip=body.tip,
        tip_secant=tip_secant,
    )


def _turning(body: Body, twist: float, s: Floats) -> tuple[Floats, Floats]:
    """Twist times P x t and P . t, with the profile's tangent t, at arc lengths."""
    if not twist:
        return np.zeros_like(s), np.zeros_like(s)
    places = np.ravel(s)
    point, first, _ = body.curve.derivatives(places)
    (x, y), (t_x, t_y) = point.T, (first / np.linalg.norm(first, axis=1, keepdims=True)).T
    across, along = twist * (x * t_y - y * t_x), twist * (x * t_x + y * t_y)
    return across.reshape(np.shape(s)), along.reshape(np.shape(s))


def _tabled_turning(
    body: Body, twist: float
) -> tuple[Callable[[Floats], Floats], Callable[[Floats], Floats]]:
    """ds/dz along the straight line and 1/cos(beta) by interpolation, for a flank with a tip."""
    assert body.tip is not None
    inside = np.linspace(1e-9, 1.0 - 1e-9, TABLE)
    low, high = body.mode_range_mm
    ends = np.array([low, high, body.tip.end_mm])
    s = np.concatenate([one + (two - one) * inside for one, two in pairwise(ends)])
    across, along = _turning(body, twist, s)

    def slope(places: Floats) -> Floats:
        return np.interp(places, s, -across)

    def secant(places: Floats) -> Floats:
        return np.interp(places, s, np.hypot(1.0, along))

    return slope, secant


def end_strength(angle_deg: float, poisson_ratio: float) -> float:
    """Strength psi of the image behind an end face at an interior angle to the flank."""
    at_right_angle, at_steel = np.interp([poisson_ratio, STEEL_RATIO], *RIGHT_ANGLE)
    by_angle = AT_STEEL * np.exp(-DECAY_PER_DEGREE * (angle_deg - 90.0))
    return float(by_angle * at_right_angle / at_steel)


def edge_angles(body: Body, twist: float) -> tuple[float, float]:
    """Interior angles between the flank and the low and high end face, degrees.

    90 +- asin(n.e) with the outward normal e of the end face and n.e = -+ kappa l cos(beta_b),
    where l is the lever arm of the transverse normal in the middle of the flank, tan(beta_b) =
    |kappa l|, and `twist` is kappa, rad/mm.

    Raises
    ------
    SceneError
        If an angle is less than 50 degrees.
    """
    leaning = float(np.degrees(np.arctan(-twist * body.normal_lever_mm)))
    angles = 90.0 - leaning, 90.0 + leaning
    if min(angles) < LEAST_ANGLE:
        raise SceneError(
            key="helix_angle_deg",
            expected=f"at least {LEAST_ANGLE:g} degrees between flank and end face",
            found=f"{min(angles):.3g} degrees",
        )
    return angles


def unit_gauss(points: int) -> tuple[Floats, Floats]:
    """Gauss rule on [0, 1]."""
    at, weights = leggauss(points)
    return 0.5 + 0.5 * at, 0.5 * weights
