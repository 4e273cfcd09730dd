"""Instructions that effects cost the core: absent, absent beside others, and on.

The sweep of the external pair at a few positions, under callgrind: counts, not seconds, so that
they are the same on a loaded machine. Whatever the core runs with an effect and not in the plain
sweep are the effect's own procedures; of these nothing may run without it, others on or off.
FLANKLOAD_OTHER_CORE=FILE counts the plain sweep and friction in another build of the core, too: one
from before an effect was there shows what its absence costs.
"""

from __future__ import annotations

import os
import tomllib
from collections.abc import Mapping
from copy import deepcopy
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from unittest.mock import patch

import numpy as np

import flankload as fl
from flankload import _core
from flankload.scene.effects import EFFECTS, Effect
from flankload.scene.effects.keys import EffectsAsked
from tests.benchmarks._instructions import Counted, count_instructions, has_valgrind
from tests.support.paths import SCENES

SCENE = SCENES / "external_gear.toml"
#: Some with two pairs that carry, some with one.
POSITIONS = 4
#: Effects that other kinds of bodies have.
ELSEWHERE = frozenset(row.name for row in EFFECTS if row.only_for)
PLAIN = EffectsAsked()
#: Effects on, by the keys that call for them; those of the plain scene are taken off.
ON: dict[str, dict[str, Any]] = {
    **{
        row.name: {"effects": {key: value for key, value in row.on.items() if value is not None}}
        for row in EFFECTS
        if row.on and not row.is_asked(PLAIN)
    },
    "three_dimensions": {"effects": {"dimension": 3}},
    "lead_modifications": {"body_1": {"lead_crowning_um": 5.0}},
    "misalignment": {"pair": {"deviation_um_per_mm": 0.5}},
    "shafts": {
        "body_1": {
            "shaft": {
                "diameters_mm": [30.0],
                "lengths_mm": [100.0],
                "gear_position_mm": 40.0,
                "bearing_positions_mm": [0.0, 100.0],
                "radial_stiffness_N_per_um": [200.0, 200.0],
            }
        }
    },
    "flank_modifications": {"body_1": {"tip_radius_mm": 0.3}},
    "pitch_errors": {"body_1": {"pitch_errors_um": [0, 3] * 8}, "positions": {"pitches": 2}},
    "thermal_growth": {"effects": {"temperature_rise_K": 10.0, "support_expansion_per_K": 0.0}},
    "several_torques": {"load": {"torque_Nm": [200, 302]}},
}
OFF: dict[str, dict[str, Any]] = {
    **{row.name: {"effects": row.off} for row in EFFECTS if row.is_asked(PLAIN)},
    "elastic_body_1": {"body_1": {"rigid": True}},
    "elastic_body_2": {"body_2": {"rigid": True}},
}
#: What goes together: all the neighbours of an effect that change what the core does.
TOGETHER = (
    "flank_modifications",
    "thermal_growth",
    "centrifugal_growth",
    "friction",
)
#: Where pairs are written, and how much more room they get, so that no position is asked for again.
ROOMY = ("pair_site", "pair_table")
ROOM = 4
#: Procedures that lead a position, and what they call in its stages.
LEADING = ("solve_cases", "solve_loads", "solve_pairs", "solve_matrix", "solve_lumped")
STAGES = {
    "zones": ("locate",),
    "known": ("solve_known",),
    "pairs": ("lay_pairs", "measure_reach", "append_place", "reach_of"),
    "influence": ("pair_influences",),
    "loop": ("solve_contact_problem", "solve_pass"),
}
#: An absent effect may cost this part of the core without it.
ALLOWED = 1e-3


@dataclass(frozen=True)
class Case:
    """A scene by what it has beside the plain one, and the sweep that it makes."""

    name: str
    scene: fl.Scene
    call: dict[str, Any]

    @property
    def states(self) -> int:
        """Positions times torques."""
        return int(self.call["motion"].shape[1] * len(self.call["torques"]))


def run() -> str:
    """Count and return the tables."""
    if not has_valgrind():
        return "missing: valgrind (apt-get install valgrind)"
    rows = readable()
    cases = {"plain": _case("plain", {})}
    for row in rows:
        cases[row.name] = _case(row.name, {**ON, **OFF}[row.name])
    neighbours = [row.name for row in rows if row.name in TOGETHER]
    for name in neighbours:
        others = [ON[other] for other in neighbours if other != name]
        cases[f"without {name}"] = _case(f"without {name}", merged(*others))
    cases["together"] = _case("together", merged(*(ON[name] for name in neighbours)))
    core = Path(_core.__file__)
    calls = [case.call for case in cases.values()]
    counted = dict(zip(cases, count_instructions(core, calls), strict=True))
    lines = [*_stages(cases, counted), "", *_absent(rows, neighbours, counted)]
    if other := os.environ.get("FLANKLOAD_OTHER_CORE"):
        names = ["plain", "friction"]
        before = count_instructions(Path(other), [cases[name].call for name in names])
        lines += ["", *_against(dict(zip(names, before, strict=True)), counted)]
    return "\n".join(lines)


