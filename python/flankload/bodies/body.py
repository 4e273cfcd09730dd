"""The common data of all bodies: flank curve, mesh and material."""

from __future__ import annotations

from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from flankload.bodies.axial_shape import PLANE_SHAPE, AxialShape
from flankload.bodies.corner_angle import STRAIGHT_ANGLE, angle_at
from flankload.bodies.tip_modes import Tip
from flankload.meshes.blocks import edges_along
from flankload.scene.refusal import refuse

if TYPE_CHECKING:
    from flankload.base.arrays import Floats, Numbers
    from flankload.bodies.imported.compliance import ImportedCompliance
    from flankload.bodies.profile.involute import Involute
    from flankload.flank import FlankCurve
    from flankload.meshes.blocks import BlockMesh


#: Relative distance from the end of the modes' range at which the flank's last normal is computed.
BEFORE_END = 1e-9


@dataclass(frozen=True)
class Material:
    """A linear elastic, isotropic material.

    Attributes
    ----------
    young_modulus_MPa, poisson_ratio : float
    """

    young_modulus_MPa: float
    poisson_ratio: float

    @property
    def shear_modulus_MPa(self) -> float:
        """G."""
        return 0.5 * self.young_modulus_MPa / (1.0 + self.poisson_ratio)


@dataclass(frozen=True)
class SectorMesh:
    """Quadratic finite elements of one of the equal sectors of a body.

    Attributes
    ----------
    nodes : (N, 2) array
        Coordinates in the frame of the body, mm.
    cells : tuple of (str, (E, k) array)
        Element type and node numbers in meshio's names and order: "quad9", "quad8", "triangle6".
    flank_edges : (m, 3) array
        First, last and middle node of the edges with pressure modes, by ascending arc length.
    flank_arc_length : (N,) array
        Arc length on the flank curve of the nodes of `flank_edges`, mm; NaN elsewhere.
    fixed_nodes : array
        Nodes with fixed displacements.
    left_nodes, right_nodes : arrays of equal size
        Nodes of the cuts at the smaller and the larger polar angle, without fixed nodes; right
        node k is left node k rotated by one pitch.
    teeth : int
        Number of equal sectors.
    tip_edges, tip_arc_length : (k, 3) arrays
        Edges of a tip rounding or chamfer, in the order of `flank_edges`, and the arc lengths of
        their nodes, mm; empty without one.
    regions : tuple of str
        Name of the region of each entry of `cells`, "" if it is as wide as the teeth; empty if all
        elements are.
    bore_edges : (b, 3) array
        Edges, as for `flank_edges`, of a bore (or the outside of a ring) that is free but for its
        mean motion; empty if it is fixed.
    """

    nodes: Floats
    cells: tuple[tuple[str, Numbers], ...]
    flank_edges: Numbers
    flank_arc_length: Floats
    fixed_nodes: Numbers
    left_nodes: Numbers
    right_nodes: Numbers
    teeth: int
    tip_edges: Numbers = field(default_factory=lambda: np.empty((0, 3), dtype=np.int64))
    tip_arc_length: Floats = field(default_factory=lambda: np.empty((0, 3)))
    regions: tuple[str, ...] = ()
    bore_edges: Numbers = field(default_factory=lambda: np.empty((0, 3), dtype=np.int64))

    @property
    def has_free_bore(self) -> bool:
        """Whether only the mean motion of the bore is held."""
        return bool(self.bore_edges.size)

    @property
    def bore_nodes(self) -> Numbers:
        """Nodes of the bore (or the outside of a ring), fixed or not."""
        return np.union1d(self.fixed_nodes, self.bore_edges)

    @property
    def flank_elements(self) -> int:
        """Number of elements along the flank."""
        return len(self.flank_edges)

    @property
    def flanks(self) -> tuple[SectorMesh, ...]:
        """The only flank, as in a `WholeMesh`."""
        return (self,)

    @cached_property
    def end_angles_deg(self) -> tuple[float, float]:
        """Interior angles of the metal at both ends of the flank's modes; 180 on a cut."""
        low, high = _end_angles(self, self.flank_edges)
        cut = np.concatenate([self.left_nodes, self.right_nodes])
        on_cut = np.isin(self.flank_edges[[0, -1], [0, 1]], cut)
        return STRAIGHT_ANGLE if on_cut[0] else low, STRAIGHT_ANGLE if on_cut[1] else high


@dataclass(frozen=True)
class MeshedFlank:
    """One flank of a whole body, for its pressure modes.

    Attributes
    ----------
    tooth : int
        Tooth number: tooth k is k pitches counter-clockwise of tooth 0.
    nodes, flank_edges, flank_arc_length
        As in `SectorMesh`; nodes of the whole body.
    """

    tooth: int
    nodes: Floats
    flank_edges: Numbers
    flank_arc_length: Floats


