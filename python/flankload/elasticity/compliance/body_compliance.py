"""Compliance of the flanks of one body, and conversions of it."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from flankload.bodies.tip_modes import tip_modes, with_tip
from flankload.elasticity.compliance.contributions import (
    AxialModes,
    CoastCompliance,
    Expansion,
    FlankModes,
    NearField,
    RimMotion,
    RimResponse,
    RootResponse,
)
from flankload.elasticity.job_log import JobCost
from flankload.elasticity.near_field import mode_products
from flankload.elasticity.nodal_loads import every_second_node

if TYPE_CHECKING:
    from collections.abc import Callable

    from flankload.base.arrays import Flags, Floats, Numbers
    from flankload.bodies.body import Body
    from flankload.pairing.expansion import BodyLoad

    Blocks = Callable[[Floats], Floats]


@dataclass(frozen=True, eq=False)
class BodyCompliance:
    """Compliance of the flanks of one body, per mm of face width; in 3D that of the whole width.

    Attributes
    ----------
    smooth : (z, p, p) array, or (f * f, p, p) array where `flanks` names f teeth
        smooth[t] maps the pressure modes of tooth 0 to displacements out of the material on tooth
        t, as mode coefficients, without the near field; mm²/N, in three dimensions mm/N. By pairs
        of flanks, smooth[i * f + j] maps the modes of flank j to the displacements of flank i.
        With `modes.nodes`, smooth, tangential and along are complete displacements under unit
        forces at these nodes, and the near field is used for the expected width of contacts only.
    near : NearField
        In three dimensions that of a half-space with k = kernel/2 (`prism.flank_potential`).
    flanks : tuple of int
        Teeth with a flank; empty if smooth depends on the difference of tooth numbers only.
    tangential : (z, p, q) array, or (f * f, p, q) array; or None
        Normal displacements under q modes of tangential load towards increasing arc length, without
        the near field; mm²/N. None if no such loads act.
    along_near : (p, p) array; None without friction and for nodes
        That near field on the loaded flank as mode coefficients: jump, and images behind free
        corners.
    along : as tangential, (…, q, q); None without friction or with small forces
        Tangential displacements under the same loads, without the logarithm of strength
        `near.kernel`.
    turns : bool
        Whether forces turn over sharp tips, with `tangential`.
    root : RootResponse or None
        Stress in the root fillets, if requested.
    rim : RimResponse or None
        Displacements of a free rim, if requested.
    rim_motion : RimMotion or None
        Motion of a rim on bolts.
    fe_error : (1, p, p) array, or (f, p, p) array where `flanks` names f teeth; or None
        Estimated discretization error of the response of a flank to its own modes in `smooth`;
        that in `tangential` is multiplied by a coefficient of friction and neglected. None without
        an estimate.
    """

    smooth: Floats
    near: NearField
    modes: FlankModes
    flanks: tuple[int, ...] = ()
    tangential: Floats | None = None
    along_near: Floats | None = None
    along: Floats | None = None
    turns: bool = False
    coast: CoastCompliance | None = None
    expansion: Expansion = field(default_factory=Expansion)
    root: RootResponse | None = None
    rim: RimResponse | None = None
    rim_motion: RimMotion | None = None
    fe_error: Floats | None = None
    job: JobCost = field(default_factory=JobCost)

    @property
    def is_rigid(self) -> bool:
        """Whether forces do not deform the body."""
        return self.near.kernel == 0.0

    @property
    def modes_per_place(self) -> int:
        """Number of modes along the axis for each mode along the profile; 1 in a plane scene."""
        return self.modes.axial.count

    @property
    def modes_along(self) -> int:
        """Number of pressure modes along the arc length, with those of the tip."""
        return self.smooth.shape[1] // self.modes_per_place

    @property
    def flank_modes(self) -> int:
        """Number of pressure modes along the arc length, without those of the tip."""
        n = self.modes_along
        return n if self.modes.tip is None else n - tip_modes(n)

    @property
    def own_blocks(self) -> Numbers:
        """Indices in `smooth` of the responses of flanks to their own loads."""
        f = len(self.flanks)
        return np.arange(f) * (f + 1) if f else np.zeros(1, dtype=np.int64)

    @property
    def exchanged(self) -> Numbers:
        """Indices in `smooth` of the responses with displaced and loaded flank exchanged."""
        f, z = len(self.flanks), len(self.smooth)
        return np.arange(z).reshape(f, f).T.ravel() if f else -np.arange(z) % z

    def block_of(self, displaced: Numbers, loaded: Numbers, teeth: int) -> Numbers:
        """Indices in `smooth` of responses by tooth numbers (arrays that broadcast), from 0.

        `teeth` is the number of teeth.
        """
        if self.is_rigid:
            return np.zeros_like(displaced - loaded)
        if not self.flanks:
            return (displaced - loaded) % teeth
        place = np.searchsorted(self.flanks, np.arange(teeth))
        return place[displaced] * len(self.flanks) + place[loaded]

    def shift_of(self, at: Numbers, n_working: int | None = None) -> Floats:
        """Displacement of flanks by all body loads: mode coefficients (n, p), mm.

        `at` (n,): numbers of teeth, from 0, those of `n_working` working flanks first, by default
        all; (0, p) without body loads.
        """
        shifts, coast = (
            list(parts.values()) for parts in (self.expansion.shifts, self.expansion.coast_shifts)
        )
        if not shifts:
            return np.empty((0, self.smooth.shape[1]))
        total = np.sum(shifts, axis=0)
        if len(total) > 1:
            return np.asarray(total[np.searchsorted(self.flanks, at)])
        found = np.repeat(total, at.size, axis=0)
        if coast and n_working is not None:
            found[n_working:] = np.sum(coast, axis=0)
        return found

    def blocks_of_sites(self, teeth_at: Numbers, n_working: int, teeth: int) -> Numbers:
        """Blocks (S, S) of `all_blocks` for displacements at sites (rows) under loads at sites.

        `teeth_at` (S,): teeth of the body at the sites, working flanks first; `teeth`: number of
        teeth of the body.
        """
        displaced, loaded = teeth_at[:, None], teeth_at[None, :]
        block = self.block_of(displaced, loaded, teeth)
        if n_working == teeth_at.size or self.is_rigid:
            return block
        coast = np.arange(teeth_at.size) >= n_working
        return block + teeth * (coast[:, None] + 2 * coast[None, :])

    def all_blocks(self) -> tuple[Floats, Floats | None]:
        """`smooth` and `tangential`, each followed by the response of coast flanks, if any."""
        coast, tangential = self.coast, self.tangential
        if coast is None:
            return self.smooth, tangential
        if tangential is not None and coast.tangential is not None:
            tangential = np.concatenate([tangential, coast.tangential])
        return np.concatenate([self.smooth, coast.normal]), tangential

    def with_blocks(self, change: Blocks, of_coast: Blocks | None = None) -> BodyCompliance:
        """The compliance with changed responses.

        `change` maps each of smooth, tangential and along, if present; `of_coast` those of the
        coast flanks, by default `change`.
        """
        blocks = {name: getattr(self, name) for name in ("smooth", "tangential", "along")}
        coast, of_coast = self.coast, of_coast or change
        if coast is not None:
            along = coast.tangential
            coast = CoastCompliance(
                of_coast(coast.normal), None if along is None else of_coast(along)
            )
        changed: dict[str, Any] = {
            name: change(part) for name, part in blocks.items() if part is not None
        }
        return replace(self, coast=coast, **changed)

    def fewer_modes(self, fewer: int = 1) -> BodyCompliance:
        """The compliance without the highest modes of the flank.

        Modes without a tip are orthogonal, so that blocks of the matrices remain. With a tip, its
        highest modes are dropped as well, and responses are projected. Each harmonic of a closed
        flank has two modes. Tables between nodes are reduced to half of the nodes.
        """
        if self.modes.nodes is not None:
            half, parts = every_second_node(self.modes.nodes)
            halved = self.with_blocks(lambda table: parts.T @ table @ parts)
            root = self.root_under(lambda table: table @ parts)
            return replace(halved, modes=replace(self.modes, nodes=half), root=root)
        places, parts = self._lower_modes(fewer)
        if places.size == self.smooth.shape[1]:
            return self

        def projected(blocks: Floats) -> Floats:
            if self.modes.tip is None:
                return blocks[:, : places.size, : places.size]
            return np.asarray(parts @ blocks @ parts.T)

        return replace(
            self.with_blocks(projected),
            expansion=self.expansion.with_shifts(lambda modes: modes @ parts.T),
            root=self.root_under(lambda table: table[..., places]),
            fe_error=None,
        )

    def _lower_modes(self, fewer: int) -> tuple[Numbers, Floats]:
        """Numbers of the kept modes (k,), and their coefficients (k, p) from those of all modes."""
        n, each, tip = self.smooth.shape[1], self.modes_per_place, self.modes.tip
        flank = each * self.flank_modes
        kept = flank - each * (2 * fewer if self.modes.closed else fewer)
        if kept < 1:
            return np.arange(n), np.eye(n)
        own = 0 if tip is None else each * with_tip(kept // each) - kept
        places = np.r_[:kept, flank : flank + own]
        parts = np.eye(n)[places]
        if tip is not None:
            along_axis = np.diag(1.0 / (2.0 * np.arange(each) + 1.0))
            products = np.kron(mode_products(self.modes.range_mm, n // each, tip), along_axis)
            parts = np.asarray(np.linalg.solve(parts @ products @ parts.T, parts @ products))
        return places, parts

    def onto_lower_modes(self, fewer: int = 1) -> Floats:
        """Projection (p, p) of coefficients of all modes on the modes of `fewer_modes`."""
        if self.modes.nodes is not None:
            _, parts = every_second_node(self.modes.nodes)
            return np.asarray(parts @ parts.T)
        places, parts = self._lower_modes(fewer)
        return np.eye(self.smooth.shape[1])[:, places] @ parts

    def root_under(self, change: Blocks) -> RootResponse | None:
        """Root stress under other loads: `change` maps tables of normal or tangential ones."""
        n, root = self.smooth.shape[1], self.root

        def changed(table: Floats) -> Floats:
            kinds = [table[..., k : k + n] for k in range(0, table.shape[-1], n)]
            return np.concatenate([change(kind) for kind in kinds], axis=-1)

        return None if root is None else root.with_each(changed)

    def fewer_axial_modes(self, fewer: int = 2) -> BodyCompliance:
        """In three dimensions, the compliance without the modes of the highest degrees in z."""
        axial, kept = self.modes.axial, self._lower_degrees(fewer)
        if kept.size == self.smooth.shape[1]:
            return self
        return replace(
            self.with_blocks(lambda blocks: blocks[:, kept[:, None], kept]),
            modes=replace(self.modes, axial=replace(axial, degree=axial.degree - fewer)),
            expansion=self.expansion.with_shifts(lambda modes: modes[:, kept]),
            root=self.root_under(lambda table: table[..., kept]),
            fe_error=None,
        )

    def _lower_degrees(self, fewer: int) -> Numbers:
        """Numbers of the modes without the highest degrees in z; of all if none would remain."""
        count = self.modes.axial.count
        fewer = fewer if 0 < fewer < count else 0
        return np.flatnonzero(np.arange(self.smooth.shape[1]) % count < count - fewer)

    def onto_lower_degrees(self, fewer: int = 2) -> Floats:
        """As `onto_lower_modes`, on the modes of `fewer_axial_modes`."""
        own = np.eye(self.smooth.shape[1])
        return own * np.isin(np.arange(len(own)), self._lower_degrees(fewer))

    def with_fe_error(self, times: float) -> BodyCompliance:
        """The compliance plus a multiple of its estimated discretization error."""
        if self.fe_error is None:
            return self
        smooth, coast = self.smooth.copy(), self.coast
        smooth[self.own_blocks] += times * self.fe_error
        if coast is not None:
            normal = coast.normal.copy()
            normal[2 * len(smooth)] += times * self.fe_error[0]
            coast = replace(coast, normal=normal)
        return replace(self, smooth=smooth, coast=coast, fe_error=None)

    def without_elasticity(self) -> BodyCompliance:
        """The compliance of a body that only body loads deform."""
        count, modes = 1, replace(self.modes, tip=None, nodes=None)
        if self.expansion.shifts:  # these are in terms of all modes
            count, modes = self.smooth.shape[1], self.modes
        return replace(
            self,
            smooth=np.zeros((1, count, count)),
            modes=modes,
            near=replace(self.near, kernel=0.0),
            tangential=None,
            turns=False,
            coast=None,
            fe_error=None,
        )

    def expanded(self) -> BodyCompliance:
        """The compliance with modes on the uniformly expanded curve."""
        low, high = self.modes.range_mm
        larger, tip, axial = 1.0 + self.expansion.strain, self.modes.tip, self.modes.axial
        modes = replace(
            self.modes,
            range_mm=(larger * low, larger * high),
            tip=None if tip is None else tip.larger(larger),
            axial=replace(axial, twist=axial.twist / (1.0 + self.expansion.axial_strain)),
        )
        return replace(self, modes=modes)

    def without_friction(self, *, turns: bool = False) -> BodyCompliance:
        """The compliance without friction, in arrays of its own; `turns`: forces turn over tips."""
        if self.tangential is None:
            return self
        p, root, rim = self.smooth.shape[1], self.root, self.rim
        if root is not None:
            root = root.with_each(lambda part: part[..., :p].copy())
        if rim is not None:
            rim = rim.with_loads(lambda part: part[..., :p].copy())
        if turns:
            return replace(self, along=None, root=root, rim=rim)
        return replace(
            self,
            smooth=self.smooth.copy(),
            near=replace(self.near, jump=0.0),
            tangential=None,
            turns=False,
            along=None,
            coast=None if self.coast is None else CoastCompliance(self.coast.normal.copy()),
            root=root,
            rim=rim,
        )

    def apart(self, apart: Flags, block: Numbers) -> tuple[BodyCompliance, Numbers]:
        """The compliance without the response between some sites, and the blocks of all sites.

        Parameters
        ----------
        apart : (S, S) array of bool
            Sites that a load on another one does not displace; if some are on opposite flanks, all
            are.
        block : (S, S) array
            As for `blocks_of_sites`.
        """
        z, coast = len(self.smooth), self.coast
        if coast is not None and bool(np.all((block[apart] >= z) & (block[apart] < 3 * z))):
            own = np.arange(2 * z, 3 * z)
            return self.with_blocks(lambda part: part, lambda part: _only(part, own)), block

        def with_none(blocks: Floats) -> Floats:
            return np.concatenate([blocks, np.zeros_like(blocks[:1])])

        last = len(self.all_blocks()[0])
        change = with_none if coast is None else lambda blocks: blocks
        return self.with_blocks(change, with_none), np.where(apart, last, block)

    def without_coupling(self) -> BodyCompliance:
        """The compliance without the response of other teeth to a load on a tooth."""

        def alone(blocks: Floats) -> Floats:
            return _only(blocks, self.own_blocks)

        def alone_across(blocks: Floats) -> Floats:
            # the coast flank of an internal tooth belongs to the next space
            assert self.coast is not None
            z = len(self.coast.normal) // 3
            own = int(np.abs(self.coast.normal[:z, 0, 0]).argmax())
            return _only(blocks, np.array([own, z + -own % z, 2 * z]))

        root = self.root
        return replace(
            self.with_blocks(alone, alone_across),
            root=None if root is None else root.with_each(alone),
        )


def _only(blocks: Floats, kept: Numbers) -> Floats:
    """Blocks with zeros except for those in `kept`."""
    alone = np.zeros_like(blocks)
    alone[kept] = blocks[kept]
    return alone


def no_compliance(body: Body, body_load: BodyLoad | None = None) -> BodyCompliance:
    """Compliance of a rigid body or an unloaded one, without finite elements."""
    shape = body.axial
    tangent = shape.twist_rad_per_mm * (body.base_radius_mm or body.normal_lever_mm)
    cosine = float(1.0 / np.hypot(1.0, tangent))
    constant = AxialModes(shape.range_mm, 0, shape.twist_rad_per_mm, cosine)
    return BodyCompliance(
        np.zeros((1, 1, 1)),
        NearField(0.0),
        FlankModes(body.mode_range_mm, axial=constant),
        expansion=Expansion(0.0 if body_load is None else body_load.strain),
    )
