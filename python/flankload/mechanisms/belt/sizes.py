"""Sizes of the arrays of a timing belt, and the predicted duration of its run."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from math import log
from typing import TYPE_CHECKING

import numpy as np

from flankload.mechanisms.belt.belt import Strip
from flankload.mechanisms.belt.belt_mesh import STRAND, mesh_strip
from flankload.mechanisms.belt.drive import BeltAssembly, flank_elements, predicted_work
from flankload.mechanisms.belt.work import Asked, PieceWork, pieces_of
from flankload.mechanisms.duration import ASSEMBLY_S, Duration, elements_seconds, work_in_words

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from flankload.scene import Scene

    Floats = NDArray[np.float64]

BYTES = 8
#: CPU seconds of a contact problem of a belt.
BELT_STATE_S = 1e-3


@dataclass(frozen=True)
class BeltSizes:
    """Array sizes of a belt at its largest position.

    Attributes
    ----------
    teeth, elements : int
        Number of teeth in the wrap, and of elements on a flank.
    pieces : list of PieceWork
    unknowns : list of int
        Unknowns of the pieces.
    """

    teeth: int
    elements: int
    pieces: Sequence[PieceWork]
    unknowns: Sequence[int]

    @classmethod
    def of(cls, strip: Strip, elements: int, position_rad: Floats) -> BeltSizes:
        """Sizes for a number of elements on a flank, with strands that begin in mid-land.

        Parameters
        ----------
        strip : Strip
        elements : int
        position_rad : (P,) array

        Returns
        -------
        BeltSizes
        """
        pieces = pieces_of(strip, elements, position_rad)
        last = 2 * (strip.wrapped_teeth - 1)
        places = {(0, 0): (0, 2), (1, 0): (-STRAND, 0), (0, 1): (last, last + STRAND)}
        nodes = {
            ends: len(mesh_strip(strip, elements, places=places[ends]).nodes)
            for ends in {(piece.held, piece.pulled) for piece in pieces}
        }
        unknowns = [2 * nodes[p.held, p.pulled] - p.kept - p.hats - p.held for p in pieces]
        return cls(strip.wrapped_teeth, elements, pieces, unknowns)

    @property
    def pairs(self) -> int:
        """Number of contact pairs of the whole wrap."""
        return self.teeth * (self.elements + 1)

    @cached_property
    def hats(self) -> int:
        """Number of shape functions on the lands of the whole wrap."""
        inner = max((p.hats for p in self.pieces if not p.held and not p.pulled), default=0)
        tight = max(p.hats for p in self.pieces if p.held)
        return (self.teeth - 1) * inner + tight + min(p.hats for p in self.pieces if p.pulled)

    @property
    def factors(self) -> float:
        """Entries of the factors of all pieces, up to a constant factor."""
        return sum(n * log(n) for n in self.unknowns)

    def bytes(self, asked: Asked) -> int:
        """Bytes of the response at a position."""
        n, h = self.pairs, self.hats
        numbers = n * n + h * n + 2 * n + 3 * h
        numbers += (asked.sliding + asked.lifting) * (n * h + h * h + h)
        lines = 2 * self.teeth * (2 * self.elements + 1)
        return BYTES * (numbers + lines) + self.flank_bytes

    @property
    def flank_bytes(self) -> int:
        """Bytes of the places, normals, levers, gaps and lengths of the pairs."""
        return BYTES * 8 * self.pairs

    def state_bytes(self, asked: Asked) -> int:
        """Bytes of a state, with contact at most of the pairs."""
        return BYTES * (3 * (self.pairs + asked.lifting * self.hats) + 4 * self.teeth)


def duration_of(scene: Scene, assembly: BeltAssembly) -> Duration:
    """Predict the duration of a run of a belt.

    Parameters
    ----------
    scene : Scene
    assembly : BeltAssembly

    Returns
    -------
    Duration
    """
    strip, position_rad = assembly.strip, assembly.position_rad
    counted = predicted_work(scene, strip, position_rad)
    sizes = BeltSizes.of(strip, flank_elements(scene, strip), position_rad)
    mean = sum(sizes.unknowns) // len(sizes.unknowns)
    elements_s = sum(
        len(sizes.unknowns) * ASSEMBLY_S
        + elements_seconds(counters, mean, sum(sizes.unknowns) // 8)
        for name, counters in counted.items()
        if "fe_factorisations" in counters
    )
    states = sum(counters.get("states", 0) for counters in counted.values())
    work = f"{work_in_words(scene, position_rad.size)}, {strip.wrapped_teeth} teeth"
    return Duration(elements_s, BELT_STATE_S * states, work)
