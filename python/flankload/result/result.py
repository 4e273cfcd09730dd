"""Result of one torque at all positions, and derived quantities."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from math import degrees
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from flankload.result.belt import BeltDrive
from flankload.result.chain import ChainDrive
from flankload.result.coast_contact import CoastContact, coast_summary
from flankload.result.contact_quantities import ContactQuantities, frozen
from flankload.result.forms import ResultForms
from flankload.result.friction import FrictionResult
from flankload.result.harmonics import over_positions
from flankload.result.pairs import PairDrawing, PairTable
from flankload.result.root_stress import RootReading, RootStress, root_stress, root_summary
from flankload.result.shafts import ShaftLoads, shaft_summary
from flankload.result.slices import SliceLoads, slice_summary
from flankload.result.summary import stiffness_means, summary_of_contacts

if TYPE_CHECKING:
    from flankload.result.geometry import PairGeometry

Floats = NDArray[np.float64]

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
#: Those that may be None.
OPTIONAL_ARRAYS = ("follower_angle_rad", "unloaded_rotation_rad")


@dataclass(frozen=True, eq=False, repr=False)
class Result(ContactQuantities, ResultForms):
    """Load distribution at P positions on S sites (flank pairs), for one torque.

    A scene with a list of torques has a `TorqueSeries`, a result whose arrays have an axis of
    torques in front.

    Attributes
    ----------
    name : str
        Name of the scene.
    torque_Nm : float
        Torque on body 1.
    sites : (S,) array
        Pair numbers: pair 0 is at the pitch point at position 0, greater numbers are further into
        recess.
    position_rad, rotation_rad : (P,) arrays
        Angle of body 1 (with a cam: of the cam) from position zero; additional rotation of body 1
        under load.
    reference_radius_mm, face_width_mm : float
        Radius that converts rotation into transmission error; face width.
    pitch_rad, period_rad : float
        One tooth pitch of body 1 (a turn of the cam); rotation of body 1 after which everything
        repeats.
    closed : bool
        Whether the ascending positions cover the period once from the first on: the last position
        is followed by the first, a period later.
    whole_circle : bool
        Whether the sites are all teeth of the bodies (splines), including unloaded ones.
    follower_angle_rad : (P,) array or None
        Angle of a follower on its cam without load, counter-clockwise from the line between both
        axes to the line through its axis and its roller's centre (along its flat). None for other
        pairs.
    site_force_N, peak_pressure_MPa : (P, S) arrays
        Force of each flank pair, 0 if open; largest pressure of each flank pair, 0 if open.
    stiffness_tangent_Nm_per_rad : (P,) array
        Derivative of the torque with respect to the rotation.
    status : (P,) array
        0 solved, 1 ill-conditioned, 2 degenerate, 3 uniqueness not certain.
    pair_tables : sequence of PairTable, one per position
    corner_contact : (P, S) array of bool
        Contact on a sharp corner, where the peak pressure is meaningless.
    estimate : dict or None
        Estimated relative errors.
    cost : dict
        Seconds by stage and counters.
    unloaded_rotation_rad : (P,) array or None
        Rotation without torque, caused by deviations, offset, expansion and preload. None if no
        such state exists, and for chains and belts.
    accuracy : dict or None
        Report on a tolerance named by the scene: values of the discretization and their reasons.
    warnings : tuple of str
    slices : SliceLoads or None
        Loads of the slices of the face width; None in a plane scene.
    shafts : ShaftLoads or None
        Tilt of the teeth by shafts, forces on their bearings; None without shafts.
    outside_limits : tuple of str
        Premises of the model that the scene violates, with `effects.beyond_limits = true`; the
        error estimate, which also lists them, does not include the consequences.
    drawing : PairDrawing
    friction : FrictionResult or None
        Friction forces, losses, torque on body 2; None without friction.
    geometry : PairGeometry or None
        Positions and motion of the bodies; without it sliding and coast flanks are unknown.
    drive : ChainDrive, BeltDrive or None
        Tensions, places and margins of a chain or a belt; its sites are rollers, or teeth of the
        belt, with circumferential forces; pressures are 0.
    root_readings : two RootReading or None
        Conversion of forces into stress in the tooth roots, if requested.
    coast : CoastContact or None
        Contact on the coast flanks, if they can carry load; everything else refers to working
        flanks.
    """

    name: str
    torque_Nm: float
    sites: NDArray[np.int64]
    position_rad: Floats
    rotation_rad: Floats
    reference_radius_mm: float
    face_width_mm: float
    pitch_rad: float
    period_rad: float
    closed: bool
    site_force_N: Floats
    peak_pressure_MPa: Floats
    stiffness_tangent_Nm_per_rad: Floats
    status: NDArray[np.int64]
    pair_tables: Sequence[PairTable]
    corner_contact: NDArray[np.bool_]
    estimate: Mapping[str, Any] | None
    cost: Mapping[str, Any]
    warnings: tuple[str, ...]
    drawing: PairDrawing
    whole_circle: bool = False
    friction: FrictionResult | None = None
    geometry: PairGeometry | None = None
    root_readings: tuple[RootReading | None, RootReading | None] = (None, None)
    follower_angle_rad: Floats | None = None
    drive: ChainDrive | BeltDrive | None = None
    coast: CoastContact | None = None
    accuracy: Mapping[str, Any] | None = None
    unloaded_rotation_rad: Floats | None = None
    outside_limits: tuple[str, ...] = ()
    slices: SliceLoads | None = None
    shafts: ShaftLoads | None = None

    @property
    def by_torque(self) -> tuple[Result, ...]:
        """The results of single torques: this one alone."""
        return (self,)

    @property
    def position_deg(self) -> Floats:
        """(P,) Angle of body 1 (with a cam: of the cam) from position zero, degrees."""
        return frozen(np.degrees(self.position_rad))

    @property
    def rotation_deg(self) -> Floats:
        """(P,) Additional rotation of body 1 under load, degrees."""
        return frozen(np.degrees(self.rotation_rad))

    @property
    def unloaded_rotation_deg(self) -> Floats | None:
        """(P,) Rotation without torque, degrees; None if no such state exists."""
        unloaded = self.unloaded_rotation_rad
        return None if unloaded is None else frozen(np.degrees(unloaded))

    @property
    def follower_angle_deg(self) -> Floats | None:
        """(P,) Angle of a follower on its cam without load, degrees; None for other pairs."""
        angle = self.follower_angle_rad
        return None if angle is None else frozen(np.degrees(angle))

    @property
    def pitch_deg(self) -> float:
        """One tooth pitch of body 1 (a turn of the cam), degrees."""
        return degrees(self.pitch_rad)

    @property
    def period_deg(self) -> float:
        """Rotation of body 1 after which everything repeats, degrees."""
        return degrees(self.period_rad)

    @property
    def slice_z_mm(self) -> Floats:
        """(J,) Axial positions of the slices; one slice at 0 in a plane scene."""
        return frozen(np.zeros(1)) if self.slices is None else self.slices.z_mm

    @property
    def slice_peak_pressure_MPa(self) -> Floats:
        """(P, S, J) Largest pressure of each flank pair in each slice."""
        if self.slices is None:
            return self.peak_pressure_MPa[..., np.newaxis]
        return self.slices.peak_pressure_MPa

    @property
    def slice_line_load_N_per_mm(self) -> Floats:
        """(P, S, J) Force per mm of face width of each flank pair in each slice."""
        if self.slices is None:
            return self.line_load_N_per_mm[..., np.newaxis]
        return self.slices.line_load_N_per_mm

    @property
    def tilt_um_per_mm(self) -> Floats | None:
        """(P,) Slope of the gap along z by both shafts, um/mm; None without shafts."""
        return None if self.shafts is None else self.shafts.tilt_um_per_mm

    @property
    def axial_force_N(self) -> Floats:
        """(P,) Axial force on body 1, positive along z; 0 in a plane scene."""
        if self.slices is None:
            return frozen(np.zeros_like(self.rotation_rad))
        return self.slices.axial_force_N

    @property
    def tilting_moment_Nm(self) -> Floats:
        """(P,) Moment of the transverse forces about the middle of the face width, N m; 0 if plane.

        Positive if more load is at larger z; of a spline the magnitude of the moment about x and y.
        """
        if self.slices is None:
            return frozen(np.zeros_like(self.rotation_rad))
        return self.slices.tilting_moment_Nm

    @property
    def flank_face_load_factor(self) -> Floats:
        """(P, S) Largest line load of each flank over its mean; 1 in a plane scene."""
        if self.slices is None:
            return frozen(np.ones_like(self.site_force_N))
        return self.slices.flank_face_load_factor

    @property
    def face_load_factor(self) -> float:
        """K_Hbeta: largest line load of a slice over the mean; 1 in a plane scene.

        The load of a slice is the sum over all flanks; of a spline that of one tooth, and the mean
        is that of all teeth.
        """
        return 1.0 if self.slices is None else self.slices.face_load_factor

    @cached_property
    def transverse_load_factor(self) -> float | None:
        """K_Halpha: largest load share of a pair times the mean number of loaded pairs.

        None if the positions do not cover the period.
        """
        over = over_positions(self)
        if not over.covers_period:
            return None
        return float(self.load_share.max() * over.mean_of_steps(self.loaded_pairs))

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

    @property
    def coast_force_N(self) -> Floats | None:
        """(P, S) Force of each coast flank, 0 if open; None if they cannot carry load."""
        return None if self.coast is None else self.coast.force_N

    @property
    def coast_peak_pressure_MPa(self) -> Floats | None:
        """(P, S) Largest pressure of each coast flank; None if they cannot carry load."""
        return None if self.coast is None else self.coast.peak_pressure_MPa

    @property
    def has_cam(self) -> bool:
        """Whether a follower lies on a cam."""
        return self.follower_angle_rad is not None

    @property
    def words_for_sites(self) -> tuple[str, str]:
        """Words for a site, and for several: pair, tooth or roller."""
        if self.drive is not None:
            return self.drive.words_for_sites
        return ("tooth", "teeth") if self.whole_circle else ("pair", "pairs")

    @cached_property
    def transmission_error_um(self) -> Floats:
        """(P,) Rotation times reference radius, um; positive if body 1 has turned further."""
        return frozen(1000.0 * self.rotation_rad * self.reference_radius_mm)

    @property
    def unloaded_transmission_error_um(self) -> Floats | None:
        """(P,) Transmission error without torque, um; None if no such state exists."""
        unloaded = self.unloaded_rotation_rad
        return None if unloaded is None else 1000.0 * unloaded * self.reference_radius_mm

    @property
    def turned_by_load_rad(self) -> Floats:
        """(P,) Rotation minus that without torque; if the latter is unknown, the whole rotation."""
        unloaded = self.unloaded_rotation_rad
        return self.rotation_rad if unloaded is None else self.rotation_rad - unloaded

    @cached_property
    def load_share(self) -> Floats:
        """(P, S) Force divided by the sum of forces, for working flanks; 0 if unloaded."""
        total = self.site_force_N.sum(axis=1, keepdims=True)
        share = np.zeros_like(self.site_force_N)
        np.divide(self.site_force_N, total, out=share, where=total > 0)
        return frozen(share)

    @property
    def period_pitches(self) -> int:
        """Number of tooth pitches of body 1 in a period."""
        return round(self.period_rad / self.pitch_rad)

    @cached_property
    def loaded_pairs(self) -> NDArray[np.int64]:
        """(P,) Number of pairs (on splines: teeth) that carry load."""
        return frozen((self.site_force_N > 0).sum(axis=1))

    @property
    def stands_alike(self) -> bool:
        """Whether the bodies have the same state at all positions: splines on common axes."""
        concentric = self.geometry is not None and self.geometry.center_distance_mm == 0.0
        return self.whole_circle and concentric and not self.drawing.tilted

    @cached_property
    def root_stress(self) -> tuple[RootStress | None, RootStress | None]:
        """Stress in the tooth roots of both bodies; None if not requested, or for rigid bodies."""
        one, two = (
            None if reading is None else root_stress(reading, self.pair_tables, self.sites, z)
            for z, reading in enumerate(self.root_readings)
        )
        return one, two

    @cached_property
    def stiffness_secant_Nm_per_rad(self) -> Floats:
        """(P,) Torque divided by the rotation beyond that without torque; NaN unless both > 0.

        The rotation caused by deviations, an offset, expansion and preload is no deflection.
        """
        turned = self.turned_by_load_rad
        stiffness = np.full_like(turned, np.nan)
        np.divide(self.torque_Nm, turned, out=stiffness, where=(turned > 0) & (self.torque_Nm > 0))
        return frozen(stiffness)

    @property
    def stiffness_secant_N_per_um(self) -> Floats:
        """(P,) Secant stiffness along the line of action (force divided by deflection there)."""
        return self._along_line_of_action(self.stiffness_secant_Nm_per_rad)

    @property
    def stiffness_tangent_N_per_um(self) -> Floats:
        """(P,) Tangent stiffness along the line of action."""
        return self._along_line_of_action(self.stiffness_tangent_Nm_per_rad)

    @property
    def _by_load_um(self) -> Floats:
        return 1000.0 * self.turned_by_load_rad * self.reference_radius_mm

    def _along_line_of_action(self, stiffness_Nm_per_rad: Floats) -> Floats:
        # N m = 1000 N mm and mm = 1000 um: the factors cancel.
        return frozen(stiffness_Nm_per_rad / self.reference_radius_mm**2)

    @cached_property
    def key_figures(self) -> dict[str, Any]:
        """Part of the summary that follows from few curves: its entries up to the pressures."""
        error = self.transmission_error_um
        loaded = self.loaded_pairs
        smooth = np.where(self.corner_contact, 0.0, self.peak_pressure_MPa)
        over = over_positions(self)
        return {
            "transmission_error_mean_um": over.mean(error),
            "transmission_error_by_load_mean_um": over.mean(self._by_load_um),
            "transmission_error_peak_to_peak_um": float(np.ptp(error)),
            "transmission_error_harmonics_um": over.harmonics(error),
            "transmission_error_mesh_harmonics_um": over.harmonics(
                error, every=self.period_pitches
            ),
            "contact_ratio_under_load": over.mean_of_steps(loaded) if over.covers_period else None,
            "contact_ratio_geometric": self.geometry.contact_ratio if self.geometry else None,
            "contact_ratio_usable": self.geometry.usable_contact_ratio if self.geometry else None,
            "loaded_pairs_min": int(loaded.min()),
            "loaded_pairs_max": int(loaded.max()),
            **self._largest("peak_pressure", self.peak_pressure_MPa),
            "peak_pressure_at_corner": bool(self.peak_pressure_MPa.max() > smooth.max()),
            **self._largest("peak_pressure_off_corners", smooth),
        }

    @cached_property
    def summary(self) -> dict[str, Any]:
        """Summary of a report.

        `transmission_error_mean_um` (over the period; for uneven positions the integral of the
        curve through them), `transmission_error_by_load_mean_um` (the same minus the state without
        torque), `transmission_error_peak_to_peak_um` (of the positions);
        `transmission_error_harmonics_um` (amplitudes of the first five of the period),
        `transmission_error_mesh_harmonics_um` (the same of a tooth pitch: waves that pass once,
        twice, ... in a pitch) and `contact_ratio_under_load` (mean number of loaded pairs), None if
        the positions do not cover the period; `loaded_pairs_min`, `loaded_pairs_max`;
        `peak_pressure_MPa` with `peak_pressure_position_rad`, `peak_pressure_pair`,
        `peak_pressure_at_corner`; and the same for `peak_pressure_off_corners`, the largest
        meaningful one. In addition `contact_ratio_geometric` (path of contact divided by base
        pitch; None if unknown), `contact_ratio_usable` (the same between form circles and tip
        roundings or chamfers), the means of both stiffnesses over the period,
        `peak_line_load_N_per_mm` with its position and pair, `largest_sliding_mm_per_rad`
        (magnitude) and `coast_flank_gap_min_um`; if requested, `root_stress_1` and `root_stress_2`
        with largest `tension` and `compression`, and the `coast_summary` of the coast flanks. In
        three dimensions `face_load_factor`, `peak_line_load_z_mm` and the largest magnitudes
        `axial_force_N` and `tilting_moment_Nm`; with shafts `tilt_mean_um_per_mm` and the largest
        force on each bearing, and `k_h_beta_iso` for comparison if one bends under the teeth.
        """
        return {
            **self.key_figures,
            **stiffness_means(self),
            **summary_of_contacts(self),
            **coast_summary(self),
            **self._root_summary(),
            **slice_summary(self.slices),
            **shaft_summary(self.shafts, over_positions(self).mean),
        }

    def _root_summary(self) -> dict[str, Any]:
        return {
            f"root_stress_{z + 1}": root_summary(
                stress, self.position_rad, self.sites, self.site_force_N
            )
            for z, stress in enumerate(self.root_stress)
            if stress is not None
        }

    def _largest(self, key: str, pressure: Floats) -> dict[str, Any]:
        """Largest pressure with its position and pair; None if there is none."""
        p, s = np.unravel_index(np.argmax(pressure), pressure.shape)
        found = float(pressure[p, s])
        return {
            f"{key}_MPa": found,
            f"{key}_position_rad": float(self.position_rad[p]) if found > 0 else None,
            f"{key}_pair": int(self.sites[s]) if found > 0 else None,
        }

    def pairs(self, p: int) -> PairTable:
        """Contact pairs of position p: radius, force, pressure, gap and place."""
        return self.pair_tables[p]
