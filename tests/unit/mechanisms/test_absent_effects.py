"""Effects that a scene does not request leave no trace: no counted work, nothing in the core.

Each row of the table of effects has a case here: a scene with it, the same without, and the
quantity that shows it in a run. A row without its case fails.
"""

from __future__ import annotations

import subprocess
import sys
import tomllib
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pytest

import flankload as fl
from flankload import _core
from flankload.contact.body_record import core_sites
from flankload.mechanisms.flank_pair.assembly import build_bodies
from flankload.mechanisms.stage.assembly import NAMES, assemble
from flankload.mechanisms.stage.states import compliances_of
from flankload.mechanisms.stage_clock import StageClock
from flankload.result.drives import BeltDrive
from flankload.scene.effects import EFFECTS, Effect, switches_of
from flankload.scene.effects.keys import EffectsAsked
from tests.support.body_records import parts_of
from tests.support.gear_scenes import changed
from tests.support.paths import SCENES

#: A pair that is solved quickly, without meaning for gears.
SMALL: dict[str, Any] = {
    "positions__count": 2,
    "accuracy__flank_element_mm": 3.0,
    "accuracy__modes": 3,
}
#: Nothing varies along the axis of three-dimensional bodies.
SPATIAL: dict[str, Any] = {
    **{"effects__dimension": 3, "accuracy__slices": 3},
    **{"accuracy__axial_degree": 4, "accuracy__load_degree_z": 0},
}
#: A stage with lumped contact.
STAGE: dict[str, Any] = {
    **{"example": "planetary_stage", "effects__contact": "lumped"},
    **{"accuracy__estimate": False, "accuracy__modes": 3, "accuracy__flank_element_mm": 2.0},
}
SHAFT: dict[str, Any] = {
    "diameters_mm": [30.0],
    "lengths_mm": [100.0],
    "gear_position_mm": 40.0,
    "bearing_positions_mm": [0.0, 100.0],
    "radial_stiffness_N_per_um": [200.0, 200.0],
}
#: Arguments of the core, in their order.
ARGUMENTS = _core.flankload_sweep_mesh.__doc__.partition("(")[2].partition(")")[0].split(",")


def by_name(arguments: tuple[Any, ...]) -> dict[str, Any]:
    """Arguments of a call of the core, the parts of the mesh and of both bodies, by name."""
    call = dict(zip(ARGUMENTS, arguments, strict=True))
    for z in (1, 2):
        parts = parts_of(call[f"record_{z}"])
        call |= {f"{name}_{z}": values for name, values in parts.items()}
    call |= {name: values for name, values in parts_of(call["mesh"]).items() if name != "mesh"}
    *_, level, finite_steps = parts_of(call["mesh"])["mesh"]
    return call | {"speeds": call["motion"][2:], "level": level, "finite_steps": finite_steps}


@dataclass(frozen=True)
class Run:
    """A scene, its result (that of the last torque), and all calls of the core."""

    scene: fl.Scene
    result: fl.Result
    calls: list[dict[str, Any]]

    def counted(self, effect: Effect) -> dict[str, int]:
        """Counters of an effect in its stages."""
        stages = self.result.cost["stages"]
        accounts = [stages[name]["counters"] for name in effect.stages if name in stages]
        return {key: sum(a.get(key, 0) for a in accounts) for key in effect.counters}


def amount(*names: str) -> Callable[[Run], float]:
    """The contents of all arguments of the core together."""

    def of(run: Run) -> float:
        values = [np.ravel(call[name]) for call in run.calls for name in names]
        return float(np.abs(np.concatenate(values)).sum())

    return of


def vanishing_blocks(run: Run) -> int:
    """Distances of teeth of body 1 without mutual influence."""
    smooth = run.calls[-1]["smooth_1"]
    return int(sum(not smooth[:, :, k].any() for k in range(smooth.shape[2])))


def coupling_blocks(run: Run) -> int:
    """Distances of teeth of body 1, other than none, over which a load moves something."""
    smooth = run.calls[-1]["smooth_1"]
    return int(sum(smooth[:, :, k].any() for k in range(1, smooth.shape[2])))


def beyond_active(run: Run) -> float:
    """Length of flank 1 beyond the active part that may touch, mm."""
    curve = build_bodies(run.scene).body_1.curve
    low, high = curve.range_of("flank")
    breaks = run.calls[-1]["breaks_1"]
    return float(breaks[-1] - breaks[0] - (high - low))


def unevenness(run: Run) -> float:
    """How much the angles between neighbouring sites of body 1 differ, in 1e-9 rad."""
    return float(np.round(1e9 * np.abs(np.diff(run.calls[-1]["site_angles_1"], 2)).max()))