@dataclass(frozen=True)
class WholeMesh:
    """Quadratic finite elements of a whole body with many flanks.

    Attributes
    ----------
    nodes, cells, fixed_nodes
        As in `SectorMesh`.
    flanks : tuple of MeshedFlank
        By ascending tooth number, tooth 0 first.
    """

    nodes: Floats
    cells: tuple[tuple[str, Numbers], ...]
    fixed_nodes: Numbers
    flanks: tuple[MeshedFlank, ...]
    #: All elements are as wide as the teeth.
    regions: ClassVar[tuple[str, ...]] = ()

    @classmethod
    def of_blocks(cls, blocks: BlockMesh, fixed: Numbers, flank: Numbers, s: Floats) -> WholeMesh:
        """Mesh from blocks, with one flank: its nodes (2 m + 1,) and their arc lengths s, mm."""
        nodes = blocks.nodes
        arc_length = np.full(len(nodes), np.nan)
        arc_length[flank[::-1]] = s[::-1]  # a closed flank ends at its first node
        flanks = (MeshedFlank(0, nodes, edges_along(flank), arc_length),)
        return cls(nodes, blocks.quads, np.unique(fixed), flanks)

    @property
    def flank_elements(self) -> int:
        """Least number of elements along a flank."""
        return min(len(flank.flank_edges) for flank in self.flanks)

    @cached_property
    def end_angles_deg(self) -> tuple[float, float]:
        """Interior angles of the metal at both ends of the modes of the first flank."""
        return _end_angles(self, self.flanks[0].flank_edges)


def _end_angles(mesh: SectorMesh | WholeMesh, edges: Numbers) -> tuple[float, float]:
    """Interior angles at both ends of the edges of a flank, degrees."""
    low, high = (angle_at(mesh.nodes, mesh.cells, int(node)) for node in edges[[0, -1], [0, 1]])
    return low, high


@dataclass(frozen=True)
class FlankNodes:
    """The nodes from which a flank curve was fitted.

    Attributes
    ----------
    count : int
    spacing_mm : float
        Largest distance of neighbouring nodes.
    deviation_mm : float
        Estimated distance of the curve from the true profile; infinite if it cannot be estimated.
    """

    count: int
    spacing_mm: float
    deviation_mm: float


@dataclass(frozen=True)
class Roller:
    """Roller of a follower.

    Attributes
    ----------
    arm_mm : float
        Distance of the roller's centre from the axis, along x of the follower's frame.
    radius_mm : float
    angles_rad : (float, float)
        Polar angles about the roller's centre that limit its possible contact with the cam.
    """

    arm_mm: float
    radius_mm: float
    angles_rad: tuple[float, float]


@dataclass(frozen=True)
class Flat:
    """Flat face of a follower, parallel to x of the follower's frame.

    Attributes
    ----------
    offset_mm : float
        Distance of the flat's line from the axis, positive towards the cam.
    ends_mm : (float, float)
        Start and end along the line, from the foot of the perpendicular from the axis; positive.
    """

    offset_mm: float
    ends_mm: tuple[float, float]


@dataclass(frozen=True, kw_only=True)
class BodySites:
    """Fields for pairing, pictures and notes; the elements of a body do not depend on them.

    Attributes
    ----------
    reference_radius_mm : float
        Factor from rotation to transmission error. Gears: base radius; splines: pitch radius;
        followers: length of the arm, or distance of the middle of the flat.
    flank_angle_known : bool
        True: pairing rotates the body so that pair 0 is at the pitch point. False: the body remains
        at the angle in its file.
    turns_clockwise : bool
        Sense of rotation of a cam.
    pitch_errors_um : tuple of float
        Empty, or one per tooth.
    flank_turns_rad : tuple of float
        Empty, or the angle of each flank from its nominal position, counter-clockwise.
    named_teeth : tuple of int
        Empty if every tooth has a flank; otherwise the teeth with a flank, ascending.
    flank_nodes : FlankNodes or None
        The nodes of a curve through nodes; None if the exact profile is known.
    active_range_mm : (float, float) or None
        Arc lengths (two breaks of the curve) that limit contact; None: no limits.
    outline : (k, 2) array
        Toothed contour of one sector from cut to cut, counter-clockwise, mm; for pictures.
    notes : tuple of str
        Remarks on the body for the user.
    """

    reference_radius_mm: float = 0.0
    flank_angle_known: bool = True
    turns_clockwise: bool = False
    pitch_errors_um: tuple[float, ...] = ()
    flank_turns_rad: tuple[float, ...] = ()
    named_teeth: tuple[int, ...] = ()
    flank_nodes: FlankNodes | None = None
    active_range_mm: tuple[float, float] | None = None
    outline: Floats = field(default_factory=lambda: np.empty((0, 2)))
    notes: tuple[str, ...] = ()


