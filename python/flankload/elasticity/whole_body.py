"""Response of a whole meshed body at all its flanks: one factorisation, no symmetry assumed."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

import numpy as np

from flankload.cost import Account
from flankload.elasticity.finite_elements import degrees_of, factored
from flankload.elasticity.near_field import mode_loads
from flankload.elasticity.nodal_loads import hat_loads

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from numpy.typing import NDArray
    from scipy.sparse import csc_array

    from flankload.bodies.body import MeshedFlank, SectorMesh, WholeMesh
    from flankload.bodies.tip_modes import Tip


def unit_loads(
    mesh: SectorMesh | MeshedFlank,
    mode_range_mm: tuple[float, float],
    n_modes: int,
    *,
    friction: bool,
    closed: bool = False,
    nodes: NDArray[np.float64] | None = None,
    tip: Tip | None = None,
) -> NDArray[np.float64]:
    """Loads of the modes along the normal; with friction followed by those along the tangent.

    Parameters
    ----------
    mesh : SectorMesh or MeshedFlank
    mode_range_mm : (float, float)
    n_modes : int
    friction : bool
    closed : bool
        The modes' range is a turn around the body.
    nodes : (n_modes,) array, optional
        Arc lengths, mm: unit forces at nodes in place of modes.
    tip : Tip, optional
        Behind the range; the last modes are its own.

    Returns
    -------
    (2 N, n_modes) or (2 N, 2 n_modes) array
    """

    def loads(along: Literal["normal", "tangent"]) -> NDArray[np.float64]:
        if nodes is not None:
            return hat_loads(mesh, nodes, along=along)
        return mode_loads(mesh, mode_range_mm, n_modes, along=along, closed=closed, tip=tip)

    return np.hstack([loads("normal"), loads("tangent")]) if friction else loads("normal")


def count_loads(account: Account, columns: int, *, friction: bool) -> None:
    """Count load cases of a flank by direction, as `unit_loads` orders them.

    Parameters
    ----------
    account : Account
    columns : int
        Normal ones, with friction followed by as many tangential ones.
    friction : bool
    """
    tangential = columns // 2 if friction else 0
    account.count(unit_loads_normal=columns - tangential, unit_loads_tangential=tangential)


def whole_response(
    matrix: csc_array,
    mesh: WholeMesh,
    mode_range_mm: tuple[float, float],
    n_modes: int,
    tell: Callable[[str], None],
    *,
    friction: bool = False,
    readings: Callable[[int], Sequence[NDArray[np.float64] | None]] | None = None,
    forces: NDArray[np.float64] | None = None,
    closed: bool = False,
    account: Account | None = None,
    nodes: NDArray[np.float64] | None = None,
    look: Callable[[NDArray[np.float64]], None] | None = None,
    carried: Callable[[NDArray[np.float64]], NDArray[np.float64]] = np.asarray,
) -> tuple[NDArray[np.float64], NDArray[np.float64], int]:
    """Response of every flank to the pressure modes on every flank.

    Parameters
    ----------
    matrix : csc_array, (2N, 2N)
        Stiffness of the body.
    mesh : WholeMesh
        With f flanks.
    mode_range_mm : (float, float)
    n_modes : int
    tell : callable
        Told the name of each step when it is done.
    friction : bool
        Modes of load along the flanks follow those along the normals.
    readings : callable, optional
        Number of a flank to kinds of columns (2N, q) that only read the displacements.
    forces : (2N, k) array, optional
        Known loads.
    closed : bool
        The modes' range is a turn around the body.
    account : Account, optional
        Where load cases and solutions are counted.
    nodes : (n_modes,) array, optional
        Arc lengths on each flank, mm: unit forces at nodes in place of modes.
    look : callable, optional
        Shown the displacements (2N, p) under the loads of each flank, one after the other.
    carried : callable
        Loads (2N, p) to loads of those nodes that are unknown.

    Returns
    -------
    response : (f * f, p + q, p) array, p twice n_modes with friction
        response[i * f + j] is that of flank i to the modes on flank j, that of its readings below.
    moved : (f, k, p) array
        What the modes on each flank read under each known load.
    degrees_of_freedom : int
        Those that are not held.
    """
    free = np.setdiff1d(np.arange(matrix.shape[0]), degrees_of(mesh.fixed_nodes))
    if account is None:
        account = Account()
    solve = factored(matrix[free][:, free].tocsc(), account)
    tell("factorisation")

    def loads_of(flank: MeshedFlank) -> NDArray[np.float64]:
        return carried(
            unit_loads(flank, mode_range_mm, n_modes, friction=friction, closed=closed, nodes=nodes)
        )

    loads = [_nonzero(loads_of(flank)[free]) for flank in mesh.flanks]
    # each kind of reading by itself: what one reads does not depend on the bits of another
    seen = [[load] for load in loads]
    if readings is not None:
        for i, kinds in enumerate(seen):
            kinds += [_nonzero(part[free]) for part in readings(i) if part is not None]
    f, p, r = len(loads), loads[0][1].shape[1], sum(part[1].shape[1] for part in seen[0])
    response = np.empty((f, f, r, p))
    for j, (rows, column) in enumerate(loads):
        right = np.zeros((free.size, p))
        right[rows] = column
        count_loads(account, p, friction=friction)
        moved = solve(right)
        for i, kinds in enumerate(seen):
            response[i, j] = np.concatenate([weight.T @ moved[at] for at, weight in kinds])
        if look is not None:
            shown = np.zeros((matrix.shape[0], p))
            shown[free] = moved
            tell("solution")
            look(shown)
    by_forces = np.zeros((f, 0, p))
    if forces is not None:
        account.count(fe_load_cases_growth=forces.shape[1])
        moved = solve(forces[free])
        by_forces = np.array([moved[rows].T @ column for rows, column in loads])
    tell("solution")
    return response.reshape(f * f, r, p), by_forces, free.size


def _nonzero(columns: NDArray[np.float64]) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Rows that hold something, and what they hold."""
    rows = np.flatnonzero(columns.any(axis=1))
    return rows, columns[rows]
