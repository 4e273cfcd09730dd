"""Coarse runs of a scene, as it is and with each of its effects switched: sizes and costs.

The size of an effect is the difference of two coarse runs. The cost of a run is that of its coarse
run, stage by stage, times the ratio of their exact counters. All runs share bodies and compliances.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from msgspec import structs

from flankload.cost import Account, held_bytes
from flankload.errors import FlankloadError, PremiseError
from flankload.mechanisms import Earlier, Parts, mechanism_of, run_once
from flankload.mechanisms.effect_size import States, size_of
from flankload.mechanisms.parameters import (
    CELLS_WORK,
    FINITE_SECONDS,
    STATES_SECONDS,
    relative,
)
from flankload.mechanisms.premises import require_premises
from flankload.mechanisms.stage_clock import ELEMENTS
from flankload.mechanisms.toggles import Toggle, toggles, without_keys
from flankload.scene.effects import effects_of, known_effects, switches_of
from flankload.scene.pair import Positions
from flankload.scene.steps import STRIPS
from flankload.studies.coarse import NODES_APART, coarse

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flankload.mechanisms.effect_size import Size
    from flankload.mechanisms.parameters import Values
    from flankload.result import Result
    from flankload.scene import Scene
    from flankload.scene.effects import Effect

#: Effects that are not tried while off, unless `levels` is set: coarser contact models, which are
#: rarely wanted; finite influence coefficients and forces at nodes, which cost a multiple; coast
#: flanks, since a scene in which they touch but are not allowed is refused.
LEVELS_ONLY = (
    *("segment", "single_tooth", "nodal_near_field"),
    *("finite_influence", "lumped_contact", "coast_flanks"),
)
#: Number of positions at which effects are switched.
POSITIONS = 8
#: Final number of adaptive positions relative to the first round, approximately.
ADAPTIVE_PART = 3.0
#: Reason for a missing size of three dimensions.
SKIPPED = "its elements are solved with --dimension only"


@dataclass(frozen=True)
class Measured:
    """Size of an effect, or the reason for a missing size."""

    size: Size | None = None
    unknown: str | None = None


class CoarseRuns:
    """Coarse runs of a scene and of its toggles.

    Attributes
    ----------
    effects : tuple of Effect
        Effects that the scene may have.
    toggles : mapping of str to Toggle
        The scene with each of them switched; without those that are not tried.

    Raises
    ------
    PremiseError
        If the least or the largest torque violates a premise of the model.
    FlankloadError
        If a position has no solution.
    """

    def __init__(self, scene: Scene, *, levels: bool = False, dimension: bool = False) -> None:
        self.scene = scene
        self.effects: tuple[Effect, ...] = known_effects(scene)
        on = {name: switch.on for name, switch in switches_of(scene).items()}
        self.toggles: dict[str, Toggle] = {
            name: toggle
            for name, toggle in toggles(scene, [effect.name for effect in self.effects]).items()
            if levels or name not in LEVELS_ONLY or on[name] or toggle.impossible
        }
        spatial = self.toggles.get("three_dimensions")
        if spatial is not None and spatial.scene and not (dimension or on["three_dimensions"]):
            self.toggles["three_dimensions"] = Toggle(None, skipped=SKIPPED)
        friction = self.toggles.get("friction", Toggle(None))
        # of lumped contacts, the sweeps of an estimate cost what their states do
        estimate = scene.accuracy.estimate and not effects_of(scene).lumped_contact
        self._parts = Parts(
            tangential=on["friction"] or friction.scene is not None, estimate=estimate
        )
        self._assemblies: dict[Scene, tuple[Any, Account]] = {}
        self._runs: dict[Scene, tuple[Result, ...]] = {}
        require_premises(scene, mechanism_of(scene).broken_by_geometry(self._assembly(scene)[0]))
        run = coarse(scene, self._parts)
        accuracy = structs.replace(run.accuracy, estimate=estimate)
        self._spent = self._solved(scene, replace(run, accuracy=accuracy))
        at = self._spent[0].position_rad
        self._every = slice(None, None, max(1, -(-at.size // POSITIONS)))
        self._angles_deg = tuple(np.degrees(at[self._every]).tolist())
        self.base = _states(self._spent, self._every)
        unloaded = self._spent[0].unloaded_rotation_rad
        if unloaded is None:  # of a drive: friction alone would turn its wheel
            still = replace(scene, load=structs.replace(scene.load, torque_Nm=0.0))
            (unmoved,) = self._run(without_keys(still, "land_friction"))
            self._unloaded_rad = unmoved.rotation_rad
        else:
            self._unloaded_rad = unloaded[self._every]

    def _run(self, scene: Scene) -> tuple[Result, ...]:
        """Coarse run at few positions, without estimate, also beyond the limits."""
        if scene not in self._runs:
            run = coarse(scene, self._parts)
            positions = Positions(angles_deg=self._angles_deg, driver=run.positions.driver)
            accuracy = structs.replace(run.accuracy, estimate=False)
            effects = structs.replace(run.effects, beyond_limits=True)
            run = replace(run, positions=positions, accuracy=accuracy, effects=effects)
            self._runs[scene] = self._solved(scene, run, unloaded=False)
        return self._runs[scene]

    def _solved(self, scene: Scene, run: Scene, *, unloaded: bool = True) -> tuple[Result, ...]:
        """Run under the least and the largest torque of a scene."""
        loaded = [torque for torque in scene.torques_Nm if torque > 0]
        torques = tuple(dict.fromkeys((min(loaded), max(loaded)))) if loaded else (0.0,)
        effects = structs.replace(run.effects, root_stress=False)
        torque_Nm = torques if scene.has_torque_list else torques[0]
        run = replace(run, effects=effects)
        few = replace(run, load=structs.replace(run.load, torque_Nm=torque_Nm))
        earlier = Earlier(parts=self._parts, unloaded=unloaded)
        try:
            return run_once(few, earlier=earlier)
        except PremiseError:
            run_once(run, earlier=earlier)  # names the torque by its place among all
            raise

    # --- sizes ------------------------------------------------------------------------------------
    def measured(self, names: tuple[str, ...] | None = None) -> dict[str, Measured]:
        """The size of each effect, or of those with some names, or why it has none."""
        on = {name: switch.on for name, switch in switches_of(self.scene).items()}
        found = {}
        for effect in self.effects:
            name = effect.name
            toggle = self.toggles.get(name)
            if toggle is None or (names is not None and name not in names):
                found[name] = Measured()
            elif toggle.impossible is not None:
                found[name] = Measured(unknown=f"{IMPOSSIBLE}: {toggle.impossible}")
            elif toggle.skipped is not None:
                found[name] = Measured(unknown=toggle.skipped)
            else:
                try:
                    found[name] = Measured(self._size(effect, toggle, on=on[name]))
                except FlankloadError as error:
                    found[name] = Measured(unknown=" ".join(str(error).split()))
        return found

    def _size(self, effect: Effect, toggle: Toggle, *, on: bool) -> Size | None:
        """Results with the effect minus results without it; None if it changes no state."""
        if toggle.scene is None or effect.size_by == "nothing":
            return None
        size = self.change(toggle.scene, on=on)
        if effect.size_by == "spacing":  # proportional to it
            return size.times(1.0 / NODES_APART)
        if effect.size_by == "cells":  # proportional to their width
            scenes = coarse(self.scene), self.scene
            few, many = (_values(each, None)[STRIPS] for each in scenes)
            return size.times(few / many)
        return size

    def change(self, scene: Scene, *, on: bool = False) -> Size:
        """The change from this scene to another one; the other way round if `on`."""
        other = _states(self._run(scene))
        return size_of(
            *((self.base, other) if on else (other, self.base)),
            base=self.base,
            unloaded_rad=self._unloaded_rad,
            reference_radius_mm=self._spent[0].reference_radius_mm,
        )

    # --- cost -------------------------------------------------------------------------------------
    def _assembly(self, scene: Scene) -> tuple[Any, Account]:
        """Bodies of a scene with its own discretization, and their cost."""
        if scene not in self._assemblies:
            with Account() as account:
                built = mechanism_of(scene).build(scene, None, self._parts, account=account)
            account.bytes = held_bytes(built)
            self._assemblies[scene] = built, account
        return self._assemblies[scene]

    def price(self, scene: Scene) -> dict[str, Account]:
        """CPU seconds, bytes and counters by stage of the run of this scene or of a toggle."""
        assembly, (_, bodies) = self._assembly(scene)[0], self._assembly(self.scene)
        counted = mechanism_of(scene).work(scene, assembly)
        spent = own = self._spent[0].cost["stages"]
        if scene in self._runs or not all(_spent_on(name, own, spent) for name in counted):
            own = spent | self._run(scene)[0].cost["stages"]
        run = coarse(scene, self._parts)
        wanted, few = (_values(each, self._parts) for each in (scene, run))
        part = ADAPTIVE_PART if scene.positions.adaptive else 1.0
        states = part * assembly.position_rad.size * len(scene.torques_Nm)
        more = _More(
            states=states / (self._spent[0].position_rad.size * len(self._spent)),
            state_s=relative(
                FINITE_SECONDS if scene.effects.influence == "finite" else STATES_SECONDS,
                wanted,
                few,
            ),
            cells=relative(CELLS_WORK, wanted, few),
        )
        stages = {
            name: more.scaled(_spent_on(name, own, spent), counters)
            for name, counters in counted.items()
            if name != "bodies"
        }
        slower = _state_s(own) / max(_state_s(spent), TINY_S)
        for name in STATES & stages.keys():
            stages[name].cpu_s *= slower
        return {"bodies": replace(bodies, counters=dict(counted["bodies"])), **stages}


def _values(scene: Scene, parts: Parts | None) -> Values:
    """Discretization parameters of a scene."""
    return mechanism_of(scene).parameters(scene, parts).values


def _spent_on(name: str, own: Mapping[str, Any], base: Mapping[str, Any]) -> Mapping[str, Any]:
    """Cost of a coarse run in a stage: for its own elements, for the states of the scene."""
    if not name.startswith(ELEMENTS):
        found: Mapping[str, Any] = base.get(name, base["sweep"])
        return found
    both = (own, base)
    named = [stages[name] for stages in both if name in stages]
    # equal bodies are solved once
    equal = (part for stages in both for key, part in stages.items() if key.startswith(ELEMENTS))
    return next(iter((*named, *equal)), {})


def _state_s(stages: Mapping[str, Any]) -> float:
    """Seconds of a state."""
    sweep = stages["sweep"]
    seconds: float = sweep["cpu_s"] / sweep["counters"]["states"]
    return seconds


def _states(results: tuple[Result, ...], which: slice = slice(None)) -> list[States]:
    """Curves of each torque at some of the positions."""
    return [
        States.of(
            result.torque_Nm,
            result.sites,
            result.rotation_rad[which],
            result.site_force_N[which],
            result.width_loads.factor_of(which),
        )
        for result in results
    ]


@dataclass(frozen=True)
class _More:
    """A run over its coarse run: number of states, seconds and cells of one."""

    states: float
    state_s: float
    cells: float

    def scaled(self, spent: Mapping[str, Any], counted: Mapping[str, int]) -> Account:
        """Cost of a stage from that of the coarse run and from the exact counters."""
        own = spent["counters"]
        exact = {name: number for name, number in counted.items() if name != "bytes"}
        if own.get("fe_unknowns"):
            size = seconds = exact.get("fe_unknowns", 0) / own["fe_unknowns"]
            further: dict[str, int] = {}
        elif own.get("states"):
            size = exact.get("states", self.states * own["states"]) / own["states"]
            columns = own.get("influence_columns", 0)
            cells = self.cells
            if columns and exact.get("influence_columns"):
                cells = exact["influence_columns"] / columns / size
            seconds = size * max(cells, self.state_s)
            further = {
                name: round(number * size * (cells if name in WITH_CELLS else 1.0))
                for name, number in own.items()
            }
            size *= cells
        else:  # read from a file
            size, seconds, further = 1.0, 1.0, {}
        return Account(
            cpu_s=spent["cpu_s"] * seconds,
            bytes=counted.get("bytes", round(spent["bytes"] * size)),
            workspace_bytes=round(spent["workspace_bytes"] * size),
            counters={**further, **exact},
        )


#: Stages of states, and least seconds of one: the resolution of clocks.
STATES, TINY_S = {"sweep", "estimate"}, 1e-7
#: Counters that grow with the number of cells.
WITH_CELLS = ("influence_columns", "influence_columns_tangential", "pivots", "refactorisations")
#: Beginning of the reason for a missing size, if a scene cannot have the effect.
IMPOSSIBLE = "not with this scene"
