"""Screening of two bodies with flanks: gears, rings, splines, cams.

Each effect is another sweep of few positions, with few modes and wide cells; what the sweeps take
stands in `pair_models`. The run costs what its bodies, elements and states took here, scaled by
what is counted.

Nodal forces lead to the same states as pressure modes at a hundred times the cost, so none are
solved for. Their error depends on the node spacing divided by the half-width of the contact;
docs/guide/effects.md compares the law with runs.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import log
from time import process_time
from typing import TYPE_CHECKING

import numpy as np

from flankload.analysis.load_factors import face_load_factor
from flankload.bodies import SectorMesh
from flankload.cost import Account, held_bytes
from flankload.elasticity.nodal_loads import nodes_of
from flankload.errors import ContactError
from flankload.mechanisms.effect_size import Size, States
from flankload.mechanisms.element_rates import unknowns_of
from flankload.mechanisms.flank_pair.assembly import build_bodies
from flankload.mechanisms.flank_pair.pair_models import COARSE, PairModels, screened
from flankload.mechanisms.flank_pair.prediction import (
    elements_estimated,
    estimate_sweeps,
    predicted_work,
    states_of,
)
from flankload.mechanisms.flank_pair.premises import blame_load, broken_by_geometry, broken_by_load
from flankload.mechanisms.flank_pair.stages import contact_of, expanded_pair, swept
from flankload.mechanisms.premises import require_premises
from flankload.mechanisms.screening import Screening
from flankload.mechanisms.toggles import Toggle, toggles, with_keys
from flankload.pairing.body_pair import BodyPair
from flankload.pairing.node_spacing import half_widths_apart, spacing_for_loads
from flankload.result.geometry import PairGeometry, pair_geometry
from flankload.scene.discretization import Grid
from flankload.scene.effects import EFFECTS, effects_of

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from flankload.base.arrays import Floats
    from flankload.contact.sweep import Sweep
    from flankload.scene import Scene


#: Number of positions of the screening; with the run's own cells if sizes are compared on them, and
#: if only seconds are measured; with finite forces.
MOST_POSITIONS, FINE_POSITIONS, TIMED_POSITIONS, FINITE_POSITIONS = 8, 4, 3, 4
#: Final number of adaptive positions relative to the first round, approximately.
ADAPTIVE_PART = 3.0
#: Effects that are not tried while off, unless `levels` is set: coarser contact models, which are
#: rarely wanted; finite influence coefficients, which cost a hundred times as much; and coast
#: flanks, since a scene in which they touch but are not allowed is refused.
OFF = (
    "segment",
    "single_tooth",
    "nodal_near_field",
    "finite_influence",
    "lumped_contact",
    "coast_flanks",
)
SPATIAL = "three_dimensions"
#: Effects that do not exist for flanks.
OF_DRIVES = ("large_displacement", "land_friction", "land_lift")
#: Evaluation points in the root fillets of a tooth.
PLACES = 40
#: Part of the wind-up per half-width of node spacing: largest at a position, and mean.
LARGEST, MEAN = 0.06, 0.02
#: Limits for nodes much further apart than the contact width, independent of their spacing: for
#: both bodies; for one body in addition to the error of the other; for one body in the mean.
MOST_LARGEST, MOST_BEYOND, MOST_MEAN = 0.22, 0.056, 0.1
#: Load share divided by the difference between largest and mean amount.
SHARE = 1.5
#: Least duration of a call of the core, s.
TINY_S = 1e-5
#: Of conforming flanks, a state on twice as many cells takes 1.6 to 3 times as long, and 1.1 to 1.4
#: times as many pivots, influence columns and bytes.
MORE_SECONDS, MORE_WORK = 2.0, 1.3
MORE_ON_FINER = ("pivots", "influence_columns", "influence_columns_tangential")
#: CPU seconds of the plane elements behind the error estimate of a prism, as part of the prism's.
SECTION_PART = 0.1


@dataclass(frozen=True)
class StateRate:
    """CPU seconds of a sweep."""

    call_s: float
    state_s: float
    coarser_s: float
    sweep: Account
    states: int


class FlankPairScreening(Screening):
    """The effects of a scene on a coarse discretization, and what its run will cost.

    With `levels`, coarser contact models that are off are tried as well; with `dimension`, three
    dimensions in a plane scene, however short its run is.

    Raises
    ------
    PremiseError
        If the least or the largest torque violates a premise of the model.
    FlankloadError
        If a position has no solution.
    """

    def __init__(self, scene: Scene, *, levels: bool = False, dimension: bool = False) -> None:
        self._scene = scene
        with Account() as self._bodies:
            self._pair = build_bodies(scene)
        require_premises(scene, broken_by_geometry(self._pair))
        self._bodies.bytes = held_bytes(self._pair)
        known = [row for row in EFFECTS if row.name not in OF_DRIVES]
        teeth = self._pair.pairing.motion is None
        self.rows = tuple(row.name for row in known if teeth or not row.of_teeth)
        effects = self._pair.effects
        self.toggles: dict[str, Toggle] = {
            name: self._tried(name, toggle, dimension=dimension)
            for name, toggle in toggles(scene, self.rows).items()
            if levels or name not in OFF or getattr(effects, name) or toggle.impossible
        }
        at = self._pair.position_rad
        self._at = at[_every(at, MOST_POSITIONS)]
        loaded = [torque for torque in scene.torques_Nm if torque > 0]
        self._torques = tuple(dict.fromkeys((min(loaded), max(loaded)))) if loaded else (0.0,)
        self._state_s: dict[Scene, float] = {}
        self._models = PairModels(scene, self._pair, self.toggles)
        base, self._base_s = self._first_states()
        self._check_load(base)
        self.base = self._states(self._models.screened, base)
        self.unloaded_rad, call_s = self.base[0].rotation_rad, 0.0
        if loaded:
            (unloaded,), call_s = self._timed(self._models.screened, torques_Nm=(0.0,))
            self.unloaded_rad = unloaded.rotation_rad
        self.reference_radius_mm = self._pair.body_1.reference_radius_mm
        # states without torque take little time beside the call itself
        self._rate = self._state_rate(min(call_s, 0.5 * self._base_s))

    def _tried(self, name: str, toggle: Toggle, *, dimension: bool) -> Toggle:
        """The toggle; without a scene if it adds a dimension that is not requested."""
        if name != SPATIAL or toggle.scene is None or self._pair.slices is not None or dimension:
            return toggle
        return Toggle(None, skipped="its elements are solved with --dimension only")

    # --- sizes ------------------------------------------------------------------------------------
    def size(self, name: str, *, on: bool) -> Size | None:
        """Return the size of an effect; four effects have rules of their own."""
        scene = self.toggles[name].scene
        if scene is None:
            return None
        if name == "nodal_near_field":
            nodal = self._scene if on else scene
            return nodal_size(nodal, self._pair, self.base[0], self.unloaded_rad)
        if name == "finite_influence":
            return self._finite_size(scene, on=on)
        if name == "lumped_contact":
            # contact pairs in slices take as long as all other states together
            return self._with_fine_cells(scene, on=on, fewer=1 if self._pair.slices is None else 2)
        if name == SPATIAL:
            return self._with_fine_cells(scene, on=on, mine=None if on else self._sections())
        return super().size(name, on=on)

    def change(self, scene: Scene) -> Size:
        """Change by another scene; without cells against the cells of the run."""
        if effects_of(scene).lumped_contact and not self._pair.effects.lumped_contact:
            return self._with_fine_cells(scene, on=False)
        return super().change(scene)

    def _sections(self) -> list[States]:
        """States of the plane scene on the elements of its coarse three-dimensional bodies."""
        few, torque = _every(self._at, FINE_POSITIONS), self._torques[-1:]
        found, _ = self._timed(self._scene, few, torque, fine=True, sections=True)
        return self._states(self._scene, found)

    def _with_fine_cells(
        self, scene: Scene, *, on: bool, mine: list[States] | None = None, fewer: int = 1
    ) -> Size:
        """Change by a scene that differs in its cells or slices, with those of the run.

        By default with those of the scene itself, at each `fewer`-th of their positions.
        """
        few = slice(None, None, fewer * _every(self._at, FINE_POSITIONS).step)
        found, seconds = self._timed(screened(scene), few, self._torques[-1:], fine=True)
        more = MORE_SECONDS if self._timed_grid != self._grid else 1.0
        state_s = max(TINY_S, (seconds - self._rate.call_s) / found[0].status.size)
        self._state_s[scene] = more * state_s
        other = self._states(screened(scene), found)
        mine = mine or self._states(self._scene, self._fine, slice(None, None, fewer))
        return self.between(other, on=on, mine=mine, which=few)

    def states(self, scene: Scene) -> list[States]:
        """States with other effects; how much longer each takes is kept."""
        found, seconds = self._timed(screened(scene))
        other, mine = (max(TINY_S, each - self._rate.call_s) for each in (seconds, self._base_s))
        self._state_s[scene] = self._rate.state_s * other / mine
        return self._states(screened(scene), found)

    def _finite_size(self, scene: Scene, *, on: bool) -> Size | None:
        """Size of finite influence coefficients: their effect is proportional to the cell width."""
        if self._pair.pairing.whole_circle:  # a conforming flank has too many pairs for that
            return None
        few = _every(self._at, FINITE_POSITIONS)
        finite = with_keys(self._models.screened, influence="finite")
        found, seconds = self._timed(finite, few, self._torques[-1:])
        finer = self._grid.strips_per_half_width / COARSE.grid.strips_per_half_width
        # each two pairs have numbers of their own; beside these the call itself takes no time
        more = finer**2 * seconds / found[0].status.size
        self._state_s[scene] = max(TINY_S, self._rate.state_s + (-more if on else more))
        return self.between(self._states(finite, found), on=False, which=few).times(1.0 / finer)

    @property
    def _grid(self) -> Grid:
        """Cells of the run."""
        return self._pair.discretization.grid

    @property
    def _timed_grid(self) -> Grid:
        """Cells on which states are timed: of conforming flanks half as many as in the run."""
        return self._grid.coarser() if self._pair.pairing.whole_circle else self._grid

    def _states(
        self, scene: Scene, found: tuple[Sweep, ...], which: slice = slice(None)
    ) -> list[States]:
        pair = self._models.assembly(scene)
        return [
            States.of(
                part.torque_Nmm / 1000.0,
                pair.pairing.sites,
                part.rotation_rad[which],
                part.site_force_N[which],
                face_load_factor=_face_load_factor(part, which),
            )
            for part in found
        ]

    def _timed(
        self,
        scene: Scene,
        few: slice = slice(None),
        torques_Nm: tuple[float, ...] | None = None,
        account: Account | None = None,
        *,
        fine: bool = False,
        sections: bool = False,
    ) -> tuple[tuple[Sweep, ...], float]:
        """The sweep of some positions on wide cells or few slices, or those of the run; seconds."""
        pair = self._models.assembly(scene)
        if pair.slices is not None and not fine:
            pair = replace(pair, slices=pair.slices.coarser())
        models = self._models
        found_of = models.sections(pair) if sections else models.compliances(scene, pair)
        pair, compliances = expanded_pair(pair, found_of)
        torques, start = self._torques if torques_Nm is None else torques_Nm, process_time()
        found = swept(
            contact_of(scene, pair, compliances, self._timed_grid if fine else COARSE.grid),
            self._at[few],
            [1000.0 * torque for torque in torques],
            keep_pairs=account is not None,
            account=account,
            watched=False,
        )
        return found, process_time() - start

    def _check_load(self, base: tuple[Sweep, ...]) -> None:
        """Refuse a scene whose least or largest torque violates a premise of the model."""
        pair, geometry = self._geometry()
        for torque, found in zip(self._torques, base, strict=True):
            number = self._scene.torques_Nm.index(torque)
            require_premises(
                self._scene, broken_by_load(self._scene, pair, geometry, found, number)
            )

    def _geometry(self) -> tuple[BodyPair, PairGeometry]:
        pair = replace(self._models.assembly(self._models.screened), position_rad=self._at)
        pair, compliances = expanded_pair(
            pair, self._models.compliances(self._models.screened, pair)
        )
        return pair, pair_geometry(pair, compliances)

    def _first_states(self) -> tuple[tuple[Sweep, ...], float]:
        """States of the scene; without any, check the premises under a part of the torque."""
        try:
            return self._timed(self._models.screened)
        except ContactError as error:
            pair, geometry = self._geometry()

            def again(torque_Nmm: float) -> tuple[Sweep, ...]:
                return self._timed(self._models.screened, torques_Nm=(torque_Nmm / 1000.0,))[0]

            blame_load(self._scene, pair, geometry, error, again)
            raise

    # --- cost -------------------------------------------------------------------------------------
    def price(self, scene: Scene) -> dict[str, Account]:
        """CPU seconds, bytes and counters by stage for the run of a scene with other effects."""
        nodal = effects_of(scene).nodal_near_field and not self._pair.effects.nodal_near_field
        pair = self._pair if nodal else self._models.assembly(scene)
        counted = predicted_work(scene, pair)
        stages = {"bodies": replace(self._bodies, counters={})}
        smoothing = 0.0
        for z in (0, 1):
            name = f"compliance body {z + 1}"
            if name not in counted:
                continue
            if pair.slices is not None:
                body, counters = pair.bodies[z], counted[name]
                if pair.effects.root_stress and pair.fillets[z] is None:  # of another scene
                    counters = counters | {"stress_recoveries": PLACES}
                stages[name] = self._models.prism_rates[z].price(scene, body, counters)
                smoothing += stages[name].cpu_s * SECTION_PART * (z in elements_estimated(pair))
                continue
            if z not in self._models.rates:  # it comes from a file
                stages[name] = Account(bytes=held_bytes(self._models.compliance(scene, pair, z)))
                continue
            counters, finer = counted[name], 1.0
            if self._pair.slices is not None:  # of its section, on coarse elements
                finer = unknowns_of(self._pair.bodies[z]) / unknowns_of(self._models.rates[z].body)
            if nodal:
                finer, counters = self._nodal(scene, pair, z, counters)
            fillets, places = pair.fillets[z], 0
            if fillets is not None:
                places = int(fillets.points.arc_length_mm.size)
            elif pair.effects.root_stress:  # of another scene: so many, about
                places = PLACES * isinstance(self._models.rates[z].body.mesh, SectorMesh)
                counters = counters | {"fe_solutions": counters["fe_solutions"] + places}
            stages[name] = self._models.rates[z].price(counters, places=places, finer=finer)
            stages[name].bytes += held_bytes(fillets.points) if fillets is not None else 0
            if z in elements_estimated(pair):
                smoothing += self._models.rates[z].smoothing_s(counters)
        stages |= self._sweeps(scene, pair)
        if "estimate" in stages:
            stages["estimate"].cpu_s += smoothing
        for name, account in stages.items():
            account.counters |= counted.get(name, {})
        return stages

    def _nodal(
        self, scene: Scene, pair: BodyPair, z: int, counters: dict[str, int]
    ) -> tuple[float, dict[str, int]]:
        """Factors of unknowns and loads if nodes are close enough for nodal forces."""
        body, spacing = pair.bodies[z], _node_spacings(scene, pair)[z]
        if spacing is None or body.mesh is None:
            return 1.0, counters
        low, high = body.mode_range_mm
        nodes = round((high - low) / spacing) + 1
        loads = counters["unit_loads_normal"]
        more = {
            "unit_loads_normal": nodes,
            "fe_solutions": counters["fe_solutions"] + nodes - loads,
        }
        return max(1.0, nodes / (body.mesh.flank_elements + 1)), counters | more

    def _sweeps(self, scene: Scene, pair: BodyPair) -> dict[str, Account]:
        """Cost of the sweeps of the run: number of states times cost of a state."""
        rate = self._rate
        slower = self._state_s.get(scene, rate.state_s) / rate.state_s
        positions = pair.position_rad.size * (ADAPTIVE_PART if pair.adaptive else 1.0)
        stages = {}
        for name, torques in states_of(scene, pair).items():
            calls, state_s, counters = 1, rate.state_s, rate.sweep.counters
            if name == "estimate":
                calls, state_s, counters = estimate_sweeps(pair), rate.coarser_s, {}
            states = positions * torques
            part = states / rate.states
            stages[name] = Account(
                cpu_s=calls * rate.call_s + states * state_s * slower,
                bytes=round(rate.sweep.bytes * part) if name == "sweep" else 0,
                workspace_bytes=round(rate.sweep.workspace_bytes * part),
                counters={key: round(count * part) for key, count in counters.items()},
            )
        return stages

    def _state_rate(self, call_s: float) -> StateRate:
        """Measure the seconds of a state on the run's own cells, and on cells twice as wide.

        Of conforming flanks on cells twice as wide only.
        """
        compared = self._pair.slices is not None or "lumped_contact" in self.toggles
        few = _every(self._at, FINE_POSITIONS if compared else TIMED_POSITIONS)
        torque, account = self._torques[-1:], Account()
        found, seconds = self._timed(self._scene, few, torque, account, fine=True)
        self._fine, count = found, found[0].status.size
        account.bytes = held_bytes(found)
        state = max(TINY_S, (seconds - call_s) / count)
        if self._timed_grid != self._grid:
            for name in MORE_ON_FINER:
                account.counters[name] = round(MORE_WORK * account.counters.get(name, 0))
            account.bytes = round(MORE_WORK * account.bytes)
            return StateRate(call_s, MORE_SECONDS * state, state, account, count)
        wide = max(TINY_S, (self._base_s - call_s) / (self._at.size * len(self._torques)))
        cells = self._grid.strips_per_half_width / COARSE.grid.strips_per_half_width
        ratio = cells if self._pair.slices is None else 1.0  # slices stay in most of the estimate
        # by the power law between both
        power = log(state / wide) / log(ratio) if ratio > 1.0 and state > wide else 0.0
        return StateRate(call_s, state, state * 0.5**power, account, count)


def _face_load_factor(found: Sweep, which: slice) -> float | None:
    """K_Hbeta of some positions, which have equal parts in the mean; None in the plane."""
    if found.slices is None:
        return None
    weights = np.zeros(found.status.size)
    weights[which] = 1.0
    return face_load_factor(found, weights)


def _every(positions: Floats, most: int) -> slice:
    """At most so many of some positions, evenly spread, the first among them."""
    return slice(None, None, max(1, -(-positions.size // most)))


# --- nodal forces ---------------------------------------------------------------------------------
def _node_spacings(scene: Scene, pair: BodyPair) -> list[float | None]:
    """Node spacing of each body, mm, if the scene had nodal forces; None without elements.

    `pair` is that of the scene, with or without nodal forces.
    """
    bodies = pair.bodies
    wanted = scene.accuracy.flank_element_mm
    if wanted is None:
        wanted = spacing_for_loads(bodies, scene.torques_Nm, scene.pair.face_width_mm)
    spacings: list[float | None] = []
    for z, body in enumerate(bodies):
        if body.mesh is None or body.rigid:
            spacings.append(None)
        elif pair.effects.nodal_near_field or f"body_{z + 1}.file" in scene.files:
            spacings.append(float(np.diff(nodes_of(body.mesh)).max()))
        else:
            spacings.append(wanted)
    return spacings


def nodal_size(
    scene: Scene, pair: BodyPair, states: States, unloaded_rad: NDArray[np.float64]
) -> Size | None:
    """Size of the effect of nodal forces; None without torque, or if neither body has elements.

    `scene` has nodal forces; `states` are those of the least torque: the narrowest contact has the
    largest error. `unloaded_rad` (P,) is the rotation without torque.
    """
    spacings = [each for each in _node_spacings(scene, pair) if each is not None]
    if not spacings or states.torque_Nm <= 0.0:
        return None
    bodies = pair.bodies
    least = half_widths_apart(bodies, min(spacings), states.torque_Nm, scene.pair.face_width_mm)
    if least is None:
        return None
    parts = np.array(spacings) * least / min(spacings)
    both, beyond = parts.min(), parts.max() - parts.min()
    largest = min(LARGEST * both, MOST_LARGEST) + min(0.5 * LARGEST * beyond, MOST_BEYOND)
    mean = float(np.minimum(MEAN * parts, MOST_MEAN).mean())
    wind_up = float(np.max(states.rotation_rad - unloaded_rad))
    return Size(
        rotation_mean=-mean,
        rotation_largest=float(largest),
        rotation_um=1000.0 * pair.body_1.reference_radius_mm * float(largest) * wind_up,
        load_share=SHARE * (float(largest) - mean) if states.load_share.shape[1] > 1 else 0.0,
        torque_Nm=states.torque_Nm,
    )
