"""Condensation of a mesh to the loads on it and to the cuts of its sector.

Each node of the plane mesh has c (p + 1) unknowns for c components, by axial function, then
component: 2 in the plane, 3 (p + 1) in a prism. Cuts have the axial degrees up to q, i.e. the first
c (q + 1) unknowns of each node. The remainder of the elimination (`elimination`) is the input of
the ring closure.

Without twist, displacements in the section of even (odd) axial degree are coupled to axial ones of
odd (even) degree only: two problems of half the size. This includes regions of different widths
with a common middle plane.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flankload.base.blas_threads import one_blas_thread
from flankload.bodies.body import SectorMesh
from flankload.cost import Account
from flankload.elasticity.axial_basis import AxialBasis
from flankload.elasticity.condensed_sector import CondensedSector
from flankload.elasticity.fronts.dissection import dissect
from flankload.elasticity.fronts.elimination import Elimination, PairStiffness
from flankload.elasticity.fronts.mirror import images_of, reflection
from flankload.elasticity.fronts.problem import Problem

if TYPE_CHECKING:
    from flankload.base.arrays import Floats, Numbers
    from flankload.bodies.body import WholeMesh
    from flankload.elasticity.axial_basis import AxialFunctions
    from flankload.elasticity.finite_elements import SectionStiffness
    from flankload.elasticity.fronts.dissection import Dissection
    from flankload.elasticity.fronts.recovery import Recovery

#: Functions of z of a plane body: constant displacements, per mm of width.
PLANE = AxialBasis((0.0, 1.0), 0)


def condense_nodes(
    section: SectionStiffness,
    axial: AxialFunctions,
    mesh: SectorMesh | WholeMesh,
    loads: Floats,
    *,
    cut_degree: int = 0,
    twisted: bool = False,
    held: bool = False,
    account: Account | None = None,
    recovery: Recovery | None = None,
) -> CondensedSector:
    """Condense a mesh to its loads and cuts, with nodes that are fixed over their whole width.

    Parameters
    ----------
    loads : (N, c (p + 1), r) array
        Columns by node and unknown, which are also readings.
    cut_degree : int
        Degree q <= p of the displacements of the cuts in z. Their unknowns are by node, axial
        function, component.
    twisted : bool
        False: two problems of half the size if the functions of z are even or odd.
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
    if isinstance(mesh, SectorMesh):
        cut = np.concatenate([mesh.left_nodes, mesh.right_nodes])
        inner[cut] = False
        cut = cut[:0] if held else cut
    inner[mesh.fixed_nodes] = False
    images, turn = None, None
    if isinstance(mesh, SectorMesh) and (axial.symmetric or not twisted):
        images = images_of(mesh, inner)
    if isinstance(mesh, SectorMesh) and images is not None:
        turn = reflection(mesh, axial.count, section.components, twisted=twisted)
    order = dissect(
        mesh.nodes,
        [cells for _, cells in mesh.cells],
        inner=inner,
        kept=cut,
        unknowns=section.components * axial.count,
        images=images,
    )
    return condense_in_order(
        section,
        axial,
        order,
        loads,
        cut_degree=cut_degree,
        twisted=twisted,
        account=account,
        recovery=recovery,
        turn=turn,
    )


def condense_in_order(
    section: SectionStiffness,
    axial: AxialFunctions,
    order: Dissection,
    loads: Floats,
    *,
    cut_degree: int = 0,
    twisted: bool = False,
    account: Account | None = None,
    recovery: Recovery | None = None,
    turn: Floats | None = None,
) -> CondensedSector:
    """Condense nodes in a given order; other arguments as of `condense_nodes`.

    `turn`: reflection of the unknowns of a node, for a symmetric mesh.
    """
    account = Account() if account is None else account
    cut = order.order[order.inner :]
    per_cut = section.components * (cut_degree + 1)
    count, size = loads.shape[2], cut.size * per_cut
    whole = np.zeros((size + count, size + count))
    products = axial.products(section)
    coupled = section.components == 2 or twisted or not axial.symmetric
    sets = _independent(axial.count, section.components, coupled=coupled)
    if recovery is not None:
        recovery.begin(order, cut, axial.count * section.components, per_cut)
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
