"""Plan of a scene: sizes of its effects and cost of its run, by coarse runs."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import replace
from time import process_time
from typing import TYPE_CHECKING

from flankload.cost import totals
from flankload.errors import FlankloadError
from flankload.scene import scene_of
from flankload.scene.effects import switches_of
from flankload.studies.plan.choice import (
    asks_for_choice,
    chosen_scene,
    wanted_sizes,
    without_choice,
)
from flankload.studies.plan.coarse_runs import CoarseRuns
from flankload.studies.plan.planned import ADAPTIVE_WITHIN, WITHIN, Plan, PlannedEffect
from flankload.studies.plan.text import is_significant, remark_on
from flankload.studies.tolerance import first_discretization, first_scene

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flankload.cost import Account
    from flankload.scene import Scene, SceneLike
    from flankload.studies.plan.coarse_runs import Measured
    from flankload.studies.plan.planned import Chosen


def plan(scene: SceneLike, *, levels: bool = False, dimension: bool = False) -> Plan:
    """Plan a run of a scene: its effects, their cost and their size.

    Sizes are differences of coarse runs: the scene on a coarse discretization, once with its
    effects and once with each of them switched. The cost of the run is that of the coarse run,
    stage by stage, times the ratio of their exact counters.

    Parameters
    ----------
    scene : Scene, path or mapping
        As for `solve`.
    levels : bool
        Whether to include size and cost of contact models that are off. Without them the plan takes
        at most about half the time of most runs.
    dimension : bool
        Whether to include size and cost of three dimensions for a plane scene, whose run may take
        less time than that.

    Returns
    -------
    Plan

    Raises
    ------
    SceneError
        If the scene is impossible; `PremiseError` if it violates a premise of the model.
    FlankloadError
        If a position has no solution.
    """
    start, scene = process_time(), scene_of(scene)
    picked = {"keys": first_discretization(scene).tables()} if scene.names_tolerance else None
    plain = without_choice(first_scene(scene))
    runs = CoarseRuns(plain, levels=levels or asks_for_choice(scene), dimension=dimension)
    tried = None if levels or not asks_for_choice(scene) else wanted_sizes(plain)
    measured = runs.measured(tried)
    chosen, left_out = plain, None
    choice: tuple[Chosen, ...] = ()
    if asks_for_choice(scene) and any(scene.torques_Nm):
        chosen, choice = chosen_scene(plain, runs.effects, measured)
        left_out = runs.change(chosen)
    costs = _marginal_costs(runs, plain, runs.price(plain), tried)
    found = Plan(
        name=scene.name,
        tolerance=scene.accuracy.tolerance,
        effects=_rows(chosen, runs, measured, costs, choice),
        predicted=predicted_of(runs.price(chosen)),
        choice=choice,
        left_out=left_out,
        picked=picked,
        within=WITHIN * (ADAPTIVE_WITHIN if scene.positions.adaptive else 1.0),
    )
    return replace(found, cpu_s=process_time() - start)


def predicted_of(stages: Mapping[str, Account]) -> dict[str, object]:
    """Costs of stages in the form of `Plan.predicted`."""
    return {
        "stages": {
            name: {
                "cpu_s": account.cpu_s,
                "bytes": account.bytes,
                "workspace_bytes": account.workspace_bytes,
                "counters": dict(account.counters),
            }
            for name, account in stages.items()
        },
        "counters": totals(stages),
    }


def _rows(
    scene: Scene,
    runs: CoarseRuns,
    measured: Mapping[str, Measured],
    costs: Mapping[str, tuple[float, int]],
    choice: tuple[Chosen, ...],
) -> tuple[PlannedEffect, ...]:
    """A row for each effect."""
    switches, decided = switches_of(scene), {one.effect: one for one in choice}
    rows = []
    for effect in runs.effects:
        switch, found, why = switches[effect.name], measured[effect.name], decided.get(effect.name)
        toggle, size = runs.toggles.get(effect.name), found.size
        extra_s, extra_bytes = costs.get(effect.name, (None, None))
        row = PlannedEffect(
            name=effect.name,
            title=effect.title,
            on=switch.on,
            because=switch.because if why is None else f'effects.choose = "auto" ({why.why})',
            named=switch.named,
            stages=effect.stages,
            extra_s=extra_s,
            extra_bytes=extra_bytes,
            size=size,
            assumed=None if toggle is None or size is None else toggle.assumed,
            unknown=found.unknown,
            matters=size is not None and is_significant(size.largest, scene.accuracy.tolerance),
        )
        rows.append(replace(row, remark=remark_on(row, coarser=effect.coarser)))
    return tuple(rows)


def _marginal_costs(
    runs: CoarseRuns,
    scene: Scene,
    stages: Mapping[str, Account],
    tried: tuple[str, ...] | None,
) -> dict[str, tuple[float, int]]:
    """CPU seconds and bytes that each tried effect adds to the run, or would add."""
    switches, costs = switches_of(scene), {}
    for name, toggle in runs.toggles.items():
        if toggle.skipped is not None or (tried is not None and name not in tried):
            continue
        other = stages
        if toggle.scene is not None:
            with suppress(FlankloadError):  # otherwise no scene for comparison exists
                other = runs.price(toggle.scene)
        one, two = (other, stages) if not switches[name].on else (stages, other)
        costs[name] = (_seconds(one) - _seconds(two), _bytes(one) - _bytes(two))
    return costs


def _seconds(stages: Mapping[str, Account]) -> float:
    return sum(account.cpu_s for account in stages.values())


def _bytes(stages: Mapping[str, Account]) -> int:
    return sum(account.bytes + account.workspace_bytes for account in stages.values())
