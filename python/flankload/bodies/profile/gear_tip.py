"""The flank of a gear or ring from form circle to tip: modifications, tip rounding or chamfer."""

from __future__ import annotations

from dataclasses import replace
from math import atan2, cos, pi, sin, sqrt
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from flankload.bodies.bisection import sign_change
from flankload.bodies.plane import circle, line
from flankload.bodies.profile.involute import Involute, InvoluteFlank, Modifications
from flankload.errors import SceneError
from flankload.flank import CurvePiece
from flankload.scene.refusal import refuse
from flankload.scene.table import RELIEF_EXPONENTS

if TYPE_CHECKING:
    from flankload.base.arrays import Floats
    from flankload.scene.involute import InvoluteKeys


class FormPoint(NamedTuple):
    """Point where fillet and involute meet.

    Attributes
    ----------
    roll : float
        Roll parameter of the involute.
    beta : float
        End of the fillet: angle of the rack's tip rounding, or of the arc in a ring.
    undercut : bool
        Fillet and involute meet in a corner instead of a common tangent.
    free : InvoluteFlank or None
        Involute of a protuberance flank, if the fillet ends on it; `beta` is then its roll
        parameter.
    """

    roll: float
    beta: float
    undercut: bool
    free: InvoluteFlank | None = None


def modifications_of(
    spec: InvoluteKeys, involute: Involute, form_roll: float, key: str
) -> Modifications:
    """Modifications of a profile, checked: places of reliefs, amount of material removed."""
    tip_roll = involute.roll_at(involute.tip_radius_mm)
    outward = involute.outward
    modifications = Modifications(
        tip_relief_mm=outward * (spec.tip_relief_um or 0.0) / 1000.0,
        relief_start=tip_roll,
        relief_exponent=RELIEF_EXPONENTS[spec.tip_relief_shape],
        crowning_mm=outward * (spec.profile_crowning_um or 0.0) / 1000.0,
        roll_form=form_roll,
        roll_tip=tip_roll,
        root_relief_mm=outward * (spec.root_relief_um or 0.0) / 1000.0,
        root_exponent=RELIEF_EXPONENTS[spec.root_relief_shape],
    )
    modifications = _with_places(modifications, spec, involute, key)
    _check_amounts(modifications, spec, involute.base_radius_mm, key)
    return modifications


def _with_places(
    modifications: Modifications, spec: InvoluteKeys, involute: Involute, key: str
) -> Modifications:
    """Modifications with the places of their reliefs, checked for their order on the flank."""
    form, tip = involute.form_radius_mm, involute.tip_radius_mm
    places: dict[str, float] = {}
    low, said = form, f"the form diameter {2 * form:.4f}"
    wanted = [("root_start", "root_relief_start_diameter_mm")] if spec.root_relief_um else []
    if spec.tip_relief_um:
        wanted.append(("relief_start", "tip_relief_start_diameter_mm"))
        if spec.tip_relief_shape == "double_linear":
            wanted.append(("knee_roll", "tip_relief_knee_diameter_mm"))
    for name, place in wanted:
        diameter = getattr(spec, place) or 0.0
        inner, outer = sorted((low, tip))
        # tip and root relief may have the same start
        same = name == "relief_start" and 0.5 * diameter == low != form
        if not (inner < 0.5 * diameter < outer or same):
            expected = f"between {said} and the tip diameter {2 * tip:g}"
            refuse(f"{key}.{place}", expected, f"{diameter:g}")
        places[name] = involute.roll_at(0.5 * diameter)
        low, said = 0.5 * diameter, f"{key}.{place} ({diameter:g})"
    if "knee_roll" in places:
        places["knee_mm"] = involute.outward * (spec.tip_relief_knee_um or 0.0) / 1000.0
    return replace(modifications, **places)  # type: ignore[arg-type]


def _check_amounts(modifications: Modifications, spec: InvoluteKeys, base: float, key: str) -> None:
    """Check that the involute has the material removed, and that the flank does not turn back."""
    form_roll, tip_roll = modifications.roll_form, modifications.roll_tip
    roll = np.linspace(form_roll, tip_roll, 200)
    off, first, _ = modifications.at(roll)
    enough, onward = bool((base * roll - off > 0).all()), bool((first < base).all())
    if not (enough and onward):
        amounts = {
            "profile_crowning_um": spec.profile_crowning_um or 0.0,
            "tip_relief_um": spec.tip_relief_um or 0.0,
            "root_relief_um": spec.root_relief_um or 0.0,
        }
        name = max(amounts, key=lambda each: amounts[each])
        value = amounts[name]
        raise SceneError(
            key=f"{key}.{name}",
            expected=(
                "less material removed than the involute has above its base circle, "
                f"{1000 * base * form_roll:.3f} um at the form circle"
            )
            if not enough
            else "a less steep modification, with which the flank still leads from root to tip",
            found=f"{value:g}",
        )


def flank_and_tip(
    flank: InvoluteFlank, involute: Involute, start: FormPoint, spec: InvoluteKeys, key: str
) -> list[CurvePiece]:
    """Pieces from the form point to the tip circle, checked."""
    tip: list[CurvePiece] = []
    if spec.tip_radius_mm is not None:
        end, piece = _tip_rounding(flank, involute, start, spec.tip_radius_mm, key)
        tip = [piece]
    elif spec.tip_chamfer_mm is not None:
        end, piece = _tip_chamfer(flank, involute, spec.tip_chamfer_mm, key)
        tip = [piece]
    else:
        end = flank.roll_at(involute.tip_radius_mm)
        if not _inside_tooth(flank.point(end), involute):
            expected = "less, so that the modified flanks leave a tip"
            refuse(f"{key}.tip_diameter_mm", expected, f"{2 * involute.tip_radius_mm:g}")
    kink = flank.modifications.relief_start
    relieved = bool(flank.modifications.tip_relief_mm) and involute.outward * (end - kink) > 0.0
    first_end = kink if relieved else end
    pieces = _flank_pieces(flank, start, first_end, involute.outward)
    if relieved:
        pieces += _relief_pieces(flank, end, involute.outward)
    return [*pieces, *tip]


