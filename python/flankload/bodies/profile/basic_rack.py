"""The basic rack (DIN 867, ISO 53) and the root fillet that it generates (DIN 3960).

Rack coordinates: xi outwards from the gear's reference circle, eta along its tangent from the
centre of the gear's tooth. At the roll angle phi, the point (xi, eta) of the rack has the position
in the frame of the gear

    P = (r + xi) e_r(phi) + (eta - r phi) e_theta(phi).

The normal at a contact point passes through the pitch point (0, r phi): the tip rounding, at its
normal -(sin beta, cos beta), touches at phi(beta) = (eta_c - xi_c cot beta)/r.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from math import atan, cos, pi, radians, sin, tan
from typing import TYPE_CHECKING

import numpy as np

from flankload.base.rotation import directions
from flankload.bodies.plane import across
from flankload.errors import SceneError
from flankload.scene.form import fields_of
from flankload.scene.refusal import refuse

if TYPE_CHECKING:
    from flankload.base.arrays import Floats
    from flankload.scene import SplineShaft
    from flankload.scene.involute import Geometry


@dataclass(frozen=True)
class BasicRack:
    """The tip rounding of the generating rack and its position relative to a gear.

    Attributes
    ----------
    reference_radius_mm : float
        r, radius of the circle that rolls on the rack's pitch line.
    pressure_angle_rad : float
    center_mm : (float, float)
        Centre (xi_c, eta_c) of the tip rounding.
    tip_radius_mm : float
        Radius of the rounding.
    protuberance_angle_rad : float or None
        Pressure angle of a protuberance flank, in the normal section; None without protuberance.
    """

    reference_radius_mm: float
    pressure_angle_rad: float
    center_mm: tuple[float, float]
    tip_radius_mm: float
    protuberance_angle_rad: float | None = field(default=None, kw_only=True)

    @property
    def root_radius_mm(self) -> float:
        """Radius of the gear's root circle, mm."""
        return self.reference_radius_mm + self.center_mm[0] - self.tip_radius_mm

    @property
    def flank_angle_rad(self) -> float:
        """Parameter beta at which the fillet meets the involute."""
        return self.pressure_angle_rad

    @property
    def root_half_angle_rad(self) -> float:
        """Polar angle at which the fillet meets the root circle."""
        return self.center_mm[1] / self.reference_radius_mm

    @property
    def end_angle_rad(self) -> float:
        """Parameter beta at which the rounding ends: at the flank, or at its protuberance."""
        angle = self.protuberance_angle_rad
        return self.flank_angle_rad if angle is None else angle

    def protuberance_flank(self) -> tuple[float, float]:
        """Base radius, mm, and base half angle, rad, of the involute of the protuberance flank."""
        assert self.protuberance_angle_rad is not None
        slant = tan(self.protuberance_angle_rad) / self.section_cosine
        normal = self.tip_radius_mm / cos(self.protuberance_angle_rad) / self.section_cosine
        angle = atan(slant)
        # thickness on the pitch line: eta = eta_c + xi_c tan(a) - rho/cos(a)
        half = self.center_mm[1] + self.center_mm[0] * slant - normal
        return (
            self.reference_radius_mm * cos(angle),
            half / self.reference_radius_mm + tan(angle) - angle,
        )

    @property
    def section_cosine(self) -> float:
        """Cosine of the helix angle: 1 for a spur gear."""
        return 1.0

    def roll_of_form_point(self, base_half_angle_rad: float) -> float:
        """Roll parameter of the involute where the fillet touches it; negative: undercut."""
        angle = self.pressure_angle_rad
        phi = (self.center_mm[1] - self.center_mm[0] / tan(angle)) / self.reference_radius_mm
        return base_half_angle_rad + angle - phi

    def slope(self, beta: Floats) -> Floats:
        """Arc length of the fillet per beta, mm/rad; the fillet has a cusp unless it is > 0."""
        xi, _ = self.center_mm
        sine = np.sin(beta)
        r, rho = self.reference_radius_mm, self.tip_radius_mm
        return xi**2 / (r * sine**3) + rho - rho * xi / (r * sine**2)

    def fillet(self, beta: Floats) -> tuple[Floats, Floats, Floats]:
        """Points (m, 2) of the fillet at beta (m,), mm, and their first two derivatives.

        beta runs from pi/2 (root circle) to the pressure angle (start of the involute).
        """
        beta = np.atleast_1d(np.asarray(beta, dtype=float))
        xi, eta = self.center_mm
        r, rho = self.reference_radius_mm, self.tip_radius_mm
        sine, cosine = np.sin(beta), np.cos(beta)
        phi = (eta - xi * cosine / sine) / r
        phi_1 = xi / (r * sine**2)
        radial = directions(phi)
        sideways = across(radial)
        outward = sine[:, None] * radial + cosine[:, None] * sideways
        downward = -cosine[:, None] * radial + sine[:, None] * sideways
        place = (r + xi - rho * sine)[:, None] * radial
        place = place + (xi * cosine / sine - rho * cosine)[:, None] * sideways
        slope = self.slope(beta)
        slope_1 = (-3 * xi**2 / (r * sine**4) + 2 * rho * xi / (r * sine**3)) * cosine
        # d downward = (1 - phi') outward
        first = slope[:, None] * downward
        second = slope_1[:, None] * downward + (slope * (1 - phi_1))[:, None] * outward
        return place, first, second


