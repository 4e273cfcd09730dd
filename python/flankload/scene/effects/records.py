"""The records of all effects; an effect that a scene does not request is not computed."""

from __future__ import annotations

from dataclasses import fields, make_dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, Any

from flankload.scene.axial import LEAD_KEYS, MISALIGNMENTS, REGION_KEYS
from flankload.scene.effects import switches
from flankload.scene.effects.record import Effect, Switch, Work

if TYPE_CHECKING:
    from flankload.scene.scene import Scene

#: Effects of scenes with a table [stage] only.
STAGE = "stage"
BODIES = ("compliance body 1", "compliance body 2")
SWEEPS = ("sweep", "estimate")
#: Common parts of records: effects on the elastic part of a body, on gaps, by expansion.
OF_SECTORS: dict[str, Any] = {"stages": BODIES, "size_by": "compliance", "of_teeth": True}
OF_GAPS: dict[str, Any] = {"stages": ("bodies",), "size_by": "gaps", "of_teeth": True}
OF_EXPANSION: dict[str, Any] = {
    "stages": (*BODIES, *SWEEPS),
    "work": Work(growth_loads=1),
    "counters": ("fe_load_cases_growth",),
    "size_by": "gaps",
}
#: Kinds of bodies without a model of their coast flanks, with the reason.
ONE_FLANK = {
    "mesh": "of whose teeth a file names one flank",
    "compliance": "of whose teeth a file names one flank",
    "cam": "which has one flank",
    "follower": "which has one flank",
    "sprocket": "whose pockets hold rollers",
    "chain": "which has no teeth",
}
IN_MODES = (
    "the default with effects.coast_flank, whose coupling across the teeth is known in modes for "
    "small forces"
)


def _elastic(number: int) -> Effect:
    """The record of an elastic body."""
    return Effect(
        f"elastic_body_{number}",
        f"elastic body {number}",
        keys=(f"body_{number}.rigid",),
        called_for=switches.is_elastic(number),
        needs_load=True,
        stages=(f"compliance body {number}",),
        work=Work(factorisations=1, normal_loads=1),
        counters=("fe_factorisations", "unit_loads_normal"),
        size_by="compliance",
    )


