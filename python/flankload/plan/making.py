"""The plan of a scene: sizes on coarse meshes, the price at its own discretization."""

from __future__ import annotations

from dataclasses import replace
from time import process_time
from typing import TYPE_CHECKING

from flankload.plan.choice import asks_for_choice, chosen_scene, without_choice
from flankload.plan.coarse import Coarse
from flankload.plan.drive import predicted_of
from flankload.plan.extras import Extras
from flankload.plan.measuring import Measured, Sizes, rows
from flankload.plan.planned import Chosen, Plan, PlannedEffect
from flankload.plan.price import price_run
from flankload.plan.quarter import QUARTER
from flankload.plan.remarks import remarked
from flankload.scene import Belt, Chain
from flankload.scene.effects import switches_of
from flankload.steering import first_pick, first_scene

if TYPE_CHECKING:
    from flankload.cost import Account
    from flankload.scene import Scene
    from flankload.scene.effects import Effect, Switch


def plan(scene: Scene) -> Plan:
    """What a run of a scene will simulate, what that costs and how much each effect changes.

    Sizes come from sweeps on coarse meshes (0.2 % of the rotation beside the fine ones), the price
    from a few states at the scene's own discretization: less than a second in all for most scenes.

    Parameters
    ----------
    scene : Scene

    Returns
    -------
    Plan

    Raises
    ------
    SceneError
        If the scene asks for something impossible; `PremiseError` if it breaks a premise of the
        model.
    FlankloadError
        If a position has no answer.
    """
    if isinstance(scene.body_2, Chain):
        from flankload.plan.chain import plan_chain

        return plan_chain(scene)
    start = process_time()
    picked = first_pick(scene).as_dict() if scene.steers else None
    scene = first_scene(scene)
    if isinstance(scene.body_2, Belt):
        from flankload.plan.belt import plan_belt

        return replace(plan_belt(scene), picked=picked)
    plain = without_choice(scene)
    coarse = Coarse(plain)
    coarse.check_load(plain)
    sizes, switches = Sizes(plain, coarse), switches_of(plain)
    measured = {effect.name: sizes.of(effect, switches[effect.name]) for effect in rows(scene)}
    chosen, left_out = plain, None
    choice: tuple[Chosen, ...] = ()
    if asks_for_choice(scene) and any(scene.torques_Nm):
        chosen, choice = chosen_scene(plain, switches, measured)
        left_out = sizes.against(chosen)
        switches = switches_of(chosen)
    stages, extras = _price(chosen, coarse)
    decided = {one.effect: one for one in choice}
    effects = tuple(
        _planned(
            effect,
            switches[effect.name],
            measured[effect.name],
            extras,
            decided.get(effect.name),
            scene.accuracy.tolerance,
        )
        for effect in rows(scene)
    )
    return Plan(
        name=scene.name,
        tolerance=scene.accuracy.tolerance,
        effects=effects,
        predicted=predicted_of(stages),
        choice=choice,
        left_out=left_out,
        picked=picked,
        cpu_s=process_time() - start,
    )


def _price(scene: Scene, coarse: Coarse) -> tuple[dict[str, Account], Extras]:
    """Stages of the run, and what each effect adds to them."""
    small = coarse.pair(scene)
    compliances = coarse.compliances(scene, small)
    pair = coarse.fine_pair(scene)
    stages = price_run(scene, pair, compliances, small, coarse.fine_pair_seconds(scene))
    return stages, Extras(scene, pair, stages, coarse)


def _planned(
    effect: Effect,
    switch: Switch,
    measured: Measured,
    extras: Extras,
    chosen: Chosen | None,
    tolerance: float,
) -> PlannedEffect:
    """One row."""
    extra_s, extra_bytes = extras.of(effect, on=switch.on)
    size = measured.size
    matters = size is not None and size.largest > QUARTER * tolerance
    row = PlannedEffect(
        name=effect.name,
        title=effect.title,
        on=switch.on,
        because=switch.because if chosen is None else f'effects.choose = "auto" ({chosen.why})',
        named=switch.named,
        stages=effect.stages,
        extra_s=extra_s,
        extra_bytes=extra_bytes,
        size=size,
        assumed=measured.assumed,
        unknown=measured.unknown,
        matters=matters,
        remark=None,
    )
    return row if not matters or switch.on != effect.coarser else remarked(row, effect)
