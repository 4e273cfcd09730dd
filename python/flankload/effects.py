"""The effects that a scene can call for, as one table; what it does not call for is not computed.

A row of the table says which keys call for an effect, what it adds to a run, in which counters that
shows and how its size is found before the run (`Effect`). What other rooms read is one truth value
a row (`Effects`), and on request because of which key it is so (`Switch`).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, fields
from typing import Any, Literal

from flankload.scene import (
    Belt,
    BodySpec,
    Cam,
    Chain,
    ComplianceBody,
    Follower,
    MeshBody,
    Pulley,
    Scene,
    Sprocket,
)

#: How the size of an effect is found before the run: the same pair with another compliance, with
#: other gaps, with other places of contact, with other levers; by a law, from how far apart nodes
#: stand; or it changes no state at all.
SizeBy = Literal["compliance", "gaps", "places", "levers", "spacing", "nothing"]


@dataclass(frozen=True)
class Switch:
    """Whether a scene calls for an effect, and because of what.

    Attributes
    ----------
    on : bool
    because : str
        The key that says so, with its value; or what holds without a key.
    named : bool
        The scene names the key.
    """

    on: bool
    because: str
    named: bool


@dataclass(frozen=True)
class Work:
    """What an effect adds to a run, in units of what is there without it; negative: saves.

    Attributes
    ----------
    factorisations, growth_loads : float
        Of each body with finite elements; load cases that stand for the body's own forces.
    normal_loads, tangential_loads, coast_readings : float
        For each pressure mode of each loaded flank.
    recoveries : float
        For each place in the root fillets of a tooth.
    columns : float
        Influence columns, for each of the contact pairs of a position under a torque.
    solves : float
        Contact problems, for each position under a torque.
    """

    factorisations: float = 0
    growth_loads: float = 0
    normal_loads: float = 0
    tangential_loads: float = 0
    coast_readings: float = 0
    recoveries: float = 0
    columns: float = 0
    solves: float = 0


@dataclass(frozen=True)
class Effect:
    """A row of the table.

    Attributes
    ----------
    name : str
        Field of `Effects`.
    title : str
    keys : tuple of str
        What calls for it; "body_*" is either body.
    switch : callable
        Scene to Switch.
    stages : tuple of str
        Stages of the run that do its work, as `result.cost["stages"]` names them.
    work : Work
    counters : tuple of str
        Counters of `result.cost` that are 0 or absent without it.
    size_by : SizeBy
    excludes : tuple of str
        Effects that do not go with it; a scene with both is refused, and the error names both keys.
    of_teeth : bool
        Only bodies with teeth know it; a cam and its follower do not.
    coarser : bool
        With it less is computed than without: what it changes is an error.
    """

    name: str
    title: str
    keys: tuple[str, ...]
    switch: Callable[[Scene], Switch]
    stages: tuple[str, ...]
    work: Work = Work()
    counters: tuple[str, ...] = ()
    size_by: SizeBy = "nothing"
    excludes: tuple[str, ...] = ()
    of_teeth: bool = False
    coarser: bool = False


@dataclass(frozen=True)
class Effects:
    """What a scene calls for: a field for each row of the table.

    Attributes
    ----------
    elastic_body_1, elastic_body_2 : bool
        The body yields: finite elements are solved for it, once, unless its compliance comes from
        a file. Not where it is rigid, and not where no torque loads it.
    segment, single_tooth : bool
        A body is a segment of its teeth, or one tooth, with held cuts in place of the whole.
    tooth_coupling : bool
        A load on a tooth moves the other teeth, too.
    nodal_near_field : bool
        Compliance as tables between the nodes of the flanks.
    finite_influence : bool
        Influence numbers of finite forces, by the deformed flanks.
    lumped_contact : bool
        One unknown for each place of contact, in place of contact pairs.
    tip_contact : bool
        Tip corners, tip roundings and root fillets can carry.
    coast_flanks : bool
        The flanks on the other side of the teeth can carry, too.
    flank_modifications : bool
        A profile departs from the involute below its tip circle (relief, crowning, tip radius or
        chamfer), by the keys of the scene.
    pitch_errors : bool
        Teeth stand beside their place; the period of the result is then one of many.
    thermal_growth, centrifugal_growth : bool
        The bodies grow by heat, by their speed.
    friction : bool
        Flanks rub on each other: their compliance along the tangent is solved, too.
    power_loss : bool
        What friction takes of the power.
    root_stress : bool
        Stress in the tooth roots of the bodies that yield.
    several_torques : bool
        One result per torque.
    large_displacement : bool
        The rollers of a chain are followed to where they stand.
    land_friction, land_lift : bool
        The lands of a belt rub; they may lift off the pulley.
    """

    elastic_body_1: bool
    elastic_body_2: bool
    segment: bool
    single_tooth: bool
    tooth_coupling: bool
    nodal_near_field: bool
    finite_influence: bool
    lumped_contact: bool
    tip_contact: bool
    coast_flanks: bool
    flank_modifications: bool
    pitch_errors: bool
    thermal_growth: bool
    centrifugal_growth: bool
    friction: bool
    power_loss: bool
    root_stress: bool
    several_torques: bool
    large_displacement: bool
    land_friction: bool
    land_lift: bool


def effects_of(scene: Scene) -> Effects:
    """Effects that a scene calls for.

    Parameters
    ----------
    scene : Scene

    Returns
    -------
    Effects
    """
    return Effects(**{effect.name: effect.switch(scene).on for effect in EFFECTS})


def switches_of(scene: Scene) -> dict[str, Switch]:
    """Effects that a scene calls for, each with the key that says so.

    Parameters
    ----------
    scene : Scene

    Returns
    -------
    dict of str to Switch
        In the order of the table.
    """
    return {effect.name: effect.switch(scene) for effect in EFFECTS}


def work_in(stage: str, effects: Effects) -> Work:
    """What all effects that are called for add to a stage.

    Parameters
    ----------
    stage : str
    effects : Effects

    Returns
    -------
    Work
        Sum of their rows.
    """
    rows = [row.work for row in EFFECTS if stage in row.stages and getattr(effects, row.name)]
    return Work(
        **{item.name: sum(getattr(row, item.name) for row in rows) for item in fields(Work)}
    )


# --- switches -------------------------------------------------------------------------------------
def _is_loaded(scene: Scene) -> bool:
    """By a torque, by flanks that may press on each other across the teeth, or by a taut belt."""
    taut = isinstance(scene.body_2, Belt)
    return any(scene.torques_Nm) or scene.effects.coast_flank or taut


def _yields(number: int) -> Callable[[Scene], Switch]:
    """A body yields unless it is rigid or nothing loads it."""

    def switch(scene: Scene) -> Switch:
        body = (scene.body_1, scene.body_2)[number - 1]
        if isinstance(body, Pulley):
            word = "true" if body.rigid else "false"
            return Switch(not body.rigid, f"body_{number}.rigid = {word}", not body.rigid)
        if body.rigid:
            return Switch(False, f"body_{number}.rigid = true", True)
        if not _is_loaded(scene):
            return Switch(False, "load.torque_Nm = 0", True)
        return Switch(True, f"body_{number}.rigid absent", False)

    return switch


def _level(key: str, value: object, default: object) -> Callable[[Scene], Switch]:
    """A key of [effects] has this value."""

    def switch(scene: Scene) -> Switch:
        asked = getattr(scene.effects, key, default)
        if key in scene.named_effects:
            return Switch(asked == value, f"effects.{key} = {_shown(asked)}", True)
        return Switch(asked == value, f"effects.{key} absent", False)

    return switch


def _quantity(key: str) -> Callable[[Scene], Switch]:
    """A key of [effects] has a number, or numbers, other than 0."""

    def switch(scene: Scene) -> Switch:
        asked = getattr(scene.effects, key, None)
        if asked is None:
            return Switch(False, f"effects.{key} absent", False)
        numbers = asked if isinstance(asked, tuple) else (asked,)
        return Switch(any(numbers), f"effects.{key} = {_shown(asked)}", True)

    return switch


def _rubs(scene: Scene) -> Switch:
    asked = scene.effects.friction_coefficient
    if asked is None:
        return Switch(False, "effects.friction_coefficient absent", False)
    return Switch(scene.has_friction, f"effects.friction_coefficient = {_shown(asked)}", True)


def _stressed(scene: Scene) -> Switch:
    switch = _level("root_stress", True, False)(scene)
    if switch.on and not _is_loaded(scene):
        return Switch(False, "load.torque_Nm = 0", True)
    return switch


def _modified(scene: Scene) -> Switch:
    """The first key that says so."""
    for number, body in enumerate((scene.body_1, scene.body_2), start=1):
        key = _modification(body)
        if key is not None:
            return Switch(True, f"body_{number}.{key}", True)
    return Switch(False, "no relief, crowning, tip radius or chamfer", False)


def _modification(body: BodySpec) -> str | None:
    if isinstance(body, ComplianceBody | Cam | Follower | Sprocket | Chain | Pulley | Belt):
        return None
    inside = "profile." if isinstance(body, MeshBody) else ""
    profile = body.profile if isinstance(body, MeshBody) else body
    for key in MODIFICATIONS if profile is not None else ():
        value = getattr(profile, key)
        if value:
            return f"{inside}{key} = {_shown(value)}"
    return None


def _misplaced(scene: Scene) -> Switch:
    for number, body in enumerate((scene.body_1, scene.body_2), start=1):
        if any(body.pitch_errors_um):
            return Switch(True, f"body_{number}.pitch_errors_um", True)
    return Switch(False, "body_*.pitch_errors_um absent", False)


def _several(scene: Scene) -> Switch:
    torque = scene.load.torque_Nm
    return Switch(scene.has_torque_list, f"load.torque_Nm = {_shown(torque)}", True)


def _shown(value: Any) -> str:
    """A value as a scene file has it, of a list no more than its length."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, tuple):
        return f"[{len(value)} entries]"
    return f'"{value}"' if isinstance(value, str) else f"{value:g}"


