"""Working geometry of two involute bodies at their centre distance (DIN 3960), checked.

External and internal pairs have the same equations with a sense s = 1 (external teeth of body 2) or
-1 (internal teeth): radii of body 2 are multiplied by s, and a circle of radius r about O2
intersects the line of centres at the distance s (a - r) from O1, on the side of the pitch point.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import acos, cos, degrees, hypot, pi, tan
from typing import TYPE_CHECKING

from flankload.base.involute import PITCH_TOLERANCE, distance_of_backlash, ends_of_path
from flankload.bodies.profile_deviation import deviation_at
from flankload.errors import SceneError
from flankload.pairing.interference import overlapping_flanks, root_contacts

if TYPE_CHECKING:
    from flankload.bodies.body import Body
    from flankload.bodies.profile.involute import Involute

#: Largest overlap of the flanks at the pitch circle, in base pitches; less causes a warning only,
#: since nominal dimensions may overlap (FZG C14: by some micrometres).
LARGEST_OVERLAP = 0.01

#: Half of the last digit of a centre distance on a drawing, mm. An overlap that it explains is no
#: reason for a warning.
ROUNDING_MM = 0.005

#: Largest usual backlash on the working pitch circle: a clearance of any gear, mm, and that of its
#: size, in base pitches. Standards for accurate and for coarse gears stay below half of it.
USUAL_CLEARANCE_MM, USUAL_BACKLASH = 0.1, 0.05

DISTANCE = "pair.center_distance_mm"


@dataclass(frozen=True)
class GearGeometry:
    """Geometry of a pair of involute gears at its centre distance.

    Attributes
    ----------
    pressure_angle_rad : float
        Working pressure angle.
    pitch_radius_1_mm, pitch_radius_2_mm : float
        Radii of the working pitch circles.
    base_pitch_mm : float
    path_start_mm, path_end_mm : float
        Ends of the theoretical path of contact, measured from the pitch point in the direction of
        motion.
    contact_ratio : float
        Length of that path over the base pitch.
    usable_contact_ratio : float
        The same for the part on which both flanks are involutes, also with reliefs: between form
        circles and tip roundings or chamfers.
    overlap_ratio : float
        Common face width over the axial pitch; 0 in a plane scene and of straight teeth.
    backlash_mm : float
        Circular backlash on the working pitch circles, j_wt; negative if the flanks overlap.
    normal_backlash_mm : float
        Distance of the coast flanks along their normal, j_bn = j_wt cos(alpha_wt) cos(beta_b)
        (ISO 21771).
    """

    pressure_angle_rad: float
    pitch_radius_1_mm: float
    pitch_radius_2_mm: float
    base_pitch_mm: float
    path_start_mm: float
    path_end_mm: float
    contact_ratio: float
    usable_contact_ratio: float
    overlap_ratio: float
    backlash_mm: float
    normal_backlash_mm: float

    @property
    def overlap_by_rounding_mm(self) -> float:
        """Overlap along the base tangent, if the rounding of the centre distance explains it."""
        overlap, angle = -self.backlash_mm, self.pressure_angle_rad
        return overlap * cos(angle) if 0.0 < overlap <= _backlash_of_rounding(angle) else 0.0

    @property
    def total_contact_ratio(self) -> float:
        """Sum of contact ratio and overlap ratio: mean number of pairs in mesh by geometry."""
        return self.contact_ratio + self.overlap_ratio


@dataclass(frozen=True)
class _Pair:
    """Both involutes, their numbers of teeth and their centre distance."""

    one: Involute
    two: Involute
    teeth: tuple[int, int]
    distance: float

    @property
    def sense(self) -> int:
        return self.two.outward

    @property
    def base_pitch(self) -> float:
        return 2 * pi * self.one.base_radius_mm / self.teeth[0]

    def on_centers(self, radius_2: float) -> float:
        """Distance from O1 at which a circle about O2 meets the line of centres, mm."""
        return self.sense * (self.distance - radius_2)


def gear_geometry(
    body_1: Body,
    body_2: Body,
    distance: float,
    warnings: list[str],
    *,
    coast_flanks: bool = False,
) -> GearGeometry:
    """Working geometry of two bodies with involute flanks; body 1 has external teeth.

    Warnings for the user are appended; a SceneError states why bodies cannot mesh.
    """
    assert body_1.involute is not None
    assert body_2.involute is not None
    pair = _Pair(body_1.involute, body_2.involute, (body_1.teeth, body_2.teeth), distance)
    one, two = pair.one, pair.two
    _check_teeth(pair)
    least = _check_distance(pair)
    angle = acos(least / distance)
    radius_1, radius_2 = one.base_radius_mm / cos(angle), two.base_radius_mm / cos(angle)
    backlash = _backlash(pair, radius_1, radius_2, warnings, coast_flanks=coast_flanks)
    _check_clearances(pair)
    tangent_1, tangent_2 = (r * tan(angle) for r in (one.base_radius_mm, two.base_radius_mm))
    start, end = _path_of_contact(pair, angle)
    contact_ratio = (end - start) / pair.base_pitch
    usable = _usable_path(pair.sense, body_1, body_2, (tangent_1, tangent_2)) / pair.base_pitch
    usable, overlap = min(usable, contact_ratio), _overlap_ratio(body_1, body_2)
    _warn_of_short_path(contact_ratio, usable, overlap, warnings)
    deepest = (tangent_1 + start, tangent_2 - pair.sense * end)
    warnings += [
        *root_contacts((one, two), deepest),
        *overlapping_flanks(body_1, body_2, (radius_1, radius_2), distance),
    ]
    return GearGeometry(
        pressure_angle_rad=angle,
        pitch_radius_1_mm=radius_1,
        pitch_radius_2_mm=radius_2,
        base_pitch_mm=pair.base_pitch,
        path_start_mm=start,
        path_end_mm=end,
        contact_ratio=contact_ratio,
        usable_contact_ratio=usable,
        overlap_ratio=overlap,
        backlash_mm=backlash,
        normal_backlash_mm=backlash * cos(angle) * cosine_base_helix(body_1),
    )


def cosine_base_helix(body: Body) -> float:
    """Cosine of the helix angle on the base cylinder."""
    assert body.involute is not None
    twist = body.axial.twist_rad_per_mm
    return 1.0 / hypot(1.0, twist * body.involute.base_radius_mm)


def _path_of_contact(pair: _Pair, angle: float) -> tuple[float, float]:
    """Ends of the path of contact from the pitch point, mm, at the working pressure angle."""
    one, two = pair.one, pair.two
    radii, tips = zip(*((x.base_radius_mm, x.tip_radius_mm) for x in (one, two)), strict=True)
    start, end = ends_of_path(radii, tips, angle, pair.sense)
    if end <= start:
        raise SceneError(
            key=DISTANCE,
            expected="a distance at which the tip circles overlap along the line of action",
            found=f"{pair.distance:g} mm: the path of contact is {end - start:.4f} mm long",
        )
    return start, end


def _overlap_ratio(body_1: Body, body_2: Body) -> float:
    """Common face width over the axial pitch."""
    one, two = body_1.axial, body_2.axial
    low, high = (choose(one.range_mm[k], two.range_mm[k]) for k, choose in ((0, max), (1, min)))
    return (high - low) * abs(one.twist_rad_per_mm) * body_1.teeth / (2 * pi)


def _warn_of_short_path(
    contact_ratio: float, usable: float, overlap: float, warnings: list[str]
) -> None:
    """Warn if at some positions no section of the width has contact on both involutes."""
    if contact_ratio + overlap < 1.0:
        warnings.append(
            f"the contact ratio is {contact_ratio + overlap:.3f}: between two flank contacts, a "
            "tip corner carries the load"
        )
    elif usable + overlap < 1.0:
        warnings.append(
            f"both flanks are involutes over {usable:.3f} of the contact ratio of "
            f"{contact_ratio:.3f}: between two such contacts, a fillet or a tip rounding carries "
            "the load"
        )


def _usable_path(sense: int, body_1: Body, body_2: Body, tangents_mm: tuple[float, float]) -> float:
    """Length of the path of contact on which both flanks are involutes, mm.

    `tangents_mm` are the lengths along the line of action from both base circles to the pitch
    point. When the length on body 1 increases, that on an external body 2 decreases.
    """
    (root_1, tip_1), (root_2, tip_2) = (_ends_of_involute(body) for body in (body_1, body_2))
    start = max(root_1 - tangents_mm[0], sense * (tangents_mm[1] - tip_2))
    end = min(tip_1 - tangents_mm[0], sense * (tangents_mm[1] - root_2))
    return max(0.0, end - start)


def _ends_of_involute(body: Body) -> tuple[float, float]:
    """Lengths along the line of action at the ends of a flank's involute (root, tip)."""
    involute, curve = body.involute, body.curve
    assert involute is not None
    end = curve.active_range[1]
    at_tip = float(deviation_at(involute, curve.point([end]))[0][0])
    return involute.base_radius_mm * involute.roll_at(involute.form_radius_mm), at_tip


