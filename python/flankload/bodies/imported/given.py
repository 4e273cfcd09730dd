"""Imported compliances of bodies, used instead of one computed from finite elements."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from flankload.bodies.body import Material
from flankload.scene.table import LARGEST_MODULUS

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from flankload.meshes.io.named_arrays import NamedArrays


@dataclass(frozen=True)
class ModalCompliance:
    """A modal compliance as computed by flankload, per mm of face width.

    Attributes
    ----------
    file : Path
        File from which it was imported.
    plane : str
        "strain" or "stress".
    smooth : (z, p, p) array, or (f * f, p, p) array where `flanks` names f teeth
        As in `BodyCompliance`, mm²/N.
    kernel : float
        Coefficient of the logarithmic kernel, mm²/N.
    asymmetry : float
        Relative asymmetry before both directions were averaged.
    flanks : tuple of int
        Empty if `smooth` depends only on the distance of teeth.
    tangential : array or None
        Like `smooth`, for modes of tangential load; None if the file does not contain it.
    jump : float
        Coefficient of the tangential jump, mm²/N.
    """

    file: Path
    plane: str
    smooth: NDArray[np.float64]
    kernel: float
    asymmetry: float
    flanks: tuple[int, ...] = ()
    tangential: NDArray[np.float64] | None = None
    jump: float = 0.0

    @property
    def description(self) -> str:
        """One line for a report."""
        return f"{self.smooth.shape[1]} pressure modes from {self.file.name}, plane {self.plane}"


@dataclass(frozen=True)
class NodalCompliance:
    """A compliance between the nodes of a flank from another program, per mm of face width.

    Attributes
    ----------
    file : Path
    plane : str
        "strain" or "stress", as in the other program.
    arc_length_mm : (n,) array
        Arc lengths of the nodes on the flank curve.
    quadratic : bool
        Every second node is the middle node of an element; else each inner node is between two
        elements.
    of_pressures : bool
        The columns of the matrix belong to nodal pressures, else to nodal forces.
    offsets : (k,) array
        Displaced teeth, counted from the loaded tooth.
    matrix : (k, n, n) array
        Twice the work of loads on tooth 0 on the displacements of tooth offsets[k], with the
        columns in terms of consistent normal nodal forces, mm²/N, or nodal pressures, mm⁴/N.
    asymmetry : float
    """

    file: Path
    plane: str
    arc_length_mm: NDArray[np.float64]
    quadratic: bool
    of_pressures: bool
    offsets: NDArray[np.int64]
    matrix: NDArray[np.float64]
    asymmetry: float

    @property
    def tangential(self) -> None:
        """None: no response to tangential loads."""

    @property
    def flank_elements(self) -> int:
        """Number of elements along the flank."""
        return (self.arc_length_mm.size - 1) // (2 if self.quadratic else 1)

    @property
    def description(self) -> str:
        """One line for a report."""
        shape = "quadratic" if self.quadratic else "linear"
        return (
            f"{self.arc_length_mm.size} nodes of {shape} elements from {self.file.name}, "
            f"plane {self.plane}"
        )


GivenCompliance = ModalCompliance | NodalCompliance


def read_material(found: NamedArrays) -> Material:
    """Material of a compliance file.

    Parameters
    ----------
    found : NamedArrays

    Returns
    -------
    Material

    Raises
    ------
    ComplianceFileError
        If a number is missing or out of range.
    """
    modulus = found.number("young_modulus_MPa", above=0.0, most=LARGEST_MODULUS)
    ratio = found.number("poisson_ratio", least=0.0)
    if ratio >= 0.5:
        found.refuse("poisson_ratio", "a number < 0.5", f"{ratio:g}")
    return Material(modulus, ratio)