EFFECTS = (
    _elastic(1),
    _elastic(2),
    Effect(
        "three_dimensions",
        "three-dimensional bodies",
        keys=(
            "effects.dimension",
            "body_*.helix_angle_deg",
            *(f"body_*.{key}" for key in (*LEAD_KEYS, "face_width_mm", "axial_offset_mm")),
            *(f"body_*.{key}" for key in (*REGION_KEYS, "shaft")),
            *(f"pair.{key}" for key in MISALIGNMENTS),
        ),
        called_for=switches.is_spatial,
        stages=(*BODIES, *SWEEPS),
        counters=("slices",),
        size_by="compliance",
        of_teeth=True,
    ),
    Effect(
        "segment",
        "segment of teeth with fixed cuts",
        on={"body": "segment", "segment_teeth": 5},
        coarser=True,
        **OF_SECTORS,
    ),
    Effect(
        "single_tooth",
        "single tooth with fixed cuts",
        on={"body": "tooth", "segment_teeth": None},
        coarser=True,
        **OF_SECTORS,
    ),
    Effect("tooth_coupling", "coupling between teeth", on={"tooth_coupling": True}, **OF_SECTORS),
    Effect(
        "elastic_planet",
        "elastic planets",
        keys=("planet.rigid",),
        called_for=switches.has_elastic_planets,
        needs_load=True,
        stages=("compliance planet",),
        work=Work(factorisations=1, normal_loads=1),
        counters=("fe_factorisations", "unit_loads_normal"),
        size_by="compliance",
        only_for=STAGE,
    ),
    Effect(
        "mesh_coupling",
        "coupling of meshes through the bodies",
        on={"mesh_coupling": True},
        called_for=switches.has_coupled_meshes,
        stages=SWEEPS,
        size_by="compliance",
        only_for=STAGE,
    ),
    Effect(
        "floating_sun",
        "floating sun",
        keys=("stage.floating",),
        called_for=switches.has_floating_sun,
        stages=SWEEPS,
        size_by="gaps",
        only_for=STAGE,
    ),
    Effect(
        "ring_support",
        "ring support that bends",
        keys=("stage.ring_support",),
        called_for=switches.has_bending_ring,
        stages=("compliance body 2", *SWEEPS),
        size_by="compliance",
        only_for=STAGE,
    ),
    Effect(
        "nodal_near_field",
        "near field from nodal forces",
        on={"near_field": "nodes"},
        stages=(*BODIES, *SWEEPS),
        counters=("unit_loads_nodal",),
        size_by="spacing",
        coarser=True,
        refused_with={
            "thermal_growth": "'analytic' with effects.temperature_rise_K: expansion is known in "
            "modes only",
            "centrifugal_growth": "'analytic' with effects.speed_rpm: expansion is known in modes "
            "only",
            "coast_flanks": IN_MODES,
        },
        refused_for={
            "cam": "'analytic' with body_2.kind 'cam': a closed flank has no first and last node"
        },
    ),
    Effect(
        "finite_influence",
        "influence coefficients of finite forces",
        on={"influence": "finite"},
        stages=(*BODIES, *SWEEPS),
        work=Work(tangential_loads=1, columns=2, solves=2),
        counters=("unit_loads_tangential", "finite_solutions"),
        size_by="cells",
        refused_with={"coast_flanks": IN_MODES},
    ),
    Effect(
        "lumped_contact",
        "lumped Hertz contact",
        on={"contact": "lumped"},
        stages=SWEEPS,
        work=Work(columns=-1, solves=-1),
        size_by="places",
        coarser=True,
        refused_with={
            "nodal_near_field": "'pairs' with effects.near_field 'nodes': nodal forces need "
            "resolved contact",
            "finite_influence": "'pairs' with effects.influence 'finite': finite forces need "
            "resolved contact",
        },
        refused_for={
            "spline_shaft": "'pairs' with body_1.kind 'spline_shaft': its flanks conform, and "
            "touch over a length instead of at a place"
        },
    ),
    Effect(
        "tip_contact",
        "tip and fillet contact",
        on={"tip_contact": True},
        stages=SWEEPS,
        size_by="places",
        of_teeth=True,
    ),
    Effect(
        "coast_flanks",
        "contact on the coast flanks",
        on={"coast_flank": True},
        stages=(*BODIES, *SWEEPS),
        work=Work(coast_readings=1),
        counters=("coast_readings",),
        size_by="places",
        of_teeth=True,
        refused_for={
            kind: f"false with {{body}}.kind '{kind}', {why}" for kind, why in ONE_FLANK.items()
        },
    ),
    Effect(
        "flank_modifications",
        "flank modifications",
        keys=tuple(f"body_*.{key}" for key in switches.MODIFICATIONS),
        called_for=switches.is_modified,
        stages=("bodies", *BODIES),
        work=Work(tangential_loads=1),
        counters=("unit_loads_tangential",),
        size_by="gaps",
        of_teeth=True,
    ),
    Effect(
        "pitch_errors",
        "pitch errors",
        keys=("body_*.pitch_errors_um",),
        called_for=switches.is_misplaced,
        **OF_GAPS,
    ),
    Effect(
        "lead_modifications",
        "lead modifications",
        keys=tuple(f"body_*.{key}" for key in LEAD_KEYS),
        called_for=switches.has_lead,
        **OF_GAPS,
    ),
    Effect(
        "misalignment",
        "misalignment of the axes",
        keys=tuple(f"pair.{key}" for key in MISALIGNMENTS),
        called_for=switches.is_misaligned,
        **OF_GAPS,
    ),
    Effect(
        "shafts",
        "shafts and bearings",
        keys=("body_*.shaft",),
        called_for=switches.has_shaft,
        stages=SWEEPS,
        size_by="compliance",
        of_teeth=True,
    ),
    Effect(
        "thermal_growth",
        "thermal expansion",
        keys=(
            "effects.temperature_rise_K",
            "effects.thermal_expansion_per_K",
            "effects.support_expansion_per_K",
        ),
        on={"temperature_rise_K": 50.0},
        **OF_EXPANSION,
    ),
    Effect(
        "centrifugal_growth",
        "centrifugal expansion",
        keys=("effects.speed_rpm", "effects.density_kg_m3"),
        on={"speed_rpm": 3000.0},
        **OF_EXPANSION,
        refused_for={
            "cam": "nothing, since body_2.kind is 'cam': its follower, body_1, swings and does not "
            "turn"
        },
    ),
    Effect(
        "friction",
        "friction",
        on={"friction_coefficient": 0.1},
        stages=(*BODIES, *SWEEPS),
        work=Work(tangential_loads=1, columns=1),
        counters=("unit_loads_tangential",),
        size_by="levers",
    ),
    Effect("power_loss", "power loss", on={"friction_coefficient": 0.1}, stages=("result",)),
    Effect(
        "root_stress",
        "tooth root stress",
        on={"root_stress": True},
        needs_load=True,
        stages=(*BODIES, "result"),
        work=Work(recoveries=1),
        counters=("stress_recoveries",),
        of_teeth=True,
        refused_with={
            "coast_flanks": "false with effects.coast_flank: stress is known for forces on the "
            "working flanks only"
        },
        refused_for={"cam": "nothing: a cam and its follower have no tooth roots"},
    ),
    Effect(
        "several_torques",
        "several torques",
        keys=("load.torque_Nm",),
        called_for=switches.has_several_torques,
        stages=SWEEPS,
        work=Work(columns=1, solves=1),
    ),
    Effect(
        "large_displacement",
        "large displacements of chain rollers",
        on={"large_displacement": True},
        stages=("sweep",),
        work=Work(columns=10, solves=10),
        size_by="places",
        only_for="chain",
    ),
    Effect(
        "land_friction",
        "friction on the lands of a belt",
        on={"land_friction": 0.1},
        stages=(*BODIES, "sweep", "estimate"),
        work=Work(tangential_loads=1),
        counters=("unit_loads_tangential",),
        size_by="levers",
        only_for="belt",
    ),
    Effect(
        "land_lift",
        "lift-off of the lands of a belt",
        on={"land_lift": True},
        stages=("compliance body 2", "sweep"),
        work=Work(normal_loads=1, columns=1),
        size_by="places",
        refused_with={
            "land_friction": "false with effects.land_friction, which assumes that all lands slide"
        },
        only_for="belt",
    ),
)


