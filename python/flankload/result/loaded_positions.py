"""Positions of a result, rotation and loads there, and quantities derived from these."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import degrees
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from flankload.base.read_only import frozen
from flankload.base.rounding import round_down, round_up
from flankload.base.torque import N_MM_PER_N_M
from flankload.result.flank_contact import FlankContacts, flank_contacts
from flankload.result.pairs import PairDrawing, PairTable
from flankload.result.torque_axis import TorqueAxis, per_torque

if TYPE_CHECKING:
    from flankload.base.arrays import Flags, Floats, Numbers
    from flankload.result.geometry import PairGeometry


#: Axes (P positions, S sites) and type of each array of a result.
ARRAYS: Mapping[str, tuple[str, type]] = {
    "sites": ("S", int),
    "position_rad": ("P", float),
    "rotation_rad": ("P", float),
    "site_force_N": ("PS", float),
    "peak_pressure_MPa": ("PS", float),
    "stiffness_tangent_Nm_per_rad": ("P", float),
    "status": ("P", int),
    "corner_contact": ("PS", bool),
    "follower_angle_rad": ("P", float),
    "unloaded_rotation_rad": ("P", float),
}
#: Arrays that may be None.
OPTIONAL_ARRAYS = ("follower_angle_rad", "unloaded_rotation_rad")


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class PairPositions(TorqueAxis):
    """Positions and dimensions of a pair, which no torque changes; fields as in `Result`."""

    name: str
    position_rad: Floats
    reference_radius_mm: float
    face_width_mm: float
    pitch_rad: float
    period_rad: float
    closed: bool
    drawing: PairDrawing
    whole_circle: bool = False
    follower_angle_rad: Floats | None = None
    geometry: PairGeometry | None = None

    @property
    def position_deg(self) -> Floats:
        """(P,) Angle of body 1 (with a cam: of the cam) from position zero, degrees."""
        return frozen(np.degrees(self.position_rad))

    @property
    def pitch_deg(self) -> float:
        """One tooth pitch of body 1 (a turn of the cam), degrees."""
        return degrees(self.pitch_rad)

    @property
    def period_deg(self) -> float:
        """Rotation of body 1 after which everything repeats, degrees."""
        return degrees(self.period_rad)

    @property
    def period_pitches(self) -> int:
        """Number of tooth pitches of body 1 in a period."""
        return round(self.period_rad / self.pitch_rad)

    @property
    def follower_angle_deg(self) -> Floats | None:
        """(P,) Angle of a follower on its cam without load, degrees; None for other pairs."""
        angle = self.follower_angle_rad
        return None if angle is None else frozen(np.degrees(angle))

    @property
    def has_cam(self) -> bool:
        """Whether a follower lies on a cam."""
        return self.follower_angle_rad is not None

    @property
    def has_involute_path(self) -> bool:
        """Whether both flanks are involutes with a known path of contact."""
        known = self.geometry is not None and self.geometry.path_pitches is not None
        return known and None not in self.drawing.profiles

    @property
    def stands_alike(self) -> bool:
        """Whether the bodies have the same state at all positions: splines on common axes."""
        concentric = self.geometry is not None and self.geometry.center_distance_mm == 0.0
        return self.whole_circle and concentric and not self.drawing.tilted


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class LoadedPositions(PairPositions):
    """Rotation and loads at P positions on S sites under one torque; fields as in `Result`.

    Quantities that follow from these are computed on first use.
    """

    torque_Nm: float
    sites: Numbers
    rotation_rad: Floats
    site_force_N: Floats
    peak_pressure_MPa: Floats
    stiffness_tangent_Nm_per_rad: Floats
    status: Numbers
    pair_tables: Sequence[PairTable]
    corner_contact: Flags
    unloaded_rotation_rad: Floats | None = None

    def __post_init__(self) -> None:
        """Copy the arrays and make them read-only.

        Raises
        ------
        ValueError
            If an array has another shape than (P,), (P, S) or (S,), or P or S is 0.
        """
        size = {"P": np.size(self.position_rad), "S": np.size(self.sites)}
        if 0 in size.values():
            raise ValueError(f"expected positions and sites, found {size['P']} and {size['S']}")
        for key, (axes, kind) in ARRAYS.items():
            value = getattr(self, key)
            if value is None and key in OPTIONAL_ARRAYS:
                continue
            array: NDArray[Any] = np.array(value, dtype=kind)
            if array.shape != (shape := tuple(size[axis] for axis in axes)):
                raise ValueError(f"{key}: expected shape {shape}, found {array.shape}")
            object.__setattr__(self, key, frozen(array))
        if len(self.pair_tables) != size["P"]:
            raise ValueError(f"pair_tables: expected {size['P']}, found {len(self.pair_tables)}")

    @per_torque
    def torque_Nmm(self) -> float:
        """Torque on body 1, N mm."""
        return N_MM_PER_N_M * self.torque_Nm

    @per_torque
    def rotation_deg(self) -> Floats:
        """(P,) Additional rotation of body 1 under load, degrees."""
        return frozen(np.degrees(self.rotation_rad))

    @per_torque
    def unloaded_rotation_deg(self) -> Floats | None:
        """(P,) Rotation without torque, degrees; None if no such state exists."""
        unloaded = self.unloaded_rotation_rad
        return None if unloaded is None else frozen(np.degrees(unloaded))

    @per_torque
    def transmission_error_um(self) -> Floats:
        """(P,) Rotation times reference radius, um; positive if body 1 has turned further."""
        return frozen(1000.0 * self.rotation_rad * self.reference_radius_mm)

    @per_torque
    def unloaded_transmission_error_um(self) -> Floats | None:
        """(P,) Transmission error without torque, um; None if no such state exists."""
        unloaded = self.unloaded_rotation_rad
        return None if unloaded is None else 1000.0 * unloaded * self.reference_radius_mm

    @per_torque
    def turned_by_load_rad(self) -> Floats:
        """(P,) Rotation minus that without torque; if the latter is unknown, the whole rotation."""
        unloaded = self.unloaded_rotation_rad
        return self.rotation_rad if unloaded is None else self.rotation_rad - unloaded

    @per_torque
    def load_share(self) -> Floats:
        """(P, S) Force divided by the sum of forces, for working flanks; 0 if unloaded."""
        total = self.site_force_N.sum(axis=1, keepdims=True)
        share = np.zeros_like(self.site_force_N)
        np.divide(self.site_force_N, total, out=share, where=total > 0)
        return frozen(share)

    @per_torque
    def loaded_pairs(self) -> Numbers:
        """(P,) Number of pairs (on splines: teeth) that carry load."""
        return frozen((self.site_force_N > 0).sum(axis=1))

    @per_torque
    def potential_pairs(self) -> Numbers:
        """(P,) Number of pairs that could carry load.

        Pairs between the ends of the geometric path of contact, and pairs whose rigid flanks would
        touch (their gap without load is less than the rotation, so that the core
        places cells on them).
        """
        path = None if self.geometry is None else self.geometry.path_pitches
        counts = []
        for place, table in zip(self.position_rad / self.pitch_rad, self.pair_tables, strict=True):
            could = set(table.site.tolist())
            if path is not None:
                # pair j is j pitches further along
                could |= set(range(round_up(path[0] - place), round_down(path[1] - place) + 1))
            counts.append(len(could))
        return frozen(np.array(counts))

    @per_torque
    def flank_contacts(self) -> FlankContacts:
        """Contact width of each pair, and motion of both bodies there."""
        return flank_contacts(self.pair_tables, self.sites, self.geometry)

    @per_torque
    def contact_half_width_mm(self) -> Floats:
        """(P, S) Half the length of flank in contact, more accurate than one cell; NaN if open.

        A Hertz contact has b = sqrt(2 rho F c) with the line load F, the reduced radius rho and the
        sum c of 2 (1 - nu²)/(pi E) of both bodies (plane strain). In three dimensions the largest
        of all slices.
        """
        return self.flank_contacts.half_width_mm

    @per_torque
    def sliding_mm_per_rad(self) -> Floats:
        """(P, S) Sliding (v_2 - v_1)·t_1, mean over each contact weighted by force; NaN if open.

        t_1 points to the tip of body 1. The value is per rad of body 1 in the sense of its torque:
        multiplied by its speed in rad/s it is in mm/s; if body 2 drives, that speed is negative.
        """
        if self.geometry is None:
            return frozen(np.full(self.site_force_N.shape, np.nan))
        return frozen(self.flank_contacts.velocity_2 - self.flank_contacts.velocity_1)

    @per_torque
    def specific_sliding_1(self) -> Floats:
        """(P, S) 1 - v_2/v_1 (DIN 3960), v along the flank; NaN if open, or if v_1 is 0."""
        return _specific(self.flank_contacts.velocity_1, self.flank_contacts.velocity_2)

    @per_torque
    def specific_sliding_2(self) -> Floats:
        """(P, S) 1 - v_1/v_2 (DIN 3960), v along the flank; NaN if open, or if v_2 is 0."""
        return _specific(self.flank_contacts.velocity_2, self.flank_contacts.velocity_1)

    @per_torque
    def coast_flank_gap_um(self) -> Floats | None:
        """(P,) Distance of the coast flanks along the line of action, um; None if not known.

        From geometry: body 1 has turned by the rotation, and flanks have their shape without load.
        Loaded teeth bend back by part of the rotation, so at least this distance minus the
        transmission error remains. The angle by which body 1 turns back when its torque reverses is
        this distance divided by its base radius.
        """
        if self.geometry is None or self.geometry.coast is None:
            return None
        coast = self.geometry.coast
        return frozen(1000.0 * coast.base_radius_mm * (coast.gap_rad + self.rotation_rad))

    @per_torque
    def stiffness_secant_Nm_per_rad(self) -> Floats:
        """(P,) Torque divided by the rotation beyond that without torque; NaN unless both > 0.

        The rotation caused by deviations, an offset, expansion and preload is no deflection.
        """
        turned = self.turned_by_load_rad
        stiffness = np.full_like(turned, np.nan)
        np.divide(self.torque_Nm, turned, out=stiffness, where=(turned > 0) & (self.torque_Nm > 0))
        return frozen(stiffness)

    @per_torque
    def stiffness_secant_N_per_um(self) -> Floats:
        """(P,) Secant stiffness along the line of action (force divided by deflection there)."""
        return self._along_line_of_action(self.stiffness_secant_Nm_per_rad)

    @per_torque
    def stiffness_tangent_N_per_um(self) -> Floats:
        """(P,) Tangent stiffness along the line of action."""
        return self._along_line_of_action(self.stiffness_tangent_Nm_per_rad)

    def _along_line_of_action(self, stiffness_Nm_per_rad: Floats) -> Floats:
        # N m = 1000 N mm and mm = 1000 um: the factors cancel.
        return frozen(stiffness_Nm_per_rad / self.reference_radius_mm**2)

    def pairs(self, p: int) -> PairTable:
        """Contact pairs of position p: radius, force, pressure, gap and place.

        For a list of torques, a tuple with a table for each.
        """
        tables = tuple(one.pair_tables[p] for one in self.by_torque)
        return tables if self.has_torque_list else tables[0]  # type: ignore[return-value]


def _specific(own: Floats, other: Floats) -> Floats:
    found = np.full_like(own, np.nan)
    np.divide(own - other, own, out=found, where=own != 0)
    return frozen(found)
