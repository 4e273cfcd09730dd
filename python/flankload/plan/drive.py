"""What the plans of chains and belts have in common: few of their positions, rows of effects."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from flankload.cost import totals
from flankload.plan.planned import Plan, PlannedEffect
from flankload.plan.quarter import QUARTER
from flankload.plan.remarks import remarked
from flankload.scene.effects import EFFECTS, switches_of

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flankload.cost import Account
    from flankload.plan.measuring import Measured
    from flankload.scene import Scene

#: Positions that are tried.
TRIED = 6


def few_of(count: int) -> slice:
    """At most `TRIED` of so many positions, evenly spread, the first among them."""
    return slice(None, None, max(1, -(-count // TRIED)))


def few_torques(scene: Scene) -> tuple[float, ...]:
    """Least and largest torque of a scene, N m."""
    return tuple(dict.fromkeys((min(scene.torques_Nm), max(scene.torques_Nm))))


def plan_of(
    scene: Scene,
    measured: Mapping[str, Measured],
    extra: Mapping[str, tuple[float, int]],
    stages: Mapping[str, Account],
    cpu_s: float,
) -> Plan:
    """A plan from what was measured.

    Parameters
    ----------
    scene : Scene
    measured : mapping of str to Measured
        Size of each effect that a drive knows.
    extra : mapping of str to (float, int)
        CPU seconds and bytes that each adds, or would add.
    stages : mapping of str to Account
        Price of the run.
    cpu_s : float
        What the plan itself took.

    Returns
    -------
    Plan
    """
    switches, rows = switches_of(scene), []
    for effect in (effect for effect in EFFECTS if effect.name in measured):
        switch, found = switches[effect.name], measured[effect.name]
        size = found.size
        matters = size is not None and size.largest > QUARTER * scene.accuracy.tolerance
        row = PlannedEffect(
            name=effect.name,
            title=effect.title,
            on=switch.on,
            because=switch.because,
            named=switch.named,
            stages=effect.stages,
            extra_s=extra[effect.name][0],
            extra_bytes=extra[effect.name][1],
            size=size,
            assumed=found.assumed,
            unknown=found.unknown,
            matters=matters,
        )
        rows.append(remarked(row, effect) if matters and not switch.on else row)
    return Plan(
        name=scene.name,
        tolerance=scene.accuracy.tolerance,
        effects=tuple(rows),
        predicted=predicted_of(stages),
        cpu_s=cpu_s,
    )


def predicted_of(stages: Mapping[str, Account]) -> dict[str, Any]:
    """Prices of stages as `Plan.predicted`.

    Parameters
    ----------
    stages : mapping of str to Account

    Returns
    -------
    dict of str to Any
    """
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