_Booleans: Any = make_dataclass(
    "_Booleans", [(effect.name, bool) for effect in EFFECTS], frozen=True
)


class Effects(_Booleans):
    """The effects that a scene requests: one Boolean per record of `EFFECTS`, by its name."""


@lru_cache(maxsize=64)
def effects_of(scene: Scene) -> Effects:
    """Effects that a scene requests."""
    return Effects(**{effect.name: effect.switch(scene).on for effect in EFFECTS})


def known_effects(scene: Scene) -> tuple[Effect, ...]:
    """Effects that the bodies of a scene may have; chains and belts have few."""
    if scene.is_drive:
        known = ["several_torques", *["elastic_body_1"] * (not scene.body_1.rigid)]
        kind = scene.body_2.kind
        return tuple(row for row in EFFECTS if row.name in known or row.only_for == kind)
    teeth, own = scene.body_2.has_teeth, {None, STAGE if scene.stage is not None else None}
    return tuple(row for row in EFFECTS if row.only_for in own and (teeth or not row.of_teeth))


def switches_of(scene: Scene) -> dict[str, Switch]:
    """Effects that a scene requests, each with the deciding key, in the order of records."""
    return {effect.name: effect.switch(scene) for effect in EFFECTS}


def excluded_by(effect: Effect) -> tuple[str, ...]:
    """All effects that cannot be combined with this one."""
    return tuple(
        other.name
        for other in EFFECTS
        if other.name in effect.refused_with or effect.name in other.refused_with
    )


def work_in(stage: str, effects: Effects) -> Work:
    """Sum of the work that all requested effects add to a stage."""
    work = [row.work for row in EFFECTS if stage in row.stages and getattr(effects, row.name)]
    return Work(
        **{item.name: sum(getattr(row, item.name) for row in work) for item in fields(Work)}
    )
