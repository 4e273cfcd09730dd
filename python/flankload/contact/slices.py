"""Flanks cut in slices along the face width: contact in three dimensions (`fortran/position`)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

import numpy as np

from flankload.errors import InputError

if TYPE_CHECKING:
    from numpy.typing import NDArray


class Axial(Protocol):
    """What a body is along its axis."""

    @property
    def range_mm(self) -> tuple[float, float]:
        """End faces."""

    @property
    def count(self) -> int:
        """Number of Legendre polynomials over the width in the modes of the compliance."""

    @property
    def twist(self) -> float:
        """By how much sections turn counter-clockwise with growing z, rad/mm."""

    @property
    def end(self) -> tuple[float, float]:
        """Strengths psi of the images of the near field behind the ends at low and high z."""


@dataclass(frozen=True, eq=False)
class Slices:
    """How the flanks of both bodies are cut.

    Attributes
    ----------
    edges_mm : (J + 1,) array
        Where the slices end, ascending, within both bodies.
    axial : two of Axial
        Of both bodies.
    gap_mm : (S, J) array or None
        Metal removed at each site and slice by both flanks together, on average over the slice,
        along the normal in the plane of the section; None: nothing.
    """

    edges_mm: NDArray[np.float64]
    axial: tuple[Axial, Axial]
    gap_mm: NDArray[np.float64] | None = None

    @property
    def count(self) -> int:
        """J."""
        return len(self.edges_mm) - 1

    @property
    def middle_mm(self) -> NDArray[np.float64]:
        """(J,) Middle of each slice."""
        return np.asarray(0.5 * (self.edges_mm[1:] + self.edges_mm[:-1]))

    @property
    def width_mm(self) -> NDArray[np.float64]:
        """(J,) Width of each slice."""
        return np.diff(self.edges_mm)

    def angles(self, site_angles_rad: NDArray[np.float64], z: int) -> NDArray[np.float64]:
        """(S J,) Angles of the sections of body z, the slices of a site together, rad."""
        turned = self.axial[z].twist * self.middle_mm
        return np.asarray((site_angles_rad[:, None] + turned).ravel())

    def deviations(self, site_deviations_mm: NDArray[np.float64], z: int) -> NDArray[np.float64]:
        """(S J,) Metal of body z that touches early; the gap counts to body 1.

        Raises
        ------
        InputError
            If the gap has another shape.
        """
        early = np.repeat(site_deviations_mm[:, None], self.count, axis=1)
        if self.gap_mm is not None and z == 0:
            if self.gap_mm.shape != early.shape:
                raise InputError(f"gap_mm: expected shape {early.shape}, found {self.gap_mm.shape}")
            early = early - self.gap_mm
        return early.ravel()

    def blocks(self, block: NDArray[np.int64]) -> NDArray[np.int64]:
        """(S J, S J) Block of each pair of slices from those of the sites."""
        return np.repeat(np.repeat(block, self.count, axis=0), self.count, axis=1)

    def parts(self, z: int) -> list[tuple[str, NDArray[np.float64]]]:
        """Parts of the record of body z."""
        axial = self.axial[z]
        numbers = np.array([axial.count, *axial.range_mm, axial.twist, *axial.end], dtype=float)
        edges = np.asarray(self.edges_mm, dtype=float)
        return [("axial", numbers), *([("slices", edges)] if z == 0 else ())]
