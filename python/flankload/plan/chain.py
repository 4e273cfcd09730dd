"""The plan of a chain on its sprocket: no flanks, no elements; its own solutions at some positions.

A chain has two effects of its own: whether its rollers are followed to where they stand, and
several torques. Positions cost the same each, so that a few of them tell what all will.
"""

from __future__ import annotations

from dataclasses import replace
from time import process_time
from typing import TYPE_CHECKING

import numpy as np
from msgspec import structs

from flankload.chain_drive import build_drive, solve_chain
from flankload.effects import EFFECTS, switches_of
from flankload.errors import FlankloadError
from flankload.plan.planned import QUARTER, Plan, PlannedEffect
from flankload.plan.remarks import remarked
from flankload.plan.sizes import Size, States, size_of
from flankload.scene.pair_tables import Positions

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flankload.result import Result
    from flankload.scene import Scene

#: Effects that a chain knows.
KNOWN = ("several_torques", "large_displacement")
#: Positions over a pitch that are tried; the estimate of a run takes two.
TRIED, ESTIMATED = 6, 2


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
    mine, state_s, counters = _tried(few)
    size, unknown, other_s = None, None, state_s
    try:
        other, other_s, _ = _tried(_large(few, large=not large))
        unloaded, _, _ = _tried(replace(few, load=structs.replace(few.load, torque_Nm=0.0)))
        size = _size(*((mine, other) if large else (other, mine)), mine, unloaded)
    except FlankloadError as error:
        unknown = " ".join(str(error).split())
    torques, positions = len(scene.torques_Nm), _count(scene)
    states = torques * positions
    sweep_s = state_s * states
    stages = {"bodies": 1e-3, "sweep": sweep_s}
    if scene.accuracy.estimate:
        stages["estimate"] = 0.0 if large else other_s * torques * min(ESTIMATED, positions)
    extra_s = {
        "several_torques": state_s * positions * (torques - 1 if torques > 1 else 1),
        "large_displacement": (state_s - other_s) * (1 if large else -1) * states,
    }
    counted = {name: round(number * states) for name, number in counters.items()}
    switches = switches_of(scene)
    rows = []
    for effect in (effect for effect in EFFECTS if effect.name in KNOWN):
        switch, own = switches[effect.name], effect.name == "large_displacement"
        matters = own and size is not None and size.largest > QUARTER * scene.accuracy.tolerance
        row = PlannedEffect(
            name=effect.name,
            title=effect.title,
            on=switch.on,
            because=switch.because,
            named=switch.named,
            stages=effect.stages,
            extra_s=extra_s[effect.name],
            extra_bytes=0,
            size=size if own else None,
            unknown=unknown if own else None,
            matters=matters,
        )
        rows.append(remarked(row, effect) if matters and not switch.on else row)
    return Plan(
        name=scene.name,
        tolerance=scene.accuracy.tolerance,
        effects=tuple(rows),
        predicted={
            "stages": {
                name: {
                    "cpu_s": seconds,
                    "bytes": 0,
                    "workspace_bytes": 0,
                    "counters": counted if name == "sweep" else {},
                }
                for name, seconds in stages.items()
            },
            "counters": counted,
        },
        cpu_s=process_time() - start,
    )


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
    step = -(-len(angles) // TRIED)
    loads = (min(scene.torques_Nm), max(scene.torques_Nm))
    return replace(
        scene,
        positions=Positions(angles_deg=angles[::step]),
        load=structs.replace(scene.load, torque_Nm=tuple(dict.fromkeys(loads))),
        accuracy=structs.replace(scene.accuracy, estimate=False),
    )


def _large(scene: Scene, *, large: bool) -> Scene:
    return replace(scene, effects=structs.replace(scene.effects, large_displacement=large))


def _tried(scene: Scene) -> tuple[tuple[Result, ...], float, dict[str, float]]:
    """Results, CPU seconds of a state and what is counted in one."""
    start = process_time()
    results = solve_chain(scene)
    number = len(results) * len(results[0].position_rad)
    counters = results[0].cost["stages"]["sweep"]["counters"]
    seconds = (process_time() - start) / number
    return results, seconds, {name: count / number for name, count in counters.items()}


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