@dataclass(frozen=True)
class HelicalRack(BasicRack):
    """The rack of a helical gear in the transverse section, where its tip rounding is an ellipse.

    The ellipse has the half-axes rho in height and rho/cos(helix) along the pitch line; its point
    at the parameter beta is that of the normal section at the normal -(sin beta, cos beta).

    Attributes
    ----------
    helix_cosine : float
        Cosine of the helix angle on the reference circle.
    """

    helix_cosine: float

    @property
    def section_cosine(self) -> float:
        """Cosine of the helix angle on the reference circle."""
        return self.helix_cosine

    @property
    def flank_angle_rad(self) -> float:
        """Parameter beta at which the fillet meets the involute: the normal pressure angle."""
        return atan(self.helix_cosine * tan(self.pressure_angle_rad))

    def _roll(self, beta: Floats) -> tuple[Floats, Floats, Floats]:
        """Roll angle phi at beta and its first two derivatives."""
        c, rho = self.helix_cosine, self.tip_radius_mm
        xi, eta = self.center_mm
        sine, cosine = np.sin(beta), np.cos(beta)
        slack = rho * (1.0 / c - c)
        phi = eta - slack * cosine - c * xi * cosine / sine
        phi_1 = slack * sine + c * xi / sine**2
        phi_2 = slack * cosine - 2 * c * xi * cosine / sine**3
        r = self.reference_radius_mm
        return phi / r, phi_1 / r, phi_2 / r

    def roll_of_form_point(self, base_half_angle_rad: float) -> float:
        """Roll parameter of the involute where the fillet touches it; negative: undercut."""
        phi = float(self._roll(np.array([self.flank_angle_rad]))[0][0])
        return base_half_angle_rad + self.pressure_angle_rad - phi

    def slope(self, beta: Floats) -> Floats:
        """Length of the fillet per beta, mm/rad; the fillet has a cusp if it is not positive."""
        _, first, _ = self.fillet(beta)
        phi = self._roll(np.asarray(beta, dtype=float))[0]
        # unit tangent, perpendicular to the normal of the ellipse
        turn = phi - np.arctan2(np.sin(beta), self.helix_cosine * np.cos(beta))
        return np.asarray(-first[:, 0] * np.cos(turn) - first[:, 1] * np.sin(turn))

    def fillet(self, beta: Floats) -> tuple[Floats, Floats, Floats]:
        """Points (m, 2) of the fillet at beta (m,), mm, and their first two derivatives.

        beta runs from pi/2 (root circle) to the normal pressure angle (start of the involute).
        """
        beta = np.atleast_1d(np.asarray(beta, dtype=float))
        c, rho, center = self.helix_cosine, self.tip_radius_mm, self.center_mm[0]
        sine, cosine = np.sin(beta), np.cos(beta)
        phi, phi_1, phi_2 = self._roll(beta)
        xi, xi_1, xi_2 = center - rho * sine, -rho * cosine, rho * sine
        eta_1, eta_2 = rho / c * sine, rho / c * cosine
        # distance from the pitch point along the pitch line, eta - r phi
        off = c * xi * cosine / sine
        off_1 = c * (xi_1 * cosine / sine - xi / sine**2)
        # components along e_r(phi) and e_theta(phi)
        first = (xi_1 - phi_1 * off, eta_1 + phi_1 * xi)
        second = (
            xi_2 - phi_2 * off - phi_1 * off_1 - phi_1 * first[1],
            eta_2 + phi_2 * xi + phi_1 * xi_1 + phi_1 * first[0],
        )
        radial = directions(phi)
        sideways = across(radial)

        def placed(parts: tuple[Floats, Floats]) -> Floats:
            return np.asarray(parts[0][:, None] * radial + parts[1][:, None] * sideways)

        return placed((self.reference_radius_mm + xi, off)), placed(first), placed(second)


