"""The effects, one record each; an effect that a scene does not request is not computed."""

from __future__ import annotations

from dataclasses import dataclass, field, fields
from functools import lru_cache
from typing import TYPE_CHECKING, Any

from flankload.scene.axial import LEAD_KEYS, MISALIGNMENTS, REGION_KEYS
from flankload.scene.effects import switches
from flankload.scene.effects.record import Effect, Switch, Work

if TYPE_CHECKING:
    from flankload.scene.scene import Scene

BODIES = ("compliance body 1", "compliance body 2")
SWEEPS = ("sweep", "tangent", "estimate")
#: Parts that several records share: effects on the elastic part of a body, on gaps, by expansion.
OF_SECTORS: dict[str, Any] = {"stages": BODIES, "size_by": "compliance", "of_teeth": True}
OF_GAPS: dict[str, Any] = {"stages": ("bodies",), "size_by": "gaps", "of_teeth": True}
OF_GROWTH: dict[str, Any] = {
    "stages": (*BODIES, *SWEEPS),
    "work": Work(growth_loads=1),
    "counters": ("fe_load_cases_growth",),
    "size_by": "gaps",
}
#: Kinds of bodies whose coast flanks are not modelled, with the reason.
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


def _effect(title: str, **record: Any) -> Any:
    """A field of `Effects` with its record."""
    return field(metadata={"title": title, **record})


def _elastic(number: int) -> Any:
    """The record of an elastic body."""
    return _effect(
        f"elastic body {number}",
        keys=(f"body_{number}.rigid",),
        called_for=switches.is_elastic(number),
        needs_load=True,
        stages=(f"compliance body {number}",),
        work=Work(factorisations=1, normal_loads=1),
        counters=("fe_factorisations", "unit_loads_normal"),
        size_by="compliance",
    )


