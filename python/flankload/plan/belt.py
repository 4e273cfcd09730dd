"""The plan of a timing belt: sizes from large elements at few positions, the price by laws.

All that lands can do is solved once; with it and without are other contact problems of the same
elements. What the large elements take says how fast the machine is.
"""

from __future__ import annotations

from time import process_time
from typing import TYPE_CHECKING

import numpy as np

from flankload.base.rounding import round_down
from flankload.cost import Account
from flankload.errors import FlankloadError, SceneError
from flankload.mechanisms.belt.drive import (
    asked_of,
    flank_elements,
    positions_of,
    pulley_mesh,
    response_at,
    solved_pulley,
    strip_of,
)
from flankload.mechanisms.belt.pulley_compliance import rest_on
from flankload.mechanisms.belt.row import BeltRow
from flankload.mechanisms.belt.states import state_under
from flankload.mechanisms.belt.work import Asked
from flankload.mechanisms.premises import Torque, broken_by_turn, held
from flankload.plan.belt_price import (
    price_belt,
    price_pulley,
    seconds_of_elements,
    seconds_of_state,
    sizes_of,
)
from flankload.plan.coarse import load_elements
from flankload.plan.drive import few_of, few_torques, plan_of
from flankload.plan.measuring import Measured
from flankload.plan.planned import IMPOSSIBLE
from flankload.plan.sizes import Size, States, size_of
from flankload.plan.variants import Variant, other_way, with_keys, without_keys
from flankload.scene.effects import switches_of

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    from flankload.mechanisms.belt.belt import Strip
    from flankload.plan.planned import Plan
    from flankload.scene import Scene

    Floats = NDArray[np.float64]
    Numbers = NDArray[np.int64]

#: Elements on a flank that is looked at: shares within half a point, unless a run takes fewer.
COARSE_ELEMENTS = 3
#: Effects that lands of a belt know.
OF_LANDS = ("land_friction", "land_lift")


def plan_belt(scene: Scene) -> Plan:
    """What a run of a timing belt will simulate, cost and leave out.

    Parameters
    ----------
    scene : Scene
        With a pulley and a belt.

    Returns
    -------
    Plan

    Raises
    ------
    FlankloadError
        If a position has no state.
    """
    start = process_time()
    strip = strip_of(scene)
    position_rad, _ = positions_of(scene, strip)
    coarse = _Coarse(scene, strip, position_rad)
    coarse.check_load()
    switches = switches_of(scene)
    stages = price_belt(scene, strip, position_rad, coarse.slower)
    measured, extra = {"several_torques": Measured()}, {}
    for name in OF_LANDS:
        on = switches[name].on
        try:
            variant = other_way(scene, name, on=on)
        except SceneError as error:
            measured[name], extra[name] = Measured(unknown=f"{IMPOSSIBLE}: {error}"), (0.0, 0)
            continue
        assert variant is not None
        measured[name] = coarse.measured(variant, on=on)
        other = price_belt(variant.scene, strip, position_rad, coarse.slower)
        extra[name] = _more(stages, other) if on else _more(other, stages)
    if not scene.body_1.rigid:
        measured["elastic_body_1"] = coarse.pulley()
        extra["elastic_body_1"] = _more({"it": stages["compliance body 1"]}, {})
    torques = len(scene.torques_Nm)
    another = stages["sweep"].cpu_s / torques, round(stages["sweep"].bytes / torques)
    times = torques - 1 if torques > 1 else 1
    extra["several_torques"] = times * another[0], times * another[1]
    return plan_of(scene, measured, extra, stages, process_time() - start)


def _more(one: Mapping[str, Account], other: Mapping[str, Account]) -> tuple[float, int]:
    """Seconds and bytes of one run beyond those of another."""
    seconds, size = 0.0, 0
    for sign, stages in ((1, one), (-1, other)):
        for account in stages.values():
            seconds += sign * account.cpu_s
            size += sign * (account.bytes + account.workspace_bytes)
    return seconds, size


def _tried(strip: Strip, position_rad: Floats) -> Numbers:
    """Few positions, and the first at which another tooth has come: lands lift most there."""
    few = np.arange(position_rad.size)[few_of(position_rad.size)]
    first = round_down(position_rad / strip.pitch_rad + 0.5)
    return np.union1d(few, np.flatnonzero(np.diff(first))[:1] + 1)


