"""Deviation of a flank from its involute over the roll length, as in a profile diagram."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from flankload.base.arrays import Floats
    from flankload.bodies.body import Body
    from flankload.bodies.profile.involute import Involute


#: Number of points in each interval of the curve.
PLACES = 8

#: Names of features at the start of an interval of the curve, by its label.
MARKS = {"relief": "relief", "tip_radius": "tip rounding", "tip_chamfer": "tip chamfer"}


@dataclass(frozen=True)
class ProfileDeviation:
    """Deviation of a flank from its involute.

    Attributes
    ----------
    roll_length_mm : (m,) array
        Length of the involute's normal from the base circle, ascending (for a ring from tip to
        root).
    deviation_um : (m,) array
        Deviation along that normal; negative where material is missing.
    base_radius_mm : float
    marks : tuple of (str, float)
        Features and their roll lengths, mm: form circle, reliefs, tip rounding or chamfer, tip
        circle.
    """

    roll_length_mm: Floats
    deviation_um: Floats
    base_radius_mm: float
    marks: tuple[tuple[str, float], ...]


def deviation_at(involute: Involute, places: Floats) -> tuple[Floats, Floats]:
    """Roll length and deviation (m,) of points (m, 2) near an involute, mm.

    The normal of the involute at the roll parameter t is r_b e_r(a) + l e_theta(a) with a = th0 - t
    and l = r_b t, the roll length, on the involute. The deviation is the distance along the normal,
    positive for extra material. Points are not inside the base circle.
    """
    base = involute.base_radius_mm
    reach = np.sqrt(np.maximum(np.sum(places**2, axis=1) - base**2, 0.0))
    polar = np.arctan2(places[:, 1], places[:, 0]) - involute.turn_rad
    polar = (polar + np.pi) % (2 * np.pi) - np.pi
    roll_length = base * (involute.base_half_angle_rad - polar + np.arctan(reach / base))
    # the material of a ring is on the other side of its involute
    return roll_length, involute.outward * (reach - roll_length)


def profile_deviation(body: Body) -> ProfileDeviation | None:
    """Deviation of a body's active flank; None without an involute."""
    involute, curve = body.involute, body.curve
    if involute is None:
        return None
    low, high = body.mode_range_mm
    breaks = np.unique(np.clip(curve.breaks, low, high))
    parts = np.arange(PLACES) / PLACES
    s = np.append((breaks[:-1, None] + np.diff(breaks)[:, None] * parts).ravel(), breaks[-1])
    roll_length, deviation = deviation_at(involute, curve.point(s))
    marks = [("form", _roll_length(involute, involute.form_radius_mm))]
    for k in range(1, len(curve.labels)):
        before, behind = curve.labels[k - 1], curve.labels[k]
        name = "root relief" if before == "root_relief" else MARKS.get(behind)
        if before != behind and name is not None:
            place = curve.point(curve.breaks[k : k + 1])
            marks.append((name, float(deviation_at(involute, place)[0][0])))
    marks.append(("tip", _roll_length(involute, involute.tip_radius_mm)))
    order = slice(None, None, involute.outward)
    return ProfileDeviation(
        roll_length[order], 1000.0 * deviation[order], involute.base_radius_mm, tuple(marks)
    )


def _roll_length(involute: Involute, radius: float) -> float:
    return involute.base_radius_mm * involute.roll_at(radius)
