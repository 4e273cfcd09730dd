"""A small sector mesh without gears, for the tests of elasticity and compliance."""

from __future__ import annotations

import numpy as np

from flankload.bodies.body import Material, SectorMesh

STEEL = Material(206000.0, 0.3)


def ring_sector(
    teeth: int, *, rows: int = 4, columns: int = 8, lobe: float = 0.08, turn: float = 0.0
) -> tuple[SectorMesh, tuple[float, float]]:
    """A sector of a ring of radii 10 and 30 with a lobe on its rim; the rim's middle is the flank.

    Returns
    -------
    mesh : SectorMesh
    mode_range : (float, float)
    """
    angles = np.linspace(-np.pi / teeth, np.pi / teeth, 2 * columns + 1)
    depth = np.linspace(0.0, 1.0, 2 * rows + 1)
    swell = 1 + lobe * depth[None] * np.cos(angles[:, None] * teeth / 2) ** 2
    radius = (10 + 20 * depth[None]) * swell
    at = angles[:, None] + turn
    nodes = np.stack([radius * np.cos(at), radius * np.sin(at)], axis=-1).reshape(-1, 2)

    def number(column: int, row: int) -> int:
        return column * (2 * rows + 1) + row

    cells = []
    for j in range(0, 2 * columns, 2):
        for i in range(0, 2 * rows, 2):
            grid = [(0, 0), (0, 2), (2, 2), (2, 0), (0, 1), (1, 2), (2, 1), (1, 0), (1, 1)]
            cells.append([number(j + dj, i + di) for dj, di in grid])
    rim = [number(j, 2 * rows) for j in range(2 * columns + 1)]
    # material on the right of the path: along decreasing polar angle
    flank = [(rim[j + 2], rim[j], rim[j + 1]) for j in range(2 * columns - 4, 0, -2)]
    order = [node for first, _, middle in flank for node in (first, middle)] + [flank[-1][1]]
    arc_length = np.full(len(nodes), np.nan)
    steps = np.linalg.norm(np.diff(nodes[order], axis=0), axis=1)
    arc_length[order] = np.concatenate([[0.0], np.cumsum(steps)])
    mesh = SectorMesh(
        nodes=nodes,
        cells=(("quad9", np.array(cells)),),
        flank_edges=np.array(flank),
        flank_arc_length=arc_length,
        fixed_nodes=np.array([number(j, 0) for j in range(2 * columns + 1)]),
        left_nodes=np.array([number(0, i) for i in range(1, 2 * rows + 1)]),
        right_nodes=np.array([number(2 * columns, i) for i in range(1, 2 * rows + 1)]),
        teeth=teeth,
    )
    return mesh, (0.0, float(arc_length[order[-1]]))
