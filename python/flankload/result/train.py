"""Quantities of a gear train: forces of both meshes, on the bearings, torques, displacements."""

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
class TrainLoads(Drive):
    """Loads of a gear train at P positions, in the frame with axis 1 at the origin.

    Attributes
    ----------
    kind : {"idler", "two_pinions"}
    teeth : (int, int, int)
        Tooth numbers of bodies 1, 2 and 3.
    centers_mm : (3, 2) array
        Axes of the bodies.
    phases : (2,) array
        Phases of both meshes at position zero, in pitches.
    torque_2_Nm, torque_3_Nm : (P,) arrays
        Torque of the meshes on bodies 2 and 3, counter-clockwise; 0 on an idler.
    bearing_force_N : (P, 3, 2) array
        Force of each body on its bearings, which is that of its meshes on it.
    orbit_um : (P, 2) array
        Displacement of the common gear by its bearings, or of a floating wheel.
    common : int
        Number of the gear in both meshes: the idler, or the wheel.
    meshes : two Result, each made when it is read
        Results of both meshes.
    """

    kind: str
    teeth: tuple[int, int, int]
    centers_mm: Floats
    phases: Floats
    torque_2_Nm: Floats = field(metadata={"P": "N m"})
    torque_3_Nm: Floats = field(metadata={"P": "N m"})
    bearing_force_N: Floats
    orbit_um: Floats
    common: int
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
        return np.asarray(np.hypot(*self.bearing_force_N[:, self.common - 1].T))

    def as_dict(self) -> dict[str, Any]:
        """The train in the form of the JSON result."""
        return {name: value for name, value in vars(self).items() if name != "meshes"}

    def drawn_force(self, result: Result, p: int, s: int) -> tuple[float, float, float]:
        """Sum of the forces of a mesh on its driven body, at the mean of their places."""
        return super().drawn_force(result, p, s)

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

    def own_pictures(self, result: Result) -> tuple[str, ...]:
        several = result.position_rad.size > 1
        return ("gear_train", *("transmission_error",) * several)

    def summary(self, result: Result) -> dict[str, Any]:
        """Entries of the summary."""
        over = over_positions(result)
        bearings = np.hypot(*np.moveaxis(self.bearing_force_N, -1, 0))
        return {
            "bearing_force_max_N": bearings.max(axis=0).tolist(),
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
