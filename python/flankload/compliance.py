"""One body's compliance at its flanks: unit loads on one sector, the ring closed by Fourier.

A body meshed as a whole takes the plain way (`whole_body`): all flanks loaded one after the other.
A body of z equal sectors needs the mesh of one (`sector_closure`). Its stiffness is factorised
once; on the right stand the pressure modes of the flank and the columns of the cut faces.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from time import perf_counter, process_time
from typing import TYPE_CHECKING

import numpy as np

from flankload.bodies.body import WholeMesh
from flankload.cost import Account
from flankload.elasticity import stiffness
from flankload.element_error import missed_compliance
from flankload.growth_loads import growth_loads, growth_of_flanks
from flankload.near_field import (
    jump_strength,
    logarithm_strength,
    mirrored_loads,
    mode_norms,
    projected_logarithm,
    projected_sign,
)
from flankload.nodal_loads import every_second, nodes_of
from flankload.sector_closure import (
    alike_response,
    close_ring,
    condense,
    segment_response,
    tooth_response,
)
from flankload.whole_body import count_loads, unit_loads, whole_response

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from numpy.typing import NDArray
    from scipy.sparse import csc_matrix

    from flankload.bodies.body import Body
    from flankload.growth import Growth
    from flankload.root_fillet import RootFillets, RootPoints


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
class BodyCompliance:
    """Compliance of the flanks of one body, per mm of face width.

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
    closed : bool
        The modes are harmonics of a turn around the body.
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
    flanks: tuple[int, ...] = ()
    tangential: NDArray[np.float64] | None = None
    jump: float = 0.0
    along: NDArray[np.float64] | None = None
    crossing: NDArray[np.float64] | None = None
    crossing_tangential: NDArray[np.float64] | None = None
    closed: bool = False
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

    def fewer_modes(self, fewer: int = 1) -> BodyCompliance:
        """The same without the highest modes: a block, since the modes are orthogonal.

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
        kept = self.smooth.shape[1] - (2 * fewer if self.closed else fewer)
        if kept < 1:
            return self
        tangential = None if self.tangential is None else self.tangential[:, :kept, :kept]
        shifts = {name: modes[:, :kept] for name, modes in self.shifts.items()}
        along = None if self.along is None else self.along[:, :kept, :kept]
        crossing = [
            None if part is None else part[:, :kept, :kept]
            for part in (self.crossing, self.crossing_tangential)
        ]
        return replace(
            self,
            smooth=self.smooth[:, :kept, :kept],
            tangential=tangential,
            along=along,
            shifts=shifts,
            crossing=crossing[0],
            crossing_tangential=crossing[1],
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
            tangential=None,
            crossing=None,
            crossing_tangential=None,
            missed=None,
        )

    def grown(self) -> BodyCompliance:
        """Of the same body, grown as a whole: its modes live on the larger curve."""
        low, high = self.mode_range_mm
        larger = 1.0 + self.expansion
        return replace(self, mode_range_mm=(larger * low, larger * high))

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
            tangential=None if self.tangential is None else alone(self.tangential),
            along=None if self.along is None else alone(self.along),
            crossing=crossing,
            crossing_tangential=along,
            root=None if root is None else replace(root, response=alone(root.response)),
        )


def no_compliance(body: Body, growth: Growth | None = None) -> BodyCompliance:
    """Of a body that does not yield, or that nothing loads: no finite elements."""
    expansion = 0.0 if growth is None else growth.strain
    return BodyCompliance(np.zeros((1, 1, 1)), 0.0, body.mode_range_mm, expansion=expansion)


def flank_compliance(
    body: Body,
    *,
    n_modes: int,
    plane: str,
    friction: bool = False,
    along: bool = False,
    nodal: bool = False,
    coast_flanks: bool = False,
    fillets: RootFillets | None = None,
    sectors: int | None = None,
    growth: Growth | None = None,
    matrix: csc_matrix | None = None,
    estimate: bool = False,
) -> BodyCompliance:
    """Compliance of a body's flanks from one finite-element job.

    Parameters
    ----------
    body : Body
        With a mesh, or rigid.
    n_modes : int
        Pressure modes of a flank; their degree should be at most half the number of flank elements.
    plane : {"strain", "stress"}
    friction : bool
        As many modes of load along the flank are solved, too.
    along : bool
        Their displacements along the flank are wanted, too.
    nodal : bool
        Unit forces at the nodes of the flank in place of modes; n_modes is not asked for then.
    coast_flanks : bool
        Displacements of the coast flanks are read, too; of a sector alone.
    fillets : RootFillets, optional
        Where stress is wanted, too.
    sectors : int, optional
        Only a segment of so many equal sectors, an odd number, its two ends held; 1: a single
        tooth. A body meshed as a whole has none.
    growth : Growth, optional
        By what the body grows; of a single tooth only as a whole.
    matrix : csc_matrix, optional
        Stiffness of its mesh, where it is there already.
    estimate : bool
        What the elements miss is estimated, too; not of nodes.

    Returns
    -------
    BodyCompliance
    """
    if body.rigid or body.mesh is None:
        return no_compliance(body, growth)
    wall, clock = perf_counter(), process_time()
    seconds: dict[str, float] = {}

    def lap(step: str) -> None:
        nonlocal clock
        now = process_time()
        seconds[step] = seconds.get(step, 0.0) + now - clock
        clock = now

    missed: list[NDArray[np.float64]] = []
    estimate = estimate and not nodal

    def look(moved: NDArray[np.float64]) -> None:
        missed.append(missed_compliance(mesh.nodes, mesh.cells, body.material, plane, moved))
        lap("estimate")

    mesh, closed = body.mesh, body.curve.closed
    nodes = None
    if nodal:
        nodes = nodes_of(mesh)
        n_modes = nodes.size
    if matrix is None:
        matrix = stiffness(mesh.nodes, mesh.cells, body.material, plane)
    flanks: tuple[int, ...] = ()
    account = Account(workspace_bytes=_sparse_bytes(matrix))
    coast_tooth = 0
    stress = _stress_columns(fillets, body, plane, matrix.shape[0])
    growing = growth_loads(matrix, mesh, growth)
    forces = np.stack(list(growing.values()), axis=1) if growing else None
    by_growth = np.zeros((0, len(growing), n_modes))
    if isinstance(mesh, WholeMesh):
        lap("assembly")
        flanks = tuple(flank.tooth for flank in mesh.flanks)
        response, by_growth, free = whole_response(
            matrix,
            mesh,
            body.mode_range_mm,
            n_modes,
            lap,
            friction=friction,
            closed=closed,
            readings=stress,
            forces=forces,
            account=account,
            nodes=nodes,
            look=look if estimate else None,
        )
        own = np.arange(len(flanks)) * (len(flanks) + 1)
        across = np.arange(len(response)).reshape(len(flanks), -1).T.ravel()
    else:
        loads = unit_loads(mesh, body.mode_range_mm, n_modes, friction=friction, nodes=nodes)
        coast = None
        if coast_flanks:
            assert body.involute is not None
            coast, coast_tooth = mirrored_loads(mesh, loads[:, :n_modes], body.involute.turn_rad)
        lap("assembly")
        more, shown = stress(0) if stress else None, look if estimate else None
        count_loads(account, loads.shape[1], friction=friction)
        if sectors == 1:
            both = [part for part in (coast, more) if part is not None]
            response, free = tooth_response(
                matrix,
                loads,
                mesh,
                lap,
                readings=np.hstack(both) if both else None,
                account=account,
                look=shown,
            )
        else:
            sector, free = condense(
                matrix,
                loads,
                mesh,
                lap,
                coast=coast,
                readings=more,
                forces=forces,
                account=account,
                look=shown,
            )
            if forces is not None:
                by_growth = alike_response(sector, mesh.teeth)[None, -len(growing) :]
            if sectors is None:
                response = close_ring(sector, mesh.teeth)
            else:
                response = segment_response(sector, mesh.teeth, sectors)
        own = np.zeros(1, dtype=np.int64)
        across = -np.arange(mesh.teeth) % mesh.teeth
    crossing = None
    if coast_flanks:
        count = response.shape[2]
        crossing = np.roll(response[:, count : count + n_modes], coast_tooth, axis=0)
        response = np.delete(response, slice(count, count + n_modes), axis=1)
    root = None
    if fillets is not None:
        count, places = response.shape[2], fillets.points.arc_length_mm.size
        root = RootResponse(fillets.points, response[:, count : count + places])
    response = response[:, : response.shape[2]]
    strength = logarithm_strength(body.material, plane)
    jump = 0.0
    if nodes is None:
        if friction:
            jump = jump_strength(body.material, plane)
        _take_out_near_field(response, own, body, n_modes, strength, jump)
    else:
        account.count(unit_loads_nodal=response.shape[2] * max(1, len(flanks)))
    if crossing is not None:
        norms = mode_norms(body.mode_range_mm, n_modes, closed=closed)
        crossing = _of_coefficients(crossing, np.tile(norms, 2) if friction else norms)
    # the response the other way is the transposed one (Betti); the halves of rounding are shared
    mirrored = response[across].transpose(0, 2, 1)
    asymmetry = float(np.abs(response - mirrored).max() / np.abs(response).max())
    response = 0.5 * (response + mirrored)
    moved = dict(zip(growing, by_growth.swapaxes(0, 1), strict=True))
    expansion, shifts = growth_of_flanks(body, growth, n_modes, moved)
    lap("ring")
    seconds["wall"] = perf_counter() - wall
    return BodyCompliance(
        smooth=response[:, :n_modes, :n_modes],
        kernel=strength,
        mode_range_mm=body.mode_range_mm,
        flanks=flanks,
        tangential=response[:, :n_modes, n_modes:] if friction else None,
        jump=jump,
        along=response[:, n_modes:, n_modes:] if along and friction else None,
        crossing=None if crossing is None else crossing[..., :n_modes],
        crossing_tangential=crossing[..., n_modes:] if crossing is not None and friction else None,
        closed=closed,
        nodes=nodes,
        asymmetry=asymmetry,
        degrees_of_freedom=free,
        counters=account.counters,
        workspace_bytes=account.workspace_bytes,
        seconds=seconds,
        root=root,
        shifts=shifts,
        expansion=expansion,
        missed=_missed_of_coefficients(np.stack(missed), body, n_modes) if missed else None,
    )


def _sparse_bytes(matrix: csc_matrix) -> int:
    return int(matrix.data.nbytes + matrix.indices.nbytes + matrix.indptr.nbytes)


def _take_out_near_field(
    response: NDArray[np.float64],
    own: NDArray[np.int64],
    body: Body,
    n_modes: int,
    strength: float,
    jump: float,
) -> None:
    """Leave what modes carry, as mode coefficients; loads along the flank stand behind."""
    low, high = body.mode_range_mm
    closed = body.curve.closed
    logarithm = strength * projected_logarithm(n_modes, high - low, closed=closed)
    response[own, :n_modes, :n_modes] += logarithm
    norms = mode_norms(body.mode_range_mm, n_modes, closed=closed)
    if response.shape[1] > n_modes:
        sign = jump * projected_sign(n_modes, high - low)
        response[own, :n_modes, n_modes:] += sign
        response[own, n_modes:, :n_modes] += sign.T
        response[own, n_modes:, n_modes:] += logarithm
        norms = np.tile(norms, 2)
    response /= norms[:, None] * norms[None, :]


def _of_coefficients(
    crossing: NDArray[np.float64], norms: NDArray[np.float64]
) -> NDArray[np.float64]:
    """What crosses the teeth, between coefficients of modes; pressures are symmetric.

    What a load on the working flank moves on the coast flank of another tooth, the load there moves
    on the working flank here (Betti), and that is the same in a mirror.
    """
    count = crossing.shape[1]
    crossing = crossing / (norms[:count, None] * norms[None, :])
    pressures = crossing[..., :count]
    crossing[..., :count] = 0.5 * (pressures + pressures.transpose(0, 2, 1))
    return crossing


def _missed_of_coefficients(
    missed: NDArray[np.float64], body: Body, n_modes: int
) -> NDArray[np.float64]:
    """What elements miss of displacements out of the material, between coefficients of modes."""
    norms = mode_norms(body.mode_range_mm, n_modes, closed=body.curve.closed)
    loads = np.tile(norms, missed.shape[2] // n_modes)
    return missed[:, :n_modes] / (norms[:, None] * loads)


def _stress_columns(
    fillets: RootFillets | None, body: Body, plane: str, size: int
) -> Callable[[int], NDArray[np.float64]] | None:
    """Columns that read stress at a flank: the strain times the modulus of a free surface."""
    if fillets is None:
        return None
    modulus = body.material.young_modulus_MPa
    if plane == "strain":
        modulus /= 1 - body.material.poisson_ratio**2
    return lambda flank: modulus * fillets.columns(flank, size)
