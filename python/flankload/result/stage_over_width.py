"""Quantities of a planetary stage over its face width: line loads, axial forces, tilts."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from flankload.result.stage import StageLoads

if TYPE_CHECKING:
    from flankload.base.arrays import Floats
    from flankload.result.result import Result


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class StageLoadsOverWidth(StageLoads):
    """Loads of a planetary stage in three dimensions, besides those of `StageLoads`.

    Attributes
    ----------
    mesh_face_load_factor : (2, n) array
        K_Hbeta of the meshes with the sun and with the ring.
    planet_line_load_N_per_mm : (P, n) array
        Largest mean line load on a flank in both meshes of each planet, per mm of face width.
    sun_axial_force_N, ring_axial_force_N : (P,) arrays
        Axial force of all planets on sun and ring, positive along z.
    planet_axial_force_N : (P, n) array
        Sum of the axial forces on each planet, which nearly cancel.
    planet_moment_Nm : (P, n, 2) array
        Moment of all contacts on each planet about x and y, in the middle of its face width.
    pin_line_force_N_per_mm : (P, n, 2, 2) array
        Force of each planet on its pin per mm of the bearing, at its ends of smaller and of larger
        z, along x and y. Between both it changes linearly, as under a rigid bore on evenly elastic
        rollers.
    planet_tilt_urad : (P, n, 2) array
        Rotation of each planet about x and y by its pin and the carrier, without errors of pins.
    sun_tilt_urad, ring_tilt_urad : (P, 2) arrays
        Rotations of sun and ring about x and y.
    """

    mesh_face_load_factor: Floats
    planet_line_load_N_per_mm: Floats = field(metadata={"PS": "N/mm"})
    sun_axial_force_N: Floats = field(metadata={"P": "N"})
    ring_axial_force_N: Floats = field(metadata={"P": "N"})
    planet_axial_force_N: Floats = field(metadata={"PS": "N"})
    planet_moment_Nm: Floats
    pin_line_force_N_per_mm: Floats
    planet_tilt_urad: Floats
    sun_tilt_urad: Floats
    ring_tilt_urad: Floats

    def own_pictures(self, result: Result) -> tuple[str, ...]:
        loaded = bool(result.torque_Nm)
        return (*super().own_pictures(result), *("stage_patterns",) * loaded)

    def summary(self, result: Result) -> dict[str, Any]:
        """Entries of the summary."""
        sun, ring = self.mesh_face_load_factor.max(axis=1)
        p, s = np.unravel_index(
            self.planet_line_load_N_per_mm.argmax(), self.planet_line_load_N_per_mm.shape
        )
        loaded = bool(result.torque_Nm)
        return super().summary(result) | {
            "peak_line_load_N_per_mm": float(self.planet_line_load_N_per_mm[p, s]),
            "peak_line_load_position_rad": float(result.position_rad[p]) if loaded else None,
            "peak_line_load_pair": int(result.sites[s]) if loaded else None,
            "sun_mesh_face_load_factor_max": float(sun),
            "ring_mesh_face_load_factor_max": float(ring),
            "sun_axial_force_max_N": _largest(self.sun_axial_force_N),
            "ring_axial_force_max_N": _largest(self.ring_axial_force_N),
            "planet_moment_max_Nm": float(np.hypot(*_last_first(self.planet_moment_Nm)).max()),
            "pin_line_force_max_N_per_mm": float(
                np.hypot(*_last_first(self.pin_line_force_N_per_mm)).max()
            ),
            "planet_tilt_max_urad": float(np.hypot(*_last_first(self.planet_tilt_urad)).max()),
        }

    def words(self) -> str:
        """Text of a report."""
        sun, ring = self.mesh_face_load_factor.max(axis=1)
        text = f"{super().words()}; K_Hbeta up to {sun:.3f} with the sun and {ring:.3f} with the "
        text += "ring"
        tilt = np.hypot(*_last_first(self.planet_tilt_urad)).max()
        return text + (f", planets tilt by up to {tilt:.4g} urad" if tilt else "")


def _largest(values: Floats) -> float:
    """The value of the largest magnitude."""
    return float(values.flat[np.abs(values).argmax()])


def _last_first(values: Floats) -> Floats:
    return np.moveaxis(values, -1, 0)
