"""Scenes on coarse meshes, with few modes and wide cells: good enough to tell what an effect does.

What two scenes have in common is built and solved once: bodies by their tables, compliances by
what they depend on. Bodies from files are what they are; their meshes cannot be made coarser.
"""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from time import process_time
from typing import TYPE_CHECKING, Any

import numpy as np
from msgspec import structs

from flankload.bodies.body import Material
from flankload.cost import Account
from flankload.elasticity.compliance import BodyCompliance, no_compliance
from flankload.elasticity.finite_elements import condensed, stiffness
from flankload.errors import ContactError
from flankload.mechanisms.flank_pair.assembly import bodies_of, build_bodies
from flankload.mechanisms.flank_pair.premises import blame_load, broken_by_geometry, broken_by_load
from flankload.mechanisms.flank_pair.stages import compliance_of, grown_pair, sweep_of
from flankload.mechanisms.premises import held
from flankload.pairing.body_pair import BodyPair
from flankload.plan.sizes import States
from flankload.result.geometry import pair_geometry
from flankload.scene.discretization import Discretization, Grid, choose_discretization
from flankload.scene.effects.keys import EffectsAsked
from flankload.scene.pair import Positions

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray
    from scipy.sparse import csc_array

    from flankload.bodies import Body
    from flankload.contact.sweep import Sweep
    from flankload.pairing.expansion import Growth
    from flankload.scene import Scene

#: Rotation of the FZG type C pair within 0.2 % of the converged one, a position in 0.15 ms.
COARSE = Discretization(flank_element_parts=0.5, modes=4, grid=Grid(4.0, 12.0))
#: Positions that a size is taken from, spread over those of the scene.
MOST_POSITIONS = 32
#: Times that agree like this are believed; the shortest counts.
AGREE, MOST_TIMES = 0.1, 6
#: Kinds of bodies that come as files.
FROM_FILES = ("mesh", "compliance")
#: Effects that say how much of a body its compliance is of; friction, growth and what moves with a
#: tooth are looked after apart, all others change no compliance.
OF_ELEMENTS = ("body", "segment_teeth", "coast_flank", "influence")


