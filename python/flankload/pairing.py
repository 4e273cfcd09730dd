"""The two bodies together: ratio, position zero, mating flanks, backlash, interference.

Body 1 turns about O1 = (0, 0) counter-clockwise, in the sense of its torque; body 2 turns about
O2 = (centre distance, 0) the other way. Pair 0 stands at the pitch point at position zero; pair j
lies j pitches further along the path of contact (j > 0: further into recess).
"""

from __future__ import annotations

from dataclasses import dataclass
from math import acos, ceil, cos, degrees, floor, hypot, pi, sqrt, tan
from typing import TYPE_CHECKING

import numpy as np

from flankload.bodies.involute import roll_of_involute_angle
from flankload.errors import SceneError

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from flankload.bodies.body import Body

#: Flanks that overlap by more than this part of the base pitch at the pitch circle cannot mesh;
#: less is a matter of tolerances (FZG C14 overlaps nominally by some micrometres) and only a
#: warning.
LARGEST_OVERLAP = 0.01

#: Two gears mesh when their base pitches agree to this relative difference.
PITCH_TOLERANCE = 1e-6

#: Sites looked at to both sides of pair 0 where the path of contact is not known.
UNKNOWN_PATH_SITES = 3


@dataclass(frozen=True)
class Mesh:
    """Geometry of a pair of involute gears on its centre distance.

    Attributes
    ----------
    pressure_angle_rad : float
        Working pressure angle.
    pitch_radius_1_mm, pitch_radius_2_mm : float
        Working pitch circles.
    base_pitch_mm : float
    path_start_mm, path_end_mm : float
        Ends of the theoretical path of contact, counted from the pitch point in the sense of
        motion.
    contact_ratio : float
        Length of that path over the base pitch.
    backlash_mm : float
        Circular backlash on the working pitch circles; negative where the flanks overlap.
    """

    pressure_angle_rad: float
    pitch_radius_1_mm: float
    pitch_radius_2_mm: float
    base_pitch_mm: float
    path_start_mm: float
    path_end_mm: float
    contact_ratio: float
    backlash_mm: float


