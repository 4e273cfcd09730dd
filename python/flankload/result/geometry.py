"""Positions and motion of the bodies of a result, and the gap between its coast flanks."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from flankload.contact.flank_contact import FlankContact
from flankload.contact.sweep import sweep
from flankload.errors import ContactError
from flankload.pairing.gear_mesh import GearMesh
from flankload.pairing.pairing import coast_sites
from flankload.pairing.slices import plane_slice

if TYPE_CHECKING:
    from flankload.base.arrays import Floats
    from flankload.bodies.body import Body
    from flankload.elasticity.compliance import BodyCompliance
    from flankload.pairing.body_pair import BodyPair
    from flankload.pairing.pairing import Pairing


@dataclass(frozen=True, eq=False)
class PairGeometry:
    """Kinematics of both bodies at P positions, and the geometry of their mesh if it is known.

    Attributes
    ----------
    center_distance_mm : float
        Distance of the axes: body 1 rotates about the origin, body 2 about a point on the x axis.
    speed_1, speed_2 : (P,) arrays
        Rotation of both bodies, counter-clockwise, per rad of position.
    contact_ratio : float or None
        Length of the path of contact divided by the base pitch.
    usable_contact_ratio : float or None
        Contact ratio of the part on which both flanks are involutes.
    overlap_ratio : float or None
        Common face width divided by the axial pitch; 0 of straight teeth.
    path_pitches : (float, float) or None
        Ends of the path of contact in base pitches from the pitch point, in the sense of motion.
    coast : CoastSide or None
        Coast flanks.
    coast_unknown : str
        Reason if `coast` is None although there are coast flanks.
    speed_rpm : float or None
        Speed of body 1, if the scene gives it.
    """

    center_distance_mm: float
    speed_1: Floats
    speed_2: Floats
    contact_ratio: float | None = None
    usable_contact_ratio: float | None = None
    overlap_ratio: float | None = None
    path_pitches: tuple[float, float] | None = None
    coast: CoastSide | None = None
    coast_unknown: str = ""
    speed_rpm: float | None = None

    @property
    def total_contact_ratio(self) -> float | None:
        """Sum of contact ratio and overlap ratio."""
        if self.contact_ratio is None or self.overlap_ratio is None:
            return None
        return self.contact_ratio + self.overlap_ratio

    @property
    def has_coast_flanks(self) -> bool:
        """Whether the bodies have coast flanks, known or not; a cam has none."""
        return self.coast is not None or bool(self.coast_unknown)


def pair_geometry(
    pair: BodyPair, compliances: tuple[BodyCompliance, BodyCompliance]
) -> PairGeometry:
    """Geometry of a pair with the displacement of its flanks from their nominal place."""
    pairing, mesh = pair.pairing, pair.pairing.gear_geometry
    speeds = pairing.speeds(pair.position_rad)
    coast, unknown = _coast_side(pair, compliances)
    known = PairGeometry(pairing.center_distance_mm, *speeds, coast=coast, coast_unknown=unknown)
    if mesh is None:
        return known
    pitch = mesh.base_pitch_mm
    return replace(
        known,
        contact_ratio=mesh.contact_ratio,
        usable_contact_ratio=mesh.usable_contact_ratio,
        overlap_ratio=mesh.overlap_ratio,
        path_pitches=(mesh.path_start_mm / pitch, mesh.path_end_mm / pitch),
    )


@dataclass(frozen=True, eq=False)
class CoastSide:
    """Mirror image of a pair, in which the search for working flanks finds the coast flanks.

    Attributes
    ----------
    contact : FlankContact
        The mirrored pair at z = 0, whose compliances are for bodies that expand without forces.
    position_rad : (P,) array
        Positions of the mirrored pair.
    base_radius_mm : float
        Base radius of body 1.
    """

    contact: FlankContact
    position_rad: Floats
    base_radius_mm: float

    @cached_property
    def gap_rad(self) -> Floats:
        """(P,) Angle by which body 1 can turn back without load before coast flanks touch.

        Negative if they overlap; NaN if no coast flanks face each other.
        """
        return self._gaps(self.position_rad)

    def _gaps(self, position_rad: Floats) -> Floats:
        try:
            (found,) = sweep(self.contact, position_rad, (0.0,), keep_pairs=False)
        except ContactError:
            if position_rad.size == 1:
                return np.full(1, np.nan)
            return np.concatenate([self._gaps(alone) for alone in position_rad[:, None]])
        return found.rotation_rad


def _coast_side(
    pair: BodyPair, compliances: tuple[BodyCompliance, BodyCompliance]
) -> tuple[CoastSide | None, str]:
    """The coast flanks of a pair; None and the reason if they are unknown.

    Both flanks of a tooth are assumed to be equal, and to expand equally; pitch errors apply to
    working flanks only.
    """
    one, two = pair.body_1.involute, pair.body_2.involute
    if any(body.curve.closed for body in pair.bodies):
        return None, ""  # a single flank all around
    for z, involute in enumerate((one, two)):
        if involute is None:
            return None, f"body_{z + 1} has no known coast flank"
        if any(len(shift) > 1 for shift in compliances[z].expansion.shifts.values()):
            return None, f"the expansion of body_{z + 1} is known on the working flanks only"
    assert one is not None
    contact = FlankContact(
        GearMesh(pair.bodies, _mirrored(pair.pairing, *pair.bodies), plane_slice(1.0)),
        (_rigid_section(compliances[0]), _rigid_section(compliances[1])),
        pair.discretization.grid,
    )
    return CoastSide(contact, -pair.position_rad, one.base_radius_mm), ""


def _rigid_section(compliance: BodyCompliance) -> BodyCompliance:
    """The compliance of a section, a mean over the width, that only body loads deform."""
    return compliance.fewer_axial_modes(compliance.modes.axial.degree).without_elasticity()


def _mirrored(pairing: Pairing, body_1: Body, body_2: Body) -> Pairing:
    """The pairing of coast flanks in the mirror image of `coast_sites`."""
    numbers = pairing.sites
    if body_2.outward > 0:
        numbers = np.union1d(numbers, numbers + 1)
    coast = coast_sites(numbers, body_1, body_2)
    turn_1, turn_2 = pairing.turns_at_zero_rad
    none = np.zeros(numbers.size)
    return replace(
        pairing,
        turns_at_zero_rad=(-turn_1, -turn_2),
        sites=numbers,
        site_teeth=coast.site_teeth,
        site_angles_rad=coast.site_angles_rad,
        site_deviations_mm=(none, none),
        coast=None,
    )