def basic_rack(
    spec: Geometry | SplineShaft, teeth: int, profile_shift: float, key: str
) -> BasicRack:
    """The generating rack of a gear, checked, with the generating profile shift in modules.

    Raises
    ------
    SceneError
        If the rack is pointed, its rounding does not fit, or no gear remains.
    """
    pressure_angle, module_mm = radians(spec.pressure_angle_deg), spec.module_mm
    dedendum_factor = spec.dedendum_factor
    _check_tip(spec, key)
    slant = tan(pressure_angle)
    rounding = spec.fillet_radius_factor * module_mm
    xi = -(dedendum_factor - profile_shift) * module_mm + rounding
    half_thickness = module_mm * (0.25 * pi + profile_shift * slant)
    eta = half_thickness - xi * slant + rounding / cos(pressure_angle)
    freed, angle_free = _protuberance(spec)
    eta -= freed / cos(pressure_angle)
    free = {"protuberance_angle_rad": angle_free}
    rack = BasicRack(0.5 * teeth * module_mm, pressure_angle, (xi, eta), rounding, **free)
    c = cos(spec.helix_rad)
    if spec.helix_rad:
        radius, angle = 0.5 * teeth * module_mm / c, atan(slant / c)
        rack = HelicalRack(radius, angle, (xi, eta / c), rounding, helix_cosine=c, **free)
    if rack.root_radius_mm <= 0.0:
        expected = f"less than {0.5 * teeth / c + profile_shift:.4f}, which leaves no root "
        expected += "circle"
        refuse(f"{key}.dedendum_factor", expected, f"{dedendum_factor:g}")
    if not rack.slope(np.linspace(rack.end_angle_rad, 0.5 * pi, 200)).min() > 0.0:
        raise SceneError(
            key=f"{key}.profile_shift",
            expected="a profile shift at which the rack's tip generates a fillet without a cusp",
            found=f"{profile_shift:g} with dedendum_factor {dedendum_factor:g}",
        )
    return rack


def _protuberance(spec: Geometry | SplineShaft) -> tuple[float, float | None]:
    """Depth below the finished flank, mm, and pressure angle, rad, of a protuberance."""
    amount = getattr(spec, "protuberance_mm", None)  # splines have none
    if amount is None:
        return 0.0, None
    stock, angle = (getattr(spec, n) for n in ("grinding_stock_mm", "protuberance_angle_deg"))
    return amount - stock, radians(angle)


def _check_tip(spec: Geometry | SplineShaft, key: str) -> None:
    """Check that the rack is not pointed and that its tip rounding fits."""
    angle, dedendum_factor = radians(spec.pressure_angle_deg), spec.dedendum_factor
    slant = tan(angle)
    half_land = 0.25 * pi - dedendum_factor * slant
    if half_land <= 0.0:
        expected = f"less than {0.25 * pi / slant:.4f}, where the rack of this pressure angle "
        expected += "is pointed"
        refuse(f"{key}.dedendum_factor", expected, f"{dedendum_factor:g}")
    largest = half_land * cos(angle) / (1.0 - sin(angle))
    name, factor = "fillet_radius_factor", spec.fillet_radius_factor
    if factor > largest:
        expected = f"at most {largest:.6f}, the full rounding of a rack with this dedendum and "
        expected += f"pressure angle ({spec.pressure_angle_deg:g} deg)"
        default = ", the default" if factor == fields_of(type(spec))[name].default else ""
        refuse(f"{key}.{name}", expected, f"{factor:g}{default}")
