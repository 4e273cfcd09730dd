"""Screening of two bodies with flanks: gears, rings, splines, cams.

The mesh is that of the run, with linear elements, which have a quarter of the unknowns; modes,
cells and positions are few. Segments, expansion, friction and coast flanks need other closures and
columns of one factorisation, rigid bodies need none, and every other effect needs another sweep.
"""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial
from math import log
from time import process_time
from typing import TYPE_CHECKING, Any

import numpy as np
from msgspec import structs

from flankload.analysis.estimate import n_sweeps
from flankload.analysis.tangent import SIDES
from flankload.bodies import SectorMesh
from flankload.cost import Account, held_bytes
from flankload.elasticity.compliance import BodyCompliance, flank_compliances, no_compliance
from flankload.elasticity.finite_elements import linear_cells, stiffness
from flankload.errors import ContactError, FlankloadError
from flankload.mechanisms.effect_size import Size, States, size_of
from flankload.mechanisms.element_rates import ElementRates, load_packages
from flankload.mechanisms.flank_pair.assembly import bodies_of, build_bodies, without_ends
from flankload.mechanisms.flank_pair.prediction import elements_estimated, predicted_work
from flankload.mechanisms.flank_pair.premises import blame_load, broken_by_geometry, broken_by_load
from flankload.mechanisms.flank_pair.screened_nodes import nodal_size, node_spacings
from flankload.mechanisms.flank_pair.stages import compliance_of, grown_pair, modes_of, sweep_of
from flankload.mechanisms.premises import held
from flankload.mechanisms.toggles import Toggle, toggles, with_keys, with_rigid
from flankload.pairing.body_pair import BodyPair
from flankload.pairing.coast_sites import coast_sites
from flankload.pairing.expansion import growth_of
from flankload.pairing.friction import friction_of
from flankload.result.geometry import PairGeometry, pair_geometry
from flankload.scene.discretization import Discretization, Grid
from flankload.scene.effects import EFFECTS, effects_of
from flankload.scene.effects.rules import check_coast_kinds

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from flankload.bodies import Body
    from flankload.contact.sweep import Sweep
    from flankload.pairing.expansion import Growth
    from flankload.scene import Scene

    Floats = NDArray[np.float64]

#: Modes and cells of the screening; its mesh is that of the run.
COARSE = Discretization(flank_element_parts=1.0, modes=3, grid=Grid(1.0, 3.0))
#: Positions of the screening; number of these with the run's own cells, and with finite influence
#: coefficients.
MOST_POSITIONS, FINE_POSITIONS, FINITE_POSITIONS = 12, 6, 4
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
#: Effects that do not exist for flanks.
OF_DRIVES = ("large_displacement", "land_friction", "land_lift")
#: Evaluation points in the root fillets of a tooth.
PLACES = 40
#: Least duration of a call of the core, s.
TINY_S = 1e-5


@dataclass(frozen=True)
class StateRate:
    """Measured CPU seconds of a sweep.

    Attributes
    ----------
    call_s, state_s, coarser_s : float
        CPU seconds per call, per state, and per state on cells twice as wide.
    sweep : Account
        Bytes and counters of the states that were tried.
    states : int
    """

    call_s: float
    state_s: float
    coarser_s: float
    sweep: Account
    states: int


