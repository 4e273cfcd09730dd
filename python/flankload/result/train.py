"""Quantities of gears in two meshes: forces, torques, displacements, load over the width."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from flankload.errors import InputError
from flankload.result.drives import Drive
from flankload.result.engagement import rows_of_positions
from flankload.result.harmonics import over_positions

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from flankload.base.arrays import Floats
    from flankload.result.result import Result


@dataclass(frozen=True, eq=False, repr=False)
class TwoMeshes(Drive):
    """Loads of gears in two meshes at P positions, in the frame with axis 1 at the origin.

    Attributes
    ----------
    kind : {"idler", "two_pinions", "double_helical"}
    teeth : tuple of int
        Tooth numbers of the bodies of the scene.
    centers_mm : (B, 2) array
        Axes of the bodies.
    torque_2_Nm : (P,) array
        Torque of the meshes on body 2, counter-clockwise.
    bearing_force_N : (P, B, 2) array
        Force of each body on its bearings, which is that of its meshes on it.
    meshes : two Result, each made when it is read
        Results of both meshes.
    """

    kind: str
    teeth: tuple[int, ...]
    centers_mm: Floats
    torque_2_Nm: Floats = field(metadata={"P": "N m"})
    bearing_force_N: Floats
    meshes: Sequence[Result]

    name = "train"
    key = "train"
    words_for_sites = ("mesh", "meshes")
    has_pressures = True
    pairs_advance = False
    sites_stay = True
    site_word = "mesh"
    drawn_bodies = None

    def mesh(self, number: int) -> Result:
        """Result of one mesh, from 1.

        Raises
        ------
        InputError
            If there is no such mesh.
        """
        if number not in (1, 2):
            raise InputError(f"number: expected 1 or 2, found {number!r}")
        return self.meshes[number - 1]

    @property
    def common_force_N(self) -> Floats:
        """(P,) Magnitude of the force of the common gear on its bearings."""
        return np.linalg.norm(self.bearing_force_N[:, self.common_gear - 1], axis=-1)

    @property
    def common_gear(self) -> int:
        """Number of the gear in both meshes, or of the double helical pinion."""
        return 1

    def own_pictures(self, result: Result) -> tuple[str, ...]:
        several = result.position_rad.size > 1
        return ("gear_train", *("transmission_error",) * several)

    def _bearings(self) -> dict[str, Any]:
        """Entry of the summary."""
        forces = np.hypot(*np.moveaxis(self.bearing_force_N, -1, 0))
        return {"bearing_force_max_N": forces.max(axis=0).tolist()}


@dataclass(frozen=True, eq=False, repr=False)
class TrainLoads(TwoMeshes):
    """Loads of three gears in two meshes.

    Attributes
    ----------
    phases : (2,) array
        Phases of both meshes at position zero, in pitches.
    torque_3_Nm : (P,) array
        Torque of the meshes on body 3, counter-clockwise; 0 on an idler.
    orbit_um : (P, 2) array
        Displacement of the common gear by its bearings, or of a floating wheel.
    common : int
        Number of the gear in both meshes: the idler, or the wheel.
    """

    phases: Floats
    torque_3_Nm: Floats = field(metadata={"P": "N m"})
    orbit_um: Floats
    common: int

    @property
    def common_gear(self) -> int:
        """Number of the gear in both meshes."""
        return self.common

    def rows(self, result: Result) -> list[str]:
        """A row per position: shares of two pinions, forces of an idler."""
        shared = self.kind == "two_pinions"
        moves = bool(self.orbit_um.any())
        heads = ["mesh 1", "mesh 2", f"bearings {self.common}", *["x", "y"] * moves]
        units = [*(["share %"] if shared else ["N"]) * 2, "N", *["um", "um"] * moves]

        def cells(p: int) -> Iterable[str]:
            values = 100.0 * result.load_share[p] if shared else result.site_force_N[p]
            yield from (f"{value:.{2 if shared else 1}f}" for value in values)
            yield f"{self.common_force_N[p]:.1f}"
            if moves:
                yield from (f"{value:.3f}" for value in self.orbit_um[p])

        return rows_of_positions(result, heads, units, cells)

    def summary(self, result: Result) -> dict[str, Any]:
        """Entries of the summary."""
        over = over_positions(result)
        return {
            **self._bearings(),
            "torque_2_mean_Nm": over.mean(self.torque_2_Nm),
            "torque_3_mean_Nm": over.mean(self.torque_3_Nm),
            "orbit_max_um": float(np.hypot(*self.orbit_um.T).max()),
        }

    def words(self) -> str:
        """Text of a report."""
        text = f"bearings of body {self.common} carry up to {self.common_force_N.max():.5g} N"
        for body, torque in ((2, self.torque_2_Nm), (3, self.torque_3_Nm)):
            if body != self.common:
                text += f", torque on body {body} {torque.mean():.5g} N m"
        return text


@dataclass(frozen=True, eq=False, repr=False)
class TrainLoadsOverWidth(TrainLoads):
    """Loads of three gears with width.

    Attributes
    ----------
    mesh_face_load_factor : (2,) array
        K_Hbeta of both meshes.
    axial_force_N : (P, 3) array
        Axial force of the meshes on each body, positive along z.
    common_moment_Nm : (P, 2) array
        Moment of both meshes on the common gear about x and y, in the middle of its face width.
    common_tilt_urad : (P, 2) array
        Rotation of the common gear about x and y by its bearings.
    """

    mesh_face_load_factor: Floats
    axial_force_N: Floats
    common_moment_Nm: Floats
    common_tilt_urad: Floats

    def summary(self, result: Result) -> dict[str, Any]:
        """Entries of the summary."""
        moment, tilt = (
            np.hypot(*part.T) for part in (self.common_moment_Nm, self.common_tilt_urad)
        )
        return super().summary(result) | {
            "mesh_face_load_factors": self.mesh_face_load_factor.tolist(),
            "axial_force_max_N": np.abs(self.axial_force_N).max(axis=0).tolist(),
            "common_moment_max_Nm": float(moment.max()),
            "common_tilt_max_urad": float(tilt.max()),
        }

    def words(self) -> str:
        """Text of a report."""
        return f"{super().words()}; {_words_of_factors(self.mesh_face_load_factor)}"


@dataclass(frozen=True, eq=False, repr=False)
class DoubleHelicalLoads(TwoMeshes):
    """Loads of double helical gears: mesh 1 is that of the halves of larger z.

    Attributes
    ----------
    mesh_face_load_factor : (2,) array
        K_Hbeta of both halves.
    axial_force_N : (P, 2) array
        Axial force on each half of body 1, positive along z.
    axial_motion_um : (P,) array
        Displacement of body 1 along z.
    moment_Nm : (P, 2) array
        Moment of both halves on body 1 about x and y, in the middle of the groove.
    tilt_urad : (P, 2) array
        Rotation of body 1 about x and y by its bearings.
    """

    mesh_face_load_factor: Floats
    axial_force_N: Floats
    axial_motion_um: Floats = field(metadata={"P": "um"})
    moment_Nm: Floats
    tilt_urad: Floats

    words_for_sites = ("half", "halves")
    site_word = "half"

    def rows(self, result: Result) -> list[str]:
        """A row per position: shares and axial forces of both halves, axial displacement."""

        def cells(p: int) -> Iterable[str]:
            yield from (f"{value:.2f}" for value in 100.0 * result.load_share[p])
            yield from (f"{value:.1f}" for value in self.axial_force_N[p])
            yield f"{self.axial_motion_um[p]:.3f}"

        heads = ["half 1", "half 2", "axial 1", "axial 2", "displaced"]
        return rows_of_positions(result, heads, ["share %", "share %", "N", "N", "um"], cells)

    def summary(self, result: Result) -> dict[str, Any]:
        """Entries of the summary."""
        along = self.axial_motion_um
        return self._bearings() | {
            "torque_2_mean_Nm": over_positions(result).mean(self.torque_2_Nm),
            "mesh_face_load_factors": self.mesh_face_load_factor.tolist(),
            "axial_force_max_N": np.abs(self.axial_force_N).max(axis=0).tolist(),
            "axial_force_total_max_N": float(np.abs(self.axial_force_N.sum(axis=1)).max()),
            "axial_motion_peak_to_peak_um": float(along.max() - along.min()),
        }

    def words(self) -> str:
        """Text of a report."""
        ends = (f"{end:.4g}" for end in (self.axial_motion_um.min(), self.axial_motion_um.max()))
        text = f"body 1 moves along its axis by {' to '.join(dict.fromkeys(ends))} um; "
        return text + _words_of_factors(self.mesh_face_load_factor)


def _words_of_factors(factors: Floats) -> str:
    return "K_Hbeta " + " and ".join(f"{factor:.3f}" for factor in factors)