def _all_asked(scene: Scene) -> Scene:
    """The scene with lands that rub, so that nothing is missing."""
    return with_keys(scene, land_friction=scene.effects.land_friction or 0.1)


class _Coarse:
    """A belt of large elements at a few positions, with all that lands can do."""

    def __init__(self, scene: Scene, strip: Strip, position_rad: Floats) -> None:
        self._scene, self._strip = scene, strip
        self._positions = position_rad[_tried(strip, position_rad)]
        elements = min(COARSE_ELEMENTS, flank_elements(scene, strip))
        load_elements()
        start = process_time()
        row = BeltRow(strip, elements, rubbing=True, lifting=True)
        held = [response_at(strip, row, None, float(angle)) for angle in self._positions]
        self._responses, self.slower = held, {}
        pulley_s = 0.0
        if not scene.body_1.rigid:
            begun = process_time()
            known = solved_pulley(_all_asked(scene), pulley_mesh(scene, elements), Account())
            pulley_s = process_time() - begun
            price = price_pulley(_all_asked(scene), elements, 1.0)
            self.slower["compliance body 1"] = pulley_s / price.cpu_s
            self._responses = [rest_on(response, strip, known) for response in held]
        self._held = held
        solved = process_time()
        self._base = self._states(scene)
        spent = process_time() - solved
        # lands that rub would turn a pulley without torque
        still = without_keys(scene, "land_friction")
        self._unloaded = self._under(still, 0.0).rotation_rad
        sizes = sizes_of(strip, elements, self._positions)
        count = self._positions.size
        law = seconds_of_elements(strip, sizes, count, Asked(rubbing=True, lifting=True))
        asked = asked_of(scene)
        states = count * len(self._base)
        self.slower["compliance body 2"] = (solved - start - pulley_s) / law
        self.slower["sweep"] = spent / (states * seconds_of_state(sizes, asked))

    def check_load(self) -> None:
        """Refuse a scene whose torque breaks a premise of the model.

        Raises
        ------
        PremiseError
        """
        for states in self._base:
            torque = Torque(self._scene, self._scene.torques_Nm.index(states.torque_Nm))
            turned_rad = float((states.rotation_rad - self._unloaded).max())
            held(self._scene, tuple(broken_by_turn(turned_rad, self._strip.pitch_rad, torque)))

    def pulley(self) -> Measured:
        """What a pulley that yields changes against a rigid one."""
        yields, self._responses = self._responses, self._held
        try:
            rigid = self._states(self._scene)
        except FlankloadError as error:
            return Measured(unknown=" ".join(str(error).split()))
        finally:
            self._responses = yields
        return Measured(self._size(self._base, rigid))

    def measured(self, variant: Variant, *, on: bool) -> Measured:
        """What an effect changes that the scene has, or has not."""
        try:
            other = self._states(variant.scene)
        except FlankloadError as error:
            return Measured(unknown=" ".join(str(error).split()))
        size = self._size(self._base, other) if on else self._size(other, self._base)
        return Measured(size, variant.assumed)

    def _size(self, with_it: list[States], without: list[States]) -> Size:
        return size_of(
            with_it,
            without,
            base=self._base,
            unloaded_rad=self._unloaded,
            reference_radius_mm=self._strip.pitch_radius_mm,
        )

    def _states(self, scene: Scene) -> list[States]:
        return [self._under(scene, torque) for torque in few_torques(scene)]

    def _under(self, scene: Scene, torque_Nm: float) -> States:
        first = min(response.first_tooth for response in self._responses)
        last = max(response.first_tooth + response.teeth for response in self._responses)
        force = np.zeros((len(self._responses), last - first))
        rotation = np.zeros(len(self._responses))
        for p, response in enumerate(self._responses):
            state = state_under(scene, self._strip, response, torque_Nm, Account())
            own = response.first_tooth - first
            force[p, own : own + response.teeth] = self._strip.width_mm * state.tooth_N_per_mm
            rotation[p] = state.rotation_rad
        return States.of(torque_Nm, np.arange(first, last), rotation, force)