def readable() -> list[Effect]:
    """Effects that a scene of two gears can call for."""
    keys = {f"effects.{key}" for key in EffectsAsked.__struct_fields__}
    return [
        row
        for row in EFFECTS
        if row.name not in ELSEWHERE
        and any(key in keys or not key.startswith("effects.") for key in row.keys)
    ]


def merged(*changes: Mapping[str, Mapping[str, Any]]) -> dict[str, dict[str, Any]]:
    """All changes of several."""
    together: dict[str, dict[str, Any]] = {}
    for change in changes:
        for table, keys in change.items():
            together.setdefault(table, {}).update(keys)
    return together


def _case(name: str, changes: Mapping[str, Mapping[str, Any]]) -> Case:
    """Solve the scene and take down how its sweep calls the core."""
    tables = tomllib.loads(SCENE.read_text(encoding="utf-8"))
    plain: dict[str, dict[str, Any]] = {
        "positions": {"count": POSITIONS},
        "accuracy": {"estimate": False},
    }
    for table, keys in merged(plain, changes).items():
        tables.setdefault(table, {}).update(keys)
    scene = fl.Scene.from_dict(tables)
    interface = _core.flankload_sweep_mesh
    names = interface.__doc__.partition("(")[2].partition(")")[0].split(",")
    calls: list[dict[str, Any]] = []

    def watched(*arguments: Any) -> Any:
        calls.append(deepcopy(dict(zip(names, arguments, strict=True))))
        return interface(*arguments)

    with patch.object(_core, "flankload_sweep_mesh", watched):
        fl.solve(scene)
    room = {key: np.empty_like(calls[0][key], shape=ROOM * calls[0][key].size) for key in ROOMY}
    return Case(name, scene, calls[0] | room)


# --- tables ---------------------------------------------------------------------------------------
def _stages(cases: Mapping[str, Case], counted: Mapping[str, Counted]) -> list[str]:
    """Thousands of instructions of a state, stage by stage."""
    head = f"{'1000 instructions a state':<32}"
    lines = [head + "".join(f"{stage:>10}" for stage in (*STAGES, "whole", "/ plain"))]
    plain = counted["plain"].whole / cases["plain"].states
    for name, case in cases.items():
        label = f"{name} off" if name in OFF else name
        numbers = [*_by_stages(counted[name]), counted[name].whole]
        lines.append(
            f"{label:<32}"
            + "".join(f"{number / case.states / 1000:10.1f}" for number in numbers)
            + f"{counted[name].whole / case.states / plain:10.3f}"
        )
    return [*lines, "whole: without finding and giving back memory"]


def _by_stages(counted: Counted) -> list[int]:
    """Instructions of the stages."""
    return [
        sum(counted.within[leader, name] for leader in LEADING for name in names)
        for names in STAGES.values()
    ]


def _absent(rows: list[Effect], neighbours: list[str], counted: Mapping[str, Counted]) -> list[str]:
    """Procedures of an effect, and what they take without it."""
    lines = [
        f"{'own procedures of':<32}{'number':>10}{'on':>12}{'plain':>10}{'beside others':>16}",
    ]
    plain = counted["plain"]
    for row in rows:
        if row.name in OFF:
            continue
        on = counted[row.name].own
        own = {name for name in on if on[name] and not plain.own[name]}
        beside = "-"
        if row.name in neighbours:
            theirs = [counted[name].own for name in neighbours if not _alike(name, row.name)]
            alone = {name for name in own if not any(other[name] for other in theirs)}
            found = counted[f"without {row.name}"].own
            beside = f"{sum(found[name] for name in alone)} of {len(alone)}"
        numbers = [sum(run[name] for name in own) for run in (on, plain.own)]
        lines.append(f"{row.name:<32}{len(own):>10}{numbers[0]:>12}{numbers[1]:>10}{beside:>16}")
    return lines


def _alike(one: str, other: str) -> bool:
    """Whether two effects come by the same keys."""
    return ON[one] == ON[other]


def _against(before: Mapping[str, Counted], counted: Mapping[str, Counted]) -> list[str]:
    """This core against another one."""
    lines = [f"{'this core / the other':<32}" + "".join(f"{s:>10}" for s in (*STAGES, "whole"))]
    for name, old in before.items():
        new = counted[name]
        parts = zip(_by_stages(new), _by_stages(old), strict=True)
        ratios = [*(now / max(1, then) for now, then in parts), new.whole / old.whole]
        lines.append(f"{name:<32}" + "".join(f"{ratio:10.5f}" for ratio in ratios))
    lines.append(f"wanted: whole <= {1 + ALLOWED}")
    return lines
