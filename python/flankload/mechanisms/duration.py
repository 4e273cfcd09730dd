"""Predicted duration of a run: counted work times measured rates.

Nothing is solved, so the prediction is right to a factor of two; `flankload plan` solves some
states and is right to a factor of 1.5. The rates were measured on gears, rings, cams and splines
with 10 to 40 cells on a half-width, and on elements with 600 to 16000 unknowns (CPU seconds, the
shortest of several runs on one thread of a core at 3 GHz); on another machine they scale with its
speed.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flankload.scene import Scene

    Counters = Mapping[str, int]

#: Of a mesh, an element, a factor, a solution; a column of the cuts takes less than another one.
ASSEMBLY_S, ELEMENT_S, FACTOR_S, FACTOR_POWER = 0.011, 6.5e-5, 3.0e-7, 1.3
SOLUTION_S, CUT_PART, SMOOTHING_S = 1.0e-7, 0.3, 8e-7


@dataclass(frozen=True)
class Duration:
    """How long a run will take, to a factor of two or so.

    Attributes
    ----------
    elements_s, states_s : float
        Finite elements; states, on as many threads as there are.
    work : str
        What there is to do.
    """

    elements_s: float
    states_s: float
    work: str

    @property
    def seconds(self) -> float:
        """All of it."""
        return self.elements_s + self.states_s

    def __str__(self) -> str:
        """One line."""
        return f"about {float(f'{self.seconds:.1g}'):g} s: {self.work}"


def work_in_words(scene: Scene, positions: int, least: str = "") -> str:
    """Torques and positions of a run.

    Parameters
    ----------
    scene : Scene
    positions : int
    least : str
        Before the number of positions.

    Returns
    -------
    str
    """
    torques = len(scene.torques_Nm)
    work = f"{least}{positions} position{'s' * (positions != 1)}"
    return f"{torques} torques x {work}" if torques > 1 else work


def elements_seconds(counters: Counters, unknowns: int, elements: int) -> float:
    """Seconds of assembly, factorisations and solutions.

    Parameters
    ----------
    counters : mapping of str to int
        Of the stage.
    unknowns, elements : int
        Of a mesh.

    Returns
    -------
    float
    """
    cuts = counters.get("cut_columns", 0)
    columns = counters["fe_solutions"] - cuts + CUT_PART * cuts
    factors = counters["fe_factorisations"] * FACTOR_S * unknowns**FACTOR_POWER
    return ASSEMBLY_S + ELEMENT_S * elements + factors + SOLUTION_S * unknowns * columns
