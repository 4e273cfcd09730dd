"""Runs of scenes of one drive that differ by known displacements of its bodies only."""

from __future__ import annotations

from typing import TYPE_CHECKING

from flankload.mechanisms.premises import require_premises
from flankload.mechanisms.registry import mechanism_of
from flankload.mechanisms.runner import finished
from flankload.mechanisms.stage_clock import StageClock

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flankload.mechanisms.reuse import Parts
    from flankload.result import Result
    from flankload.scene import Scene


def are_displaced(one: Scene, other: Scene) -> bool:
    """Whether `run_displaced` solves two scenes together."""
    displaced = mechanism_of(one).displaced
    return displaced is not None and displaced.alike(one, other)


def run_displaced(scenes: Sequence[Scene], parts: Parts) -> tuple[tuple[Result, ...], ...]:
    """Results of scenes of which any two are `are_displaced`, one tuple per scene.

    Each state starts from that of another scene, so that results differ from those of `run_once` by
    the convergence of its iteration. The cost is that of the last stages, of all scenes together.

    Raises
    ------
    SceneError, FlankloadError
        As `run_once`, for the first scene without a result.
    """
    mechanism, first = mechanism_of(scenes[0]), scenes[0]
    clock = StageClock(None, mechanism.body_names, mechanism.sweeps(first), {})
    with clock.stage("bodies") as account:
        built = mechanism.build(first, None, parts, account=account)
        by_geometry = require_premises(first, mechanism.broken_by_geometry(built))
    assembly, compliances = mechanism.compliances(first, built, clock, {}, parts)
    assert mechanism.displaced is not None
    runs = mechanism.displaced.states(scenes, assembly, compliances, clock)
    found = []
    for scene, (own, states) in zip(scenes, runs, strict=True):
        numbers = range(len(states.found))
        broken = [
            require_premises(scene, mechanism.broken_by_load(scene, own, states, n))
            for n in numbers
        ]
        results = mechanism.results(scene, own, compliances, states, [None] * len(numbers))
        found.append(
            tuple(
                finished(result, (*by_geometry, *beyond), clock.stages, {}, ())
                for result, beyond in zip(results, broken, strict=True)
            )
        )
    return tuple(found)