def relieved(run: Run) -> int:
    """Pieces of flank 1 that depart from the involute."""
    return build_bodies(run.scene).body_1.curve.labels.count("relief")


def unlike_slices(run: Run) -> float:
    """How much the gaps of the slices of body 1 or 2 differ."""
    slices = build_bodies(run.scene).slices
    return 0.0 if slices is None else float(sum(np.ptp(part) for part in slices.removed_mm))


def lost(run: Run) -> float:
    """Work that friction takes."""
    friction = run.result.friction
    return 0.0 if friction is None else float(friction.loss_work_J or 0.0)


def stress_readings(run: Run) -> int:
    """Bodies whose stress is known."""
    return sum(reading is not None for reading in run.result.root_readings)


def further_torques(run: Run) -> float:
    """States of the sweep beyond one a position."""
    cost = run.result.cost
    return cost["stages"]["sweep"]["counters"]["states"] / cost["positions"] - 1


def further_passes(run: Run) -> int:
    """Contact problems beyond the two of a position: one for the state, one for its stiffness."""
    sweep = run.result.cost["stages"]["sweep"]["counters"]
    return int(sweep["contact_passes"]) - 2 * int(sweep["states"])


def land_rub(run: Run) -> float:
    """The load that the lands of a belt take from its teeth."""
    drive = run.result.drive
    assert isinstance(drive, BeltDrive)
    return float(np.abs(drive.land_friction_N).sum())


def land_lift(run: Run) -> float:
    """Distance of the lands of a belt from the pulley."""
    drive = run.result.drive
    assert isinstance(drive, BeltDrive)
    return float(drive.land_lift_um.sum() + drive.last_land_lift_um.sum())


@dataclass(frozen=True)
class Case:
    """Keys of a scene with an effect and without it, and the quantity that shows it.

    `off` names the effect's keys where a scene without it can name them; `plain` says that a scene
    that names none of them is without it.
    """

    on: dict[str, Any]
    off: dict[str, Any]
    seen: Callable[[Run], float]
    plain: bool = True
    more: dict[str, Any] = field(default_factory=dict)


def planet_work(run: Run) -> float:
    """Unknowns of the planets."""
    return float(run.result.cost["fe_degrees_of_freedom"][1])


def coupled_meshes(run: Run) -> float:
    """Blocks of the sun by which a force in a mesh moves its flanks in another one."""
    scene = run.scene
    assembly = assemble(scene)
    assembly, found = compliances_of(scene, assembly, StageClock(None, NAMES, 1, {}), {})
    contact = assembly.contact(scene, found)
    parts = parts_of(contact.body_records()[0])
    counts = [core_sites(mesh) for mesh in contact.meshes]
    blocks = parts["block"].reshape(sum(counts[:4]), -1)[: counts[0], counts[0] :]
    return float(np.abs(parts["smooth"][:, :, blocks.astype(int) - 1]).sum())


def coupled(run: Run) -> float:
    """Displacement of teeth beside a loaded one by the pulley of a belt."""
    drive = run.result.drive
    assert isinstance(drive, BeltDrive)
    return float(drive.pulley_coupling_um_per_N.sum())