class Coarse:
    """Coarse scenes at some positions of one scene.

    Parameters
    ----------
    scene : Scene
    """

    def __init__(self, scene: Scene) -> None:
        self._bodies: dict[Any, Body] = {}
        self._pairs: dict[Scene, BodyPair] = {}
        self._compliances: dict[Any, BodyCompliance] = {}
        self._matrices: dict[Any, tuple[csc_array, float]] = {}
        self._sweeps: dict[Scene, tuple[Sweep, ...]] = {}
        self._state_s: dict[Scene, float] = {}
        self._solutions: dict[Scene, float] = {}
        self._fine: dict[Scene, tuple[BodyPair, float]] = {}
        self._file_s = [0.0, 0.0]
        scene = without_knobs(scene)
        self._has_coast = scene.effects.coast_flank
        bodies = (self._body(scene, 0), self._body(scene, 1))
        pair = build_bodies(scene, COARSE, bodies=bodies)
        held(scene, tuple(broken_by_geometry(pair)))
        self.position_rad = some_of(pair.position_rad)
        self.reference_radius_mm = bodies[0].reference_radius_mm
        self.torques_Nm = some_torques(scene)

    def of(self, scene: Scene) -> Scene:
        """The scene as it is looked at: some of its positions, no knobs of its own."""
        degrees = tuple(float(angle) for angle in np.degrees(self.position_rad))
        positions = Positions(angles_deg=degrees, driver=scene.positions.driver)
        return replace(without_knobs(scene), positions=positions)

    def bodies_from_files(self, scene: Scene) -> tuple[Body | None, Body | None]:
        """Bodies that are the same however finely the scene is resolved."""
        body_1, body_2 = (
            self._body(scene, z) if spec.kind in FROM_FILES else None
            for z, spec in enumerate((scene.body_1, scene.body_2))
        )
        return body_1, body_2

    def pair(self, scene: Scene) -> BodyPair:
        """Bodies of a scene, coarsely meshed.

        Where the plan's scene has coast flanks, one without them is the same pair that has lost
        them: teeth may be wider than their spaces, which no scene without coast flanks may have.
        """
        scene = self.of(scene)
        if scene not in self._pairs:
            lost = self._has_coast and not scene.effects.coast_flank
            bodies = (self._body(scene, 0), self._body(scene, 1))
            asked = _with_coast(scene) if lost else scene
            pair = build_bodies(asked, COARSE, bodies=bodies)
            self._pairs[scene] = _without_coast(pair) if lost else pair
        return self._pairs[scene]

    def fine_pair(self, scene: Scene) -> BodyPair:
        """Bodies of a scene as its run meshes them."""
        return self._timed_pair(scene)[0]

    def fine_pair_seconds(self, scene: Scene) -> float:
        """CPU seconds that building them takes, with the reading of files."""
        return self._timed_pair(scene)[1] + sum(self._file_s)

    def _timed_pair(self, scene: Scene) -> tuple[BodyPair, float]:
        """Bodies as the run meshes them; seconds without those from files, which are there."""
        if scene not in self._fine:
            discretization = choose_discretization(scene)
            made = self.bodies_from_files(scene)
            alike = self._body(scene, 0), self._body(scene, 1)
            start = process_time()
            which = tuple(z for z in (0, 1) if made[z] is None)
            others = dict(
                zip(which, bodies_of(scene, discretization, which, alike=alike), strict=True)
            )
            one, two = (made[z] or others[z] for z in (0, 1))
            pair = build_bodies(scene, discretization, bodies=(one, two))
            self._fine[scene] = pair, process_time() - start
        return self._fine[scene]

    def _body(self, scene: Scene, z: int) -> Body:
        """A body; one of another, where only its errors differ or that it does not yield."""
        spec = (scene.body_1, scene.body_2)[z]
        key = z, _placed(spec)
        if key not in self._bodies and spec.rigid:
            key = z, structs.replace(key[1], rigid=False)
        if key not in self._bodies:
            key = z, _placed(spec)
            start = process_time()
            self._bodies[key] = bodies_of(scene, COARSE, (z,))[0]
            if spec.kind in FROM_FILES and not self._file_s[z]:
                self._file_s[z] = process_time() - start
        body = self._bodies[key]
        errors = getattr(spec, "pitch_errors_um", ())
        if spec.kind == "compliance" and not errors:
            errors = body.pitch_errors_um  # those of the file
        return replace(body, rigid=spec.rigid, pitch_errors_um=tuple(errors))

    def compliances(self, scene: Scene, pair: BodyPair) -> tuple[BodyCompliance, BodyCompliance]:
        """Compliances of its bodies, before they grow as a whole."""
        return self._compliance(scene, pair, 0), self._compliance(scene, pair, 1)

    def _compliance(self, scene: Scene, pair: BodyPair, z: int) -> BodyCompliance:
        """Of a body; with friction from the first on where elements are solved."""
        body, growth = (pair.body_1, pair.body_2)[z], pair.growth[z]
        loaded = growth is not None and growth.needs_elements
        if not (pair.effects.elastic_body_1, pair.effects.elastic_body_2)[z] and not loaded:
            return no_compliance(body, growth)
        rubs = scene.has_friction or body.given is None
        asked = _for_compliance(scene, rubs=rubs)
        spec = (scene.body_1, scene.body_2)[z]
        key = (z, _placed(spec), asked.effects, growth if loaded else None)
        if key not in self._compliances:
            self._compliances[key] = self._solved(asked, z, body, growth if loaded else None)
        found = self._compliances[key]
        if growth is not None and not loaded:
            found = replace(found, expansion=growth.strain)
        return found if scene.effects.tooth_coupling else found.without_coupling()

    def _solved(self, asked: Scene, z: int, body: Body, growth: Growth | None) -> BodyCompliance:
        """Elements of a body, assembled once; the time that it took counts each time."""
        matrix, seconds = None, 0.0
        if body.mesh is not None:
            key = z, _placed((asked.body_1, asked.body_2)[z])
            if key not in self._matrices:
                if not self._matrices:
                    load_elements()
                start = process_time()
                mesh, plane = body.mesh, asked.accuracy.plane
                matrix = stiffness(mesh.nodes, mesh.cells, body.material, plane)
                self._matrices[key] = matrix, process_time() - start
            matrix, seconds = self._matrices[key]
        found = compliance_of(body, self.of(asked), COARSE, growth=growth, matrix=matrix)
        assembly = seconds + found.seconds.get("assembly", 0.0)
        return replace(found, seconds={**found.seconds, "assembly": assembly})

    def states(
        self,
        scene: Scene,
        torques_Nm: tuple[float, ...] | None = None,
        *,
        grid: Grid = COARSE.grid,
    ) -> list[States]:
        """What the sweep finds, torque by torque.

        Parameters
        ----------
        scene : Scene
        torques_Nm : tuple of float, optional
            Those of the plan if absent.
        grid : Grid, optional
            How fine the cells are.

        Returns
        -------
        list of States
        """
        pair = self.pair(scene)
        torques = self.torques_Nm if torques_Nm is None else torques_Nm
        found = self._swept(scene, torques, grid)
        sites = pair.pairing.sites
        return [
            States.of(torque, sites, part.rotation_rad, part.site_force_N)
            for torque, part in zip(torques, found, strict=True)
        ]

    def _swept(self, scene: Scene, torques: tuple[float, ...], grid: Grid) -> tuple[Sweep, ...]:
        """The sweep behind the states; that of the plan's torques on coarse cells once."""
        usual = torques == self.torques_Nm and grid == COARSE.grid
        if usual and scene in self._sweeps:
            return self._sweeps[scene]
        run, states = self._sweep(scene, self.pair(scene)), self.position_rad.size * len(torques)
        account, start = Account(), process_time()
        found = run(self.position_rad, torques, grid, account)
        if usual:
            self._state_s[scene] = (process_time() - start) / states
            self._sweeps[scene] = found
        self._solutions[scene] = account.counters.get("finite_solutions", 0) / states
        return found

    def check_load(self, scene: Scene) -> None:
        """Refuse a scene whose least or largest torque breaks a premise of the model.

        Raises
        ------
        PremiseError
        """
        coarse = self.pair(scene)
        pair, compliances = grown_pair(coarse, self.compliances(scene, coarse))
        geometry = pair_geometry(pair, compliances)
        swept = partial(self._swept, scene, grid=COARSE.grid)
        try:
            sweeps = swept(self.torques_Nm)
        except ContactError as error:
            blame_load(scene, pair, geometry, error, lambda torque: swept((torque / 1000.0,)))
            raise
        for torque, found in zip(self.torques_Nm, sweeps, strict=True):
            number = scene.torques_Nm.index(torque)
            held(scene, tuple(broken_by_load(scene, pair, geometry, found, number)))

    def state_seconds(self, scene: Scene) -> float:
        """CPU seconds of a state on coarse cells, with its part of the call."""
        if scene not in self._state_s:
            self.states(scene)
        return self._state_s[scene]

    def finite_solutions(self, scene: Scene) -> float:
        """How often a state is solved until its finite forces rest; 0 if it was never looked at."""
        return self._solutions.get(scene, 0.0)

    def fine_seconds(self, scene: Scene, grid: Grid, *, few: int) -> float:
        """CPU seconds of a call at a few positions, on fine cells, of the largest torque."""
        run = self._sweep(scene, self.pair(scene))
        last = self.position_rad.size - 1
        which = np.unique(np.linspace(0, last, few).round().astype(int))
        return shortest(lambda: run(self.position_rad[which], self.torques_Nm[-1:], grid))

    def _sweep(self, scene: Scene, pair: BodyPair) -> Callable[..., tuple[Sweep, ...]]:
        """The sweep of a coarse scene; compliances are solved when this returns."""
        pair, compliances = grown_pair(pair, self.compliances(scene, pair))
        run = sweep_of(scene, pair)
        return lambda position_rad, torques_Nm, grid, account=None: run(
            compliances=compliances,
            position_rad=position_rad,
            torques_Nmm=[1000.0 * torque for torque in torques_Nm],
            grid=grid,
            keep_pairs=False,
            account=account,
        )


