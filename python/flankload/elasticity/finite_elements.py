"""Plane finite elements: stiffness matrix, loads and factorisation, per mm of width.

Shape functions and quadrature are those of scikit-fem; degrees of freedom are 2*node + component.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING

import numpy as np
from scipy.sparse import coo_array, csc_array
from scipy.sparse.linalg import SuperLU, splu

from flankload.cost import Account

if TYPE_CHECKING:
    from collections.abc import Callable

    from flankload.base.arrays import Cells, Floats, Numbers
    from flankload.bodies.body import Material

#: Degree of the quadrature; degree 6 changes the compliance of a gear by 1e-9.
INTEGRATION_DEGREE = {"quad9": 4, "triangle6": 4}
#: The same for loads that are linear in the coordinates.
LOAD_DEGREE = 6
#: Number of right-hand sides solved at once; all at once take twice the time (cache).
BLOCK = 16
#: Number of kept unknowns above which a second factorisation is cheaper than a solution for each.
MANY_KEPT = 150


def lame_parameters(material: Material, plane: str) -> tuple[float, float]:
    """Lamé's lambda and mu (MPa) in plane "strain" or "stress".

    In plane stress lambda is 2 lambda mu / (lambda + 2 mu).
    """
    modulus, ratio = material.young_modulus_MPa, material.poisson_ratio
    lame_mu = modulus / (2 * (1 + ratio))
    lame_lambda = modulus * ratio / ((1 + ratio) * (1 - 2 * ratio))
    if plane == "stress":
        lame_lambda = 2 * lame_lambda * lame_mu / (lame_lambda + 2 * lame_mu)
    return lame_lambda, lame_mu


def stiffness(nodes: Floats, cells: Cells, material: Material, plane: str) -> csc_array:
    """Stiffness (2N, 2N) of a mesh of quadratic elements, or of linear ones, N/mm per mm of width.

    Parameters
    ----------
    nodes : (N, 2) array
        mm; degree of freedom 2*node + component.
    cells : ((kind, (E, k) array), ...)
        "quad9" or "triangle6" in meshio's node order;
        blocks of both kinds may share nodes.
    plane : {"strain", "stress"}
    """
    first, *others = (
        _block_stiffness(nodes, kind, connectivity, material, plane) for kind, connectivity in cells
    )
    total = sum(others, start=first)
    total.eliminate_zeros()
    return total


def _block_stiffness(
    nodes: Floats, kind: str, connectivity: Numbers, material: Material, plane: str
) -> csc_array:
    basis = block_basis(nodes, kind, connectivity, INTEGRATION_DEGREE[kind])
    shapes, _, elements, points = basis.slopes.shape
    each = basis.slopes.transpose(2, 0, 1, 3).reshape(elements, 2 * shapes, points)
    # [e, a, i, b, j]: integral of dN_a/dx_i dN_b/dx_j over element e
    products = ((each * basis.dx[:, None]) @ each.transpose(0, 2, 1)).reshape(
        elements, shapes, 2, shapes, 2
    )
    lame_lambda, lame_mu = lame_parameters(material, plane)
    blocks = lame_lambda * products + lame_mu * products.transpose(0, 1, 4, 3, 2)
    same = lame_mu * np.trace(products, axis1=2, axis2=4)
    for component in range(2):
        blocks[:, :, component, :, component] += same
    degrees = degrees_of(connectivity.ravel()).reshape(elements, 2 * shapes)
    rows = np.repeat(degrees, 2 * shapes, axis=1).ravel()
    columns = np.tile(degrees, 2 * shapes).ravel()
    return assembled(blocks.ravel(), rows, columns, (2 * len(nodes), 2 * len(nodes)))


def assembled(values: Floats, rows: Numbers, columns: Numbers, shape: tuple[int, int]) -> csc_array:
    """Sparse matrix of entries (n,) with the 32-bit indices of SuperLU; duplicates are summed."""
    places = (rows.astype(np.int32), columns.astype(np.int32))
    return coo_array((values, places), shape=shape).tocsc()


def centrifugal_load(nodes: Floats, cells: Cells) -> Floats:
    """Consistent nodal loads of a force per area equal to the coordinates.

    Integral of N_q x, (2N,), mm³; times density and the square of the speed, the centrifugal force
    per mm of width.
    """
    loads = np.zeros_like(nodes)
    for kind, connectivity in cells:
        basis = block_basis(nodes, kind, connectivity, LOAD_DEGREE)
        force = basis.dx * basis.places  # (2, E, points)
        for value, node in zip(basis.values, connectivity.T, strict=True):
            np.add.at(loads, node, (force * value).sum(axis=2).T)
    return loads.ravel()


@dataclass(frozen=True, eq=False)
class BlockBasis:
    """Shape functions of a block of elements at its quadrature points.

    Attributes
    ----------
    values : (k, g) array
        Shape k, which belongs to node k of each element, at point g.
    slopes : (k, 2, E, g) array
        Its gradient in element e, 1/mm.
    places : (2, E, g) array
        The points, mm.
    dx : (E, g) array
        Weights of the points, mm².
    """

    values: Floats
    slopes: Floats
    places: Floats
    dx: Floats


def block_basis(nodes: Floats, kind: str, connectivity: Numbers, degree: int) -> BlockBasis:
    """Isoparametric elements with a quadrature that is exact to a degree; kinds of `stiffness`."""
    values, slopes, weights = _reference(kind, degree)
    shape = (2, len(connectivity), len(weights))
    places, jacobian = np.zeros(shape), np.zeros((2, *shape))  # dx_i/dX_j: [j, i]
    for value, slope, node in zip(values, slopes, connectivity.T, strict=True):
        place = nodes[node].T[:, :, None]
        places += place * value
        jacobian += place * slope[:, None, None]
    (xx, yx), (xy, yy) = jacobian
    area = xx * yy - xy * yx
    inverse = np.array([[yy, -xy], [-yx, xx]]) / area
    gradients = slopes[:, 0, None, None] * inverse[0] + slopes[:, 1, None, None] * inverse[1]
    return BlockBasis(values, gradients, places, np.abs(area) * weights)


@cache
def _reference(kind: str, degree: int) -> tuple[Floats, Floats, Floats]:
    """scikit-fem's shape functions (k, g) at its quadrature points, slopes (k, 2, g), weights (g,).

    On its element of reference.
    """
    import skfem
    from skfem.quadrature import get_quadrature

    element = {
        "quad9": skfem.ElementQuad2,
        "triangle6": skfem.ElementTriP2,
    }[kind]()
    points, weights = get_quadrature(element.refdom, degree)
    each = [element.lbasis(points, k) for k in range(len(element.doflocs))]
    values, slopes = (np.stack(part) for part in zip(*each, strict=True))
    return values, slopes, weights


def degrees_of(nodes: Numbers) -> Numbers:
    """Degrees of freedom of nodes, x and y alternating."""
    return (2 * np.asarray(nodes)[:, None] + np.arange(2)).ravel()


def factored(matrix: csc_array, account: Account | None = None) -> Callable[[Floats], Floats]:
    """Factorise a symmetric positive definite matrix (n, n); the account counts the work.

    Returns a function from right-hand sides (n, k) to solutions (n, k).
    """
    if account is None:
        account = Account()
    return _in_blocks(_factor(matrix, "MMD_AT_PLUS_A", account), account)


def condensed(
    matrix: csc_array, inner: Numbers, kept: Numbers, account: Account | None = None
) -> tuple[Callable[[Floats], Floats], Floats]:
    """Factorise the inner part of a symmetric positive definite matrix and condense it to the rest.

    The Schur complement of many kept unknowns is the last block of a second factorisation, which is
    cheaper than a solution for each (588 of 21044 unknowns: a sixth of the time). Unknowns that are
    neither inner nor kept are fixed.

    Returns
    -------
    solve : callable
        Right-hand sides of the inner unknowns (i, k) -> solutions, with the kept ones at 0.
    complement : (m, m) array
        Schur complement of the kept unknowns.
    """
    if account is None:
        account = Account()
    factor = _factor(matrix[inner][:, inner].tocsc(), "MMD_AT_PLUS_A", account)
    solve = _in_blocks(factor, account)
    if kept.size > MANY_KEPT:
        complement = _last_block(matrix, inner[np.argsort(factor.perm_c)], kept, account)
        if complement is not None:
            return solve, complement
    coupling = matrix[inner][:, kept].toarray()
    account.count(cut_columns=kept.size)
    return solve, matrix[kept][:, kept].toarray() - coupling.T @ solve(coupling)


def _factor(matrix: csc_array, order: str, account: Account) -> SuperLU:
    factor = splu(matrix, permc_spec=order, diag_pivot_thresh=0.0, options={"SymmetricMode": True})
    account.count(fe_factorisations=1)
    account.workspace_bytes += matrix.data.itemsize * factor.nnz  # the values of L and U
    return factor


def _in_blocks(factor: SuperLU, account: Account) -> Callable[[Floats], Floats]:
    def solve(right: Floats) -> Floats:
        account.count(fe_solutions=right.shape[1])
        solved = np.empty_like(right)
        for first in range(0, right.shape[1], BLOCK):
            block = slice(first, first + BLOCK)
            solved[:, block] = factor.solve(right[:, block])
        return solved

    return solve


def _last_block(
    matrix: csc_array, inner: Numbers, kept: Numbers, account: Account
) -> Floats | None:
    """L22 U22 of the factors with the kept unknowns last; None if pivoting changes the order."""
    order = np.concatenate([inner, kept])
    factor = _factor(matrix[order][:, order].tocsc(), "NATURAL", account)
    place = factor.perm_c
    first = inner.size
    if (place[first:] < first).any() or (factor.perm_r != place).any():
        return None
    block = factor.L[first:, first:].toarray() @ factor.U[first:, first:].toarray()
    own = place[first:] - first
    return np.asarray(block[np.ix_(own, own)])
