"""Equations that hold the mean motion of the nodes on a bore, each with few displacements."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Iterator

    from flankload.base.arrays import Floats, Numbers

#: Mean motions of a plane body: two displacements and the rotation.
MEAN_MOTIONS = 3
#: Neighbouring nodes in the equations of a group. One equation over all nodes couples all of them:
#: the stiffness has a full block of their size, and CalculiX takes five times as long.
GROUP = 8


def further_nodes(held: int) -> int:
    """Number of further nodes of a bore with so many nodes."""
    return max(1, held // GROUP) - 1


def mean_motion_equations(
    nodes: Numbers, places: tuple[Floats, Floats], weights: Floats, axis: int, first_sum: int
) -> Iterator[list[tuple[int, int, float]]]:
    """Equations by which the mean motion of nodes (h,) is the rotation of the axis node.

    With the motions R_g u_g of the nodes of group g, the sums s_g are components of the further
    nodes, numbered from `first_sum`:

        R_g u_g + c_g rotation + s_(g-1) - s_g = 0,    s_0 = 0 and s_last = 0

    Parameters
    ----------
    nodes : (h,) array
        Numbers of the nodes.
    places : x, y, each (h,)
        From the axis, mm.
    weights : (h,) array
        Length of the bore that belongs to each node, mm.
    axis : int
        Number of the node whose first component is the rotation.

    Yields
    ------
    Terms (node, component, factor), the dependent displacement first: each equation of a group is
    solved for a displacement that the others do not contain.
    """
    around = np.argsort(np.arctan2(places[1], places[0]))
    groups = np.array_split(around, 1 + further_nodes(around.size))
    for g, group in enumerate(groups):
        rows = _motions(places[0][group], places[1][group], weights[group])
        unknowns = [(int(node), c) for node in nodes[group] for c in (1, 2)] + [(axis, 1)]
        sums = np.zeros((MEAN_MOTIONS, 0))
        for number, sign in ((g - 1, 1.0), (g, -1.0)):
            if 0 <= number < len(groups) - 1:
                sums = np.hstack([sums, sign * np.eye(MEAN_MOTIONS)])
                unknowns += [(first_sum + number, c) for c in (1, 2, 3)]
        rows = np.hstack([rows, sums])
        dx, dy = (place[group[-1]] - place[group[0]] for place in places)
        last = 2 * group.size - (1 if abs(dx) > abs(dy) else 2)
        solved = [0, 1, last]
        reduced = np.linalg.solve(rows[:, solved], rows)
        others = [k for k in range(len(unknowns)) if k not in solved]
        for row, own in zip(reduced, solved, strict=True):
            yield [(*unknowns[k], float(row[k])) for k in (own, *others) if row[k]]


def _motions(x: Floats, y: Floats, weights: Floats) -> Floats:
    """Motions (3, 2 h + 1) by the displacements of nodes and the rotation of the axis."""
    rows = np.zeros((MEAN_MOTIONS, 2 * x.size + 1))
    rows[0, :-1:2] = rows[1, 1:-1:2] = weights
    rows[2, :-1:2], rows[2, 1:-1:2] = -weights * y, weights * x
    rows[:, -1] = weights @ y, -weights @ x, -weights @ (x**2 + y**2)
    return rows