def shortest(work: Callable[[], object]) -> float:
    """Shortest CPU seconds of some work, done again until the two shortest agree."""
    times: list[float] = []
    for _ in range(MOST_TIMES):
        start = process_time()
        work()
        times = sorted([*times, process_time() - start])
        if len(times) > 1 and times[1] <= (1.0 + AGREE) * times[0]:
            break
    return times[0]


def without_knobs(scene: Scene) -> Scene:
    """The scene without knobs of its own, and without what changes no state or is told by a law.

    Forces at nodes are another way to the same states, a hundred times as dear: modes tell sizes.
    """
    accuracy = structs.replace(
        scene.accuracy,
        flank_element_mm=None,
        modes=None,
        strips_per_half_width=None,
        corner_strips_per_half_width=None,
        zone_half_widths=None,
    )
    effects = structs.replace(scene.effects, root_stress=False, near_field="analytic")
    return replace(scene, effects=effects, accuracy=accuracy)


def load_elements() -> None:
    """Assemble and factorise next to nothing: the first body then takes as long as the next."""
    side = np.linspace(0.0, 1.0, 3)
    nodes = np.array([[x, y] for y in side for x in side])
    corners, middles = [0, 2, 8, 6], [1, 5, 7, 3]
    cell = np.array([[*corners, *middles, 4]])
    matrix = stiffness(nodes, (("quad9", cell),), Material(1.0, 0.3), "strain")
    condensed(matrix, np.arange(4, 18), np.arange(4))