def _check_teeth(pair: _Pair) -> None:
    """Check for equal base pitches; inside a ring also the number of teeth and the tip circle."""
    pitch_1, pitch_2 = pair.base_pitch, 2 * pi * pair.two.base_radius_mm / pair.teeth[1]
    if abs(pitch_2 / pitch_1 - 1) > PITCH_TOLERANCE:
        raise SceneError(
            key="body_2.module_mm",
            expected=f"the base pitch of body_1, {pitch_1:.6f} mm (module times cos of the "
            "pressure angle)",
            found=f"{pitch_2:.6f} mm",
        )
    if pair.sense > 0:
        return
    if pair.teeth[0] >= pair.teeth[1]:
        raise SceneError(
            key="body_1.teeth",
            expected=f"fewer than the {pair.teeth[1]} teeth of body_2, inside which it turns",
            found=f"{pair.teeth[0]}",
        )
    if pair.one.tip_radius_mm >= pair.two.root_radius_mm:
        raise SceneError(
            key="body_1.tip_diameter_mm",
            expected=f"less than the root diameter {2 * pair.two.root_radius_mm:g} of body_2, "
            "inside which it turns",
            found=f"{2 * pair.one.tip_radius_mm:g}",
        )


def _check_distance(pair: _Pair) -> float:
    """Check the centre distance; returns that for a working pressure angle of 0, mm."""
    one, two, distance, name = pair.one, pair.two, pair.distance, "sum"
    if pair.sense < 0:
        name = "difference"
    least = abs(one.base_radius_mm + pair.sense * two.base_radius_mm)
    if distance <= least:
        raise SceneError(
            key=DISTANCE,
            expected=f"more than the {name} of the base radii, {least:.4f} mm",
            found=f"{distance:g} mm, {least - distance:.4f} mm too small",
        )
    apart = pair.on_centers(two.tip_radius_mm) - one.tip_radius_mm
    if apart >= 0.0:
        reach = abs(one.tip_radius_mm + pair.sense * two.tip_radius_mm)
        raise SceneError(
            key=DISTANCE,
            expected=f"{'less' if pair.sense > 0 else 'more'} than the {name} of the tip radii, "
            f"{reach:.4f} mm",
            found=f"{distance:g} mm: the tips pass each other {apart:.4f} mm apart",
        )
    return least


