"""Contact patterns of all meshes of a planetary stage, on the unrolled flanks of its planets."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flankload.plot.load_maps import contact_pattern, draw_contact_pattern
from flankload.plot.picture import largest, panels, picture
from flankload.plot.style import SIZE
from flankload.result.stage import MESHES

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from flankload.plot.picture import Results
    from flankload.result import Result

#: Number of the planet in its meshes with the sun and with the ring.
PLANET_IN = {"sun": 2, "ring": 1}
#: Width of a panel and height of a row, inches.
PANEL = (2.3, 2.6)


@picture(largest)
def plot_stage_patterns(results: Results) -> Figure:
    """Figure of the largest pressure on both flanks of all planets: a column per planet."""
    result = largest(results)
    assert result.stage is not None
    n = result.stage.count
    meshes = [[result.stage.mesh(j + 1, kind) for j in range(n)] for kind in MESHES]
    most = max(
        _largest(mesh, kind) for kind, row in zip(MESHES, meshes, strict=True) for mesh in row
    )
    size = max(SIZE[0], PANEL[0] * n), 2 * PANEL[1]
    with panels(result, "Contact patterns on the planets", size) as figure:
        every = figure.subplots(2, n, squeeze=False)
        for kind, row, of_mesh in zip(MESHES, every, meshes, strict=True):
            for j, (axes, mesh) in enumerate(zip(row, of_mesh, strict=True)):
                _draw(axes, mesh, kind, most, key=j == n - 1)
                axes.set_title(f"planet {j + 1}, {kind}: K_Hβ {_factor(mesh):.3f}", fontsize=9)
                if j:
                    axes.set_ylabel("")
    return figure


@picture(largest)
def draw_stage_patterns(
    axes: Axes, results: Results, *, planet: int = 1, mesh: str = MESHES[0]
) -> None:
    """Draw the largest pressure on the flank of a planet in its mesh with the sun or the ring."""
    result = largest(results)
    assert result.stage is not None
    _draw(axes, result.stage.mesh(planet, mesh), mesh, None, key=True)


def _draw(axes: Axes, mesh: Result, kind: str, most: float | None, *, key: bool) -> None:
    """Draw the pattern on the planet of a mesh."""
    draw_contact_pattern(axes, mesh, body=PLANET_IN[kind], largest_MPa=most, key=key)
    axes.set_ylabel("diameter in mm")


def _largest(mesh: Result, kind: str) -> float:
    """Largest pressure of a pattern, MPa."""
    return float(np.max(contact_pattern(mesh, PLANET_IN[kind])[1], initial=0.0))


def _factor(mesh: Result) -> float:
    assert mesh.slices is not None
    return mesh.slices.face_load_factor
