"""A gear's flank from the form circle to the tip: modifications, tip rounding or chamfer."""

from __future__ import annotations

from math import atan2, cos, pi, sin, sqrt
from typing import TYPE_CHECKING, NamedTuple, Protocol

import numpy as np
from scipy.optimize import brentq

from flankload.bodies.involute import Involute, InvoluteFlank, Modifications
from flankload.errors import SceneError
from flankload.flank_curve import CurvePiece

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]


class GearGeometry(Protocol):
    """Keys of a gear's profile, as in the scene."""

    @property
    def module_mm(self) -> float: ...
    @property
    def pressure_angle_deg(self) -> float: ...
    @property
    def profile_shift(self) -> float: ...
    @property
    def tip_diameter_mm(self) -> float: ...
    @property
    def dedendum_factor(self) -> float: ...
    @property
    def fillet_radius_factor(self) -> float: ...
    @property
    def tip_relief_um(self) -> float | None: ...
    @property
    def tip_relief_start_diameter_mm(self) -> float | None: ...
    @property
    def tip_relief_shape(self) -> str: ...
    @property
    def tip_radius_mm(self) -> float | None: ...
    @property
    def tip_chamfer_mm(self) -> float | None: ...
    @property
    def profile_crowning_um(self) -> float | None: ...


class FormPoint(NamedTuple):
    """Where fillet and involute meet.

    Attributes
    ----------
    roll : float
        Roll of the involute.
    beta : float
        Angle of the rack's tip rounding.
    undercut : bool
        They cross in a corner instead of touching.
    """

    roll: float
    beta: float
    undercut: bool


def modifications_of(
    spec: GearGeometry, involute: Involute, form_roll: float, key: str
) -> Modifications:
    """Modifications that a gear asks for, checked.

    Raises
    ------
    SceneError
        If the relief begins outside the flank, or more metal is taken off than there is involute.
    """
    tip_roll = involute.roll_at(involute.tip_radius_mm)
    relief = (spec.tip_relief_um or 0.0) / 1000.0
    start = tip_roll
    if relief:
        diameter = spec.tip_relief_start_diameter_mm or 0.0
        if not involute.form_radius_mm < 0.5 * diameter < involute.tip_radius_mm:
            raise SceneError(
                key=f"{key}.tip_relief_start_diameter_mm",
                expected=f"between the form diameter {2 * involute.form_radius_mm:.4f} and the tip "
                f"diameter {2 * involute.tip_radius_mm:g}",
                found=f"{diameter:g}",
            )
        start = involute.roll_at(0.5 * diameter)
    modifications = Modifications(
        tip_relief_mm=relief,
        relief_start=start,
        relief_power=2 if spec.tip_relief_shape == "parabolic" else 1,
        crowning_mm=(spec.profile_crowning_um or 0.0) / 1000.0,
        roll_form=form_roll,
        roll_tip=tip_roll,
    )
    roll = np.linspace(form_roll, tip_roll, 200)
    off, first, _ = modifications.at(roll)
    base = involute.base_radius_mm
    enough, onward = bool((base * roll - off > 0).all()), bool((first < base).all())
    if not (enough and onward):
        name, value = (
            ("tip_relief_um", spec.tip_relief_um)
            if modifications.tip_relief_mm > modifications.crowning_mm
            else ("profile_crowning_um", spec.profile_crowning_um)
        )
        raise SceneError(
            key=f"{key}.{name}",
            expected="less metal taken off than the involute has above its base circle, "
            f"{1000 * base * form_roll:.3f} um at the form circle"
            if not enough
            else "a modification less steep than the flank is high, so that the flank goes on "
            "towards the tip",
            found=f"{value:g}",
        )
    return modifications