@dataclass(frozen=True)
class Effects:
    """The effects that a scene requests: one truth value per effect, with its record (`Effect`)."""

    elastic_body_1: bool = _elastic(1)
    elastic_body_2: bool = _elastic(2)
    three_dimensions: bool = _effect(
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
        counters=("fe_unknowns", "slices"),
        size_by="compliance",
        of_teeth=True,
    )
    segment: bool = _effect(
        "segment of teeth with fixed cuts",
        on={"body": "segment", "segment_teeth": 5},
        coarser=True,
        **OF_SECTORS,
    )
    single_tooth: bool = _effect(
        "single tooth with fixed cuts",
        on={"body": "tooth", "segment_teeth": None},
        coarser=True,
        **OF_SECTORS,
    )
    tooth_coupling: bool = _effect(
        "coupling between teeth", on={"tooth_coupling": True}, **OF_SECTORS
    )
    nodal_near_field: bool = _effect(
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
    )
    finite_influence: bool = _effect(
        "influence coefficients of finite forces",
        on={"influence": "finite"},
        stages=(*BODIES, *SWEEPS),
        work=Work(tangential_loads=1, columns=2, solves=2),
        counters=("unit_loads_tangential", "finite_solutions"),
        size_by="levers",
        refused_with={"coast_flanks": IN_MODES},
    )
    lumped_contact: bool = _effect(
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
            "coast_flanks": "'pairs' with effects.coast_flank: lumped contact has working flanks "
            "only",
        },
        refused_for={
            "spline_shaft": "'pairs' with body_1.kind 'spline_shaft': its flanks conform, and "
            "touch over a length instead of at a place"
        },
    )
    tip_contact: bool = _effect(
        "tip and fillet contact",
        on={"tip_contact": True},
        stages=SWEEPS,
        size_by="places",
        of_teeth=True,
    )
    coast_flanks: bool = _effect(
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
    )
    flank_modifications: bool = _effect(
        "flank modifications",
        keys=tuple(f"body_*.{key}" for key in switches.MODIFICATIONS),
        called_for=switches.is_modified,
        **OF_GAPS,
    )
    pitch_errors: bool = _effect(
        "pitch errors",
        keys=("body_*.pitch_errors_um",),
        called_for=switches.is_misplaced,
        **OF_GAPS,
    )
    lead_modifications: bool = _effect(
        "lead modifications",
        keys=tuple(f"body_*.{key}" for key in LEAD_KEYS),
        called_for=switches.has_lead,
        **OF_GAPS,
    )
    misalignment: bool = _effect(
        "misalignment of the axes",
        keys=tuple(f"pair.{key}" for key in MISALIGNMENTS),
        called_for=switches.is_misaligned,
        **OF_GAPS,
    )
    shafts: bool = _effect(
        "shafts and bearings",
        keys=("body_*.shaft",),
        called_for=switches.has_shaft,
        stages=SWEEPS,
        size_by="compliance",
        of_teeth=True,
    )
    thermal_growth: bool = _effect(
        "thermal expansion",
        keys=(
            "effects.temperature_rise_K",
            "effects.thermal_expansion_per_K",
            "effects.support_expansion_per_K",
        ),
        on={"temperature_rise_K": 50.0},
        **OF_GROWTH,
    )
    centrifugal_growth: bool = _effect(
        "centrifugal expansion",
        keys=("effects.speed_rpm", "effects.density_kg_m3"),
        on={"speed_rpm": 3000.0},
        **OF_GROWTH,
        refused_for={
            "cam": "nothing, since body_2.kind is 'cam': its follower, body_1, swings and does not "
            "turn"
        },
    )
    friction: bool = _effect(
        "friction",
        on={"friction_coefficient": 0.1},
        stages=(*BODIES, *SWEEPS),
        work=Work(tangential_loads=1, columns=1),
        counters=("unit_loads_tangential",),
        size_by="levers",
    )
    power_loss: bool = _effect("power loss", on={"friction_coefficient": 0.1}, stages=("result",))
    root_stress: bool = _effect(
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
    )
    several_torques: bool = _effect(
        "several torques",
        keys=("load.torque_Nm",),
        called_for=switches.has_several_torques,
        stages=SWEEPS,
        work=Work(columns=1, solves=1),
    )
    large_displacement: bool = _effect(
        "large displacements of chain rollers",
        on={"large_displacement": True},
        stages=("sweep",),
        work=Work(columns=10, solves=10),
        size_by="places",
        only_for="chain",
    )
    land_friction: bool = _effect(
        "friction on the lands of a belt",
        on={"land_friction": 0.1},
        stages=(*BODIES, "sweep", "estimate"),
        work=Work(tangential_loads=1),
        counters=("unit_loads_tangential",),
        size_by="levers",
        only_for="belt",
    )
    land_lift: bool = _effect(
        "lift-off of the lands of a belt",
        on={"land_lift": True},
        stages=("compliance body 2", "sweep"),
        work=Work(normal_loads=1, columns=1),
        size_by="places",
        refused_with={
            "land_friction": "false with effects.land_friction, which assumes that all lands slide"
        },
        only_for="belt",
    )


def _records() -> tuple[Effect, ...]:
    """The complete records; an exclusion that one record states holds for both effects."""
    rows = {item.name: dict(item.metadata) for item in fields(Effects)}
    for row in rows.values():
        on = row.get("on", {})
        row.setdefault("keys", tuple(f"effects.{key}" for key in on if on[key] is not None))
    pairs = {(name, other) for name, row in rows.items() for other in row.get("refused_with", ())}
    return tuple(
        Effect(
            name=name,
            excludes=tuple(b for b in rows if (name, b) in pairs or (b, name) in pairs),
            **row,
        )
        for name, row in rows.items()
    )


EFFECTS = _records()


@lru_cache(maxsize=64)
def effects_of(scene: Scene) -> Effects:
    """Effects that a scene requests."""
    return Effects(**{effect.name: effect.switch(scene).on for effect in EFFECTS})


def switches_of(scene: Scene) -> dict[str, Switch]:
    """Effects that a scene requests, each with the key that decides, in the order of records."""
    return {effect.name: effect.switch(scene) for effect in EFFECTS}


def work_in(stage: str, effects: Effects) -> Work:
    """Work that all requested effects add to a stage, the sum over the records."""
    work = [row.work for row in EFFECTS if stage in row.stages and getattr(effects, row.name)]
    return Work(
        **{item.name: sum(getattr(row, item.name) for row in work) for item in fields(Work)}
    )
