"""Work of a belt, counted in advance: pieces, columns, positions."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flankload.base.rounding import round_down, round_up
from flankload.elasticity.finite_elements import MANY_KEPT
from flankload.mechanisms.belt.belt_mesh import cord_rows, half_land
from flankload.mechanisms.belt.row import strand_ends

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from flankload.mechanisms.belt.belt import Strip
    from flankload.mechanisms.belt.pulley_mesh import PulleyMesh

    Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Asked:
    """Optional land columns.

    Attributes
    ----------
    sliding, lifting : bool
    """

    sliding: bool = False
    lifting: bool = False


def phases(strip: Strip, position_rad: Floats) -> Floats:
    """(P,) Position of the middle of the first land beyond the tangent point, in pitches."""
    at = position_rad / strip.pitch_rad
    return np.asarray(at - round_down(at + 0.5))


def distinct_ends(strip: Strip, elements: int, position_rad: Floats) -> tuple[set[float], ...]:
    """Distinct places at which the tight and the slack strand begin, over all positions.

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


@dataclass(frozen=True)
class PieceWork:
    """A piece of belt that is solved once.

    Attributes
    ----------
    pairs, hats : int
        Number of contact pairs on its flank, and of shape functions on its lands.
    held, pulled : int
        Whether the tight strand fixes it, and whether the slack one pulls it: 0 or 1.
    kept : int
        Unknowns of its cuts.
    """

    pairs: int
    hats: int
    held: int
    pulled: int
    kept: int

    @property
    def cut_solutions(self) -> int:
        """Solutions for the unknowns of its cuts; for many a second factorisation is cheaper."""
        return 0 if self.kept > MANY_KEPT else self.kept

    def columns(self, asked: Asked) -> int:
        """Solutions for its columns."""
        return self.pairs + self.held + self.pulled + self.hats * (1 + asked.sliding)


def pieces_of(strip: Strip, elements: int, position_rad: Floats) -> list[PieceWork]:
    """Pieces that are solved for all positions: the cell, the tight ends, the slack ends.

    Parameters
    ----------
    strip : Strip
    elements : int
        On a flank.
    position_rad : (P,) array

    Returns
    -------
    list of PieceWork
    """
    land = half_land(strip, elements)
    face = 2 * (cord_rows(strip, elements) + 2 * elements)
    half, pairs = land.size - 1, elements + 1
    tight, slack = distinct_ends(strip, elements, position_rad)
    cell = [PieceWork(pairs, 2 * half + 1, 0, 0, 2 * face)] if strip.wrapped_teeth > 1 else []
    return [
        *cell,
        *(PieceWork(pairs, half + 1 + _beyond(land, -end), 1, 0, face) for end in sorted(tight)),
        *(PieceWork(0, half + 1 + _beyond(land, end), 0, 1, face) for end in sorted(slack)),
    ]


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
    pieces = pieces_of(strip, elements, position_rad)
    hats = sum(piece.hats for piece in pieces)
    cuts = sum(piece.cut_solutions for piece in pieces)
    return {
        "fe_factorisations": sum(1 + (piece.kept > MANY_KEPT) for piece in pieces),
        "fe_solutions": cuts + sum(piece.columns(asked) for piece in pieces),
        "cut_columns": cuts,
        "unit_loads_normal": sum(piece.pairs + piece.pulled for piece in pieces)
        + asked.lifting * hats,
        "unit_loads_tangential": asked.sliding * hats,
    }


def work_of_pulley(mesh: PulleyMesh, asked: Asked) -> dict[str, int]:
    """Factorisations, columns and solutions of an elastic pulley.

    Parameters
    ----------
    mesh : PulleyMesh
    asked : Asked

    Returns
    -------
    dict of str to int
        As for `work_of_elements`.
    """
    kept = 2 * (mesh.sector.left_nodes.size + mesh.sector.right_nodes.size)
    many = kept > MANY_KEPT
    normal, along = 2 * mesh.flank.size + mesh.land.size, mesh.land.size * asked.sliding
    return {
        "fe_factorisations": 1 + many,
        "fe_solutions": normal + along + (0 if many else kept),
        "cut_columns": 0 if many else kept,
        "unit_loads_normal": normal,
        "unit_loads_tangential": along,
    }


def _beyond(land: Floats, end: float) -> int:
    """Fixed elements of a land beyond its middle; negative if the fixed part ends before it."""
    size = float(land[1])
    if end < 0:
        # the fixed part extends from the strand to the other edge
        return round_up((land[-1] + end) / size) - (land.size - 1)
    return round_up(end / size)


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
        As for `work_of_elements`.
    """
    pairs = strip.wrapped_teeth * (elements + 1)
    return {"states": states, "contact_passes": states, "influence_columns": states * pairs}
