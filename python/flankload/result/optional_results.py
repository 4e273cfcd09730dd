"""Results that only some scenes have: slices, shafts, coast flanks, friction, drives."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from flankload.base.arrays import Flags, Floats, Numbers
from flankload.base.card import Card
from flankload.base.read_only import KeepsReadOnly
from flankload.result.drives import BeltDrive, ChainDrive
from flankload.result.engagement import Engagement, engagement_of
from flankload.result.friction import FrictionResult
from flankload.result.loaded_positions import LoadedPositions
from flankload.result.pairs import PairTable
from flankload.result.root_stress import RootReading, RootStress, root_stress
from flankload.result.slices import PlaneLoads, SliceLoads
from flankload.result.stage import StageLoads
from flankload.result.torque_axis import per_torque
from flankload.result.train import DoubleHelicalLoads, TrainLoads, TwoMeshes

#: Arrays over positions and sites that only results with coast flanks have, with their units.
OVER_COAST_SITES = {"coast_force_N": "N", "coast_peak_pressure_MPa": "MPa"}


@dataclass(frozen=True, eq=False, repr=False)
class CoastContact(KeepsReadOnly, Card):
    """Contact on coast flanks at P positions, for the S pair numbers of the working flanks.

    Pair j is the tooth of body 1 whose working flank belongs to pair j; its coast flank faces the
    tooth of body 2 that meets the next tooth, or, if body 2 is an internal gear, the other side of
    its own space.

    Attributes
    ----------
    force_N, peak_pressure_MPa : (P, S) arrays
        Force and largest pressure; 0 if open.
    corner_contact : (P, S) array of bool
        Contact on a sharp corner, where no finite peak pressure exists.
    pair_tables : sequence of PairTable, one per position
        Their forces turn body 1 against its torque.
    """

    force_N: Floats
    peak_pressure_MPa: Floats
    corner_contact: Flags
    pair_tables: Sequence[PairTable]

    @property
    def loaded(self) -> Numbers:
        """(P,) Number of coast flanks that carry load."""
        return np.asarray((self.force_N > 0).sum(axis=1))


@dataclass(frozen=True, eq=False, repr=False)
class ShaftLoads(KeepsReadOnly, Card):
    """Shafts and bearings of both bodies at P positions.

    Attributes
    ----------
    tilt_um_per_mm : (P,) array
        Slope of the gap between the flanks by both shafts, along the base tangent; positive if the
        gap opens towards larger z, as a positive `helix_slope_um` over the face width does.
    bearing_force_1_N, bearing_force_2_N : (P, B, 3) arrays
        Force (x, y, z) of the shaft on each of its B bearings; x from axis 1 to axis 2, z along the
        axes. B = 0 if the shaft is known by its compliance only, and without a shaft.
    k_h_beta_iso : float or None
        Face load factor by the formulas of ISO 6336-1, method C, for comparison only; None without
        a shaft that bends and twists under the teeth of the pinion, and where they do not apply.
    """

    tilt_um_per_mm: Floats
    bearing_force_1_N: Floats
    bearing_force_2_N: Floats
    k_h_beta_iso: float | None = None

    @property
    def bearing_forces(self) -> dict[str, Floats]:
        """Forces on the bearings of the shafts with known bearings, by name."""
        names = ("bearing_force_1_N", "bearing_force_2_N")
        return {name: getattr(self, name) for name in names if getattr(self, name).size}


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class EffectResults(LoadedPositions):
    """Loaded positions with the results that only some scenes have; fields as in `Result`."""

    friction: FrictionResult | None = None
    root_readings: tuple[RootReading | None, RootReading | None] = (None, None)
    drive: ChainDrive | BeltDrive | StageLoads | TwoMeshes | None = None
    coast: CoastContact | None = None
    slices: SliceLoads | None = None
    shafts: ShaftLoads | None = None

    @property
    def words_for_sites(self) -> tuple[str, str]:
        """Words for a site, and for several: pair, tooth or roller."""
        return self.engagement.words_for_sites

    @property
    def engagement(self) -> Engagement:
        """How the bodies touch: words, tables and pictures that depend on it."""
        return engagement_of(self.by_torque[0])

    @per_torque
    def stage(self) -> StageLoads | None:
        """Loads of a planetary stage; None without one."""
        return self.drive if isinstance(self.drive, StageLoads) else None

    @per_torque
    def train(self) -> TrainLoads | DoubleHelicalLoads | None:
        """Loads of a gear train, or of double helical gears; None without one."""
        return self.drive if isinstance(self.drive, TrainLoads | DoubleHelicalLoads) else None

    @per_torque
    def bearing_force_N(self) -> Floats | None:
        """(P, B, 2) Force of each body of a train on its bearings; None without a train."""
        return None if self.train is None else self.train.bearing_force_N

    @per_torque
    def mesh_load_factor(self) -> Floats | None:
        """(P,) K_gamma: number of planets times the largest share; None without planets."""
        return None if self.stage is None else self.stage.mesh_load_factor

    @per_torque
    def planet_load_share(self) -> Floats | None:
        """(P, n) Share of each planet in the load of the meshes with the sun; None without one."""
        return None if self.stage is None else self.load_share

    @per_torque
    def planet_force_N(self) -> Floats | None:
        """(P, n, 2) Force of the sun on each planet, in the frame of the carrier."""
        return None if self.stage is None else self.stage.planet_force_N

    @per_torque
    def pin_force_N(self) -> Floats | None:
        """(P, n, 2) Force of each planet on its pin, in the frame of the carrier."""
        return None if self.stage is None else self.stage.pin_force_N

    @per_torque
    def sun_orbit_um(self) -> Floats | None:
        """(P, 2) Displacement of the sun of a stage in the frame of the carrier."""
        return None if self.stage is None else self.stage.sun_orbit_um

    @per_torque
    def ring_orbit_um(self) -> Floats | None:
        """(P, 2) Displacement of the ring of a stage in the frame of the carrier."""
        return None if self.stage is None else self.stage.ring_orbit_um

    @per_torque
    def carrier_orbit_um(self) -> Floats | None:
        """(P, 2) Displacement of the carrier of a stage from the middle."""
        return None if self.stage is None else self.stage.carrier_orbit_um

    @per_torque
    def ring_deflection_um(self) -> Floats | None:
        """(P, z) Radial displacement of the outside of the ring behind each of its spaces."""
        return None if self.stage is None else self.stage.ring_deflection_um

    @per_torque
    def ring_torque_Nm(self) -> Floats | None:
        """(P,) Torque of the planets on the ring, clockwise; None without a stage."""
        return None if self.stage is None else self.stage.ring_torque_Nm

    @per_torque
    def carrier_torque_Nm(self) -> Floats | None:
        """(P,) Torque on the carrier, counter-clockwise; None without a stage."""
        return None if self.stage is None else self.stage.carrier_torque_Nm

    @per_torque
    def transmission_error_output_urad(self) -> Floats | None:
        """(P,) Transmission error at the carrier, with the ring at rest; None without a stage."""
        return None if self.stage is None else self.stage.transmission_error_output_urad

    def site_after_period(self, s: int) -> int | None:
        """Index of the site whose place site s takes a period later; None if it is not listed."""
        if self.engagement.sites_stay:
            return s
        number = self.sites[s] + self.period_pitches
        if self.engagement.cyclic_sites:
            number %= self.sites.size
        found = np.flatnonzero(self.sites == number)
        return int(found[0]) if found.size else None

    @per_torque
    def width_loads(self) -> SliceLoads:
        """Loads of the slices of the face width; of a plane result those of a single one."""
        return self.slices or PlaneLoads.of(
            self.site_force_N, self.peak_pressure_MPa, self.face_width_mm
        )

    @per_torque
    def line_load_N_per_mm(self) -> Floats:
        """(P, S) Force of each pair per mm of face width; (P, S, J) in three dimensions."""
        return self.width_loads.per_width

    @property
    def slice_z_mm(self) -> Floats:
        """(J,) Axial positions of the slices; one slice at 0 in a plane scene."""
        return self.by_torque[0].width_loads.z_mm

    @per_torque
    def slice_peak_pressure_MPa(self) -> Floats:
        """(P, S, J) Largest pressure of each flank pair in each slice."""
        return self.width_loads.peak_pressure_MPa

    @per_torque
    def slice_line_load_N_per_mm(self) -> Floats:
        """(P, S, J) Force per mm of face width of each flank pair in each slice."""
        return self.width_loads.line_load_N_per_mm

    @per_torque
    def mean_line_load_N_per_mm(self) -> Floats:
        """(P, S, J) Mean line load over `line_load_length_mm`, the larger of those that begin or
        end with a slice."""
        return self.width_loads.mean_line_load_N_per_mm

    @per_torque
    def tilt_um_per_mm(self) -> Floats | None:
        """(P,) Slope of the gap along z by both shafts, um/mm; None without shafts."""
        return None if self.shafts is None else self.shafts.tilt_um_per_mm

    @per_torque
    def axial_force_N(self) -> Floats:
        """(P,) Axial force on body 1, positive along z; 0 in a plane scene."""
        return self.width_loads.axial_force_N

    @per_torque
    def tilting_moment_Nm(self) -> Floats:
        """(P,) Moment of the transverse forces about the middle of the face width, N m; 0 if plane.

        Positive if more load is at larger z; of a spline the magnitude of the moment about x and y.
        """
        return self.width_loads.tilting_moment_Nm

    @per_torque
    def flank_face_load_factor(self) -> Floats:
        """(P, S) Largest line load of each flank over its mean; 1 in a plane scene."""
        return self.width_loads.flank_face_load_factor

    @per_torque
    def face_load_factor(self) -> float:
        """K_Hbeta (ISO 6336-1): load over the face width, largest over mean; 1 in a plane scene.

        The load of a slice is the sum over all flanks, averaged over the mesh period (over the
        positions where they do not cover the period). Of a spline equal to `line_load_factor`.
        """
        return self.width_loads.face_load_factor

    @per_torque
    def line_load_factor(self) -> float:
        """Largest line load of all positions over the mean at its position; 1 in a plane scene.

        The line load of a slice is the sum over all flanks. On helical pairs it varies along the
        face width even if the load averaged over the mesh period does not: where a contact line
        ends, others carry. Of a spline it is that of one tooth, and the mean is that of all teeth.
        """
        return self.width_loads.line_load_factor

    @per_torque
    def coast_force_N(self) -> Floats | None:
        """(P, S) Force of each coast flank, 0 if open; None if they cannot carry load."""
        return None if self.coast is None else self.coast.force_N

    @per_torque
    def coast_peak_pressure_MPa(self) -> Floats | None:
        """(P, S) Largest pressure of each coast flank; None if they cannot carry load."""
        return None if self.coast is None else self.coast.peak_pressure_MPa

    @per_torque
    def root_stress(self) -> tuple[RootStress | None, RootStress | None]:
        """Stress in the tooth roots of both bodies; None if not requested, or for rigid bodies."""
        one, two = (
            None if reading is None else root_stress(reading, self.pair_tables, self.sites, z)
            for z, reading in enumerate(self.root_readings)
        )
        return one, two
