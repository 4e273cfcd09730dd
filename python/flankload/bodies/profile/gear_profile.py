"""The profile of a gear: generated root fillet, involute with its modifications, tip.

The tooth's centre line is the body's +x axis; the working flank is at positive polar angles.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import atan2, cos, hypot, pi, radians, sqrt, tan
from typing import TYPE_CHECKING, NoReturn

import numpy as np

from flankload.bodies.bisection import sign_change
from flankload.bodies.profile.basic_rack import BasicRack, basic_rack
from flankload.bodies.profile.gear_tip import (
    FormPoint,
    following_fillet,
    modifications_of,
    profile_curve,
)
from flankload.bodies.profile.involute import (
    Involute,
    InvoluteFlank,
    Modifications,
    involute_function,
    roll_of_involute_angle,
)
from flankload.bodies.profile.tooth_thickness import generating_shift
from flankload.errors import SceneError
from flankload.flank import ACTIVE, CurvePiece, FlankCurve, Place

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from flankload.bodies.profile.gear_tip import GearGeometry

    Floats = NDArray[np.float64]

#: Least roll parameter at which an involute begins: its curvature is infinite on the base circle.
#: The omitted piece is r_b t²/2 long, below 1e-9 mm for r_b < 200 mm.
LEAST_ROLL = 3e-6
#: Places of a fillet among which the deepest one below the involute is sought.
FOOT_PLACES = 200


@dataclass(frozen=True)
class GearProfile:
    """Profile of a gear's tooth.

    Attributes
    ----------
    curve : FlankCurve
        The working flank: fillet from the root circle, flank, tip.
    involute : Involute
        Radii and angles.
    teeth : int
    mode_range_mm : (float, float)
        Arc lengths of the active flank, on which pressure modes are defined; without fillet and
        tip rounding, where the normal turns and few modes could not represent the pressure.
    root_half_angle_rad : float
        Polar angle at which the fillet meets the root circle.
    """

    curve: FlankCurve
    involute: Involute
    teeth: int
    mode_range_mm: tuple[float, float]
    root_half_angle_rad: float

    @property
    def root_radius_mm(self) -> float:
        """Radius of the root circle, mm."""
        return self.involute.root_radius_mm

    @property
    def tip_radius_mm(self) -> float:
        """Radius of the tip circle, mm."""
        return self.involute.tip_radius_mm

    def rotated(self, angle: float) -> GearProfile:
        """Return the profile rotated counter-clockwise about the axis by an angle in rad."""
        turn = self.involute.turn_rad + angle
        return replace(
            self, curve=self.curve.rotated(angle), involute=replace(self.involute, turn_rad=turn)
        )

    def outline(self) -> Floats:
        """Outer contour (k, 2) of one sector from cut to cut, counter-clockwise, mm."""
        s = np.concatenate(
            [
                start + (end - start) * np.arange(4) / 4
                for start, end in zip(self.curve.breaks[:-1], self.curve.breaks[1:], strict=True)
            ]
        )
        flank = self.curve.rotated(-self.involute.turn_rad).point(
            np.append(s, self.curve.breaks[-1])
        )
        radius, tip_radius = self.involute.root_radius_mm, self.involute.tip_radius_mm
        tip = _arc(tip_radius, 0.0, atan2(flank[-1, 1], flank[-1, 0]), 5)[:-1]
        root = _arc(radius, self.root_half_angle_rad, pi / self.teeth, 5)[1:]
        half = np.concatenate([tip, flank[::-1], root])
        whole = np.concatenate([half[:0:-1] * [1.0, -1.0], half])
        c, s_ = np.cos(self.involute.turn_rad), np.sin(self.involute.turn_rad)
        return whole @ np.array([[c, s_], [-s_, c]])


def _arc(radius: float, start: float, end: float, n: int) -> Floats:
    angle = np.linspace(start, end, n)
    return radius * np.stack([np.cos(angle), np.sin(angle)], axis=1)


def gear_profile(spec: GearGeometry, key: str, *, teeth: int | None = None) -> GearProfile:
    """Profile of a gear.

    Parameters
    ----------
    spec : GearGeometry
        Keys of a gear, or of the profile of a mesh.
    key : str
        Dotted path of these keys in the scene, for messages.
    teeth : int, optional
        Number of teeth; default: `spec.teeth`.

    Returns
    -------
    GearProfile

    Raises
    ------
    SceneError
        If the gear is impossible; names the key.
    """
    z = int(teeth if teeth is not None else getattr(spec, "teeth", 0) or 0)
    if z < 3:
        raise SceneError(key=f"{key}.teeth", expected="at least 3 teeth", found=f"{z}")
    normal_angle = radians(spec.pressure_angle_deg)
    shift = generating_shift(spec, z, key, helix_rad=spec.helix_rad)
    rack = basic_rack(
        teeth=z,
        module_mm=spec.module_mm,
        pressure_angle_rad=normal_angle,
        profile_shift=shift,
        dedendum_factor=spec.dedendum_factor,
        fillet_radius_factor=spec.fillet_radius_factor,
        key=key,
        helix_angle_rad=spec.helix_rad,
        protuberance=_protuberance(spec),
    )
    base_radius = rack.reference_radius_mm * cos(rack.pressure_angle_rad)
    base_half_angle = (0.5 * pi + 2 * shift * tan(normal_angle)) / z
    base_half_angle += involute_function(rack.pressure_angle_rad)
    plain = InvoluteFlank(base_radius, base_half_angle, Modifications.none())
    start = _form_point(rack, plain, key)
    involute = Involute(
        base_radius_mm=base_radius,
        reference_radius_mm=rack.reference_radius_mm,
        root_radius_mm=rack.root_radius_mm,
        form_radius_mm=base_radius * hypot(1.0, start.roll),
        tip_radius_mm=0.5 * spec.tip_diameter_mm,
        base_half_angle_rad=base_half_angle,
    )
    _check_tooth(involute, rack, start, spec, key)
    flank = replace(plain, modifications=modifications_of(spec, involute, start.roll, key))
    curve = profile_curve(
        lambda flank: _fillet_pieces(rack, flank, start), flank, involute, start, spec, key
    )
    return GearProfile(
        curve=curve,
        involute=involute,
        teeth=z,
        mode_range_mm=curve.range_of(*ACTIVE),
        root_half_angle_rad=rack.root_half_angle_rad,
    )


def _protuberance(spec: GearGeometry) -> tuple[float, float] | None:
    """Depth below the finished flank, mm, and pressure angle, rad, of a protuberance."""
    amount = getattr(spec, "protuberance_mm", None)  # splines have none
    if amount is None:
        return None
    stock, angle = (getattr(spec, n) for n in ("grinding_stock_mm", "protuberance_angle_deg"))
    return amount - stock, radians(angle)


def _form_point(rack: BasicRack, flank: InvoluteFlank, key: str) -> FormPoint:
    """End of the fillet: it touches the involute there, or cuts it (undercut, protuberance)."""
    angle, low = rack.end_angle_rad, 0.5 * pi
    free = rack.protuberance_angle_rad is not None
    roll = rack.roll_of_form_point(flank.base_half_angle_rad)
    if roll > -LEAST_ROLL and not free:
        return FormPoint(max(roll, LEAST_ROLL), angle, False)

    def place(beta: float) -> tuple[float, float]:
        x, y = rack.fillet(np.array([beta]))[0][0]
        return hypot(x, y), atan2(y, x)

    def metal_left(beta: float) -> float:
        radius, polar = place(beta)
        return polar - flank.polar_angle_at(radius)

    if free and metal_left(angle) < 0.0:
        return _on_protuberance(rack, flank, place(angle)[0], key)
    # the radius grows as beta falls; below the base circle there is no involute
    if place(low)[0] < flank.base_radius_mm:
        low = sign_change(lambda beta: place(beta)[0] - flank.base_radius_mm, angle, low)
    if free:
        # the fillet leaves the tooth at its foot, and cuts the involute above its deepest place
        between = [rack.flank_angle_rad, *np.linspace(angle, low, FOOT_PLACES)[1:-1]]
        low = float(min((beta for beta in between if beta < low), key=metal_left))
        if metal_left(low) >= 0.0:
            _refuse_protuberance(key, "a protuberance that cuts into the involute")
    beta = sign_change(metal_left, angle, low)
    return FormPoint(max(flank.roll_at(place(beta)[0]), LEAST_ROLL), beta, True)


def _on_protuberance(rack: BasicRack, flank: InvoluteFlank, low: float, key: str) -> FormPoint:
    """End of the fillet on the involute of the protuberance flank, above a radius."""
    free = InvoluteFlank(*rack.protuberance_flank(), Modifications.none())

    def metal_left(radius: float) -> float:
        return free.polar_angle_at(radius) - flank.polar_angle_at(radius)

    high = 2.0 * rack.reference_radius_mm
    if low < free.base_radius_mm or metal_left(high) <= 0.0:
        _refuse_protuberance(key, "a protuberance whose flank ends on the involute")
    radius = sign_change(metal_left, low, high)
    return FormPoint(flank.roll_at(radius), free.roll_at(radius), True, free)


def _refuse_protuberance(key: str, expected: str) -> NoReturn:
    raise SceneError(
        key=f"{key}.protuberance_mm",
        expected=expected,
        found="one that does not, with this angle and tip radius",
    )


def _fillet_pieces(rack: BasicRack, flank: InvoluteFlank, start: FormPoint) -> list[CurvePiece]:
    """The fillet, from the root circle to the flank."""
    end = start.beta if start.free is None else rack.end_angle_rad
    parts: list[tuple[Place, float, float]] = [(rack.fillet, 0.5 * pi, end)]
    if start.free is not None:
        x, y = rack.fillet(np.array([end]))[0][0]
        parts.append((start.free.place, start.free.roll_at(hypot(x, y)), start.beta))
    if flank.modifications.crowning_mm or flank.modifications.root_relief_mm:
        place, first, last = parts[-1]
        moved = flank.point(start.roll) - place(np.array([last]))[0][0]
        parts[-1] = (following_fillet(place, first, last, moved), first, last)
    return [CurvePiece("fillet", *part) for part in parts]


def _check_tooth(
    involute: Involute, rack: BasicRack, start: FormPoint, spec: GearGeometry, key: str
) -> None:
    """Check that the tooth has a flank and a foot and is not pointed."""
    if involute.base_half_angle_rad <= 0.0:
        raise SceneError(
            key=f"{key}.profile_shift",
            expected="a profile shift that leaves the tooth some thickness at its base circle",
            found=f"{spec.profile_shift:g}",
        )
    end = start.beta if start.free is None else rack.end_angle_rad
    foot = rack.fillet(np.linspace(0.5 * pi, end, 200))[0]
    if foot[:, 1].min() <= 0.0:
        raise SceneError(
            key=f"{key}.profile_shift",
            expected="a profile shift at which the rack does not cut the tooth off its foot",
            found=f"{spec.profile_shift:g}",
        )
    if involute.tip_radius_mm <= involute.form_radius_mm:
        raise SceneError(
            key=f"{key}.tip_diameter_mm",
            expected=f"more than the form diameter {2 * involute.form_radius_mm:.4f}, where the "
            "involute begins",
            found=f"{spec.tip_diameter_mm:g}",
        )
    if involute.half_angle_at(involute.tip_radius_mm) <= 0.0:
        roll = roll_of_involute_angle(involute.base_half_angle_rad)
        largest = 2 * involute.base_radius_mm * sqrt(1.0 + roll**2)
        raise SceneError(
            key=f"{key}.tip_diameter_mm",
            expected=f"less than {largest:.4f}, where the teeth are pointed",
            found=f"{spec.tip_diameter_mm:g}",
        )
