"""What is known of how the flanks of one body yield, and what follows from it by itself."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np

from flankload.bodies.tip_modes import TIP_MODES
from flankload.elasticity.near_field import mode_products
from flankload.elasticity.nodal_loads import every_second

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    from flankload.bodies.body import Body
    from flankload.bodies.root_fillet import RootPoints
    from flankload.bodies.tip_modes import Tip
    from flankload.pairing.expansion import Growth


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
        the flank, towards growing arc length.
    """

    points: RootPoints
    response: NDArray[np.float64]


@dataclass(frozen=True)
class AxialModes:
    """Modes along the axis, of a body in three dimensions.

    Attributes
    ----------
    range_mm : (float, float)
        Between which they live: the whole width of the body.
    degree : int
        Highest degree q_z; a mode of the flank is P_a(xi_s) P_b(xi_z), at index a (q_z + 1) + b.
    twist : float
        By how much the section turns counter-clockwise with growing z, rad/mm.
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


@dataclass(frozen=True)
class BodyCompliance:
    """Compliance of the flanks of one body: per mm of face width, or with `axial` of all of it.

    Attributes
    ----------
    smooth : (z, p, p) array, or (f * f, p, p) array where `flanks` names f teeth
        smooth[t] maps the pressure modes of tooth 0 to displacements out of the material on tooth
        t, as mode coefficients, without the logarithm; mm²/N. By pairs of flanks smooth[i * f + j]
        maps the modes of flank j to the displacements of flank i.
    kernel : float
        Strength c0 of the logarithm, mm²/N; 0 for a rigid body.
    mode_range_mm : (float, float)
        Arc lengths of the flank curve between which the modes live.
    wedge : (float, float)
        Strengths psi of the mirror images of the logarithm behind free corners at both ends of that
        range; 0 where the surface goes on smoothly, on closed flanks and where nodes are given.
    turned : (z, p) array, or (f * f, p) array; None without a sharp tip
        As smooth, displacements by a unit force along the flank at its sharp tip, towards growing
        arc length, without its images: forces turn over the corner.
    wedge_along : (float, float)
        Strengths psi_nt of the images of loads along the flank, towards growing arc length, by
        which it moves along its normal; as wedge.
    flanks : tuple of int
        Empty where smooth depends on the distance of teeth alone; else the teeth that have a flank.
    tangential : (z, p, q) array, or (f * f, p, q) array; None without friction
        In the same places, displacements out of the material by q modes of load along the flank
        towards growing arc length, without the jump; mm²/N.
    jump : float
        Strength j of the jump, mm²/N; 0 without friction.
    along : as tangential, (…, q, q); None without friction, or where forces are small ones
        Displacements along the flank by the same loads, without the logarithm, which is as strong
        as the kernel.
    crossing : (z, p, p) array; None without contact on coast flanks
        crossing[t] maps the pressure modes on the working flank of tooth 0 to displacements on the
        coast flank of tooth t; mm²/N. What coast flanks do to each other and to working flanks is
        the same in a mirror.
    crossing_tangential : (z, p, q) array; None without friction
        The same for the modes of load along the working flank.
    axial : AxialModes or None
        In three dimensions: smooth is in mm/N, its modes are products, and the near field is that
        of a half-space with k = kernel/2 (`prism.flank_potential`).
    closed : bool
        The modes are harmonics of a turn around the body.
    tip : Tip or None
        Where the modes of a tip rounding or chamfer end; the last two modes are theirs.
    nodes : (n,) array, or None
        Arc lengths of the nodes, mm, where tables between them stand in place of modes: smooth,
        tangential and along then hold whole displacements by unit forces, mm²/N, and the kernel
        only says how wide contacts are to be expected.
    asymmetry : float
        Largest relative difference of a response and its transposed counterpart before both were
        averaged.
    degrees_of_freedom : int
        Of its elements, those that are not held.
    counters : mapping of str to int
        What it took, by the names of `cost.COUNTERS`, without zeros.
    workspace_bytes : int
        Of stiffness, factors and solutions, which are given back.
    seconds : dict of str to float
        CPU seconds of assembly, factorisation, solution, ring closure; "wall" for the whole.
    root : RootResponse or None
        Stress in the root fillets, where it is asked for.
    shifts : dict of str to (1, p) or (f, p) array
        By name of a known load, how far flanks stand out of the material under it before they
        touch, as mode coefficients, mm: one row for all teeth, or one for each of `flanks`.
    expansion : float
        Strain by which the body grows as a whole before anything touches; shifts come on top.
    missed : (1, p, p + q) array, or (f, p, p + q) array where `flanks` names f teeth; or None
        What the elements miss, by their estimate, of the response of a flank to the modes on
        itself: of `smooth`, and behind it of `tangential`. None where no estimate is wanted.
    """

    smooth: NDArray[np.float64]
    kernel: float
    mode_range_mm: tuple[float, float]
    wedge: tuple[float, float] = (0.0, 0.0)
    turned: NDArray[np.float64] | None = None
    wedge_along: tuple[float, float] = (0.0, 0.0)
    flanks: tuple[int, ...] = ()
    tangential: NDArray[np.float64] | None = None
    jump: float = 0.0
    along: NDArray[np.float64] | None = None
    crossing: NDArray[np.float64] | None = None
    crossing_tangential: NDArray[np.float64] | None = None
    axial: AxialModes | None = None
    closed: bool = False
    tip: Tip | None = None
    nodes: NDArray[np.float64] | None = None
    asymmetry: float = 0.0
    degrees_of_freedom: int = 0
    counters: Mapping[str, int] = field(default_factory=dict)
    workspace_bytes: int = 0
    seconds: dict[str, float] = field(default_factory=dict)
    root: RootResponse | None = None
    shifts: dict[str, NDArray[np.float64]] = field(default_factory=dict)
    expansion: float = 0.0
    missed: NDArray[np.float64] | None = None

    @property
    def is_rigid(self) -> bool:
        """Whether the body does not yield at all."""
        return self.kernel == 0.0

    @property
    def flank_modes(self) -> int:
        """Number of pressure modes along the arc length, without those of the tip."""
        n = self.smooth.shape[1] // (1 if self.axial is None else self.axial.count)
        return n - TIP_MODES * (self.tip is not None)

    def block_of(
        self, displaced: NDArray[np.int64], loaded: NDArray[np.int64], teeth: int
    ) -> NDArray[np.int64]:
        """Where in `smooth` the response of teeth to loads on teeth stands.

        Parameters
        ----------
        displaced, loaded : arrays that broadcast
            Teeth of the body, from 0.
        teeth : int
            Number of teeth of the body.

        Returns
        -------
        array
        """
        if self.is_rigid:
            return np.zeros_like(displaced - loaded)
        if not self.flanks:
            return (displaced - loaded) % teeth
        place = np.searchsorted(self.flanks, np.arange(teeth))
        return place[displaced] * len(self.flanks) + place[loaded]

    def shift_of(self, at: NDArray[np.int64]) -> NDArray[np.float64]:
        """How far flanks stand out under all known loads together.

        Parameters
        ----------
        at : (n,) array
            Teeth of the body, from 0.

        Returns
        -------
        (n, p) array
            Mode coefficients, mm; (0, p) where no load is known.
        """
        if not self.shifts:
            return np.empty((0, self.smooth.shape[1]))
        total = np.sum(list(self.shifts.values()), axis=0)
        if len(total) == 1:
            return np.broadcast_to(total, (at.size, total.shape[1]))
        return np.asarray(total[np.searchsorted(self.flanks, at)])

    def blocks_of_sites(
        self, teeth_at: NDArray[np.int64], n_working: int, teeth: int
    ) -> NDArray[np.int64]:
        """Blocks of `all_blocks` for displacements at sites (rows) under loads at sites.

        Parameters
        ----------
        teeth_at : (S,) array
            Tooth of the body at each site; sites of coast flanks stand behind the others.
        n_working : int
            Number of sites of working flanks.
        teeth : int
            Number of teeth of the body.

        Returns
        -------
        (S, S) array
        """
        displaced, loaded = teeth_at[:, None], teeth_at[None, :]
        block = self.block_of(displaced, loaded, teeth)
        if n_working == teeth_at.size or self.is_rigid:
            return block
        coast = np.arange(teeth_at.size) >= n_working
        # a load on a coast flank is one on a working flank in a mirror, which counts the other way
        block = np.where(coast[None, :], self.block_of(loaded, displaced, teeth), block)
        return block + teeth * (coast[:, None] != coast[None, :])

    def all_blocks(self) -> tuple[NDArray[np.float64], NDArray[np.float64] | None]:
        """`smooth` and `tangential`, followed by what crosses the teeth where there is such."""
        if self.crossing is None:
            return self.smooth, self.tangential
        tangential = self.tangential
        if tangential is not None and self.crossing_tangential is not None:
            tangential = np.concatenate([tangential, self.crossing_tangential])
        return np.concatenate([self.smooth, self.crossing]), tangential

    def turned_blocks(self) -> NDArray[np.float64] | None:
        """`turned`, a row for each of `all_blocks`: coast flanks do not turn with it."""
        if self.turned is None or self.crossing is None:
            return self.turned
        return np.concatenate([self.turned, np.zeros_like(self.crossing[:, :, 0])])

    def fewer_modes(self, fewer: int = 1) -> BodyCompliance:
        """The same without the highest modes of the flank.

        These are orthogonal, and the rest is a block; beside modes of a tip all are projected anew.
        The highest harmonic of a turn is two of them. Of tables: between half as many nodes.
        """
        if self.nodes is not None:
            half, parts = every_second(self.nodes)
            tables = {
                name: parts.T @ table @ parts
                for name in ("smooth", "tangential", "along")
                if (table := getattr(self, name)) is not None
            }
            return replace(self, nodes=half, **tables)
        n, each = self.smooth.shape[1], 1 if self.axial is None else self.axial.count
        flank = n - (0 if self.tip is None else each * TIP_MODES)
        kept = flank - each * (2 * fewer if self.closed else fewer)
        if kept < 1:
            return self
        parts = np.delete(np.eye(n), np.s_[kept:flank], axis=0)
        if self.tip is not None:
            along_axis = np.diag(1.0 / (2.0 * np.arange(each) + 1.0))
            products = np.kron(mode_products(self.mode_range_mm, n // each, self.tip), along_axis)
            parts = np.asarray(np.linalg.solve(parts @ products @ parts.T, parts @ products))

        def projected(blocks: NDArray[np.float64] | None) -> NDArray[np.float64] | None:
            if blocks is None:
                return None
            if self.tip is None:
                return blocks[:, :kept, :kept]
            return np.asarray(parts @ blocks @ parts.T)

        smooth = projected(self.smooth)
        assert smooth is not None
        return replace(
            self,
            smooth=smooth,
            turned=None if self.turned is None else self.turned[:, :kept],
            tangential=projected(self.tangential),
            along=projected(self.along),
            crossing=projected(self.crossing),
            crossing_tangential=projected(self.crossing_tangential),
            shifts={name: modes @ parts.T for name, modes in self.shifts.items()},
            missed=None,
        )

    def fewer_axial_modes(self, fewer: int = 2) -> BodyCompliance:
        """In three dimensions, the same without the modes of the highest degrees in z."""
        axial = self.axial
        if axial is None or axial.degree < fewer:
            return self
        kept = np.flatnonzero(np.arange(self.smooth.shape[1]) % axial.count < axial.count - fewer)
        return replace(
            self,
            smooth=self.smooth[:, kept[:, None], kept],
            axial=replace(axial, degree=axial.degree - fewer),
            missed=None,
        )

    def with_missed(self, times: float) -> BodyCompliance:
        """The same with so many times what its elements miss by their estimate."""
        if self.missed is None:
            return self
        p, f = self.smooth.shape[1], len(self.flanks)
        own = np.arange(f) * (f + 1) if f else np.zeros(1, dtype=np.int64)
        smooth, tangential = self.smooth.copy(), self.tangential
        smooth[own] += times * self.missed[:, :, :p]
        if tangential is not None:
            tangential = tangential.copy()
            tangential[own] += times * self.missed[:, :, p:]
        return replace(self, smooth=smooth, tangential=tangential, missed=None)

    def unyielding(self) -> BodyCompliance:
        """Of the same body where no force moves it; known loads do."""
        modes = self.smooth.shape[1] if self.shifts else 1
        return replace(
            self,
            smooth=np.zeros((1, modes, modes)),
            kernel=0.0,
            turned=None,
            tangential=None,
            crossing=None,
            crossing_tangential=None,
            missed=None,
        )

    def grown(self) -> BodyCompliance:
        """Of the same body, grown as a whole: its modes live on the larger curve."""
        low, high = self.mode_range_mm
        larger = 1.0 + self.expansion
        tip = None if self.tip is None else self.tip.larger(larger)
        return replace(self, mode_range_mm=(larger * low, larger * high), tip=tip)

    def on_flank(self, body: Body) -> BodyCompliance:
        """Of a body whose flank is longer or shorter by its modifications: arc lengths are its own.

        Parameters
        ----------
        body : Body

        Returns
        -------
        BodyCompliance
        """
        (low, high), span = self.mode_range_mm, body.mode_range_mm
        nodes = self.nodes
        if nodes is not None:
            nodes = span[0] + (nodes - low) * ((span[1] - span[0]) / (high - low))
        tip = None if self.tip is None else body.tip
        return replace(self, mode_range_mm=span, tip=tip, nodes=nodes)

    def without_coupling(self) -> BodyCompliance:
        """The same, but a load on a tooth moves no other tooth, and stresses none."""
        own = np.zeros(1, dtype=np.int64)
        if self.flanks:
            own = np.arange(len(self.flanks)) * (len(self.flanks) + 1)

        def alone(
            blocks: NDArray[np.float64], kept: NDArray[np.int64] = own
        ) -> NDArray[np.float64]:
            alike = np.zeros_like(blocks)
            alike[kept] = blocks[kept]
            return alike

        crossing, along = self.crossing, self.crossing_tangential
        if crossing is not None:  # a tooth that stands inwards is one of two spaces
            across = np.atleast_1d(np.abs(crossing[:, 0, 0]).argmax())
            crossing = alone(crossing, across)
            along = None if along is None else alone(along, across)
        root = self.root
        return replace(
            self,
            smooth=alone(self.smooth),
            turned=None if self.turned is None else alone(self.turned),
            tangential=None if self.tangential is None else alone(self.tangential),
            along=None if self.along is None else alone(self.along),
            crossing=crossing,
            crossing_tangential=along,
            root=None if root is None else replace(root, response=alone(root.response)),
        )


def no_compliance(body: Body, growth: Growth | None = None) -> BodyCompliance:
    """Of a body that does not yield, or that nothing loads: no finite elements."""
    expansion = 0.0 if growth is None else growth.strain
    return BodyCompliance(
        np.zeros((1, 1, 1)), 0.0, body.mode_range_mm, expansion=expansion, axial=_whole_width(body)
    )


def _whole_width(body: Body) -> AxialModes | None:
    """One constant mode over the width of a three-dimensional body that does not yield."""
    shape = body.axial
    if shape is None:
        return None
    tangent = shape.twist_rad_per_mm * (body.base_radius_mm or body.normal_lever_mm)
    return AxialModes(
        shape.range_mm, 0, shape.twist_rad_per_mm, float(1.0 / np.hypot(1.0, tangent)), (0.0, 0.0)
    )
