"""Parts of a result that only some scenes have: slices, shafts, coast flanks, friction, drives."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from flankload.base.read_only import frozen
from flankload.result.coast_contact import CoastContact
from flankload.result.course import Course
from flankload.result.drives import BeltDrive, ChainDrive
from flankload.result.friction import FrictionResult
from flankload.result.root_stress import RootReading, RootStress, root_stress
from flankload.result.shafts import ShaftLoads
from flankload.result.slices import SliceLoads

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class Parts(Course):
    """A course with the parts that only some scenes have; fields as in `Result`."""

    friction: FrictionResult | None = None
    root_readings: tuple[RootReading | None, RootReading | None] = (None, None)
    drive: ChainDrive | BeltDrive | None = None
    coast: CoastContact | None = None
    slices: SliceLoads | None = None
    shafts: ShaftLoads | None = None

    @cached_property
    def line_load_N_per_mm(self) -> Floats:
        """(P, S) Force of each pair per mm of face width; (P, S, J) in three dimensions."""
        if self.slices is not None:
            return self.slices.line_load_N_per_mm
        return frozen(self.site_force_N / self.face_width_mm)

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

    @property
    def coast_force_N(self) -> Floats | None:
        """(P, S) Force of each coast flank, 0 if open; None if they cannot carry load."""
        return None if self.coast is None else self.coast.force_N

    @property
    def coast_peak_pressure_MPa(self) -> Floats | None:
        """(P, S) Largest pressure of each coast flank; None if they cannot carry load."""
        return None if self.coast is None else self.coast.peak_pressure_MPa

    @cached_property
    def root_stress(self) -> tuple[RootStress | None, RootStress | None]:
        """Stress in the tooth roots of both bodies; None if not requested, or for rigid bodies."""
        one, two = (
            None if reading is None else root_stress(reading, self.pair_tables, self.sites, z)
            for z, reading in enumerate(self.root_readings)
        )
        return one, two
