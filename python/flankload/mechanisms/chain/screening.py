"""Screening of a chain on its sprocket: two positions, with and without large displacement."""

from __future__ import annotations

from time import process_time
from typing import TYPE_CHECKING

import numpy as np

from flankload.cost import Account, held_bytes
from flankload.mechanisms.chain.contact import solve_wrap, work_of
from flankload.mechanisms.chain.drive import (
    LINEAR_PASSES,
    assemble,
    predicted_work,
    solve_position,
)
from flankload.mechanisms.premises import Torque, broken_by_turn, require_premises
from flankload.mechanisms.screening import Screening
from flankload.mechanisms.toggles import Toggle, toggles
from flankload.mechanisms.wrapped import Sites, slack_of

if TYPE_CHECKING:
    from collections.abc import Callable

    from flankload.mechanisms.chain.contact import WrapState
    from flankload.mechanisms.effect_size import States
    from flankload.scene import Scene

#: Positions of the screening, and those at which a run estimates its errors.
POSITIONS = 2


class ChainScreening(Screening):
    """The effects of a chain at two positions, and what its run will cost."""

    rows = ("several_torques", "large_displacement")

    def __init__(self, scene: Scene) -> None:
        self.toggles: dict[str, Toggle] = toggles(scene, self.rows)
        self._large, self._torque_Nm = scene.effects.large_displacement, max(scene.torques_Nm)
        with Account() as self._bodies:
            self._assembly = assemble(scene)
        self._bodies.bytes = held_bytes(self._assembly)
        sprocket, self._positions = self._assembly.sprocket, self._assembly.position_rad.size
        self.reference_radius_mm = sprocket.pitch_radius_mm
        self._at = range(0, self._positions, max(1, -(-self._positions // POSITIONS)))
        self._pass_s: dict[bool, float] = {}
        mine = self._timed(
            self._large, lambda p: solve_position(scene, self._assembly, self._torque_Nm, p)
        )
        if not self._large:
            turned = max(state.compliance_rad_per_Nmm for state in mine) * 1000.0 * self._torque_Nm
            torque = Torque(scene, scene.torques_Nm.index(self._torque_Nm))
            require_premises(scene, broken_by_turn(turned, sprocket.pitch_rad, torque))
        slack = slack_of(scene)

        def solved(p: int, torque_Nm: float, *, large: bool) -> WrapState:
            return solve_wrap(
                self._assembly.wraps[p],
                self._assembly.chain,
                1000.0 * torque_Nm,
                slack,
                large_displacement=large,
                with_compliance=False,
            )

        self.unloaded_rad = np.array(
            [solved(p, 0.0, large=self._large).rotation_rad for p in self._at]
        )
        other = not self._large
        followed = self._timed(other, lambda p: solved(p, self._torque_Nm, large=other))
        self._found = {self._large: mine, other: followed}
        self.base = self.states(scene)

    def _timed(self, large: bool, solve: Callable[[int], WrapState]) -> list[WrapState]:
        """States at the positions of the screening; the shortest time of a pass is kept."""
        found: list[WrapState] = []
        self._pass_s[large] = np.inf
        for p in self._at:
            start = process_time()
            found.append(solve(p))
            spent = (process_time() - start) / found[-1].passes
            self._pass_s[large] = min(self._pass_s[large], spent)
        return found

    def states(self, scene: Scene) -> list[States]:
        """With large displacements, or without."""
        found = self._found[scene.effects.large_displacement]
        force = [np.hypot(*state.force_N.T) for state in found]
        sites = Sites([self._assembly.wraps[p].first for p in self._at], [f.size for f in force])
        rotation = [state.rotation_rad for state in found]
        return [sites.effect_states(self._torque_Nm, rotation, force)]

    def price(self, scene: Scene) -> dict[str, Account]:
        """Number of contact problems times the cost of one."""
        large, torques = scene.effects.large_displacement, len(scene.torques_Nm)
        counted = predicted_work(scene, self._assembly)
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
                passes = states * _passes(self._found[True])
                stages["estimate"].cpu_s = passes * self._pass_s[True]
        for name, account in stages.items():
            account.counters |= counted[name]
        return stages


def _passes(found: list[WrapState]) -> float:
    """Number of contact problems of a state."""
    return sum(state.passes for state in found) / len(found)