CASES = {
    "elastic_body_1": Case({}, {"body_1__rigid": True}, amount("kernel_1"), plain=False),
    "elastic_body_2": Case({}, {"body_2__rigid": True}, amount("kernel_2"), plain=False),
    "three_dimensions": Case(
        {"effects__dimension": 3},
        {"effects__dimension": 2, "effects__contact": "lumped"},
        amount("axial_1", "slices", "axial_2"),
        more={"effects__contact": "lumped"},
    ),
    "segment": Case(
        {"effects__body": "segment", "effects__segment_teeth": 3},
        {"effects__body": "whole"},
        vanishing_blocks,
    ),
    "single_tooth": Case({"effects__body": "tooth"}, {"effects__body": "whole"}, vanishing_blocks),
    "tooth_coupling": Case({}, {"effects__tooth_coupling": False}, coupling_blocks, plain=False),
    "nodal_near_field": Case(
        {"effects__near_field": "nodes", "accuracy__modes": None},
        {"effects__near_field": "analytic"},
        amount("nodes_1"),
    ),
    "finite_influence": Case(
        {"effects__influence": "finite"}, {"effects__influence": "small"}, amount("finite_steps")
    ),
    "lumped_contact": Case(
        {"effects__contact": "lumped"}, {"effects__contact": "pairs"}, amount("level")
    ),
    "tip_contact": Case({}, {"effects__tip_contact": False}, beyond_active, plain=False),
    "coast_flanks": Case(
        {"effects__coast_flank": True}, {"effects__coast_flank": False}, amount("sides")
    ),
    "flank_modifications": Case(
        {"body_1__tip_relief_um": 10, "body_1__tip_relief_start_diameter_mm": 80}, {}, relieved
    ),
    "lead_modifications": Case(
        {"body_1__lead_crowning_um": 5.0, **SPATIAL},
        {"body_1__lead_crowning_um": 0.0, **SPATIAL},
        unlike_slices,
        more=SPATIAL,
    ),
    "misalignment": Case(
        {"pair__deviation_um_per_mm": 0.5, **SPATIAL},
        {"pair__deviation_um_per_mm": 0.0, **SPATIAL},
        unlike_slices,
        more=SPATIAL,
    ),
    "shafts": Case(
        {"body_1__shaft": SHAFT, **SPATIAL},
        SPATIAL,
        amount("shaft_1"),
        more=SPATIAL,
    ),
    "pitch_errors": Case(
        {"body_1__pitch_errors_um": [0, 3] * 8, "positions__pitches": 2},
        {"body_1__pitch_errors_um": [0] * 16, "positions__pitches": 2},
        unevenness,
        more={"positions__pitches": 2},
    ),
    "thermal_growth": Case(
        {"effects__temperature_rise_K": 10.0, "effects__support_expansion_per_K": 0.0},
        {"effects__temperature_rise_K": 0.0},
        amount("shift_1", "shift_2"),
    ),
    "centrifugal_growth": Case(
        {"effects__speed_rpm": 3000.0},
        {"effects__speed_rpm": 0.0},
        amount("shift_1", "shift_2"),
    ),
    "friction": Case(
        {"effects__friction_coefficient": 0.1},
        {"effects__friction_coefficient": 0},
        amount("friction", "tangential_1", "speeds"),
    ),
    "power_loss": Case(
        {"effects__friction_coefficient": 0.1}, {"effects__friction_coefficient": 0}, lost
    ),
    "root_stress": Case(
        {"effects__root_stress": True}, {"effects__root_stress": False}, stress_readings
    ),
    "large_displacement": Case(
        {"example": "chain", "effects__large_displacement": True},
        {"example": "chain", "effects__large_displacement": False},
        further_passes,
        more={"example": "chain"},
    ),
    "land_friction": Case(
        {"example": "belt", "effects__land_friction": 0.1},
        {"example": "belt", "effects__land_friction": 0.0},
        land_rub,
        more={"example": "belt"},
    ),
    "land_lift": Case(
        {"example": "belt", "load__slack_tension_N": 2.0, "effects__land_lift": True},
        {"example": "belt", "load__slack_tension_N": 2.0, "effects__land_lift": False},
        land_lift,
        more={"example": "belt", "load__slack_tension_N": 2.0},
    ),
    "several_torques": Case(
        {"load__torque_Nm": [100, 302]}, {"load__torque_Nm": 302}, further_torques
    ),
    "elastic_planet": Case(
        {**STAGE, "planet__rigid": False},
        {**STAGE, "planet__rigid": True},
        planet_work,
        plain=False,
        more=STAGE,
    ),
    "mesh_coupling": Case(
        {**STAGE, "effects__mesh_coupling": True},
        {**STAGE, "effects__mesh_coupling": False},
        coupled_meshes,
        plain=False,
        more=STAGE,
    ),
    "floating_sun": Case(
        {**STAGE, "stage__floating": "sun"},
        {**STAGE, "stage__floating": "none"},
        lambda run: float(np.abs(run.result.sun_orbit_um).max()),
        more={**STAGE, "stage__floating": "none"},
    ),
    "ring_support": Case(
        {**STAGE, "stage__ring_support": "free", "stage__floating": "ring"},
        {**STAGE, "stage__ring_support": "clamped"},
        lambda run: float(np.abs(run.result.ring_deflection_um).max()),
        more=STAGE,
    ),
    "elastic_body_1 of a belt": Case(
        {"example": "belt", "body_1__rigid": False, "body_1__bore_diameter_mm": 20.0},
        {"example": "belt", "body_1__rigid": True},
        coupled,
        more={"example": "belt"},
    ),
}

ROWS = {
    effect.name: effect
    for effect in EFFECTS
    if any(
        not key.startswith("effects.")
        or key.removeprefix("effects.") in EffectsAsked.__struct_fields__
        for key in effect.keys
    )
}
#: Rows that work in another way where bodies are others.
ROWS |= {name: ROWS[name.split()[0]] for name in CASES if " " in name}
RUNS: dict[str, Run] = {}


