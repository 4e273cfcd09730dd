"""Parts of the compliance of a body: modes, near field, coast flanks, expansion, job."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from flankload.base.arrays import Floats
    from flankload.bodies.root_fillet import RootPoints
    from flankload.bodies.tip_modes import Tip


@dataclass(frozen=True)
class NearField:
    """Strengths of the near field that the modes leave out.

    Attributes
    ----------
    kernel : float
        c0 of the logarithm, mm²/N; 0 for a rigid body.
    jump : float
        j of loads along the flank, mm²/N; 0 without friction.
    wedge : (float, float)
        psi of the mirror images of the logarithm behind free corners at both ends of the modes;
        0 where the surface continues smoothly, on closed flanks and for unit forces at nodes.
    wedge_along : (float, float)
        psi_nt of the images of loads along the flank, for displacements along its normal.
    """

    kernel: float
    jump: float = 0.0
    wedge: tuple[float, float] = (0.0, 0.0)
    wedge_along: tuple[float, float] = (0.0, 0.0)


@dataclass(frozen=True)
class AxialModes:
    """Modes along the axis, of a body in three dimensions.

    Attributes
    ----------
    range_mm : (float, float)
        Their ends: the whole width of the body.
    degree : int
        Highest degree q_z; a mode of the flank is P_a(xi_s) P_b(xi_z), at index a (q_z + 1) + b.
    twist : float
        Angle by which the section turns counter-clockwise along z, rad/mm.
    cos_base_helix : float
        cos(beta_b): the area element of the flank is ds dz/cos(beta_b).
    end : (float, float)
        Strengths psi of the mirror images of the near field behind the ends at low and high z.
    """

    range_mm: tuple[float, float]
    degree: int
    twist: float
    cos_base_helix: float
    end: tuple[float, float]

    @property
    def count(self) -> int:
        """Number of modes along the axis for each along the profile."""
        return self.degree + 1


@dataclass(frozen=True, eq=False)
class FlankModes:
    """Pressure modes of a flank, or the nodes that replace them.

    Attributes
    ----------
    range_mm : (float, float)
        Arc lengths of the flank curve at the ends of the modes.
    closed : bool
        The modes are harmonics of a turn around the body.
    tip : Tip or None
        End of the modes of a tip rounding or chamfer; the last modes are the tip's.
    axial : AxialModes or None
        In three dimensions modes are products of modes along profile and axis.
    nodes : (n,) array or None
        Arc lengths of the nodes, mm, whose unit forces replace the modes.
    """

    range_mm: tuple[float, float]
    closed: bool = False
    tip: Tip | None = None
    axial: AxialModes | None = None
    nodes: Floats | None = None


@dataclass(frozen=True, eq=False)
class CoastCompliance:
    """Response of the coast flanks to loads on the working flanks.

    Attributes
    ----------
    normal : (z, p, p) array
        normal[t] maps the pressure modes on the working flank of tooth 0 to displacements on the
        coast flank of tooth t; mm²/N. Coast flanks affect each other and the working flanks in the
        same way, mirrored.
    tangential : (z, p, q) array; None without friction
        The same for the modes of load along the working flank.
    """

    normal: Floats
    tangential: Floats | None = None


@dataclass(frozen=True, eq=False)
class Expansion:
    """Expansion of a body by temperature and speed before contact.

    Attributes
    ----------
    strain : float
        Uniform strain of the whole body.
    shifts : dict of str to (1, p) or (f, p) array
        By load, displacement of the flanks out of the material beyond that strain, as mode
        coefficients, mm: one row for all teeth, or one for each flank.
    """

    strain: float = 0.0
    shifts: dict[str, Floats] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class RootResponse:
    """Stress along the root fillets under pressure modes.

    Attributes
    ----------
    points : RootPoints
        The q places of a tooth.
    response : (z, q, p) array, or (f * f, q, p) array as `BodyCompliance.smooth`
        response[t] maps the pressure modes of tooth 0 (MPa, pulling out of the material) to the
        stress in the root of tooth t, MPa; with friction followed by as many modes of load along
        the flank, towards growing arc length. In three dimensions (z, q, d + 1, p): coefficients of
        the functions of z (`prism.AxialBasis` of degree d) per N out of the material at a place of
        tooth 0 times the values of the modes there.
    range_mm : (float, float) or None
        Ends of the teeth along the axis; None in a plane.
    """

    points: RootPoints
    response: Floats
    range_mm: tuple[float, float] | None = None
