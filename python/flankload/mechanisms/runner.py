"""One run of a scene of any kind of drive, stage by stage, with measured times."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

from flankload.cost import beside_plan, held_bytes, totals
from flankload.mechanisms.premises import require_premises, with_violations
from flankload.mechanisms.registry import mechanism_of
from flankload.mechanisms.stage_clock import Kept, Progress, StageClock

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from flankload.cost import Account
    from flankload.mechanisms.premises import Broken
    from flankload.mechanisms.protocol import Counted, States
    from flankload.mechanisms.reuse import Parts
    from flankload.result import Result
    from flankload.scene import Scene
    from flankload.scene.discretization import Discretization


@dataclass(frozen=True)
class Earlier:
    """Results of earlier runs that a run may use.

    Attributes
    ----------
    stages : mapping of str to Account
        Stages that count as stages of the run.
    notes : sequence of str
        Further warnings of the results.
    parts : Parts or None
        Bodies and compliances of other scenes; those of the run are added.
    similar : States or None
        States of a scene that differs by a small step: the run has its positions, and continues
        its states where that is possible.
    unloaded : bool
        Whether the state without torque is solved, from which the deflection is measured.
    """

    stages: Mapping[str, Account] = field(default_factory=dict)
    notes: Sequence[str] = ()
    parts: Parts | None = None
    similar: States | None = None
    unloaded: bool = True


def prepare(scene: Scene, parts: Parts) -> None:
    """Build the bodies of a scene and solve their elements, for runs of similar scenes.

    Bodies and compliances are added to `parts`. Raises SceneError if the scene is impossible.
    """
    mechanism = mechanism_of(scene)
    clock = StageClock(None, mechanism.body_names, mechanism.sweeps(scene), {})
    built = mechanism.build(scene, None, parts, account=clock.account("bodies"))
    if mechanism.no_flanks_reason is None:  # the other drives reuse nothing
        mechanism.compliances(scene, built, clock, {}, parts)


def run_once(
    scene: Scene,
    kept: Kept | None = None,
    progress: Progress | None = None,
    *,
    plan: Counted | None = None,
    discretization: Discretization | None = None,
    on_states: Callable[[States], None] | None = None,
    earlier: Earlier | None = None,
) -> tuple[Result, ...]:
    """One result per torque of a scene, at the discretization that it names or at the default one.

    Parameters
    ----------
    kept : mapping of "body_1", … to compliance and Account, optional
        Compliances from another scene of the same bodies and discretization; their cost counts as
        if it were spent here. Missing ones are computed and added.
    progress : callable, optional
        Called as progress(stage, done, total); done increases up to total.
    plan : mapping, optional
        Predictions by stage, which the result shows beside the actual cost.
    discretization : Discretization, optional
        Replaces the discretization of the scene.
    on_states : callable, optional
        Called with the states of the run, which `Earlier.similar` takes.

    Raises
    ------
    SceneError
        If the scene is impossible; `PremiseError` if it violates a premise of the model.
    FlankloadError
        If a position has no solution, or the plan belongs to another scene.
    """
    mechanism, earlier = mechanism_of(scene), earlier or Earlier()
    clock = StageClock(progress, mechanism.body_names, mechanism.sweeps(scene), earlier.stages)
    with clock.stage("bodies") as account:
        built = mechanism.build(scene, discretization, earlier.parts, account=account)
        by_geometry = require_premises(scene, mechanism.broken_by_geometry(built))
        account.bytes += held_bytes(built)
    predicted = beside_plan(mechanism.work(scene, built), plan)
    kept = {} if kept is None else kept
    assembly, compliances = mechanism.compliances(scene, built, clock, kept, earlier.parts)
    if assembly.position_rad.size != built.position_rad.size:
        # teeth of different compliance need more positions, which a plan cannot predict
        predicted = beside_plan(mechanism.work(scene, assembly))
    assembly, states = mechanism.states(
        scene, assembly, compliances, clock, earlier.similar, unloaded=earlier.unloaded
    )
    if on_states is not None:
        on_states(states)
    numbers = range(len(states.found))
    by_load = [
        require_premises(scene, mechanism.broken_by_load(scene, assembly, states, n))
        for n in numbers
    ]
    estimates: Sequence[Mapping[str, object] | None] = [None] * len(numbers)
    if scene.accuracy.estimate:
        estimates = mechanism.estimates(scene, assembly, compliances, states, clock)
    with clock.stage("result") as account:
        results = mechanism.results(scene, assembly, compliances, states, estimates)
        account.bytes += held_bytes(results)
    found = tuple(
        finished(result, (*by_geometry, *broken), clock.stages, predicted, earlier.notes)
        for result, broken in zip(results, by_load, strict=True)
    )
    clock.finish()
    return found


def finished(
    result: Result,
    broken: Sequence[Broken],
    stages: Mapping[str, Account],
    predicted: Mapping[str, Mapping[str, Any]],
    notes: Sequence[str],
) -> Result:
    """A result with the warnings and the cost of its run."""
    cost = {
        **totals(stages),
        **result.cost,
        "bytes": sum(account.bytes for account in stages.values()),
        "stages": {
            name: account.as_dict() | {"predicted": dict(predicted.get(name, {}))}
            for name, account in stages.items()
        },
    }
    result = replace(result, warnings=(*notes, *result.warnings), cost=cost)
    return with_violations(result, broken)
