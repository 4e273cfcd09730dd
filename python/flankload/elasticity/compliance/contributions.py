"""Parts of the compliance of a body: modes, near field, coast flanks, expansion, root stress."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Callable

    from flankload.base.arrays import Floats, Numbers
    from flankload.bodies.root_fillet import RootPoints
    from flankload.bodies.tip_modes import Tip


@dataclass(frozen=True)
class NearField:
    """Strengths of the near field, which the modes do not include.

    Attributes
    ----------
    kernel : float
        c0 of the logarithm, mm²/N; 0 for a rigid body.
    jump : float
        j of tangential loads, mm²/N; 0 without friction.
    wedge : (float, float)
        psi of the mirror images of the logarithm behind free corners at both ends of the modes; 0
        for smooth surfaces, closed flanks and unit forces at nodes.
    wedge_along : (float, float)
        psi_nt of the images of tangential loads, for normal displacements.
    """

    kernel: float
    jump: float = 0.0
    wedge: tuple[float, float] = (0.0, 0.0)
    wedge_along: tuple[float, float] = (0.0, 0.0)


@dataclass(frozen=True)
class AxialModes:
    """Modes along the axis of a body; the constant one alone in the plane, by default.

    Attributes
    ----------
    range_mm : (float, float)
        Width of the body.
    degree : int
        Highest degree q_z; a mode of the flank is P_a(xi_s) P_b(xi_z), at index a (q_z + 1) + b.
    twist : float
        Counter-clockwise rotation of the section along z, rad/mm.
    cos_base_helix : float
        cos(beta_b): the area element of the flank is ds dz/cos(beta_b).
    end : (float, float)
        Strengths psi of the mirror images behind the end faces at low and high z.
    """

    range_mm: tuple[float, float] = (0.0, 1.0)
    degree: int = 0
    twist: float = 0.0
    cos_base_helix: float = 1.0
    end: tuple[float, float] = (0.0, 0.0)

    @property
    def count(self) -> int:
        """Number of modes along the axis for each mode along the profile."""
        return self.degree + 1


@dataclass(frozen=True, eq=False)
class NearProducts:
    """Products of the modes of a flank with the near field K of loads on it.

    Attributes
    ----------
    axial : AxialModes
    modes : (n, n) array
        <P, P> of the n modes along the profile.
    normal : (p, p) array
        <P, K P> of normal displacements under normal loads.
    along : (p, p) array
        The same for normal displacements under loads along the profile; 0 without friction.
    tangential : (p, p) array or 0
        The same for displacements along the profile under these loads, if they are read.
    """

    axial: AxialModes
    modes: Floats
    normal: Floats
    along: Floats
    tangential: Floats | float = 0.0


@dataclass(frozen=True, eq=False)
class FlankModes:
    """Pressure modes of a flank, or the nodes that replace them.

    Attributes
    ----------
    range_mm : (float, float)
        Arc lengths of the flank curve at the ends of the modes.
    closed : bool
        The modes are harmonics around the body.
    tip : Tip or None
        Tip rounding or chamfer, to which the last modes belong.
    axial : AxialModes
        Modes along the axis; modes are products with these.
    nodes : (n,) array or None
        Arc lengths of the nodes, mm, whose unit forces replace the modes.
    """

    range_mm: tuple[float, float]
    closed: bool = False
    tip: Tip | None = None
    axial: AxialModes = AxialModes()
    nodes: Floats | None = None

    def mirror_signs(self, p: int) -> Floats:
        """Factors (p,) of the modes in the image of a flank that is turned end for end in z."""
        count = self.axial.count
        return np.tile((-1.0) ** np.arange(count), p // count)


@dataclass(frozen=True, eq=False)
class CoastCompliance:
    """Response of flanks of a body of z teeth if the loaded or the displaced one is a coast flank.

    Attributes
    ----------
    normal : (3 z, p, p) array
        Maps pressure modes on a flank of tooth 0 to displacements on one of tooth t: block t from
        working to coast flanks, z + t from coast to working flanks, 2 z + t between coast flanks;
        mm²/N, in three dimensions mm/N.
    tangential : (3 z, p, q) array; None without friction
        The same for tangential loads.
    """

    normal: Floats
    tangential: Floats | None = None

    @property
    def exchanged(self) -> Numbers:
        """Indices (3 z,) of the blocks with displaced and loaded flank exchanged."""
        z = len(self.normal) // 3
        back = opposite(z)
        return np.concatenate([z + back, back, 2 * z + back])


def opposite(z: int) -> Numbers:
    """Numbers (z,) of the teeth on the other side of tooth 0."""
    return -np.arange(z) % z


@dataclass(frozen=True, eq=False)
class Expansion:
    """Expansion of a body by temperature and speed, without contact.

    Attributes
    ----------
    strain : float
        Uniform strain of the section of the whole body.
    shifts : dict of str to (1, p) or (f, p) array
        By load, normal displacement of the flanks beyond that strain, as mode coefficients, mm: one
        row for all teeth, or one for each flank.
    coast_shifts : dict of str to (1, p) array
        The same of coast flanks; empty without these.
    axial_excess : float
        Axial strain less the strain of the section.
    """

    strain: float = 0.0
    shifts: dict[str, Floats] = field(default_factory=dict)
    coast_shifts: dict[str, Floats] = field(default_factory=dict)
    axial_excess: float = 0.0

    @property
    def axial_strain(self) -> float:
        """Strain along the axis."""
        return self.strain + self.axial_excess

    def with_shifts(self, change: Callable[[Floats], Floats]) -> Expansion:
        """The expansion with changed displacements of the flanks."""
        shifts, coast = (
            {name: change(part) for name, part in parts.items()}
            for parts in (self.shifts, self.coast_shifts)
        )
        return replace(self, shifts=shifts, coast_shifts=coast)


@dataclass(frozen=True, eq=False)
class RimResponse:
    """Displacements of the held side of a rim whose mean motion alone is held.

    The part of the rim that belongs to a sector moves by the mean of its displacement, along the
    radius through its middle and across it, counter-clockwise; unit forces are spread over it. With
    a width, r = 2 (q_z + 1) displacements are pairs of means weighted by the polynomials P_b of the
    axis, in a frame that turns with the helix; in the plane r = 2.

    Attributes
    ----------
    by_modes : (z, r, p) array
        [t] maps the modes of tooth 0 to the displacements of sector t, in its frame; mm²/N, with a
        width mm/N. With tangential loads followed by as many tangential modes.
    by_forces : (z, r, r) array
        The same of the forces on the rim of sector 0.
    modes : (3, p) array
        Resultant of these modes: forces along the axes of the frame of tooth 0, and moment, mm.
    forces : (3, r) array
        Resultant of the forces on the rim of sector 0.
    """

    by_modes: Floats
    by_forces: Floats
    modes: Floats
    forces: Floats

    def with_loads(self, change: Callable[[Floats], Floats]) -> RimResponse:
        """The response to other loads on the flanks: `change` maps the tables of modes."""
        return replace(self, by_modes=change(self.by_modes), modes=change(self.modes))


@dataclass(frozen=True, eq=False)
class RimMotion:
    """Motion of a rim by loads on all flanks, whose mode coefficients are listed tooth by tooth.

    Attributes
    ----------
    radial : (z, z p) array
        Radial displacements of the rim of all sectors, means over the width, mm²/N or mm/N.
    body : (2, z p) array
        Mean displacements of the body along the axes of its frame by the bolts, mm²/N.
    """

    radial: Floats
    body: Floats


@dataclass(frozen=True, eq=False)
class RootResponse:
    """Stress along the root fillets under pressure modes.

    Attributes
    ----------
    points : RootPoints
        The q points of a tooth.
    response : (z, q, p) array, or (f * f, q, p) array as `BodyCompliance.smooth`
        response[t] maps the modes of tooth 0 (MPa, tension positive) to the stress in the root of
        tooth t, MPa; with friction followed by as many tangential modes, towards increasing arc
        length. In three dimensions (z, q, d + 1, p): coefficients of the functions of z
        (`prism.AxialBasis` of degree d) per N out of the material at a point of tooth 0 times the
        values of the modes there.
    range_mm : (float, float) or None
        Axial range of the teeth; None in a plane scene.
    coast : array or None
        As `response`, under loads on the coast flank in the sector of tooth 0, which is not that of
        an internal tooth.
    difference : float
        Relative difference between recovered and own strain of the elements where it is largest
        (`fe_error`); 0 without an estimate.
    """

    points: RootPoints
    response: Floats
    range_mm: tuple[float, float] | None = None
    coast: Floats | None = None
    difference: float = 0.0

    def with_each(self, change: Callable[[Floats], Floats]) -> RootResponse:
        """The responses of both flanks after the same change."""
        coast = None if self.coast is None else change(self.coast)
        return replace(self, response=change(self.response), coast=coast)

    def in_mirror_image(self) -> RootResponse:
        """The response in a frame in which coast flanks are working flanks and teeth run clockwise.

        Without loads on coast flanks, the body is its own mirror image.
        """
        if self.coast is None:
            return self
        working = self.points.working
        mirrored = np.concatenate([np.flatnonzero(~working), np.flatnonzero(working)])
        image = self.coast[opposite(len(self.coast))][:, mirrored]
        return replace(self, response=image, coast=None)