def _backlash(
    pair: _Pair, radius_1: float, radius_2: float, warnings: list[str], *, coast_flanks: bool
) -> float:
    """Circular backlash on the working pitch circles, mm."""
    thickness = 2 * (
        radius_1 * pair.one.tooth_half_angle_at(radius_1)
        + radius_2 * pair.two.tooth_half_angle_at(radius_2)
    )
    backlash = 2 * pi * radius_1 / pair.teeth[0] - thickness
    if backlash < -LARGEST_OVERLAP * pair.base_pitch:
        found = f"{pair.distance:g} mm with a backlash of {backlash:.4f} mm: the teeth overlap"
        enough = _distance_without_backlash(pair)
        if enough is None:
            raise SceneError(
                key="body_2.profile_shift",
                expected="spaces of body_2 into which the teeth of body_1 fit at some centre "
                "distance",
                found=f"teeth too thick for all of them ({found})",
            )
        raise SceneError(
            key=DISTANCE,
            expected=f"{enough:.4f} mm or {'more' if pair.sense > 0 else 'less'}, where the teeth "
            "have no negative backlash",
            found=found,
        )
    usual = USUAL_CLEARANCE_MM + USUAL_BACKLASH * pair.base_pitch
    if backlash > usual:
        without = _distance_without_backlash(pair)
        none = "" if without is None else f"; none at {without:.4f} mm"
        warnings.append(
            f"{DISTANCE} = {pair.distance:g}, is that what you mean? (backlash {backlash:.3g} mm, "
            f"usual: up to {usual:.2g} mm{none})"
        )
    angle = acos(pair.one.base_radius_mm / radius_1)
    if backlash < -_backlash_of_rounding(angle) and not coast_flanks:
        warnings.append(
            f"the backlash on the working pitch circle is {1000 * backlash:.2f} um: the coast "
            "flanks would touch, which this run ignores (effects.coast_flank = true includes them)"
        )
    return backlash