# --- the table ------------------------------------------------------------------------------------
#: Keys of a body by which its flank departs from the involute.
MODIFICATIONS = ("tip_relief_um", "profile_crowning_um", "tip_radius_mm", "tip_chamfer_mm")
BOTH_BODIES = ("compliance body 1", "compliance body 2")
ALL_SWEEPS = ("sweep", "tangent", "estimate")

EFFECTS: tuple[Effect, ...] = (
    Effect(
        name="elastic_body_1",
        title="body 1 yields",
        keys=("body_1.rigid",),
        switch=_yields(1),
        stages=("compliance body 1",),
        work=Work(factorisations=1, normal_loads=1),
        counters=("fe_factorisations", "unit_loads_normal"),
        size_by="compliance",
    ),
    Effect(
        name="elastic_body_2",
        title="body 2 yields",
        keys=("body_2.rigid",),
        switch=_yields(2),
        stages=("compliance body 2",),
        work=Work(factorisations=1, normal_loads=1),
        counters=("fe_factorisations", "unit_loads_normal"),
        size_by="compliance",
    ),
    Effect(
        name="segment",
        title="a segment of the teeth with held cuts",
        keys=("effects.body", "effects.segment_teeth"),
        switch=_level("body", "segment", "whole"),
        stages=BOTH_BODIES,
        size_by="compliance",
        of_teeth=True,
        coarser=True,
    ),
    Effect(
        name="single_tooth",
        title="a single tooth with held cuts",
        keys=("effects.body",),
        switch=_level("body", "tooth", "whole"),
        stages=BOTH_BODIES,
        size_by="compliance",
        of_teeth=True,
        coarser=True,
    ),
    Effect(
        name="tooth_coupling",
        title="coupling between teeth",
        keys=("effects.tooth_coupling",),
        switch=_level("tooth_coupling", True, True),
        stages=BOTH_BODIES,
        size_by="compliance",
        of_teeth=True,
    ),
    Effect(
        name="nodal_near_field",
        title="near field from plain nodes",
        keys=("effects.near_field",),
        switch=_level("near_field", "nodes", "analytic"),
        stages=(*BOTH_BODIES, *ALL_SWEEPS),
        counters=("unit_loads_nodal",),
        size_by="spacing",
        coarser=True,
        excludes=("lumped_contact", "coast_flanks", "thermal_growth", "centrifugal_growth"),
    ),
    Effect(
        name="finite_influence",
        title="influence numbers of finite force",
        keys=("effects.influence",),
        switch=_level("influence", "finite", "small"),
        stages=(*BOTH_BODIES, *ALL_SWEEPS),
        work=Work(tangential_loads=1, columns=2, solves=2),
        counters=("unit_loads_tangential", "finite_solutions"),
        size_by="levers",
        excludes=("lumped_contact", "coast_flanks"),
    ),
    Effect(
        name="lumped_contact",
        title="lumped Hertz contact",
        keys=("effects.contact",),
        switch=_level("contact", "lumped", "pairs"),
        stages=ALL_SWEEPS,
        work=Work(columns=-1, solves=-1),
        size_by="places",
        coarser=True,
        excludes=("coast_flanks", "nodal_near_field", "finite_influence"),
    ),
    Effect(
        name="tip_contact",
        title="tip and fillet contact",
        keys=("effects.tip_contact",),
        switch=_level("tip_contact", True, True),
        stages=ALL_SWEEPS,
        size_by="places",
        of_teeth=True,
    ),
    Effect(
        name="coast_flanks",
        title="contact on the coast flanks",
        keys=("effects.coast_flank",),
        switch=_level("coast_flank", True, False),
        stages=(*BOTH_BODIES, *ALL_SWEEPS),
        work=Work(coast_readings=1),
        counters=("coast_readings",),
        size_by="places",
        of_teeth=True,
        excludes=("root_stress", "lumped_contact", "nodal_near_field", "finite_influence"),
    ),
    Effect(
        name="flank_modifications",
        title="flank modifications",
        keys=tuple(f"body_*.{key}" for key in MODIFICATIONS),
        switch=_modified,
        stages=("bodies",),
        size_by="gaps",
        of_teeth=True,
    ),
    Effect(
        name="pitch_errors",
        title="pitch errors",
        keys=("body_*.pitch_errors_um",),
        switch=_misplaced,
        stages=("bodies",),
        size_by="gaps",
        of_teeth=True,
    ),
    Effect(
        name="thermal_growth",
        title="thermal growth",
        keys=(
            "effects.temperature_rise_K",
            "effects.thermal_expansion_per_K",
            "effects.support_expansion_per_K",
        ),
        switch=_quantity("temperature_rise_K"),
        stages=(*BOTH_BODIES, *ALL_SWEEPS),
        work=Work(growth_loads=1),
        counters=("fe_load_cases_growth",),
        size_by="gaps",
        excludes=("nodal_near_field",),
    ),
    Effect(
        name="centrifugal_growth",
        title="centrifugal expansion",
        keys=("effects.speed_rpm", "effects.density_kg_m3"),
        switch=_quantity("speed_rpm"),
        stages=(*BOTH_BODIES, *ALL_SWEEPS),
        work=Work(growth_loads=1),
        counters=("fe_load_cases_growth",),
        size_by="gaps",
        excludes=("nodal_near_field",),
    ),
    Effect(
        name="friction",
        title="friction",
        keys=("effects.friction_coefficient",),
        switch=_rubs,
        stages=(*BOTH_BODIES, *ALL_SWEEPS),
        work=Work(tangential_loads=1, columns=1),
        counters=("unit_loads_tangential",),
        size_by="levers",
    ),
    Effect(
        name="power_loss",
        title="power loss",
        keys=("effects.friction_coefficient",),
        switch=_rubs,
        stages=("result",),
    ),
    Effect(
        name="root_stress",
        title="stress in the tooth roots",
        keys=("effects.root_stress",),
        switch=_stressed,
        stages=(*BOTH_BODIES, "result"),
        work=Work(recoveries=1),
        counters=("stress_recoveries",),
        of_teeth=True,
        excludes=("coast_flanks",),
    ),
    Effect(
        name="several_torques",
        title="several torques",
        keys=("load.torque_Nm",),
        switch=_several,
        stages=ALL_SWEEPS,
        work=Work(columns=1, solves=1),
    ),
    Effect(
        name="large_displacement",
        title="rollers of a chain followed to where they stand",
        keys=("effects.large_displacement",),
        switch=_level("large_displacement", True, False),
        stages=("sweep",),
        work=Work(columns=10, solves=10),
        size_by="places",
    ),
    Effect(
        name="land_friction",
        title="friction on the lands of a belt",
        keys=("effects.land_friction",),
        switch=_quantity("land_friction"),
        stages=(*BOTH_BODIES, "sweep", "estimate"),
        work=Work(tangential_loads=1),
        counters=("unit_loads_tangential",),
        size_by="levers",
        excludes=("land_lift",),
    ),
    Effect(
        name="land_lift",
        title="lands of a belt that lift off",
        keys=("effects.land_lift",),
        switch=_level("land_lift", True, False),
        stages=("compliance body 2", "sweep"),
        work=Work(normal_loads=1, columns=1),
        size_by="places",
        excludes=("land_friction",),
    ),
)