def _flank_pieces(
    flank: InvoluteFlank, start: FormPoint, end: float, outward: int
) -> list[CurvePiece]:
    """Pieces from the form point to the start of the tip relief.

    Each piece has no relief of the other pieces, so that slopes at kinks are one-sided.
    """
    modifications = flank.modifications
    below = replace(flank, modifications=replace(modifications, tip_relief_mm=0.0))
    if not modifications.root_relief_mm:
        return [CurvePiece("flank", below.place, start.roll, end, start.undercut)]
    plain = replace(flank, modifications=replace(below.modifications, root_relief_mm=0.0))
    kink, kinked = modifications.root_start, modifications.root_exponent == 1
    goes_on = outward * (end - kink) > 0.0
    upper = kink if goes_on else end
    pieces = [CurvePiece("root_relief", below.place, start.roll, upper, start.undercut)]
    if goes_on:
        pieces.append(CurvePiece("flank", plain.place, kink, end, kinked))
    return pieces


def _relief_pieces(flank: InvoluteFlank, end: float, outward: int) -> list[CurvePiece]:
    """Pieces of the tip relief, up to the tip or its rounding."""
    modifications = flank.modifications
    start, knee = modifications.relief_start, modifications.knee_roll
    flank = replace(flank, modifications=replace(modifications, root_relief_mm=0.0))
    first = replace(flank, modifications=flank.modifications.before_knee)
    kinked = modifications.relief_exponent == 1
    if knee is None or outward * (end - knee) <= 0.0:
        return [CurvePiece("relief", first.place, start, end, kinked)]
    return [
        CurvePiece("relief", first.place, start, knee, kinked),
        CurvePiece("relief", flank.place, knee, end, True),
    ]


def _inside_tooth(place: Floats, involute: Involute) -> bool:
    """Whether a point is on the working side of the centre line of its tooth."""
    angle = atan2(place[1], place[0]) - involute.tooth_center_rad
    return involute.outward * angle > 0.0


def _tip_rounding(
    flank: InvoluteFlank, involute: Involute, start: FormPoint, radius: float, key: str
) -> tuple[float, CurvePiece]:
    """Roll parameter at which the tip rounding begins, and its arc."""
    tip_radius, outward = involute.tip_radius_mm, involute.outward

    def center(roll: float, rounding: float) -> Floats:
        return flank.point(roll) - outward * rounding * flank.normal(roll)

    def touching(rounding: float) -> float:
        """Roll parameter at which an arc touches flank and tip circle; NaN if there is none."""

        def beyond(roll: float) -> float:
            distance = float(np.linalg.norm(center(roll, rounding)))
            return outward * (distance - tip_radius) + rounding

        end = flank.roll_at(tip_radius)
        if outward * rounding >= tip_radius or beyond(start.roll) >= 0.0:
            return float("nan")
        return sign_change(beyond, start.roll, end)

    roll = touching(radius)
    if not (roll == roll and _inside_tooth(center(roll, radius), involute)):
        low, high = 0.0, radius
        for _ in range(40):
            middle = 0.5 * (low + high)
            at = touching(middle)
            fits = at == at and _inside_tooth(center(at, middle), involute)
            low, high = (middle, high) if fits else (low, middle)
        expected = f"less than {low:.4f}, the largest rounding that fits on the tooth"
        refuse(f"{key}.tip_radius_mm", expected, f"{radius:g}")
    place, normal = center(roll, radius), flank.normal(roll)
    first, last = atan2(normal[1], normal[0]), atan2(place[1], place[0])
    return roll, CurvePiece("tip_radius", circle(place, outward * radius), first, last)


def _tip_chamfer(
    flank: InvoluteFlank, involute: Involute, height: float, key: str
) -> tuple[float, CurvePiece]:
    """Roll parameter at which the chamfer begins, `height` below the tip circle, and its line.

    Its direction bisects the angle between flank and tip circle.
    """
    tip_radius, outward = involute.tip_radius_mm, involute.outward
    low = tip_radius - outward * height
    on_flank = outward * (low - involute.form_radius_mm) > 0.0
    end = flank.roll_at(low if on_flank else involute.form_radius_mm)
    place = flank.point(end)
    normal = flank.normal(end)
    halved = 0.5 * (atan2(normal[1], normal[0]) + atan2(place[1], place[0])) - outward * 0.5 * pi
    direction = np.array([cos(halved), sin(halved)])
    along = float(place @ direction)
    reach = along**2 + tip_radius**2 - float(place @ place)
    length = -along + outward * sqrt(max(0.0, reach))
    if not (on_flank and reach > 0.0 and _inside_tooth(place + length * direction, involute)):
        largest = outward * (tip_radius - involute.form_radius_mm)
        width = tip_radius * involute.tooth_half_angle_at(tip_radius)
        expected = f"less than the height of the flank ({largest:.4f}) and about half the width "
        expected += f"of the tip ({width:.4f})"
        refuse(f"{key}.tip_chamfer_mm", expected, f"{height:g}")
    chamfer = line(place, direction)
    return end, CurvePiece("tip_chamfer", chamfer, 0.0, length, corner_before=True)
