"""Search for the cheapest combination of parameters that meets a tolerance."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from flankload.studies.accuracy.knobs import ADAPTIVE, ADAPTIVE_START

if TYPE_CHECKING:
    from flankload.scene.named_discretization import NamedDiscretization
    from flankload.studies.accuracy.knobs import Knobs
    from flankload.studies.accuracy.runs import Run
    from flankload.studies.accuracy.truth import Truth

#: Part of a tolerance allowed for each parameter in the first guess.
FIRST_PART = 0.5
#: Largest number of guesses, and the factor of the allowed error from one to the next.
GUESSES, FINER = 3, 0.4
#: Parameters that are tried a step coarser, the most expensive first; more modes need finer
#: elements, so both are also changed together.
STEPS = (
    ("flank_element_mm",),
    ("flank_element_mm", "modes"),
    ("modes",),
    ("count",),
    ("strips_per_half_width",),
    ("zone_half_widths",),
)


def search(
    tolerance: float,
    knobs: Knobs,
    truth: Truth,
    measures: Sequence[str],
    run: Callable[[NamedDiscretization], Run],
) -> None:
    """Run combinations near the cheapest that meets a tolerance.

    Parameters
    ----------
    tolerance : float
    knobs : Knobs
    truth : Truth
    measures : sequence of str
        Errors to be limited.
    run : callable
    """

    if truth.doubt(measures) > tolerance:  # no run could be certified to meet it
        return

    def meets(setting: NamedDiscretization) -> bool:
        error = truth.within(run(setting), measures)
        return error is not None and error <= tolerance

    guesses = (
        guess(tolerance * FIRST_PART * FINER**n, knobs, truth, measures) for n in range(GUESSES)
    )
    setting = next((found for found in guesses if found is not None and meets(found)), None)
    tried = {setting}
    while setting is not None:
        others = (coarser(setting, names, knobs) for names in STEPS)
        fresh = [other for other in others if other is not None and other not in tried]
        tried.update(fresh)
        setting = next((other for other in fresh if meets(other)), None)


def coarser(
    setting: NamedDiscretization, names: tuple[str, ...], knobs: Knobs
) -> NamedDiscretization | None:
    """The setting with some parameters a step coarser; None if one has no coarser step."""
    if names == ("count",) and setting.adaptive is not None:
        looser = [tolerance for tolerance in ADAPTIVE if tolerance > setting.adaptive]
        return replace(setting, count=ADAPTIVE_START, adaptive=min(looser)) if looser else None
    return knobs.coarser(setting, *names)


def guess(
    part: float, knobs: Knobs, truth: Truth, measures: Sequence[str]
) -> NamedDiscretization | None:
    """Each parameter at its cheapest sufficient step; None if one has no sufficient step.

    Parameters
    ----------
    part : float
        Allowed error of each parameter.
    knobs, truth, measures
        As in `search`.

    Returns
    -------
    NamedDiscretization or None
    """
    setting = knobs.finest
    for knob in knobs.ladders:
        enough = [
            run
            for run in truth.steps(knob)
            if (error := truth.largest(run, measures, knob)) is not None and error <= part
        ]
        if not enough:
            return None
        cheapest = min(enough, key=lambda run: run.cpu_s).setting
        setting = replace(setting, **{knob: getattr(cheapest, knob)})
        if knob == "count":
            setting = replace(setting, adaptive=cheapest.adaptive)
    return setting
