"""What a scene calls for, as data: all that other rooms read of the table."""

from __future__ import annotations

from dataclasses import dataclass, fields

from flankload.scene import Scene
from flankload.scene.effects.effect import Switch, Work
from flankload.scene.effects.table import EFFECTS


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