class FlankPairScreening:
    """Effects of a scene on a coarse discretization, and the predicted cost of its run.

    Parameters
    ----------
    scene : Scene
        Scene without `effects.choose`.
    levels : bool
        Whether coarser contact models that are off are tried as well.

    Attributes
    ----------
    rows : tuple of str
        Effects that apply to the pair.
    toggles : dict of str to Toggle
        The scene with each of them switched, as far as that is tried.

    Raises
    ------
    PremiseError
        If the least or the largest torque violates a premise of the model.
    FlankloadError
        If a position has no solution.
    """

    def __init__(self, scene: Scene, *, levels: bool = False) -> None:
        self._scene = scene
        with Account() as self._bodies:
            self._pair = build_bodies(scene)
        held(scene, tuple(broken_by_geometry(self._pair)))
        self._bodies.bytes = held_bytes(self._pair)
        known = [row for row in EFFECTS if row.name not in OF_DRIVES]
        teeth = self._pair.pairing.motion is None
        self.rows = tuple(row.name for row in known if teeth or not row.of_teeth)
        effects = self._pair.effects
        self.toggles: dict[str, Toggle] = {
            name: toggle
            for name, toggle in toggles(scene, self.rows).items()
            if levels or name not in OFF or getattr(effects, name) or toggle.impossible
        }
        self._assemblies = {scene: self._pair}
        self._at = _spread(self._pair.position_rad, MOST_POSITIONS)
        loaded = [torque for torque in scene.torques_Nm if torque > 0]
        self._torques = tuple(dict.fromkeys((min(loaded), max(loaded)))) if loaded else (0.0,)
        self._jobs: list[dict[Any, BodyCompliance]] = [{}, {}]
        self._rates: dict[int, ElementRates] = {}
        self._meshes: dict[int, Body] = {}
        self._state_s: dict[Scene, float] = {}
        self._screened = screened(scene)
        for z in (0, 1):
            self._solve_elements(z)
        base, self._base_s = self._first_states()
        self._check_load(base)
        self._base = self._states(self._screened, base)
        self._unloaded = self._base[0].rotation_rad
        if loaded:
            self._unloaded = self._swept(self._screened, self._at, (0.0,))[0].rotation_rad
        self._rate = self._state_rate()

    # --- sizes ------------------------------------------------------------------------------------
    def size(self, name: str, *, on: bool) -> Size | None:
        """Change by a row of the table; None if it changes no state.

        Raises
        ------
        FlankloadError
            If the other scene has no solution.
        """
        row, scene = next(row for row in EFFECTS if row.name == name), self.toggles[name].scene
        if scene is None or row.size_by == "nothing":
            return None
        if row.size_by == "spacing":
            nodal = self._scene if on else scene
            return nodal_size(nodal, self._pair, self._base[0], self._unloaded)
        if name == "finite_influence":
            return self._finite_size(scene, on=on)
        if name == "lumped_contact":  # the cells make the difference
            few = _spread(self._at, FINE_POSITIONS)
            found, seconds = self._timed(screened(scene), few, self._torques[-1:], self._grid)
            self._state_s[scene] = max(TINY_S, (seconds - self._rate.call_s) / few.size)
            base, other = self._fine, self._states(screened(scene), found)
            return self._between(*((base, other) if on else (other, base)), few)
        other = self._other(scene)
        return self._between(*((self._base, other) if on else (other, self._base)))

    def change(self, scene: Scene) -> Size:
        """Change by another scene relative to this one."""
        return self._between(self._other(scene), self._base)

    def _other(self, scene: Scene) -> list[States]:
        """States with other effects; records their relative cost per state."""
        found, seconds = self._timed(screened(scene), self._at, self._torques)
        other, mine = (max(TINY_S, each - self._rate.call_s) for each in (seconds, self._base_s))
        self._state_s[scene] = self._rate.state_s * other / mine
        return self._states(screened(scene), found)

    def _finite_size(self, scene: Scene, *, on: bool) -> Size | None:
        """Size of finite influence coefficients: their effect is proportional to the cell width."""
        if self._pair.pairing.whole_circle:  # a conforming flank has too many pairs for that
            return None
        few = _spread(self._at, FINITE_POSITIONS)
        finite_scene = with_keys(self._screened, influence="finite")
        finite, finite_s = self._timed(finite_scene, few, self._torques[-1:])
        finer = self._grid.strips_per_half_width / COARSE.grid.strips_per_half_width
        # each two pairs have their own influence coefficients
        more = finer**2 * max(0.0, finite_s - self._rate.call_s) / few.size
        self._state_s[scene] = max(TINY_S, self._rate.state_s + (-more if on else more))
        small = [_at_positions(self._base[-1], np.isin(self._at, few))]
        return self._between(self._states(finite_scene, finite), small, few).times(1.0 / finer)

    def _between(
        self, with_it: list[States], without: list[States], at: Floats | None = None
    ) -> Size:
        which = np.isin(self._at, self._at if at is None else at)
        base = [_at_positions(part, which) for part in self._base[-len(with_it) :]]
        return size_of(
            with_it,
            without,
            base=base,
            unloaded_rad=self._unloaded[which],
            reference_radius_mm=self._pair.body_1.reference_radius_mm,
        )

    @property
    def _grid(self) -> Grid:
        """Cells of the run."""
        return self._pair.discretization.grid

    def _states(self, scene: Scene, found: tuple[Sweep, ...]) -> list[States]:
        sites = self.assembly(scene).pairing.sites
        return [
            States.of(part.torque_Nmm / 1000.0, sites, part.rotation_rad, part.site_force_N)
            for part in found
        ]

    def _timed(
        self, scene: Scene, at: Floats, torques_Nm: tuple[float, ...], grid: Grid = COARSE.grid
    ) -> tuple[tuple[Sweep, ...], float]:
        """The sweep, and the CPU seconds of its states at all torques."""
        pair = self.assembly(scene)
        self._compliances(scene, pair)
        start = process_time()
        return self._swept(scene, at, torques_Nm, grid), process_time() - start

    def _swept(
        self,
        scene: Scene,
        at: Floats,
        torques_Nm: tuple[float, ...],
        grid: Grid = COARSE.grid,
        account: Account | None = None,
        *,
        keep_pairs: bool = False,
    ) -> tuple[Sweep, ...]:
        pair = self.assembly(scene)
        pair, compliances = grown_pair(pair, self._compliances(scene, pair))
        return sweep_of(scene, pair)(
            compliances=compliances,
            position_rad=at,
            torques_Nmm=[1000.0 * torque for torque in torques_Nm],
            grid=grid,
            keep_pairs=keep_pairs,
            account=account,
            watched=False,
        )

    def _check_load(self, base: tuple[Sweep, ...]) -> None:
        """Refuse a scene whose least or largest torque violates a premise of the model."""
        pair, geometry = self._geometry()
        for torque, found in zip(self._torques, base, strict=True):
            number = self._scene.torques_Nm.index(torque)
            held(self._scene, tuple(broken_by_load(self._scene, pair, geometry, found, number)))

    def _geometry(self) -> tuple[BodyPair, PairGeometry]:
        pair = replace(self.assembly(self._screened), position_rad=self._at)
        pair, compliances = grown_pair(pair, self._compliances(self._screened, pair))
        return pair, pair_geometry(pair, compliances)

    def _first_states(self) -> tuple[tuple[Sweep, ...], float]:
        """States of the scene; without any, check the premises under a part of the torque."""
        try:
            return self._timed(self._screened, self._at, self._torques)
        except ContactError as error:
            pair, geometry = self._geometry()
            swept = partial(self._swept, self._screened, self._at)
            again = lambda torque: swept((torque / 1000.0,))  # noqa: E731
            blame_load(self._scene, pair, geometry, error, again)
            raise

    # --- bodies and compliances -------------------------------------------------------------------
    def assembly(self, scene: Scene) -> BodyPair:
        """Assemble the bodies of a scene with other effects, reusing available bodies."""
        if scene not in self._assemblies:
            self._assemblies[scene] = self._assembled(scene)
        return self._assemblies[scene]

    def _assembled(self, scene: Scene) -> BodyPair:
        pair, specs = self._pair, (scene.body_1, scene.body_2)
        mine = (self._scene.body_1, self._scene.body_2)
        effects = effects_of(scene)
        body_1, body_2 = (self._body(scene, z, tip_contact=effects.tip_contact) for z in (0, 1))
        if any(_geometric(one) != _geometric(two) for one, two in zip(specs, mine, strict=True)):
            return build_bodies(scene, pair.discretization, bodies=(body_1, body_2))
        coast = None
        if effects.coast_flanks:
            check_coast_kinds(body_1.kind, body_2.kind)
            coast = pair.pairing.coast or coast_sites(pair.pairing.sites, body_1, body_2)
        pairing = replace(pair.pairing, coast=coast)
        return replace(
            pair,
            body_1=body_1,
            body_2=body_2,
            pairing=pairing,
            effects=replace(
                effects,
                pitch_errors=pair.effects.pitch_errors,
                flank_modifications=pair.effects.flank_modifications,
            ),
            friction=friction_of(scene, body_1, pairing),
            fillets=pair.fillets if effects.root_stress else (None, None),
            growth=growth_of(scene, pairing),
        )

    def _body(self, scene: Scene, z: int, *, tip_contact: bool) -> Body:
        """A body for another scene; the mesh is reused if only the curve differs."""
        body, spec = (self._pair.body_1, self._pair.body_2)[z], (scene.body_1, scene.body_2)[z]
        mine = (self._scene.body_1, self._scene.body_2)[z]
        if body.mesh is None and body.given is None and not spec.rigid:
            if z not in self._meshes:
                (self._meshes[z],) = bodies_of(scene, self._pair.discretization, (z,))
            body = replace(body, mesh=self._meshes[z].mesh)
        if _unplaced(spec) != _unplaced(mine):
            rigid = with_rigid(scene, f"body_{z + 1}", rigid=True)
            (built,) = bodies_of(rigid, self._pair.discretization, (z,))
            body = replace(built, mesh=body.mesh)
        own = getattr(spec, "pitch_errors_um", ())
        if body.given is not None:  # imported with its file
            own = own or body.pitch_errors_um
        ends = replace(body, active_range_mm=None) if tip_contact else without_ends(body)
        return replace(ends, rigid=spec.rigid, pitch_errors_um=tuple(own))

    def _solve_elements(self, z: int) -> None:
        """Solve one job for all element results of a body that any of the scenes needs."""
        asked = [scene for scene in self._possible() if self._needs_elements(scene, z)]
        if not asked:
            return
        body = self._body(asked[0], z, tip_contact=True)
        if body.mesh is None:
            return
        load_packages()
        plane, cells = self._scene.accuracy.plane, linear_cells(body.mesh.cells)
        start = process_time()
        matrix = stiffness(body.mesh.nodes, cells, body.material, plane)
        seconds = process_time() - start
        variants = list(dict.fromkeys(self._variant(scene, z) for scene in asked))
        finite = not self._pair.pairing.whole_circle and "finite_influence" in self.toggles
        along = finite and self.toggles["finite_influence"].scene is not None
        found = flank_compliances(
            body,
            variants,
            n_modes=modes_of(body, self._screened, COARSE),
            plane=plane,
            friction=along or any(scene.has_friction for scene in asked),
            along=along and self._scene.has_friction,
            coast_flanks=any(scene.effects.coast_flank for scene in asked),
            matrix=matrix,
            linear=True,
        )
        self._jobs[z] = dict(zip(variants, found, strict=True))
        self._rates[z] = ElementRates(body, seconds, found[0])

    def _possible(self) -> list[Scene]:
        """The screened scene and its toggles, except those that are not solved."""
        scenes = [self._screened]
        for name, toggle in self.toggles.items():
            if toggle.scene is not None and name not in ("nodal_near_field", "finite_influence"):
                with suppress(FlankloadError):  # reported when its size is requested
                    self.assembly(screened(toggle.scene))
                    scenes.append(screened(toggle.scene))
        return list(dict.fromkeys(scenes))

    def _needs_elements(self, scene: Scene, z: int) -> bool:
        pair = self.assembly(scene)
        growth = pair.growth[z]
        elastic = (pair.effects.elastic_body_1, pair.effects.elastic_body_2)[z]
        return elastic or (growth is not None and growth.needs_elements)

    def _variant(self, scene: Scene, z: int) -> tuple[int | None, Growth | None]:
        """Key of the variants of a sector: number of sectors and expansion."""
        growth = self.assembly(scene).growth[z]
        return scene.sectors, growth if growth is not None and growth.needs_elements else None

    def _compliances(self, scene: Scene, pair: BodyPair) -> tuple[BodyCompliance, BodyCompliance]:
        return self._compliance(scene, pair, 0), self._compliance(scene, pair, 1)

    def _compliance(self, scene: Scene, pair: BodyPair, z: int) -> BodyCompliance:
        """Compliance of a body, without expansion of the whole body."""
        body, growth = (pair.body_1, pair.body_2)[z], pair.growth[z]
        if not self._needs_elements(scene, z):
            return no_compliance(body, growth)
        found = self._jobs[z].get(self._variant(scene, z)) or self._given(scene, body, z)
        if growth is not None and not growth.needs_elements:
            found = replace(found, expansion=growth.strain)
        if not scene.effects.coast_flank:
            found = replace(found, crossing=None, crossing_tangential=None)
        return found if scene.effects.tooth_coupling else found.without_coupling()

    def _given(self, scene: Scene, body: Body, z: int) -> BodyCompliance:
        """Compliance of a body with imported compliance."""
        growth = self.assembly(scene).growth[z]
        key = scene.has_friction, scene.effects.influence, growth
        if key not in self._jobs[z]:
            plain = with_keys(scene, tooth_coupling=True)
            found = compliance_of(body, plain, self._pair.discretization, growth=growth)
            self._jobs[z][key] = found
        return self._jobs[z][key]

    # --- cost -------------------------------------------------------------------------------------
    def price(self, scene: Scene) -> dict[str, Account]:
        """CPU seconds, bytes and counters by stage for the run of a scene with other effects."""
        nodal = effects_of(scene).nodal_near_field and not self._pair.effects.nodal_near_field
        pair = self._pair if nodal else self.assembly(scene)
        counted = predicted_work(scene, pair)
        stages = {"bodies": replace(self._bodies, counters={})}
        smoothing = 0.0
        for z in (0, 1):
            name = f"compliance body {z + 1}"
            if name not in counted:
                continue
            if z not in self._rates:  # imported from a file
                stages[name] = Account(bytes=held_bytes(self._compliance(scene, pair, z)))
                continue
            counters, finer = counted[name], 1.0
            if nodal:
                finer, counters = self._nodal(scene, pair, z, counters)
            fillets, places = pair.fillets[z], 0
            if fillets is not None:
                places = int(fillets.points.arc_length_mm.size)
            elif pair.effects.root_stress:  # of another scene: approximately this number
                places = PLACES * isinstance(self._rates[z].body.mesh, SectorMesh)
                counters = counters | {"fe_solutions": counters["fe_solutions"] + places}
            stages[name] = self._rates[z].price(counters, places=places, finer=finer)
            stages[name].bytes += held_bytes(fillets.points) if fillets is not None else 0
            if z in elements_estimated(pair):
                smoothing += self._rates[z].smoothing_s(counters)
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
        body, spacing = (pair.body_1, pair.body_2)[z], node_spacings(scene, pair)[z]
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
        loaded = sum(torque > 0 for torque in scene.torques_Nm)
        lumped = pair.effects.lumped_contact
        numbers = {"sweep": (1, len(scene.torques_Nm), rate.state_s)}
        if not lumped:
            numbers["tangent"] = (1, len(SIDES) * loaded, rate.state_s)
        if scene.accuracy.estimate:
            sweeps = n_sweeps(lumped=lumped, elements=bool(elements_estimated(pair)))
            numbers["estimate"] = (sweeps, sweeps * loaded, rate.coarser_s)
        stages = {}
        for name, (calls, torques, state_s) in numbers.items():
            states = positions * torques
            part = states / rate.states
            counters = rate.sweep.counters if name != "estimate" else {}
            stages[name] = Account(
                cpu_s=calls * rate.call_s + states * state_s * slower,
                bytes=round(rate.sweep.bytes * part) if name == "sweep" else 0,
                workspace_bytes=round(rate.sweep.workspace_bytes * part),
                counters={key: round(count * part) for key, count in counters.items()},
            )
        return stages

    def _state_rate(self) -> StateRate:
        """Measure the cost of a state on the run's own cells and on cells twice as wide."""
        few, torque = _spread(self._at, FINE_POSITIONS), self._torques[-1:]

        def timed(at: Floats) -> tuple[float, Account, tuple[Sweep, ...]]:
            account, start = Account(), process_time()
            found = self._swept(self._scene, at, torque, self._grid, account, keep_pairs=True)
            return process_time() - start, account, found

        seconds, account, found = timed(few)
        self._fine = self._states(self._scene, found)
        account.bytes = held_bytes(found)
        call = 0.0
        if few.size > 1:
            one, _, _ = timed(few[:1])
            call = max(0.0, one - (seconds - one) / (few.size - 1))
        wide = (self._base_s - call) / (self._at.size * len(self._torques))
        state, wide = max(TINY_S, (seconds - call) / few.size), max(TINY_S, wide)
        ratio = self._grid.strips_per_half_width / COARSE.grid.strips_per_half_width
        # by the power law between both
        power = log(state / wide) / log(ratio) if ratio > 1.0 and state > wide else 0.0
        return StateRate(call, state, state * 0.5**power, account, few.size)


def screened(scene: Scene) -> Scene:
    """The scene to screen: without effects that change no state or are examined separately."""
    effects = structs.replace(
        scene.effects, root_stress=False, near_field="analytic", influence="small"
    )
    accuracy = structs.replace(scene.accuracy, modes=None)
    return replace(scene, effects=effects, accuracy=accuracy)


def _unplaced(spec: Any) -> Any:
    """Keys of a body that affect its curve and its mesh."""
    return _with(spec, rigid=False, pitch_errors_um=())


def _geometric(spec: Any) -> Any:
    """Keys of a body that affect its curve and its mesh, and the pitch errors of its teeth."""
    return _with(spec, rigid=False)


def _with(spec: Any, **keys: Any) -> Any:
    here = {key: value for key, value in keys.items() if key in spec.__struct_fields__}
    return structs.replace(spec, **here)


def _at_positions(states: States, which: NDArray[np.bool_]) -> States:
    """States at some of the positions."""
    share = states.load_share[which]
    return replace(states, rotation_rad=states.rotation_rad[which], load_share=share)


def _spread(position_rad: Floats, most: int) -> Floats:
    """At most this number of the positions, evenly spread, with the first among them."""
    return position_rad[:: max(1, -(-position_rad.size // most))]
