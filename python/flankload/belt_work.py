"""Work of a belt that can be counted before it is done: pieces, columns, positions."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flankload.belt_row import strand_ends
from flankload.bodies.belt_mesh import cord_rows, half_land
from flankload.elasticity import MANY_KEPT

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from flankload.bodies.belt import Strip
    from flankload.bodies.pulley_mesh import PulleyMesh

    Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Asked:
    """What else lands are asked for.

    Attributes
    ----------
    rubbing, lifting : bool
    """

    rubbing: bool = False
    lifting: bool = False


def phases(strip: Strip, position_rad: Floats) -> Floats:
    """(P,) Where the middle of the first land stands beyond the tangent point, in pitches."""
    at = position_rad / strip.pitch_rad
    return np.asarray(at - np.floor(at + 0.5))


def distinct_ends(strip: Strip, elements: int, position_rad: Floats) -> tuple[set[float], ...]:
    """Places where the tight strand begins, and the slack one, on all positions.

    Parameters
    ----------
    strip : Strip
    elements : int
        On a flank.
    position_rad : (P,) array

    Returns
    -------
    tight, slack : set of float
        From the middles of the first and the last land, rad.
    """
    on = strip.pitch_rad * phases(strip, position_rad)
    both = [strand_ends(strip, elements, float(angle)) for angle in on]
    return {tight for tight, _ in both}, {slack for _, slack in both}


def work_of_elements(
    strip: Strip, elements: int, position_rad: Floats, asked: Asked
) -> dict[str, int]:
    """Factorisations, columns and solutions of all pieces of a belt.

    Parameters
    ----------
    strip : Strip
    elements : int
        On a flank.
    position_rad : (P,) array
    asked : Asked

    Returns
    -------
    dict of str to int
        By the names of `flankload.cost.COUNTERS`.
    """
    land = half_land(strip, elements)
    face = 2 * (cord_rows(strip, elements) + 2 * elements)
    half = land.size - 1
    tight, slack = distinct_ends(strip, elements, position_rad)
    # flanks, hats on lands, what strands do, unknowns of the cuts
    pieces = [(1, 2 * half + 1, 0, 2 * face)] if strip.wrapped_teeth > 1 else []
    pieces += [(1, half + 1 + _beyond(land, -end), 1, face) for end in tight]
    pieces += [(0, half + 1 + _beyond(land, end), -1, face) for end in slack]
    counted = dict.fromkeys(
        (
            "fe_factorisations",
            "fe_solutions",
            "cut_columns",
            "unit_loads_normal",
            "unit_loads_tangential",
        ),
        0,
    )
    for flanks, hats, strand, kept in pieces:
        pairs, many = flanks * (elements + 1), kept > MANY_KEPT
        counted["fe_factorisations"] += 1 + many
        counted["cut_columns"] += 0 if many else kept
        counted["unit_loads_normal"] += pairs + (strand < 0) + asked.lifting * hats
        counted["unit_loads_tangential"] += asked.rubbing * hats
        counted["fe_solutions"] += (
            pairs + abs(strand) + hats * (1 + asked.rubbing) + (0 if many else kept)
        )
    return counted


def work_of_pulley(mesh: PulleyMesh, asked: Asked) -> dict[str, int]:
    """Factorisations, columns and solutions of a pulley that yields.

    Parameters
    ----------
    mesh : PulleyMesh
    asked : Asked

    Returns
    -------
    dict of str to int
        As of `work_of_elements`.
    """
    kept = 2 * (mesh.sector.left_nodes.size + mesh.sector.right_nodes.size)
    many = kept > MANY_KEPT
    normal, along = 2 * mesh.flank.size + mesh.land.size, mesh.land.size * asked.rubbing
    return {
        "fe_factorisations": 1 + many,
        "fe_solutions": normal + along + (0 if many else kept),
        "cut_columns": 0 if many else kept,
        "unit_loads_normal": normal,
        "unit_loads_tangential": along,
    }


def _beyond(land: Floats, end: float) -> int:
    """Elements of a land that are held beyond its middle; fewer than none: short of it."""
    size = float(land[1])
    if end < 0:
        # what is held reaches from the end to the other edge
        return int(np.ceil((land[-1] + end) / size - 1e-9)) - (land.size - 1)
    return int(np.ceil(end / size - 1e-9))


def work_of_states(strip: Strip, elements: int, states: int) -> dict[str, int]:
    """Contact problems of a belt.

    Parameters
    ----------
    strip : Strip
    elements : int
        On a flank.
    states : int

    Returns
    -------
    dict of str to int
        As of `work_of_elements`.
    """
    pairs = strip.wrapped_teeth * (elements + 1)
    return {"states": states, "contact_passes": states, "influence_columns": states * pairs}
