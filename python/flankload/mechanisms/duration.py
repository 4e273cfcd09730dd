"""Predicted duration of a run: counted work multiplied by measured rates.

Nothing is solved, so the prediction is correct to a factor of two; `flankload plan` solves some
states and is correct to a factor of 1.5. The rates were measured on gears, rings, cams and splines
with 10 to 40 cells on a half-width, and on finite elements with 600 to 16000 unknowns (CPU seconds,
the shortest of several runs on one thread of a core at 3 GHz); on another machine they scale with
its speed.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flankload.scene import Scene

    Counters = Mapping[str, int]

#: CPU seconds per mesh, element, factorisation and solution; a solution for a column of the cuts
#: costs less than another one.
ASSEMBLY_S, ELEMENT_S, FACTOR_S, FACTOR_POWER = 0.011, 6.5e-5, 3.0e-7, 1.3
SOLUTION_S, CUT_PART, SMOOTHING_S = 1.0e-7, 0.3, 8e-7


@dataclass(frozen=True)
class Duration:
    """Predicted duration of a run, correct to a factor of about two.

    Attributes
    ----------
    elements_s, states_s : float
        Predicted seconds of the finite elements, and of the states on all available threads.
    work : str
        Description of the work.
    """

    elements_s: float
    states_s: float
    work: str

    @property
    def seconds(self) -> float:
        """Total duration."""
        return self.elements_s + self.states_s

    def __str__(self) -> str:
        """Duration and work in one line."""
        return f"about {float(f'{self.seconds:.1g}'):g} s: {self.work}"


def work_in_words(scene: Scene, positions: int, least: str = "") -> str:
    """Describe the torques and positions of a run; `least` precedes the number of positions."""
    torques = len(scene.torques_Nm)
    work = f"{least}{positions} position{'s' * (positions != 1)}"
    return f"{torques} torques x {work}" if torques > 1 else work


def elements_seconds(counters: Counters, unknowns: int, elements: int) -> float:
    """CPU seconds of assembly, factorisations and solutions, from the counters of a stage."""
    cuts = counters.get("cut_columns", 0)
    columns = counters["fe_solutions"] - cuts + CUT_PART * cuts
    factors = counters["fe_factorisations"] * FACTOR_S * unknowns**FACTOR_POWER
    return ASSEMBLY_S + ELEMENT_S * elements + factors + SOLUTION_S * unknowns * columns
