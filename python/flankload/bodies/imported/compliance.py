"""Imported compliances of bodies."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from flankload.bodies.body import Material
from flankload.bodies.tip_modes import Tip
from flankload.scene.table import LARGEST_MODULUS

if TYPE_CHECKING:
    from flankload.base.arrays import Floats, Numbers
    from flankload.meshes.io.named_arrays import NamedArrays


#: Names in a file of the interior angles at the low and the high end of a flank.
CORNER_ANGLES = ("root_corner_deg", "tip_corner_deg")
#: Least interior angle at a corner, degrees; thinner wedges bend under the load.
LEAST_CORNER_ANGLE = 30.0


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
        Relative asymmetry before averaging with the transpose.
    flanks : tuple of int
        Empty if `smooth` depends only on the difference of tooth numbers.
    tangential : array or None
        Like `smooth`, for modes of tangential load; None if the file does not contain it.
    jump : float
        Coefficient of the tangential jump, mm²/N.
    corner_angles_deg : (float, float)
        Interior angles at the low and the high end of the modes' range; 180 without a corner.
    tip : Tip or None
        Tip rounding or chamfer, to which the last modes belong.
    axial_degree : int or None
        Degree of the modes along the axis of a body in three dimensions, whose compliance is that
        of the whole width, mm/N; None in the plane.
    """

    file: Path
    plane: str
    smooth: Floats
    kernel: float
    asymmetry: float
    flanks: tuple[int, ...] = ()
    tangential: Floats | None = None
    jump: float = 0.0
    corner_angles_deg: tuple[float, float] = (180.0, 180.0)
    tip: Tip | None = None
    axial_degree: int | None = None

    @property
    def modes_per_place(self) -> int:
        """Number of modes along the axis for each mode along the profile; 1 in the plane."""
        return 1 + (self.axial_degree or 0)

    @property
    def description(self) -> str:
        """One line for a report."""
        extent = f"plane {self.plane}" if self.axial_degree is None else "three-dimensional"
        return f"{self.smooth.shape[1]} pressure modes from {self.file.name}, {extent}"


@dataclass(frozen=True)
class NodalCompliance:
    """A compliance between the nodes of a flank from another program, per mm of face width.

    Attributes
    ----------
    file, plane, asymmetry, corner_angles_deg
        As in `ModalCompliance`.
    arc_length_mm : (n,) array
        Arc lengths of the nodes on the flank curve.
    quadratic : bool
        Every second node is a middle node; otherwise elements are linear.
    of_pressures : bool
        The columns of the matrix belong to nodal pressures instead of nodal forces.
    offsets : (k,) array
        Displaced teeth, counted from the loaded tooth.
    matrix : (k, n, n) array
        Twice the work of loads on tooth 0 on the displacements of tooth offsets[k], per consistent
        normal nodal force, mm²/N, or nodal pressure, mm⁴/N.
    """

    file: Path
    plane: str
    arc_length_mm: Floats
    quadratic: bool
    of_pressures: bool
    offsets: Numbers
    matrix: Floats
    asymmetry: float
    corner_angles_deg: tuple[float, float] = (180.0, 180.0)

    #: None: the modes of such a body do not extend over a tip.
    tip = None

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


ImportedCompliance = ModalCompliance | NodalCompliance


def read_corner_angles(found: NamedArrays) -> tuple[float, float]:
    """Interior angles at both ends of the flank, checked, degrees; 180 if absent from the file."""
    low, high = (
        found.number(name, least=LEAST_CORNER_ANGLE, most=360.0) if name in found else 180.0
        for name in CORNER_ANGLES
    )
    return low, high


def read_material(found: NamedArrays) -> Material:
    """Material of a compliance file, checked."""
    modulus = found.number("young_modulus_MPa", above=0.0, most=LARGEST_MODULUS)
    ratio = found.number("poisson_ratio", least=0.0)
    if ratio >= 0.5:
        found.refuse("poisson_ratio", "a number < 0.5", f"{ratio:g}")
    return Material(modulus, ratio)
