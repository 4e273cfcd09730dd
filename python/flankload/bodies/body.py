"""What every kind of body hands over to the rooms behind: its flank curve, mesh and material."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from flankload.tip_modes import Tip

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from flankload.bodies.given import GivenCompliance
    from flankload.bodies.involute import Involute
    from flankload.flank_curve import FlankCurve


#: So near to the end of the modes' range, as part of it, the flank has its last direction.
FLANK_SIDE = 1e-9


@dataclass(frozen=True)
class Material:
    """Linear elastic, isotropic.

    Attributes
    ----------
    young_modulus_MPa, poisson_ratio : float
    """

    young_modulus_MPa: float
    poisson_ratio: float


@dataclass(frozen=True)
class SectorMesh:
    """Quadratic finite elements of one of the equal sectors of a body.

    Attributes
    ----------
    nodes : (N, 2) array
        Places in the frame of the body, mm.
    cells : tuple of (str, (E, k) array)
        Type of element and its nodes, both as meshio has them: "quad9", "quad8", "triangle6".
    flank_edges : (m, 3) array
        First, last and middle node of the edges that carry pressure modes, by ascending arc length.
    flank_arc_length : (N,) array
        Arc length on the flank curve of the nodes of `flank_edges`, mm; NaN elsewhere.
    fixed_nodes : array
        Nodes that are held.
    left_nodes, right_nodes : arrays of equal size
        Nodes of the cut at the smaller and at the greater polar angle, without those that are held;
        right node k is left node k turned by one pitch.
    teeth : int
        Number of equal sectors.
    tip_edges, tip_arc_length : (k, 3) arrays
        Edges of a tip rounding or chamfer as those of the flank, behind these, and the arc lengths
        of their nodes, mm. Empty without.
    """

    nodes: NDArray[np.float64]
    cells: tuple[tuple[str, NDArray[np.int64]], ...]
    flank_edges: NDArray[np.int64]
    flank_arc_length: NDArray[np.float64]
    fixed_nodes: NDArray[np.int64]
    left_nodes: NDArray[np.int64]
    right_nodes: NDArray[np.int64]
    teeth: int
    tip_edges: NDArray[np.int64] = field(default_factory=lambda: np.empty((0, 3), dtype=np.int64))
    tip_arc_length: NDArray[np.float64] = field(default_factory=lambda: np.empty((0, 3)))

    @property
    def flank_elements(self) -> int:
        """Elements along the flank."""
        return len(self.flank_edges)


@dataclass(frozen=True)
class MeshedFlank:
    """One flank of a whole body; together with the nodes what pressure modes need.

    Attributes
    ----------
    tooth : int
        Its place on the body: tooth k stands k pitches counter-clockwise of tooth 0.
    nodes : (N, 2) array
        Of the whole body, mm.
    flank_edges : (m, 3) array
        First, last and middle node of the edges that carry pressure modes, by ascending arc length.
    flank_arc_length : (N,) array
        Arc length on the flank curve of the nodes of `flank_edges`, mm; NaN elsewhere.
    """

    tooth: int
    nodes: NDArray[np.float64]
    flank_edges: NDArray[np.int64]
    flank_arc_length: NDArray[np.float64]


@dataclass(frozen=True)
class WholeMesh:
    """Quadratic finite elements of a whole body with many flanks.

    Attributes
    ----------
    nodes, cells, fixed_nodes
        As in `SectorMesh`.
    flanks : tuple of MeshedFlank
        By ascending tooth, that of tooth 0 first.
    """

    nodes: NDArray[np.float64]
    cells: tuple[tuple[str, NDArray[np.int64]], ...]
    fixed_nodes: NDArray[np.int64]
    flanks: tuple[MeshedFlank, ...]

    @property
    def flank_elements(self) -> int:
        """Elements along the flank that has fewest."""
        return min(len(flank.flank_edges) for flank in self.flanks)


@dataclass(frozen=True)
class FlankNodes:
    """How a flank curve through nodes follows from them.

    Attributes
    ----------
    count : int
    spacing_mm : float
        Largest distance of neighbours.
    deviation_mm : float
        Estimated distance of the curve from the true profile; infinite where that cannot be told.
    """

    count: int
    spacing_mm: float
    deviation_mm: float


@dataclass(frozen=True)
class Roller:
    """How a follower touches its cam: with a roller.

    Attributes
    ----------
    arm_mm : float
        Distance of its centre from the axis, along x of the follower's frame.
    radius_mm : float
    angles_rad : (float, float)
        Polar angles about its centre between which it is free to touch.
    """

    arm_mm: float
    radius_mm: float
    angles_rad: tuple[float, float]


@dataclass(frozen=True)
class Flat:
    """How a follower touches its cam: with a flat along x of the follower's frame.

    Attributes
    ----------
    offset_mm : float
        Of its line from the axis, towards the cam.
    ends_mm : (float, float)
        Places along it, from the foot of the axis, both positive.
    """

    offset_mm: float
    ends_mm: tuple[float, float]


@dataclass(frozen=True)
class Body:
    """A body of equal teeth: its curve, its sites and what its compliance is made from.

    The axis is the origin. The working flank of tooth 0 is `curve`; tooth k is tooth 0 turned by k
    pitches, counter-clockwise. From root to tip the radius grows, or falls where the teeth stand
    inwards.

    Attributes
    ----------
    kind : str
        "gear", "ring", "spline_shaft", "spline_hub", "cam", "follower", "mesh" or "compliance".
    curve : FlankCurve
        From root to tip.
    teeth : int
    material : Material
    rigid : bool
    mesh : SectorMesh, WholeMesh or None
        None for a rigid body, and for one that brings its compliance along.
    mode_range_mm : (float, float)
        Arc lengths between which pressure modes live.
    reference_radius_mm : float
        Turns a rotation into a transmission error; gears: the base radius;
        splines: the pitch radius; followers: the arm, or the middle of the flat.
    involute : Involute or None
        Radii and angles of an involute flank; None where the profile is not known.
    flank_angle_known : bool
        True: pairing turns the body so that pair 0 stands in the pitch point. False: the body
        stands as it is.
    mirrored : bool
        The flank in its file faces the other way round: the body is taken in its mirror image.
    pitch_errors_um : tuple of float
        Empty, or one per tooth.
    outline : (k, 2) array
        Toothed contour of one sector from cut to cut, counter-clockwise, mm; for pictures.
    bore_radius_mm : float
        Radius at which the body is held: its bore, or the outside of a ring; for pictures.
    notes : tuple of str
        What a user must know of the body.
    flank_turns_rad : tuple of float
        Empty, or by how much each tooth's flank stands counter-clockwise of its equal share.
    named_teeth : tuple of int
        Empty where every tooth has its flank; else those that have one, ascending.
    flank_nodes : FlankNodes or None
        Where the curve goes through nodes.
    given : ModalCompliance, NodalCompliance or None
        The compliance, where it comes with the body.
    modes_part : float
        Pressure modes over those of a gear's flank.
    touches : Roller, Flat or None
        What a follower touches its cam with.
    turns_clockwise : bool
        Of a cam.
    active_range_mm : (float, float) or None
        Arc lengths, two breaks of the curve, between which the flank may touch; None: anywhere.
    """

    kind: str
    curve: FlankCurve
    teeth: int
    material: Material
    rigid: bool
    mesh: SectorMesh | WholeMesh | None
    mode_range_mm: tuple[float, float]
    reference_radius_mm: float
    involute: Involute | None
    flank_angle_known: bool
    pitch_errors_um: tuple[float, ...]
    outline: NDArray[np.float64]
    bore_radius_mm: float
    notes: tuple[str, ...] = ()
    flank_turns_rad: tuple[float, ...] = ()
    named_teeth: tuple[int, ...] = ()
    flank_nodes: FlankNodes | None = None
    given: GivenCompliance | None = None
    modes_part: float = 1.0
    touches: Roller | Flat | None = None
    turns_clockwise: bool = False
    active_range_mm: tuple[float, float] | None = None
    mirrored: bool = False

    @property
    def tip(self) -> Tip | None:
        """Where the modes of a tip rounding or chamfer end; None without one."""
        if self.given is not None:
            return self.given.tip
        if not isinstance(self.mesh, SectorMesh) or not self.mesh.tip_edges.size:
            return None
        end, high = self.curve.length_mm, self.mode_range_mm[1]
        before = high - FLANK_SIDE * (high - self.mode_range_mm[0])
        one, other = self.curve.normal([before, end])
        turn = float(np.arccos(np.clip(one @ other, -1.0, 1.0)))
        return Tip(end, 0 if "tip_chamfer" in self.curve.labels else 1, turn)

    @property
    def outward(self) -> int:
        """1 where the flank's tip stands further from the axis than its root, -1 where nearer."""
        root, tip = (self.curve.point([s])[0] for s in (0.0, self.curve.length_mm))
        return 1 if tip @ tip > root @ root else -1

    @property
    def base_radius_mm(self) -> float | None:
        """Base radius of an involute flank."""
        return None if self.involute is None else self.involute.base_radius_mm

    @property
    def tip_radius_mm(self) -> float | None:
        """Radius of the tip circle, where the profile is known."""
        return None if self.involute is None else self.involute.tip_radius_mm

    @property
    def root_radius_mm(self) -> float | None:
        """Radius of the root circle, where the profile is known."""
        return None if self.involute is None else self.involute.root_radius_mm
