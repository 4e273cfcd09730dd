"""The working flank of a prism between the ends of its modes, as its near field sees it.

Beside a free end a flank is more compliant than a half-space. The near field of a load has a mirror
image behind the end, psi times as strong. The strengths were measured on finite elements: at an
edge of 90 degrees by Poisson's ratio, and at nu = 0.3 by the angle.
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

#: psi at a right angle, measured, by Poisson's ratio.
RIGHT_ANGLE = ((0.0, 0.2, 0.3, 0.4, 0.45), (0.94, 1.13, 1.30, 1.53, 1.69))
#: 1.33 exp(-0.062 (angle - 90)), fitted at nu = 0.3 to angles from 57 degrees on.
AT_STEEL, STEEL_RATIO, DECAY_PER_DEGREE = 1.33, 0.3, 0.062
#: Sharper edges were not measured: the image leaves 3.4 % at 57 degrees, and more below.
LEAST_ANGLE = 50.0
#: Gauss points beside those that the degrees of the modes need: in the directions in which 1/R is
#: smooth without being a polynomial. Twice as many change the projections by less than 1e-6.
DIRECTION_POINTS = 16
#: Places of a table of directions on flank and tip each: 1e-7 of them between places.
TABLE = 2000


@dataclass(frozen=True, eq=False)
class FlankSurface:
    """Flank of a prism between the ends of its modes, unrolled, and its images.

    Attributes
    ----------
    s_mm, z_mm : (float, float)
        Ranges of arc length and along the axis.
    cos_base_helix : float
        cos(beta_b).
    slope : callable
        Arc lengths to ds/dz along the straight line through the place, of the same shape.
    end : (float, float)
        Strengths psi of the images behind the end faces at low and high z.
    wedge : (float, float)
        The same behind free corners at low and high s.
    wedge_along : (float, float)
        Strengths psi_nt behind free corners of a force along the profile.
    tip : Tip or None
        Rounding or chamfer behind the flank; the last two modes are its own.
    tip_secant : callable or None
        Arc lengths on the tip to 1/cos(beta) there, of the same shape.
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
        """Arc lengths where the flank begins and ends, and where its tip does."""
        return self.s_mm if self.tip is None else (*self.s_mm, self.tip.end_mm)

    @property
    def length_mm(self) -> float:
        """Along the profile, the tip included."""
        return self.pieces_mm[-1] - self.pieces_mm[0]

    @property
    def width_mm(self) -> float:
        """Along the axis."""
        return self.z_mm[1] - self.z_mm[0]

    def secant(self, s: Floats) -> Floats:
        """1/cos(beta): area elements are this times ds dz."""
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
        """Near field of point loads over k; 1/mm, infinite at the load itself.

        Parameters
        ----------
        s, z, s_load, z_load : arrays that broadcast
            Places, mm.
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
    """The working flank of tooth 0 as its near field sees it.

    Raises SceneError if an edge between flank and end face is sharper than 50 degrees.
    """
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
    """Twist times the levers P x t and P . t of the profile's tangent t at arc lengths."""
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
    """ds/dz along the straight line and 1/cos(beta) from tables: a tip takes many places."""
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
    """Strength psi of the image behind a free end at an angle to the flank, inside the metal."""
    at_right_angle, at_steel = np.interp([poisson_ratio, STEEL_RATIO], *RIGHT_ANGLE)
    by_angle = AT_STEEL * np.exp(-DECAY_PER_DEGREE * (angle_deg - 90.0))
    return float(by_angle * at_right_angle / at_steel)


def edge_angles(body: Body, twist: float) -> tuple[float, float]:
    """Angles of the metal between the flank and the low and high end face, degrees.

    They are 90 +- asin(n.e) with e the direction out of the end: obtuse where the flank's normal
    leans out of it. n.e = -+ kappa l cos(beta_b), l the lever of the transverse normal about the
    axis, in the middle of the flank; tan(beta_b) = |kappa l|. `twist` is kappa, rad/mm.

    Raises
    ------
    SceneError
        Below 50 degrees.
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
    """Gauss's rule on [0, 1]."""
    at, weights = leggauss(points)
    return 0.5 + 0.5 * at, 0.5 * weights
