"""What each effect adds to the price of a run, by its work as the table of effects has it."""

from __future__ import annotations

from math import prod
from typing import TYPE_CHECKING

from flankload.bodies import WholeMesh
from flankload.effects import EFFECTS, switches_of
from flankload.plan.price import SOLUTION_S, unknowns_of

if TYPE_CHECKING:
    from flankload.assembly import BodyPair
    from flankload.cost import Account
    from flankload.effects import Effect
    from flankload.scene import Scene

#: Of the time of a sweep what goes with influence columns, and with contact problems.
COLUMNS_PART, SOLVES_PART = 0.35, 0.55
#: Pairs at which columns that make K unsymmetric cost twice as much.
UNSYMMETRIC_PAIRS = 350
#: Places in the root fillets of a tooth; a whole body is read where its loads are solved for.
PLACES = 40
#: Bytes of a solution with the elements of a body, for each unknown: load and answer.
SOLUTION_BYTES = 16
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
    """

    def __init__(self, scene: Scene, pair: BodyPair, stages: dict[str, Account]) -> None:
        self._pairs = _pairs_of(stages)
        self._torques = max(1, len(scene.torques_Nm))
        self._stages = stages
        self._bodies = {
            f"compliance body {z + 1}": body
            for z, body in enumerate((pair.body_1, pair.body_2))
            if body.mesh is not None
        }
        on = [effect for effect in EFFECTS if switches_of(scene)[effect.name].on]
        sweeps = [stages[name] for name in SWEEPS if name in stages]
        part = prod(
            1.0 + self._sweeps_part(effect) for effect in on if effect.name != "several_torques"
        )
        self._plain_s = sum(account.cpu_s for account in sweeps) / part
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
        if effect.name in ("elastic_body_1", "elastic_body_2"):
            account = self._stages.get(f"compliance body {effect.name[-1]}")
            if account is None:
                return 0.0, 0
            return account.cpu_s, account.bytes + account.workspace_bytes
        if effect.name == "several_torques":
            count = self._torques - 1 if on else 1
            part = count / self._torques
            return self._plain_s * part, int(self._sweep_bytes * part)
        seconds = self._plain_s * self._sweeps_part(effect)
        size = 0.0
        for stage, body in self._bodies.items():
            if stage not in self._stages:
                continue
            loads = self._stages[stage].counters.get("unit_loads_normal", 0)
            work, unknowns = effect.work, unknowns_of(body)
            columns = (
                work.growth_loads
                + (work.normal_loads + work.tangential_loads + work.coast_readings) * loads
                + work.recoveries * (0 if isinstance(body.mesh, WholeMesh) else PLACES)
            )
            seconds += columns * SOLUTION_S * unknowns
            size += columns * SOLUTION_BYTES * unknowns
        return seconds, int(size)

    def _sweeps_part(self, effect: Effect) -> float:
        """What an effect adds to the sweeps, over what they take without it."""
        columns = COLUMNS_PART * effect.work.columns
        if effect.work.unsymmetric:
            columns *= 1.0 + self._pairs / UNSYMMETRIC_PAIRS
        return columns + SOLVES_PART * effect.work.solves


def _pairs_of(stages: dict[str, Account]) -> float:
    """Contact pairs of a state."""
    counters = stages["sweep"].counters
    return counters.get("influence_columns", 0) / max(1, counters.get("contact_passes", 0))
