"""Size and time of a solid deck before anything else: from a coarse run and a small deck."""

from __future__ import annotations

import tempfile
from dataclasses import replace
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING

from msgspec import structs

from flankload.base.files import write_atomically
from flankload.errors import OtherProgramError
from flankload.mechanisms import run_once
from flankload.scene.refusal import refuse
from flankload.studies.coarse import coarse
from flankload.studies.verification.calculix import JOB, execute, find_program
from flankload.studies.verification.deck import Deck, probe_of

if TYPE_CHECKING:
    from collections.abc import Callable

    from flankload.result import Result
    from flankload.scene import Scene

    #: Deck of a number of elements on the half-width.
    DeckOf = Callable[[float], Deck]

#: Unknowns that are allowed by default: more take gigabytes and a quarter of an hour.
MOST_UNKNOWNS = 400_000
#: Least number of elements on the half-width of solids.
FEWEST_SOLID = 0.2
#: Parts of the wanted number of elements that are tried for a deck within the limit.
FEWER = (0.7, 0.5, 0.35, 0.25)
#: Iterations of a solid deck: four to sixteen.
ITERATIONS = 10
#: Wedges of the deck that measures CalculiX; it takes half a second.
PROBE = 1000
#: Wall-clock limit of that deck, s.
PROBE_LIMIT_S = 60.0


def coarse_result(scene: Scene) -> Result:
    """Result of a coarse run under the largest torque: its contacts are as wide to a percent."""
    few = coarse(scene)
    accuracy = structs.replace(few.accuracy, estimate=False, tangents=False)
    effects = structs.replace(few.effects, root_stress=False)
    load = structs.replace(few.load, torque_Nm=max(few.torques_Nm))
    (result,) = run_once(replace(few, accuracy=accuracy, effects=effects, load=load))
    return result


def require_size(unknowns: int, most: int, elements: float, deck_of: DeckOf | None = None) -> None:
    """Refuse a deck with too many unknowns; name the number of elements that has fewer.

    Raises SceneError.
    """
    if unknowns <= most:
        return
    fewer = ""
    for part in FEWER if deck_of is not None else ():
        if part * elements < FEWEST_SOLID:
            break
        assert deck_of is not None
        found = deck_of(part * elements).unknowns
        if found <= most:
            fewer = f"{part * elements:g} elements have about {rounded(found)}; "
            break
    expected = f"a deck of at most {most} unknowns ({fewer}most_unknowns or --most-unknowns allows "
    expected += "more)"
    refuse("elements", expected, f"{elements:g} elements with about {rounded(unknowns)} unknowns")


def rounded(unknowns: int) -> str:
    """A number with three digits, in words of three."""
    return f"{float(f'{unknowns:.3g}'):,.0f}".replace(",", " ")


def least_seconds(deck: Deck, program: str) -> float | None:
    """Least time of a deck by that of a small part of it; None if CalculiX does not solve it.

    The time of an iteration grows faster than the number of unknowns.
    """
    probe, unknowns = probe_of(deck, PROBE)
    with tempfile.TemporaryDirectory(prefix="flankload_") as name:
        folder = Path(name)
        write_atomically(folder / f"{JOB}.inp", probe)
        began = perf_counter()
        try:
            execute(find_program(program, folder), folder, time_limit_s=PROBE_LIMIT_S)
        except OtherProgramError:
            return None
        return ITERATIONS * (perf_counter() - began) * deck.unknowns / unknowns
