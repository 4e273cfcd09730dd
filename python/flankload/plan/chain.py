"""The plan of a chain on its sprocket: no flanks, no elements; its own solutions at some positions.

A chain has two effects of its own: whether its rollers are followed to where they stand, and
several torques. Positions cost the same each, so that a few of them tell what all will.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from time import process_time
from typing import TYPE_CHECKING

import numpy as np
from msgspec import structs

from flankload.cost import Account
from flankload.errors import FlankloadError
from flankload.mechanisms import run_once
from flankload.mechanisms.chain.drive import build_drive
from flankload.plan.drive import TRIED, few_of, few_torques, plan_of
from flankload.plan.measuring import Measured
from flankload.plan.sizes import Size, States, size_of
from flankload.scene.pair import Positions

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flankload.plan.planned import Plan
    from flankload.result import Result
    from flankload.scene import Scene

#: Positions of the estimate of a run.
ESTIMATED = 2
#: CPU seconds of a wrap: where its rollers stand.
BODIES_S = 5e-5


def plan_chain(scene: Scene) -> Plan:
    """What a run of a chain will simulate, cost and leave out; as `plan` of all other scenes.

    Parameters
    ----------
    scene : Scene
        With a sprocket and a chain.

    Returns
    -------
    Plan

    Raises
    ------
    SceneError
        If the rollers do not fit the sprocket.
    FlankloadError
        If a position has no state.
    """
    start = process_time()
    sprocket, _ = build_drive(scene)
    few = _at_few_positions(scene, 2 * np.pi / sprocket.teeth)
    large = scene.effects.large_displacement
    mine, tried = _tried(few)
    found, other_tried = Measured(), tried
    try:
        other, other_tried = _tried(_large(few, large=not large))
        unloaded, _ = _tried(replace(few, load=structs.replace(few.load, torque_Nm=0.0)))
        found = Measured(_size(*((mine, other) if large else (other, mine)), mine, unloaded))
    except FlankloadError as error:
        found = Measured(unknown=" ".join(str(error).split()))
    torques, positions = len(scene.torques_Nm), _count(scene)
    states = torques * positions
    stages = {
        "bodies": Account(cpu_s=BODIES_S * positions, bytes=round(tried.wrap_bytes * positions)),
        "sweep": Account(
            cpu_s=tried.state_s * states,
            bytes=round(tried.state_bytes * states),
            counters={name: round(number * states) for name, number in tried.counters.items()},
        ),
    }
    if scene.accuracy.estimate:
        again = 0 if large else torques * min(ESTIMATED, positions)
        stages["estimate"] = Account(
            cpu_s=other_tried.state_s * again,
            counters={
                name: round(number * again)
                for name, number in other_tried.counters.items()
                if again
            },
        )
    more = torques - 1 if torques > 1 else 1
    extra = {
        "several_torques": (
            more * tried.state_s * positions,
            round(more * tried.state_bytes * positions),
        ),
        "large_displacement": (
            (tried.state_s - other_tried.state_s) * (1 if large else -1) * states,
            round((tried.state_bytes - other_tried.state_bytes) * (1 if large else -1) * states),
        ),
    }
    measured = {"several_torques": Measured(), "large_displacement": found}
    return plan_of(scene, measured, extra, stages, process_time() - start)


def _count(scene: Scene) -> int:
    wanted = scene.positions
    if wanted.angles_deg is not None:
        return len(wanted.angles_deg)
    return wanted.count * (1 if wanted.pitches == "hunting" else int(wanted.pitches))


def _at_few_positions(scene: Scene, pitch_rad: float) -> Scene:
    """The scene at few of its positions, least and largest torque, without estimate."""
    angles = scene.positions.angles_deg
    if angles is None:
        angles = tuple(float(angle) for angle in np.degrees(pitch_rad) * np.arange(TRIED) / TRIED)
    return replace(
        scene,
        positions=Positions(angles_deg=angles[few_of(len(angles))]),
        load=structs.replace(scene.load, torque_Nm=few_torques(scene)),
        accuracy=structs.replace(scene.accuracy, estimate=False),
    )


def _large(scene: Scene, *, large: bool) -> Scene:
    return replace(scene, effects=structs.replace(scene.effects, large_displacement=large))


@dataclass(frozen=True)
class _Tried:
    """What a state took: CPU seconds, bytes, counters; bytes of a wrap at a position."""

    state_s: float
    state_bytes: float
    wrap_bytes: float
    counters: dict[str, float]


def _tried(scene: Scene) -> tuple[tuple[Result, ...], _Tried]:
    """Results of few positions, and what a state took there."""
    start = process_time()
    found = run_once(scene)
    results = found if isinstance(found, tuple) else (found,)
    spent = process_time() - start
    positions = len(results[0].position_rad)
    states = len(results) * positions
    bodies, sweep = (results[0].cost["stages"][name] for name in ("bodies", "sweep"))
    return results, _Tried(
        spent / states,
        sweep["bytes"] / states,
        bodies["bytes"] / positions,
        {name: count / states for name, count in sweep["counters"].items()},
    )


def _size(
    with_it: Sequence[Result],
    without: Sequence[Result],
    base: Sequence[Result],
    unloaded: Sequence[Result],
) -> Size:
    return size_of(
        *([_states(result) for result in results] for results in (with_it, without)),
        base=[_states(result) for result in base],
        unloaded_rad=unloaded[0].rotation_rad,
        reference_radius_mm=base[0].reference_radius_mm,
    )


def _states(result: Result) -> States:
    return States.of(result.torque_Nm, result.sites, result.rotation_rad, result.site_force_N)
