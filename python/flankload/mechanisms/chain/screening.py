"""Screening of a chain on its sprocket: two positions, with and without large displacement."""

from __future__ import annotations

from math import radians
from time import process_time
from typing import TYPE_CHECKING

import numpy as np

from flankload.cost import Account, held_bytes
from flankload.mechanisms.chain.contact import solve_wrap, work_of
from flankload.mechanisms.chain.drive import (
    LINEAR_PASSES,
    build_drive,
    positions_of,
    predicted_work,
    solve_position,
)
from flankload.mechanisms.chain.wrap import wrap_at
from flankload.mechanisms.effect_size import States
from flankload.mechanisms.premises import Torque, broken_by_turn, held
from flankload.mechanisms.screening import Screening
from flankload.mechanisms.toggles import Toggle, toggles

if TYPE_CHECKING:
    from collections.abc import Callable

    from flankload.mechanisms.chain.contact import WrapState
    from flankload.scene import Scene

#: Positions of the screening, and those at which a run estimates its errors.
POSITIONS = 2


class ChainScreening(Screening):
    """The effects of a chain at two positions, and what its run will cost."""

    rows = ("several_torques", "large_displacement")

    def __init__(self, scene: Scene, *, levels: bool = False) -> None:
        self.toggles: dict[str, Toggle] = toggles(scene, self.rows)
        self._large, self._torque_Nm = scene.effects.large_displacement, max(scene.torques_Nm)
        slack = scene.load.slack_tension_N or 0.0
        with Account() as bodies:
            sprocket, chain = build_drive(scene)
            positions, _ = positions_of(scene, sprocket)
            every = max(1, -(-positions.size // POSITIONS))
            angle = radians(scene.body_2.wrap_angle_deg)  # type: ignore[union-attr]
            wraps = [wrap_at(sprocket, angle, float(each)) for each in positions[::every]]
        self.reference_radius_mm, self._positions = sprocket.pitch_radius_mm, positions.size
        part = positions.size / len(wraps)
        self._bodies = Account(cpu_s=part * bodies.cpu_s, bytes=round(part * held_bytes(wraps)))
        spent: dict[bool, float] = {}

        def timed(large: bool, solve: Callable[[int], WrapState]) -> list[WrapState]:
            found, shortest = [], np.inf
            for p in range(len(wraps)):
                start = process_time()
                found.append(solve(p))
                shortest = min(shortest, (process_time() - start) / found[-1].passes)
            spent[large] = shortest
            return found

        mine = timed(
            self._large,
            lambda p: solve_position(scene, wraps[p], chain, self._torque_Nm, every * p),
        )
        if not self._large:
            turned = max(state.compliance_rad_per_Nmm for state in mine) * 1000.0 * self._torque_Nm
            torque = Torque(scene, scene.torques_Nm.index(self._torque_Nm))
            held(scene, tuple(broken_by_turn(turned, 2.0 * sprocket.half_pitch_rad, torque)))

        def solved(p: int, torque_Nm: float, *, large: bool) -> WrapState:
            torque = 1000.0 * torque_Nm
            return solve_wrap(
                wraps[p], chain, torque, slack, large_displacement=large, with_compliance=False
            )

        unloaded = [solved(p, 0.0, large=self._large) for p in range(len(wraps))]
        self.unloaded_rad = np.array([state.rotation_rad for state in unloaded])
        other = not self._large
        followed = timed(other, lambda p: solved(p, self._torque_Nm, large=other))
        self._found, self._pass_s = {self._large: mine, other: followed}, spent
        self._first = [wrap.first for wrap in wraps]
        self.base = self.states(scene)

    def states(self, scene: Scene) -> list[States]:
        """With rollers that are followed, or not."""
        return [self._states(self._found[scene.effects.large_displacement])]

    def _states(self, found: list[WrapState]) -> States:
        first = min(self._first)
        last = max(at + len(state.force_N) for at, state in zip(self._first, found, strict=True))
        force = np.zeros((len(found), last - first))
        for row, at, state in zip(force, self._first, found, strict=True):
            row[at - first : at - first + len(state.force_N)] = np.hypot(*state.force_N.T)
        rotation = np.array([state.rotation_rad for state in found])
        return States.of(self._torque_Nm, np.arange(first, last), rotation, force)

    def price(self, scene: Scene) -> dict[str, Account]:
        """Number of contact problems times the cost of one."""
        large, torques = scene.effects.large_displacement, len(scene.torques_Nm)
        counted = predicted_work(scene, self._positions)
        found, states = self._found[large], counted["sweep"]["states"]
        with_compliance = large != self._large and large  # not part of the screening
        each = LINEAR_PASSES if not large else (1 + with_compliance) * _passes(found)
        stages = {
            "bodies": Account(cpu_s=self._bodies.cpu_s, bytes=self._bodies.bytes),
            "sweep": Account(
                cpu_s=states * each * self._pass_s[large],
                bytes=round(states * held_bytes(found) / len(found)),
                counters={
                    name: round(states * number / len(found))
                    for name, number in work_of(found).items()
                },
            ),
        }
        if "estimate" in counted:
            stages["estimate"] = Account()
            if not large:  # by an iteration at some positions
                states = torques * min(POSITIONS, self._positions)
                followed = self._found[True]
                seconds = states * _passes(followed) * self._pass_s[True]
                stages["estimate"].cpu_s = seconds
        for name, account in stages.items():
            account.counters |= counted[name]
        return stages


def _passes(found: list[WrapState]) -> float:
    """Number of contact problems of a state."""
    return sum(state.passes for state in found) / len(found)
