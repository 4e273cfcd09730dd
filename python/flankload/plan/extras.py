"""What each effect adds to the price of a run: the price with it less that without.

Compliances are priced anew by what is counted in them; the sweeps by how much longer one state
takes. What changes no state is priced by its work, as the table of effects has it.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from flankload.bodies import WholeMesh
from flankload.errors import FlankloadError
from flankload.mechanisms.flank_pair.prediction import predicted_work
from flankload.pairing.expansion import growth_of
from flankload.plan.price import SOLUTION_S, price_compliances, unknowns_of
from flankload.plan.variants import other_way
from flankload.scene.effects import effects_of

if TYPE_CHECKING:
    from flankload.cost import Account
    from flankload.pairing.body_pair import BodyPair
    from flankload.plan.coarse import Coarse
    from flankload.scene import Scene
    from flankload.scene.effects import Effect

#: Of the time of a sweep what goes with influence columns, and with contact problems.
COLUMNS_PART, SOLVES_PART = 0.35, 0.55
#: Places in the root fillets of a tooth; a whole body is read where its loads are solved for.
PLACES = 40
#: Bytes of a solution with the elements of a body, for each unknown: load and answer.
SOLUTION_BYTES = 16
#: A state that takes longer on coarse cells already tells on these how much longer it gets.
LARGE_S = 3e-3
#: CPU seconds for each two contact pairs of a problem with influence numbers of finite forces.
FINITE_S = 8e-7
#: Such problems a state until its forces rest, where that has not been looked at.
FINITE_SOLUTIONS = 4.0
#: Positions that smaller ones are timed at; no call of the core is over sooner.
TRIED, TINY_S = 8, 1e-5
SWEEPS = ("sweep", "tangent", "estimate")


class Extras:
    """Prices of the effects of one scene.

    Parameters
    ----------
    scene : Scene
    pair : BodyPair
        Its bodies, as the run builds them.
    stages : dict of str to Account
        Price of the run.
    coarse : Coarse
    """

    def __init__(
        self, scene: Scene, pair: BodyPair, stages: dict[str, Account], coarse: Coarse
    ) -> None:
        self._scene, self._pair, self._stages, self._coarse = scene, pair, stages, coarse
        self._torques = max(1, len(scene.torques_Nm))
        self._large = coarse.state_seconds(scene) > LARGE_S
        self._call_s = 0.0 if self._large else self._seconds_of_call()
        self._state_s = self._seconds_of_state(scene)
        self._states = self._states_of(scene)
        sweeps = [stages[name] for name in SWEEPS if name in stages]
        self._sweeps_s = sum(account.cpu_s for account in sweeps)
        self._sweep_bytes = sum(account.bytes + account.workspace_bytes for account in sweeps)

    def of(self, effect: Effect, *, on: bool) -> tuple[float, int]:
        """CPU seconds and bytes that an effect adds, or would add.

        Parameters
        ----------
        effect : Effect
        on : bool
            Whether the run has it.

        Returns
        -------
        seconds : float
        bytes : int
        """
        if effect.name == "several_torques":
            part = (self._torques - 1 if on else 1) / self._torques
            return self._sweeps_s * part, int(self._sweep_bytes * part)
        if effect.size_by == "nothing":
            return self._by_work(effect)
        try:
            variant = other_way(self._scene, effect.name, on=on)
            if variant is None:
                return 0.0, 0
            seconds, size = self._of_scene(variant.scene, effect.name)
        except FlankloadError:  # no such scene to compare with
            return 0.0, 0
        return (-seconds, -size) if on else (seconds, size)

    def _of_scene(self, scene: Scene, name: str) -> tuple[float, int]:
        """What another scene takes more than this one."""
        if name == "finite_influence":
            sweeps_s = self._seconds_of_finite(scene)
        else:
            # tables between nodes are read as fast as modes
            part = 1.0
            if name != "nodal_near_field":
                part = self._seconds_of_state(scene) / self._state_s
            states = self._states_of(scene).items()
            sweeps_s = part * sum(self._sweep_seconds(*of) for of in states) - self._sweeps_s
        pair = self._as(scene)
        small = self._coarse.pair(scene)
        other = price_compliances(
            predicted_work(scene, pair), pair, self._coarse.compliances(scene, small), small
        )
        mine = {name: self._stages[name] for name in self._stages if name.startswith("compliance")}
        elements_s, size = (
            sum(of(account) for account in other.values())
            - sum(of(account) for account in mine.values())
            for of in (_seconds, _bytes)
        )
        return sweeps_s + elements_s, int(size)

    def _as(self, scene: Scene) -> BodyPair:
        """The bodies as another scene sees them, as far as work is counted."""
        if scene.effects.near_field != self._scene.effects.near_field:
            return self._coarse.fine_pair(scene)
        growth = growth_of(scene, self._pair.pairing)
        return replace(self._pair, effects=effects_of(scene), growth=growth)

    def _seconds_of_finite(self, scene: Scene) -> float:
        """What another scene, with finite forces or without, takes more in its sweeps."""
        on = effects_of(scene).finite_influence
        solutions = self._coarse.finite_solutions(scene if on else self._scene)
        solutions = solutions or FINITE_SOLUTIONS
        counters = self._stages["sweep"].counters
        pairs = counters.get("influence_columns", 0) / max(1, self._states["sweep"])
        if not on:  # each solution has columns of its own
            pairs /= solutions + 1
        seconds = FINITE_S * pairs**2 * solutions * sum(self._states.values())
        return seconds if on else -seconds

    def _sweep_seconds(self, stage: str, states: int) -> float:
        """So many states in a stage, if they were those of this scene."""
        like = stage if stage in self._stages else "sweep"
        return self._stages[like].cpu_s * states / max(1, self._states.get(like, 1))

    def _states_of(self, scene: Scene) -> dict[str, int]:
        """States of the sweeps; of adaptive positions those to begin with."""
        counted = predicted_work(scene, replace(self._as(scene), adaptive=False))
        return {name: counted[name]["states"] for name in SWEEPS if name in counted}

    def _seconds_of_call(self) -> float:
        """What a call takes beside its states, whatever they are."""
        grid = self._pair.discretization.grid
        one, few = (self._coarse.fine_seconds(self._scene, grid, few=n) for n in (1, TRIED))
        return max(0.0, one - (few - one) / (TRIED - 1))

    def _seconds_of_state(self, scene: Scene) -> float:
        if self._large:
            return self._coarse.state_seconds(scene)
        grid = self._pair.discretization.grid
        return max(TINY_S, self._coarse.fine_seconds(scene, grid, few=TRIED) - self._call_s)

    def _by_work(self, effect: Effect) -> tuple[float, int]:
        """By the work that stands in the table."""
        work = effect.work
        seconds = self._sweeps_s * (COLUMNS_PART * work.columns + SOLVES_PART * work.solves)
        size = 0.0
        for z, body in enumerate((self._pair.body_1, self._pair.body_2)):
            account = self._stages.get(f"compliance body {z + 1}")
            if account is None or body.mesh is None:
                continue
            loads = account.counters.get("unit_loads_normal", 0)
            columns = (
                work.growth_loads
                + (work.normal_loads + work.tangential_loads + work.coast_readings) * loads
                + work.recoveries * (0 if isinstance(body.mesh, WholeMesh) else PLACES)
            )
            unknowns = unknowns_of(body)
            seconds += columns * SOLUTION_S * unknowns
            size += columns * SOLUTION_BYTES * unknowns
        return seconds, int(size)


def _seconds(account: Account) -> float:
    return account.cpu_s


def _bytes(account: Account) -> int:
    return account.bytes + account.workspace_bytes