@dataclass(frozen=True, kw_only=True)
class Body(BodySites):
    """A body with equal teeth.

    The axis is the origin. Tooth k is tooth 0 rotated by k pitches counter-clockwise. From root to
    tip the radius increases; for internal teeth it decreases.

    Attributes
    ----------
    kind : str
        "gear", "ring", "spline_shaft", "spline_hub", "cam", "follower", "mesh" or "compliance".
    curve : FlankCurve
        Working flank of tooth 0 from root to tip.
    teeth : int
    material : Material
    rigid : bool
    mode_range_mm : (float, float)
        Arc lengths between which pressure modes are defined.
    modes_factor : float
        Number of pressure modes over that of a gear flank.
    bore_radius_mm : float
        Radius at which the body is fixed: its bore, or the outside of a ring.
    mesh : SectorMesh, WholeMesh or None
        None for a rigid body and for a body with an imported compliance.
    mirrored : bool
        The body is the mirror image of that in the file, whose flank faces the opposite way.
    involute : Involute or None
        Radii and angles of an involute flank; None if the profile is unknown.
    touches : Roller, Flat or None
        The part of a follower that touches the cam.
    imported : ModalCompliance, NodalCompliance or None
        Imported compliance, if any.
    axial : AxialShape
        Width, twist and lead modifications of a three-dimensional body; None in a plane scene.
    elements : Body or None
        The body without flank modifications, whose flank the elements (`mesh`) follow; None if this
        body has none, or if the elements follow its own flank.
    """

    kind: str
    curve: FlankCurve
    teeth: int
    material: Material
    rigid: bool
    mode_range_mm: tuple[float, float]
    modes_factor: float = 1.0
    bore_radius_mm: float
    mesh: SectorMesh | WholeMesh | None = None
    mirrored: bool = False
    involute: Involute | None = None
    touches: Roller | Flat | None = None
    imported: ImportedCompliance | None = None
    axial: AxialShape = PLANE_SHAPE
    elements: Body | None = None

    @property
    def unmodified(self) -> Body:
        """The body whose flank the elements follow."""
        return self if self.elements is None else self.elements

    def for_elements(self) -> Body:
        """The body for the elasticity: without the fields of `BodySites` and lead modifications."""
        body = self.unmodified
        none = BodySites()
        without = {entry.name: getattr(none, entry.name) for entry in fields(BodySites)}
        return replace(body, **without, axial=body.axial.without_lead())

    def in_mirror_image(self) -> Body:
        """The body behind a mirror along the axis, in which coast flanks are working flanks."""
        elements = None if self.elements is None else self.elements.in_mirror_image()
        return replace(self, axial=self.axial.in_mirror_image(), elements=elements)

    @property
    def is_parametric(self) -> bool:
        """Whether the involute profile is defined by keys of a scene."""
        return self.kind in ("gear", "ring", "spline_shaft", "spline_hub")

    @property
    def conforms(self) -> bool:
        """Whether the body is a spline, whose flanks conform to those of the other body."""
        return self.kind in ("spline_shaft", "spline_hub")

    @cached_property
    def tip(self) -> Tip | None:
        """The tip of a flank with rounding or chamfer, for its modes; None without one."""
        if self.imported is not None:
            return self.imported.tip
        rounded = {"tip_radius", "tip_chamfer"}.intersection(self.curve.labels)
        if not rounded or not isinstance(self.mesh, SectorMesh) or not self.mesh.tip_edges.size:
            return None
        end, high = self.curve.length_mm, self.mode_range_mm[1]
        before = high - BEFORE_END * (high - self.mode_range_mm[0])
        one, other = self.curve.normal([before, end])
        turn = float(np.arccos(np.clip(one @ other, -1.0, 1.0)))
        return Tip(end, 0 if "tip_chamfer" in self.curve.labels else 1, turn)

    @property
    def outward(self) -> int:
        """1 for external teeth, -1 for internal teeth."""
        root, tip = (self.curve.point([s])[0] for s in (0.0, self.curve.length_mm))
        return 1 if tip @ tip > root @ root else -1

    @property
    def base_radius_mm(self) -> float | None:
        """Base radius of an involute flank, mm."""
        return None if self.involute is None else self.involute.base_radius_mm

    @property
    def normal_lever_mm(self) -> float:
        """Signed lever arm of the normal in the middle of the flank about the axis, mm."""
        middle = [0.5 * (self.mode_range_mm[0] + self.mode_range_mm[1])]
        (x, y), (n_x, n_y) = self.curve.point(middle)[0], self.curve.normal(middle)[0]
        return float(x * n_y - y * n_x)

    @property
    def tip_radius_mm(self) -> float | None:
        """Radius of the tip circle, mm, if the profile is known."""
        return None if self.involute is None else self.involute.tip_radius_mm

    @property
    def root_radius_mm(self) -> float | None:
        """Radius of the root circle, mm, if the profile is known."""
        return None if self.involute is None else self.involute.root_radius_mm


def checked_pitch_errors(errors_um: tuple[float, ...], teeth: int, key: str) -> tuple[float, ...]:
    """Pitch errors of a body, checked: none, or one per tooth."""
    if errors_um and len(errors_um) != teeth:
        expected = f"one entry per tooth: {teeth}"
        refuse(f"{key}.pitch_errors_um", expected, f"{len(errors_um)} entries")
    return tuple(errors_um)