def some_of(position_rad: NDArray[np.float64]) -> NDArray[np.float64]:
    """As many of the positions as a size is taken from, the first among them."""
    step = -(-position_rad.size // MOST_POSITIONS)
    return position_rad[::step]


def some_torques(scene: Scene) -> tuple[float, ...]:
    """The least and the largest torque that load the pair; 0 where none does."""
    loaded = [torque for torque in scene.torques_Nm if torque > 0]
    return tuple(dict.fromkeys((min(loaded), max(loaded)))) if loaded else (0.0,)


def _placed(spec: Any) -> Any:
    """The table of a body without pitch errors, on which neither mesh nor compliance depend."""
    if "pitch_errors_um" not in type(spec).__struct_fields__:
        return spec
    return structs.replace(spec, pitch_errors_um=())


def _with_coast(scene: Scene) -> Scene:
    return replace(scene, effects=structs.replace(scene.effects, coast_flank=True))


def _without_coast(pair: BodyPair) -> BodyPair:
    """The pair, its working flanks alone."""
    return replace(
        pair,
        pairing=replace(pair.pairing, coast=None),
        effects=replace(pair.effects, coast_flanks=False),
    )


def _for_compliance(scene: Scene, *, rubs: bool) -> Scene:
    """The scene with no more effects than elements depend on."""
    asked = scene.effects
    kept = {key: getattr(asked, key) for key in OF_ELEMENTS if hasattr(asked, key)}
    if rubs:
        kept["friction_coefficient"] = 1.0
    if rubs and not scene.has_friction:  # then finite forces want no other loads
        kept["influence"] = "small"
    return replace(scene, effects=EffectsAsked(**kept))