@dataclass(frozen=True)
class Pairing:
    """Where the bodies stand and which flanks can meet; S sites.

    Attributes
    ----------
    center_distance_mm : float
    turns_at_zero_rad : (float, float)
        Turn of both bodies' frames at position zero.
    ratio : float
        Teeth of body 1 over teeth of body 2.
    period_rad : float
        One tooth pitch of body 1.
    sites : (S,) array
        Pair numbers.
    site_teeth : two (S,) arrays
        Tooth of each body at each site.
    site_angles_rad : two (S,) arrays
        Angle of that tooth in the frame of its body.
    site_deviations_mm : two (S,) arrays
        Metal that touches early, along the base tangent.
    mesh : Mesh or None
        Gear geometry of the pair; None where a body has no involute.
    warnings : tuple of str
    """

    center_distance_mm: float
    turns_at_zero_rad: tuple[float, float]
    ratio: float
    period_rad: float
    sites: NDArray[np.int64]
    site_teeth: tuple[NDArray[np.int64], NDArray[np.int64]]
    site_angles_rad: tuple[NDArray[np.float64], NDArray[np.float64]]
    site_deviations_mm: tuple[NDArray[np.float64], NDArray[np.float64]]
    mesh: Mesh | None
    warnings: tuple[str, ...]

    def turns(
        self, position_rad: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Turns of both bodies' frames at positions (angle of body 1, rad)."""
        turn_1, turn_2 = self.turns_at_zero_rad
        return turn_1 + position_rad, turn_2 - position_rad * self.ratio


def pair_bodies(
    body_1: Body,
    body_2: Body,
    *,
    center_distance_mm: float,
    position_rad: NDArray[np.float64],
) -> Pairing:
    """Put two bodies together.

    Parameters
    ----------
    body_1, body_2 : Body
    center_distance_mm : float
    position_rad : (P,) array
        Positions that will be asked for; they decide how many sites are looked at.

    Returns
    -------
    Pairing

    Raises
    ------
    SceneError
        If the flanks cannot mesh on this centre distance; says by how much.
    """
    warnings: list[str] = []
    mesh = None
    if body_1.involute is not None and body_2.involute is not None:
        mesh = _gear_mesh(body_1, body_2, center_distance_mm, warnings)
    turns = (
        _turn_to_pitch_point(body_1, mesh.pitch_radius_1_mm if mesh else None, 0.0),
        _turn_to_pitch_point(body_2, mesh.pitch_radius_2_mm if mesh else None, pi),
    )
    sites = _sites(mesh, body_1.teeth, body_2.teeth, position_rad)
    # Body 1 turns counter-clockwise: a tooth that is further into recess stands at a greater angle
    # on body 1, at a smaller one on body 2.
    teeth = (sites % body_1.teeth, -sites % body_2.teeth)
    # A pitch error along the base tangent turns its flank about the axis, on body 1 and on body 2
    # counter-clockwise where the metal touches early.
    angles = (
        2 * pi * sites / body_1.teeth + _pitch_turns(body_1, sites),
        -2 * pi * sites / body_2.teeth + _pitch_turns(body_2, sites),
    )
    return Pairing(
        center_distance_mm=center_distance_mm,
        turns_at_zero_rad=turns,
        ratio=body_1.teeth / body_2.teeth,
        period_rad=2 * pi / body_1.teeth,
        sites=sites,
        site_teeth=teeth,
        site_angles_rad=angles,
        site_deviations_mm=(np.zeros(sites.size), np.zeros(sites.size)),
        mesh=mesh,
        warnings=tuple(warnings),
    )


def _gear_mesh(body_1: Body, body_2: Body, distance: float, warnings: list[str]) -> Mesh:
    """Working geometry of two external involute gears (DIN 3960), checked."""
    key = "pair.center_distance_mm"
    one, two = body_1.involute, body_2.involute
    assert one is not None
    assert two is not None
    pitch_1 = 2 * pi * one.base_radius_mm / body_1.teeth
    pitch_2 = 2 * pi * two.base_radius_mm / body_2.teeth
    if abs(pitch_2 / pitch_1 - 1) > PITCH_TOLERANCE:
        raise SceneError(
            key="body_2.module_mm",
            expected=f"the base pitch of body_1, {pitch_1:.6f} mm (module times cos of the "
            "pressure angle)",
            found=f"{pitch_2:.6f} mm",
        )
    least = one.base_radius_mm + two.base_radius_mm
    if distance <= least:
        raise SceneError(
            key=key,
            expected=f"more than the sum of the base radii, {least:.4f} mm",
            found=f"{distance:g} mm, {least - distance:.4f} mm too small",
        )
    reach = one.tip_radius_mm + two.tip_radius_mm
    if distance >= reach:
        raise SceneError(
            key=key,
            expected=f"less than the sum of the tip radii, {reach:.4f} mm",
            found=f"{distance:g} mm: the tips pass each other {distance - reach:.4f} mm apart",
        )
    angle = acos(least / distance)
    radius_1 = distance * body_1.teeth / (body_1.teeth + body_2.teeth)
    radius_2 = distance - radius_1
    thickness = 2 * (
        radius_1 * one.half_angle_at(radius_1) + radius_2 * two.half_angle_at(radius_2)
    )
    backlash = 2 * pi * radius_1 / body_1.teeth - thickness
    if backlash < -LARGEST_OVERLAP * pitch_1:
        raise SceneError(
            key=key,
            expected=f"{_distance_without_backlash(body_1, body_2):.4f} mm or more, where the "
            "teeth have no negative backlash",
            found=f"{distance:g} mm with a backlash of {backlash:.4f} mm: the teeth overlap",
        )
    if backlash <= 0.0:
        warnings.append(
            f"the backlash on the working pitch circle is {1000 * backlash:.2f} um: only the "
            "working flanks are looked at"
        )
    for tip, root, name, other in ((one, two, "1", "2"), (two, one, "2", "1")):
        clearance = distance - tip.tip_radius_mm - root.root_radius_mm
        if clearance <= 0.0:
            raise SceneError(
                key=key,
                expected=f"more than {distance - clearance:.4f} mm, where the tip of body_{name} "
                f"clears the root of body_{other}",
                found=f"{distance:g} mm, {-clearance:.4f} mm too small",
            )
    tangent_1, tangent_2 = (r * tan(angle) for r in (one.base_radius_mm, two.base_radius_mm))
    start = tangent_2 - sqrt(max(0.0, two.tip_radius_mm**2 - two.base_radius_mm**2))
    end = sqrt(max(0.0, one.tip_radius_mm**2 - one.base_radius_mm**2)) - tangent_1
    if end <= start:
        raise SceneError(
            key=key,
            expected="a distance at which the tip circles overlap along the line of action",
            found=f"{distance:g} mm: the path of contact is {end - start:.4f} mm long",
        )
    contact_ratio = (end - start) / pitch_1
    if contact_ratio < 1.0:
        warnings.append(
            f"the contact ratio is {contact_ratio:.3f}: between two flanks a tip corner carries"
        )
    _warn_of_root_contact(body_1, tangent_1 + start, "1", warnings)
    _warn_of_root_contact(body_2, tangent_2 - end, "2", warnings)
    return Mesh(
        pressure_angle_rad=angle,
        pitch_radius_1_mm=radius_1,
        pitch_radius_2_mm=radius_2,
        base_pitch_mm=pitch_1,
        path_start_mm=start,
        path_end_mm=end,
        contact_ratio=contact_ratio,
        backlash_mm=backlash,
    )


def _distance_without_backlash(body_1: Body, body_2: Body) -> float:
    """Centre distance (mm) at which both flanks of a tooth touch.

    The teeth fill the pitch on the working circles r_b/cos(alpha_w): the sum of r_b (half angle at
    the base - inv(alpha_w)) of both gears is half of a base pitch.
    """
    one, two = body_1.involute, body_2.involute
    assert one is not None
    assert two is not None
    radii = (one.base_radius_mm, two.base_radius_mm)
    filled = sum(r * gear.base_half_angle_rad for r, gear in zip(radii, (one, two), strict=True))
    value = (filled - pi * one.base_radius_mm / body_1.teeth) / sum(radii)
    return sum(radii) * hypot(1.0, roll_of_involute_angle(max(0.0, value)))


def _warn_of_root_contact(body: Body, roll_mm: float, name: str, warnings: list[str]) -> None:
    """The mate's tip must meet the involute, not the fillet: compare the radii."""
    involute = body.involute
    assert involute is not None
    deepest = hypot(involute.base_radius_mm, max(0.0, roll_mm))
    if roll_mm < 0.0 or deepest < involute.form_radius_mm:
        depth = involute.form_radius_mm - deepest
        warnings.append(
            f"the mate's tip reaches {depth:.3f} mm below the form circle of body_{name} "
            f"(diameter {2 * involute.form_radius_mm:.3f} mm): it meets the root fillet"
        )


def _turn_to_pitch_point(body: Body, pitch_radius: float | None, direction: float) -> float:
    """Turn that brings tooth 0's flank to the pitch point; 0 where the file stands as it is."""
    if not body.flank_angle_known or pitch_radius is None or body.involute is None:
        return 0.0
    return direction - body.involute.polar_angle_at(pitch_radius)


def _sites(
    mesh: Mesh | None, teeth_1: int, teeth_2: int, position_rad: NDArray[np.float64]
) -> NDArray[np.int64]:
    """Pairs that come near the path of contact at any position, one to spare at each end."""
    pitches = np.asarray(position_rad) * teeth_1 / (2 * pi)
    if mesh is None:
        first = floor(-UNKNOWN_PATH_SITES - float(pitches.max()))
        last = ceil(UNKNOWN_PATH_SITES - float(pitches.min()))
    else:
        first = floor(mesh.path_start_mm / mesh.base_pitch_mm - float(pitches.max())) - 1
        last = ceil(mesh.path_end_mm / mesh.base_pitch_mm - float(pitches.min())) + 1
    if last - first + 1 > min(teeth_1, teeth_2) and np.ptp(pitches) < 1.0:
        spare = last - first + 1 - min(teeth_1, teeth_2)
        first += spare // 2
        last -= spare - spare // 2
    return np.arange(first, last + 1)


def _pitch_turns(body: Body, sites: NDArray[np.int64]) -> NDArray[np.float64]:
    """Turns (S,) of the flanks by pitch errors, rad; the tooth after pair 0 meets as pair -1."""
    if not body.pitch_errors_um:
        return np.zeros(sites.size)
    errors_mm = np.asarray(body.pitch_errors_um)[-sites % body.teeth] / 1000.0
    return errors_mm / body.reference_radius_mm


def describe_mesh(mesh: Mesh) -> tuple[tuple[str, str], ...]:
    """What a gear engineer checks first, as (name, value with unit) rows."""
    return (
        ("working pressure angle", f"{degrees(mesh.pressure_angle_rad):.4f} deg"),
        (
            "working pitch diameters",
            f"{2 * mesh.pitch_radius_1_mm:.4f} / {2 * mesh.pitch_radius_2_mm:.4f} mm",
        ),
        ("base pitch", f"{mesh.base_pitch_mm:.4f} mm"),
        ("contact ratio", f"{mesh.contact_ratio:.4f}"),
        ("backlash on the pitch circle", f"{mesh.backlash_mm:.4f} mm"),
        ("backlash, normal", f"{mesh.backlash_mm * cos(mesh.pressure_angle_rad):.4f} mm"),
    )
