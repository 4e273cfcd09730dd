"""Condensation of a mesh to the loads on it and to the cuts of its sector.

The remainder of the elimination (`elimination`) is the input of the ring closure.

Without twist, displacements in the section of even (odd) axial degree are coupled to axial ones of
odd (even) degree only: two problems of half the size. This includes regions of different widths
with a common middle plane.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from flankload.base.blas_threads import one_blas_thread
from flankload.bodies.body import SectorMesh
from flankload.cost import Account
from flankload.elasticity.condensed_sector import CondensedSector
from flankload.elasticity.fronts.dissection import dissect
from flankload.elasticity.fronts.elimination import Elimination, PairStiffness
from flankload.elasticity.fronts.mirror import images_of, line_of, reflection
from flankload.elasticity.fronts.problem import Problem

if TYPE_CHECKING:
    from flankload.base.arrays import Floats, Numbers
    from flankload.bodies.body import WholeMesh
    from flankload.elasticity.finite_elements import SectionStiffness
    from flankload.elasticity.fronts.dissection import Dissection
    from flankload.elasticity.fronts.recovery import Recovery


def condense_nodes(
    section: SectionStiffness,
    mesh: SectorMesh | WholeMesh,
    loads: Floats,
    *,
    held: bool = False,
    account: Account | None = None,
    recovery: Recovery | None = None,
) -> CondensedSector:
    """Condense a mesh to its loads and cuts, with nodes that are fixed over their whole width.

    Parameters
    ----------
    loads : (N, u, r) array
        Columns by node and unknown, which are also readings.
    held : bool
        Whether the cuts are fixed, too.
    recovery : Recovery, optional
        Stores the fronts for displacements inside the mesh.

    Raises
    ------
    MeshError
        If the stiffness is not positive definite.
    """
    cut = np.zeros(0, dtype=np.int64)
    inner = np.ones(section.nodes, dtype=bool)
    inner[mesh.fixed_nodes] = False
    images, turn, twisted = None, None, section.twist != 0.0
    if isinstance(mesh, SectorMesh):
        cut = np.concatenate([mesh.left_nodes, mesh.right_nodes])
        inner[cut] = False
        cut = cut[:0] if held else cut
        if section.halved and (section.functions.symmetric or not twisted):
            images = images_of(mesh, inner)
    if isinstance(mesh, SectorMesh) and images is not None:
        turn = reflection(mesh, section.functions.count, section.components, twisted=twisted)
    order = dissect(
        mesh.nodes,
        [cells for _, cells in mesh.cells],
        inner=inner,
        kept=cut,
        unknowns=section.unknowns,
        images=images,
    )
    sector = condense_in_order(section, order, loads, turn=turn, account=account, recovery=recovery)
    if not isinstance(mesh, SectorMesh) or turn is None:
        return sector
    line = line_of(mesh, section.cut_degree + 1, section.components, twisted=twisted)
    return replace(sector, line=line)


def condense_in_order(
    section: SectionStiffness,
    order: Dissection,
    loads: Floats,
    *,
    turn: Floats | None = None,
    account: Account | None = None,
    recovery: Recovery | None = None,
) -> CondensedSector:
    """Condense nodes in a given order; other arguments as for `condense_nodes`.

    `turn`: reflection of the unknowns of a node, for a symmetric mesh.
    """
    account = Account() if account is None else account
    cut, functions = order.order[order.inner :], section.functions
    per_cut = section.components * (section.cut_degree + 1)
    count, size = loads.shape[2], cut.size * per_cut
    whole = np.zeros((size + count, size + count))
    products = functions.products(section)
    coupled = section.components == 2 or section.twist != 0.0 or not functions.symmetric
    sets = _independent(functions.count, section.components, coupled=coupled)
    if recovery is not None:
        recovery.begin(order, cut, section.unknowns, per_cut)
    # most fronts are too small for several threads
    with one_blas_thread():
        for number, unknowns in enumerate(sets):
            problem = Problem.of(order, unknowns, per_cut, loads, turn)
            elimination = Elimination(
                order,
                problem,
                PairStiffness(section, products, order, problem),
                account,
                (number / len(sets), (number + 1) / len(sets)),
                frozenset() if recovery is None else recovery.needed,
            )
            at = (np.arange(cut.size)[:, None] * per_cut + problem.of_kept).ravel()
            at = np.append(at, size + problem.columns)
            whole[np.ix_(at, at)] += elimination.remainder()
            if recovery is not None:
                recovery.add(elimination)
    if recovery is not None:
        account.workspace_bytes += recovery.bytes
    on_cut = loads[cut][:, :per_cut].reshape(size, count)
    return CondensedSector(
        local=(-whole[size:, size:],),
        carried=(whole[:size, size:] + on_cut,),
        stiffness=whole[:size, :size],
        components=section.components,
    )


def _independent(functions: int, components: int, *, coupled: bool) -> list[Numbers]:
    """Sets of unknowns of a node that are not coupled to each other."""
    unknowns = np.arange(components * functions)
    if coupled:
        return [unknowns]
    function, component = np.divmod(unknowns, components)
    odd = (function + (component == components - 1)) % 2
    return [unknowns[odd == part] for part in (0, 1)]
