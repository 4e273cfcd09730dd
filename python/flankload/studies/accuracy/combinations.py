"""Search for the cheapest combination of parameters that meets a tolerance."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from flankload.studies.accuracy.quantities import largest
from flankload.studies.accuracy.refinements import ADAPTIVE, ADAPTIVE_START, Refinements

if TYPE_CHECKING:
    from flankload.scene.named_discretization import NamedDiscretization
    from flankload.studies.accuracy.reference import Reference
    from flankload.studies.accuracy.runs import Run

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
    ("axial_degree",),
    ("load_degree_z",),
    ("slices",),
    ("count",),
    ("strips_per_half_width",),
    ("zone_half_widths",),
)


def search(
    tolerance: float,
    refinements: Refinements,
    reference: Reference,
    measures: Sequence[str],
    run: Callable[[NamedDiscretization], Run],
) -> None:
    """Run combinations near the cheapest that meets a tolerance in some errors."""

    doubt = largest(reference.doubts, measures)
    if doubt is None or doubt > tolerance:  # no run could be certified to meet it
        return

    def meets(discretization: NamedDiscretization) -> bool:
        error = largest(reference.errors(run(discretization)), measures, reference.doubts)
        return error is not None and error <= tolerance

    guesses = (
        guess(tolerance * FIRST_PART * FINER**n, refinements, reference, measures)
        for n in range(GUESSES)
    )
    discretization = next((found for found in guesses if found is not None and meets(found)), None)
    tried = {discretization}
    while discretization is not None:
        others = (coarser(discretization, names, refinements) for names in STEPS)
        fresh = [other for other in others if other is not None and other not in tried]
        tried.update(fresh)
        discretization = next((other for other in fresh if meets(other)), None)


def coarser(
    discretization: NamedDiscretization, names: tuple[str, ...], refinements: Refinements
) -> NamedDiscretization | None:
    """The discretization with some parameters a step coarser; None if one has no coarser step."""
    if names != ("count",) or discretization.adaptive is None:
        return refinements.coarser(discretization, *names)
    looser = min((x for x in ADAPTIVE if x > discretization.adaptive), default=None)
    found = replace(discretization, count=ADAPTIVE_START, adaptive=looser)
    return None if looser is None else found


def guess(
    part: float, refinements: Refinements, reference: Reference, measures: Sequence[str]
) -> NamedDiscretization | None:
    """Each parameter at its cheapest step with a sufficiently small error.

    None if a parameter has no such step.
    """
    discretization = refinements.finest
    for parameter in refinements.ladders:
        enough = [
            run
            for run in reference.steps(parameter)
            if (error := largest(reference.errors(run, parameter), measures)) is not None
            and error <= part
        ]
        if not enough:
            return None
        cheapest = min(enough, key=lambda run: run.cpu_s).discretization
        discretization = replace(discretization, **{parameter: getattr(cheapest, parameter)})
        if parameter == "count":
            discretization = replace(discretization, adaptive=cheapest.adaptive)
    return discretization
