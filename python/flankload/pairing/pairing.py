"""The relative position of two bodies: ratio, position zero, mating flanks.

Body 1 turns counter-clockwise about O1 = (0, 0), in the sense of its torque. Body 2 turns about
O2 = (centre distance, 0), in the opposite sense if its teeth are external, in the same sense if
they are internal. At position zero pair 0 is at the pitch point; pair j is j pitches further along
the path of contact (j > 0: towards recess). The pitch point is between both axes, or, if body 1
turns inside body 2, beyond O1.

On a spline every tooth is a site: pair j is tooth j, counted in the sense of the torque from tooth
0, which at position zero is on the line of centres, on the side of O2.

A cam has one site. Positions are rotations of the cam; the angle of the follower (body 1) is that
of contact.

In the mirror image about the line of centres, coast flanks are working flanks with the same curve,
on bodies that turn in the opposite direction. The coast flank of a tooth of body 1 mates with that
tooth of body 2 whose working flank mates with the next tooth of body 1; if body 2 has internal
teeth, with the other side of the same space.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import lcm, nan, pi
from typing import TYPE_CHECKING

import numpy as np

from flankload.base.rounding import round_down, round_up
from flankload.errors import SceneError
from flankload.pairing.cam_motion import CamMotion, cam_motion
from flankload.pairing.gear_pair import GearGeometry, gear_geometry
from flankload.pairing.spline_fit import SplineFit, spline_fit

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from flankload.bodies.body import Body

#: Number of sites on each side of pair 0 if the path of contact is unknown.
UNKNOWN_PATH_SITES = 3


@dataclass(frozen=True)
class Period:
    """Period of the positions, in tooth pitches of body 1.

    `pitches` is the number after which equal teeth meet again: the least common multiple over both
    bodies of the size of the smallest group of teeth that repeats. Teeth are equal if they have
    equal deviations, friction and, if known, compliance.
    """

    pitch_rad: float
    pitches: int = 1

    @property
    def rad(self) -> float:
        """Rotation of body 1 after which everything repeats, rad."""
        return self.pitches * self.pitch_rad

    def with_compliance(self, groups: tuple[int, int]) -> Period:
        """The period with compliances that repeat after these numbers of teeth of each body."""
        return replace(self, pitches=lcm(self.pitches, *groups))


@dataclass(frozen=True)
class CoastSites:
    """S sites of coast flanks, numbered by the tooth of body 1 like pairs.

    For each body the tooth (S,) at each site, and its angle (S,) in the mirrored frame of the body,
    relative to the negative of the body's angle.
    """

    site_teeth: tuple[NDArray[np.int64], NDArray[np.int64]]
    site_angles_rad: tuple[NDArray[np.float64], NDArray[np.float64]]


@dataclass(frozen=True)
class Pairing:
    """Relative position of the bodies, and S sites: pairs of flanks that can touch.

    Attributes
    ----------
    center_distance_mm : float
    turns_at_zero_rad : (float, float)
        Angles of both bodies' frames at position zero.
    ratio : float
        Teeth of body 1 over teeth of body 2; negative if both turn in the same sense. NaN if the
        ratio is not constant.
    period : Period
        Period of the positions.
    sites : (S,) array
        Pair numbers.
    site_teeth : two (S,) arrays
        Tooth of each body at each site.
    site_angles_rad : two (S,) arrays
        Angle of that tooth in the frame of its body.
    site_deviations_mm : two (S,) arrays
        Excess material along the base tangent, which causes early contact.
    gear_geometry : GearGeometry or None
        Geometry of the gear pair; None if a body has no involute, and for splines.
    warnings : tuple of str
    fit : SplineFit or None
        Geometry of a spline.
    motion : CamMotion or None
        Motion of a follower on its cam.
    coast : CoastSites or None
        Sites of coast flanks with the same pair numbers, if they can carry load.
    """

    center_distance_mm: float
    turns_at_zero_rad: tuple[float, float]
    ratio: float
    period: Period
    sites: NDArray[np.int64]
    site_teeth: tuple[NDArray[np.int64], NDArray[np.int64]]
    site_angles_rad: tuple[NDArray[np.float64], NDArray[np.float64]]
    site_deviations_mm: tuple[NDArray[np.float64], NDArray[np.float64]]
    gear_geometry: GearGeometry | None = None
    warnings: tuple[str, ...] = ()
    fit: SplineFit | None = None
    motion: CamMotion | None = None
    coast: CoastSites | None = None

    @property
    def pitch_rad(self) -> float:
        """One tooth pitch of body 1, rad."""
        return self.period.pitch_rad

    @property
    def period_rad(self) -> float:
        """Rotation of body 1 after which everything repeats, rad."""
        return self.period.rad

    @property
    def whole_circle(self) -> bool:
        """Whether every tooth is a site, so that the last pair is next to pair 0."""
        return self.fit is not None

    def teeth_of(self, z: int) -> NDArray[np.int64]:
        """(n,) Tooth of body z at each site: working flanks, then coast flanks, if any."""
        teeth = self.site_teeth[z]
        if self.coast is None:
            return teeth
        return np.concatenate([teeth, self.coast.site_teeth[z]])

    def turns(
        self, position_rad: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Angles of both bodies' frames at positions (angle of body 1, or of a cam, rad)."""
        if self.motion is not None:
            contacts = self.motion.contacts(position_rad)
            contacts.check()
            return contacts.turn_1, contacts.turn_2
        turn_1, turn_2 = self.turns_at_zero_rad
        return turn_1 + position_rad, turn_2 - position_rad * self.ratio

    def speeds(
        self, position_rad: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Speeds of both bodies' frames at positions, rad per rad of the position.

        Positions increase in the sense of body 1's torque, whichever body drives; those of a cam in
        its sense of rotation.
        """
        if self.motion is not None:
            contacts = self.motion.contacts(position_rad)
            return contacts.rate(), np.full(contacts.turn_1.shape, float(self.motion.sense))
        one = np.ones_like(np.asarray(position_rad, dtype=float))
        return one, -self.ratio * one


def pair_bodies(
    body_1: Body,
    body_2: Body,
    *,
    center_distance_mm: float,
    position_rad: NDArray[np.float64],
    coast_flanks: bool = False,
) -> Pairing:
    """Combine two bodies at a centre distance; for splines, the offset of their axes.

    The positions (P,) determine the number of sites. Flanks may overlap without load if coast
    flanks can carry load. A SceneError states why flanks cannot mesh.
    """
    if body_1.conforms:
        return _pair_spline(body_1, body_2, center_distance_mm, coast_flanks=coast_flanks)
    if body_1.touches is not None:
        return _pair_cam(body_1, body_2, center_distance_mm, position_rad)
    return _pair_gears(body_1, body_2, center_distance_mm, position_rad, coast_flanks=coast_flanks)


def _pair_gears(
    body_1: Body,
    body_2: Body,
    distance: float,
    position_rad: NDArray[np.float64],
    *,
    coast_flanks: bool,
) -> Pairing:
    """Pair bodies with teeth."""
    if body_1.outward < 0:
        raise SceneError(
            key="body_1",
            expected="a body with outward teeth: the body around it is body_2",
            found="flanks whose radius falls from root to tip",
        )
    sense = body_2.outward
    warnings: list[str] = []
    gears = None
    if body_1.involute is not None and body_2.involute is not None:
        gears = gear_geometry(body_1, body_2, distance, warnings, coast_flanks=coast_flanks)
    # the pitch point follows from the ratio, also if the other body is at the angle of its file
    circles = abs(body_1.teeth + sense * body_2.teeth) or 1
    turns = (
        _turn_to_pitch_point(body_1, distance * body_1.teeth / circles, 0.0 if sense > 0 else pi),
        _turn_to_pitch_point(body_2, distance * body_2.teeth / circles, pi),
    )
    sites = path_sites(gears, body_1.teeth, body_2.teeth, position_rad, coast_flanks=coast_flanks)
    sites = _with_flanks(sites, body_1, body_2)
    teeth_1, angles_1 = at_sites(body_1, sites, 1)
    teeth_2, angles_2 = at_sites(body_2, sites, -sense)
    return Pairing(
        center_distance_mm=distance,
        turns_at_zero_rad=turns,
        ratio=sense * body_1.teeth / body_2.teeth,
        period=period_of(body_1, body_2),
        sites=sites,
        site_teeth=(teeth_1, teeth_2),
        site_angles_rad=(angles_1, angles_2),
        site_deviations_mm=(np.zeros(sites.size), np.zeros(sites.size)),
        gear_geometry=gears,
        warnings=tuple(warnings),
        coast=coast_sites(sites, body_1, body_2) if coast_flanks else None,
    )


def _pair_spline(shaft: Body, hub: Body, offset: float, *, coast_flanks: bool) -> Pairing:
    """Pair every tooth of the shaft with its space of the hub."""
    warnings: list[str] = []
    fit = spline_fit(shaft, hub, offset, warnings, coast_flanks=coast_flanks)
    sites = np.arange(shaft.teeth)
    angles = 2 * pi * sites / shaft.teeth
    return Pairing(
        center_distance_mm=offset,
        turns_at_zero_rad=(0.0, fit.turn_rad),
        ratio=-1.0,
        period=period_of(shaft, hub),
        sites=sites,
        site_teeth=(sites, sites),
        site_angles_rad=(angles + pitch_turns(shaft, sites), angles + pitch_turns(hub, sites)),
        site_deviations_mm=(np.zeros(sites.size), np.zeros(sites.size)),
        warnings=tuple(warnings),
        fit=fit,
        coast=coast_sites(sites, shaft, hub) if coast_flanks else None,
    )


def _pair_cam(
    follower: Body, cam: Body, distance: float, position_rad: NDArray[np.float64]
) -> Pairing:
    """Pair a follower with its cam."""
    motion = cam_motion(follower, cam, distance)
    motion.contacts(position_rad).check()
    start = motion.contacts(np.zeros(1))
    none, site = np.zeros(1), np.zeros(1, dtype=np.int64)
    return Pairing(
        center_distance_mm=distance,
        turns_at_zero_rad=(float(start.turn_1[0]), float(start.turn_2[0])),
        ratio=nan,
        period=period_of(follower, cam),
        sites=site,
        site_teeth=(site, site),
        site_angles_rad=(none, none),
        site_deviations_mm=(none, none),
        motion=motion,
    )


def _turn_to_pitch_point(body: Body, pitch_radius: float, direction: float) -> float:
    """Rotation of tooth 0's flank to the pitch point; 0 for a body at the angle of its file."""
    if not body.flank_angle_known or body.involute is None:
        return 0.0
    return direction - body.involute.polar_angle_at(pitch_radius)


def path_sites(
    gears: GearGeometry | None,
    teeth_1: int,
    teeth_2: int,
    position_rad: NDArray[np.float64],
    *,
    coast_flanks: bool,
) -> NDArray[np.int64]:
    """Pairs near the path of contact at any position, with one extra at each end.

    Coast flanks, half a pitch behind, may require one more.
    """
    pitches = np.asarray(position_rad) * teeth_1 / (2 * pi)
    start, end, spare = -float(UNKNOWN_PATH_SITES), float(UNKNOWN_PATH_SITES), 0
    if gears is not None:
        pitch = gears.base_pitch_mm
        start, end, spare = gears.path_start_mm / pitch, gears.path_end_mm / pitch, 1
    first = round_down(start - pitches) - spare
    last = round_up(end - pitches) + spare + int(coast_flanks)
    # distances between positions may be several revolutions
    runs = set(zip(first.tolist(), last.tolist(), strict=True))
    sites = np.unique(np.concatenate([np.arange(low, high + 1) for low, high in runs]))
    extra = sites.size - min(teeth_1, teeth_2)
    if extra > 0 and np.ptp(pitches) < 1.0:
        sites = sites[extra // 2 : sites.size - (extra - extra // 2)]
    return sites


def _with_flanks(sites: NDArray[np.int64], body_1: Body, body_2: Body) -> NDArray[np.int64]:
    """Sites at which both bodies have a flank."""
    there = np.ones(sites.size, dtype=bool)
    for body, teeth in (
        (body_1, sites % body_1.teeth),
        (body_2, -body_2.outward * sites % body_2.teeth),
    ):
        if body.named_teeth:
            there &= np.isin(teeth, body.named_teeth)
    if not there.any():
        raise SceneError(
            key="positions",
            expected="positions at which teeth with a flank in the files are in mesh",
            found="teeth without a flank at all of them",
        )
    return sites[there]


def at_sites(
    body: Body, sites: NDArray[np.int64], sense: int
) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Teeth (S,) of a body at its sites, and their angles (S,) in its frame, rad.

    A tooth further towards recess has a larger angle if the body turns counter-clockwise (sense 1),
    a smaller one otherwise (-1). The tooth after that of pair 0 comes into contact as pair -1.
    """
    teeth = sense * sites % body.teeth
    angles = sense * 2 * pi * sites / body.teeth
    # flanks from a file may deviate from equal angles
    own = np.asarray(body.flank_turns_rad)[teeth] if body.flank_turns_rad else 0.0
    return teeth, angles + pitch_turns(body, -sites) + own


def pitch_turns(body: Body, entries: NDArray[np.int64]) -> NDArray[np.float64]:
    """Rotations (S,) of the flanks by pitch errors, rad; `entries`: number of the error of a site.

    Excess material along the base tangent rotates the flank counter-clockwise on external teeth,
    clockwise on internal teeth.
    """
    if not body.pitch_errors_um:
        return np.zeros(entries.size)
    errors_mm = np.asarray(body.pitch_errors_um)[entries % body.teeth] / 1000.0
    return body.outward * errors_mm / (body.base_radius_mm or body.reference_radius_mm)


def coast_sites(numbers: NDArray[np.int64], body_1: Body, body_2: Body) -> CoastSites:
    """Sites of the coast flanks of teeth of body 1 with pair numbers (S,).

    Both flanks of a tooth are assumed to be equal. Pitch errors apply to working flanks only.
    """
    assert body_1.involute is not None
    assert body_2.involute is not None
    sense = body_2.outward
    other = numbers - 1 if sense > 0 else numbers
    return CoastSites(
        site_teeth=(numbers % body_1.teeth, -sense * other % body_2.teeth),
        site_angles_rad=(
            -2 * np.pi * numbers / body_1.teeth - 2 * body_1.involute.turn_rad,
            sense * 2 * np.pi * other / body_2.teeth - 2 * body_2.involute.turn_rad,
        ),
    )


def period_of(body_1: Body, body_2: Body, *, by_tooth: tuple[float, ...] = ()) -> Period:
    """Period of a pair; `by_tooth` is another property of each tooth of body 1 (friction)."""
    return Period(
        pitch_rad=2 * pi / body_1.teeth,
        pitches=lcm(teeth_until_alike(body_1, by_tooth), teeth_until_alike(body_2)),
    )


def teeth_until_alike(body: Body, by_tooth: tuple[float, ...] = ()) -> int:
    """Number of teeth after which deviations, and another property, repeat around a body."""
    places = np.zeros((4, body.teeth))
    if by_tooth:
        places[2] = by_tooth
    if body.pitch_errors_um:
        places[0] = body.pitch_errors_um
    if body.flank_turns_rad:
        places[1] = body.flank_turns_rad
    if body.axial.tooth_slopes_mm:
        places[3] = body.axial.tooth_slopes_mm
    return next(
        group
        for group in range(1, body.teeth + 1)
        if body.teeth % group == 0 and np.array_equal(np.roll(places, group, axis=1), places)
    )