def scene_with(*, example: str = "", **changes: Any) -> dict[str, Any]:
    """The small pair, or an example, with changes."""
    if not example:
        keys = {**SMALL, **changes}  # None: the key is absent
        return changed(**{key: value for key, value in keys.items() if value is not None})
    tree = tomllib.loads((SCENES / f"{example}.toml").read_text(encoding="utf-8"))
    few: dict[str, Any] = {"positions__count": 2}
    if example == "belt":  # it has one position
        few = {"body_2__wrapped_teeth": 5, "accuracy__flank_element_mm": 1.25}
    for key, value in {**few, **changes}.items():
        table, _, name = key.partition("__")
        tree.setdefault(table, {})[name] = value
    return tree


def run_of(changes: dict[str, Any]) -> Run:
    """A run, made once."""
    name = str(sorted(changes.items()))
    if name in RUNS:
        return RUNS[name]
    scene = fl.Scene.from_dict(scene_with(**changes))
    calls: list[dict[str, Any]] = []
    plain = _core.flankload_sweep_mesh

    def watched(*arguments: Any) -> Any:
        calls.append(by_name(arguments))
        return plain(*arguments)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(_core, "flankload_sweep_mesh", watched)
        found = fl.solve(scene)
    RUNS[name] = Run(scene, found.by_torque[-1], calls)
    return RUNS[name]


def test_each_row_of_the_table_has_its_case() -> None:
    assert set(ROWS) - set(CASES) == set()


@pytest.mark.parametrize("name", ROWS)
def test_an_absent_effect_leaves_no_trace(name: str) -> None:
    effect, case = ROWS[name], CASES[name]
    run = run_of(case.off)
    assert not switches_of(run.scene)[effect.name].on
    assert case.seen(run) == 0
    assert run.counted(effect) == dict.fromkeys(effect.counters, 0)


@pytest.mark.parametrize("name", ROWS)
def test_a_requested_effect_is_visible(name: str) -> None:
    effect, case = ROWS[name], CASES[name]
    run = run_of(case.on)
    assert switches_of(run.scene)[effect.name].on
    assert case.seen(run) > 0
    assert all(number > 0 for number in run.counted(effect).values())


def test_teeth_of_three_dimensional_bodies_can_be_uncoupled() -> None:
    """Regression: the key was read in plane scenes only."""
    assert coupling_blocks(run_of(SPATIAL)) > 0
    assert coupling_blocks(run_of({**SPATIAL, "effects__tooth_coupling": False})) == 0


def test_rooms_that_nothing_calls_for_stay_closed() -> None:
    code = (
        "import sys, flankload; flankload.solve; import flankload.mechanisms.flank_pair.mechanism; "
    )
    code += "print(*sys.modules)"
    loaded = subprocess.run(
        [sys.executable, "-c", code], check=True, capture_output=True, text=True
    ).stdout.split()
    assert "flankload.contact.sweep" in loaded
    closed = ("flankload.studies.plan", "flankload.plot", "flankload.studies.verification", "skfem")
    assert not set(closed) & set(loaded)


@pytest.mark.parametrize("name", ROWS)
def test_no_other_effect_works_beside_it(name: str) -> None:
    for changes in (CASES[name].on, CASES[name].off):
        run = run_of(changes)
        switches = switches_of(run.scene)
        on = {row.name for row in EFFECTS if switches[row.name].on}
        claimed = {
            (stage, key)
            for row in EFFECTS
            if row.name in on
            for stage in row.stages
            for key in row.counters
        }
        stages = run.result.cost["stages"]
        spent = {
            (row.name, stage, key): stages[stage]["counters"].get(key, 0)
            for row in EFFECTS
            for stage in row.stages
            for key in row.counters
            if row.name not in on and (stage, key) not in claimed and stage in stages
        }
        assert spent == dict.fromkeys(spent, 0)


@pytest.mark.parametrize("name", ROWS)
def test_naming_the_default_changes_nothing(name: str) -> None:
    case = CASES[name]
    own = {key: value for key, value in case.off.items() if key not in case.more}
    named = run_of(case.off if case.plain else {**case.off, **_other_way(own)})
    plain = run_of(case.more)
    for quantity in ("rotation_rad", "site_force_N", "peak_pressure_MPa"):
        assert np.array_equal(getattr(named.result, quantity), getattr(plain.result, quantity))
    for key, stage in plain.result.cost["stages"].items():
        assert named.result.cost["stages"][key]["counters"] == stage["counters"]


def _other_way(changes: dict[str, Any]) -> dict[str, Any]:
    """Switches the other way."""
    return {key: not value for key, value in changes.items()}