def flank_and_tip(
    flank: InvoluteFlank, involute: Involute, start: FormPoint, spec: GearGeometry, key: str
) -> list[CurvePiece]:
    """Pieces from the form point to the tip circle.

    Raises
    ------
    SceneError
        If tip rounding or chamfer do not fit on the tooth.
    """
    tip: list[CurvePiece] = []
    if spec.tip_radius_mm is not None:
        end, piece = _tip_rounding(flank, involute, start, spec.tip_radius_mm, key)
        tip = [piece]
    elif spec.tip_chamfer_mm is not None:
        end, piece = _tip_chamfer(flank, involute, spec.tip_chamfer_mm, key)
        tip = [piece]
    else:
        end = flank.roll_at(involute.tip_radius_mm)
        if flank.point(end)[1] <= 0.0:
            raise SceneError(
                key=f"{key}.tip_diameter_mm",
                expected="less, so that the modified flanks leave a tip",
                found=f"{2 * involute.tip_radius_mm:g}",
            )
    kink = flank.modifications.relief_start
    pieces = [CurvePiece("flank", flank.place, start.roll, min(kink, end), start.undercut)]
    if flank.modifications.tip_relief_mm and kink < end:
        pieces.append(CurvePiece("relief", flank.place, kink, end))
    elif kink < end:
        pieces[0] = pieces[0]._replace(u_end=end)
    return [*pieces, *tip]


def _tip_rounding(
    flank: InvoluteFlank, involute: Involute, start: FormPoint, radius: float, key: str
) -> tuple[float, CurvePiece]:
    """The arc that touches flank and tip circle: roll at which it leaves the flank, and the arc."""
    tip_radius = involute.tip_radius_mm

    def center(roll: float, rounding: float) -> Floats:
        return flank.point(roll) - rounding * flank.normal(roll)

    def touching(rounding: float) -> float:
        """Roll at which an arc of that radius touches both; NaN where there is none."""

        def beyond(roll: float) -> float:
            return float(np.linalg.norm(center(roll, rounding))) - (tip_radius - rounding)

        end = flank.roll_at(tip_radius)
        if rounding >= tip_radius or beyond(start.roll) >= 0.0:
            return float("nan")
        return float(brentq(beyond, start.roll, end, xtol=1e-15, rtol=1e-15))

    roll = touching(radius)
    if not (roll == roll and center(roll, radius)[1] > 0.0):
        low, high = 0.0, radius
        for _ in range(40):
            middle = 0.5 * (low + high)
            at = touching(middle)
            fits = at == at and center(at, middle)[1] > 0.0
            low, high = (middle, high) if fits else (low, middle)
        raise SceneError(
            key=f"{key}.tip_radius_mm",
            expected=f"less than {low:.4f}, the largest rounding that fits on the tooth",
            found=f"{radius:g}",
        )
    place = center(roll, radius)
    normal = flank.normal(roll)

    def arc(angle: Floats) -> tuple[Floats, Floats, Floats]:
        out = np.stack([np.cos(angle), np.sin(angle)], axis=1)
        along = np.stack([-out[:, 1], out[:, 0]], axis=1)
        return place + radius * out, radius * along, -radius * out

    first, last = atan2(normal[1], normal[0]), atan2(place[1], place[0])
    return roll, CurvePiece("tip_radius", arc, first, last)


def _tip_chamfer(
    flank: InvoluteFlank, involute: Involute, height: float, key: str
) -> tuple[float, CurvePiece]:
    """The chamfer: from the flank, that height below the tip circle, straight to the tip circle.

    Its direction halves the angle between flank and tip circle (45 degrees where that is right).
    """
    tip_radius = involute.tip_radius_mm
    low = tip_radius - height
    end = flank.roll_at(max(low, involute.form_radius_mm))
    place = flank.point(end)
    normal = flank.normal(end)
    halved = 0.5 * (atan2(normal[1], normal[0]) + atan2(place[1], place[0])) - 0.5 * pi
    direction = np.array([cos(halved), sin(halved)])
    along = float(place @ direction)
    length = -along + sqrt(along**2 + tip_radius**2 - float(place @ place))
    if low <= involute.form_radius_mm or (place + length * direction)[1] <= 0.0:
        largest = tip_radius - involute.form_radius_mm
        width = tip_radius * involute.half_angle_at(tip_radius)
        raise SceneError(
            key=f"{key}.tip_chamfer_mm",
            expected=f"less than the flank is high ({largest:.4f}) and about half the tip is wide "
            f"({width:.4f})",
            found=f"{height:g}",
        )

    def line(u: Floats) -> tuple[Floats, Floats, Floats]:
        ones = np.ones((u.size, 1))
        return place + u[:, None] * direction, ones * direction, 0.0 * ones * direction

    return end, CurvePiece("tip_chamfer", line, 0.0, length, corner_before=True)