def _backlash_of_rounding(pressure_angle_rad: float) -> float:
    """Backlash on the working pitch circles by which a rounded centre distance is off, mm."""
    return 2.0 * tan(pressure_angle_rad) * ROUNDING_MM


def _distance_without_backlash(pair: _Pair) -> float | None:
    """Centre distance without backlash, mm; None if there is none."""
    one, two = pair.one, pair.two
    half_angles = one.base_half_angle_rad, two.base_half_angle_rad - two.tooth_center_rad
    radii = one.base_radius_mm, two.base_radius_mm
    return distance_of_backlash(radii, half_angles, pair.base_pitch, pair.sense)


def _check_clearances(pair: _Pair) -> None:
    """Check that each tip circle clears the mate's root circle."""
    one, two, distance = pair.one, pair.two, pair.distance
    for name, other, clearance in (
        ("1", "2", pair.on_centers(two.root_radius_mm) - one.tip_radius_mm),
        ("2", "1", pair.on_centers(two.tip_radius_mm) - one.root_radius_mm),
    ):
        if clearance <= 0.0:
            bound, side = ("more", "small") if pair.sense > 0 else ("less", "large")
            raise SceneError(
                key=DISTANCE,
                expected=f"{bound} than {distance - pair.sense * clearance:.4f} mm, where the tip "
                f"of body_{name} clears the root of body_{other}",
                found=f"{distance:g} mm, {-clearance:.4f} mm too {side}",
            )


def _described_ratios(gears: GearGeometry) -> tuple[tuple[str, str], ...]:
    """Contact ratios; of straight teeth the total one is the transverse one."""
    usable = ("of it, both flanks involutes", f"{gears.usable_contact_ratio:.4f}")
    if not gears.overlap_ratio:
        return ("contact ratio", f"{gears.contact_ratio:.4f}"), usable
    return (
        ("contact ratio, total", f"{gears.total_contact_ratio:.4f}"),
        ("contact ratio, transverse", f"{gears.contact_ratio:.4f}"),
        usable,
        ("overlap ratio", f"{gears.overlap_ratio:.4f}"),
    )


def describe_gears(gears: GearGeometry) -> tuple[tuple[str, str], ...]:
    """Main geometry of a gear pair: rows of name and value with unit."""
    return (
        ("working pressure angle", f"{degrees(gears.pressure_angle_rad):.4f} deg"),
        (
            "working pitch diameters",
            f"{2 * gears.pitch_radius_1_mm:.4f} / {2 * gears.pitch_radius_2_mm:.4f} mm",
        ),
        ("base pitch", f"{gears.base_pitch_mm:.4f} mm"),
        *_described_ratios(gears),
        ("backlash on the pitch circle", f"{round(gears.backlash_mm, 4) + 0.0:.4f} mm"),
        ("backlash, normal", f"{round(gears.normal_backlash_mm, 4) + 0.0:.4f} mm"),
    )
