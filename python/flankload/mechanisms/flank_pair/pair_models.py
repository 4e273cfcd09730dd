"""Bodies and compliances of a scene with each of its effects the other way.

The bodies are those of the run. Their elements are linear, which leaves a quarter of the unknowns;
segments, growth, friction and coast flanks are other closures and columns of one factorisation.
Three-dimensional bodies have larger elements and lower degrees along the axis (`prism_rates`).
"""

from __future__ import annotations

from contextlib import suppress
from dataclasses import replace
from time import process_time
from typing import TYPE_CHECKING, Any

from msgspec import structs

from flankload.elasticity.compliance import (
    BodyCompliance,
    Expansion,
    JobOptions,
    flank_compliance,
    flank_compliances,
    no_compliance,
)
from flankload.elasticity.finite_elements import linear_cells, stiffness
from flankload.errors import FlankloadError
from flankload.mechanisms.element_rates import ElementRates, load_packages
from flankload.mechanisms.flank_pair.assembly import bodies_of, build_bodies, without_ends
from flankload.mechanisms.flank_pair.prism_rates import PrismRates, coarse_compliance
from flankload.mechanisms.flank_pair.stages import compliance_of, modes_of
from flankload.mechanisms.toggles import with_keys, with_rigid
from flankload.pairing.body_pair import BodyPair
from flankload.pairing.coast_sites import coast_sites
from flankload.pairing.expansion import growth_of
from flankload.pairing.friction import friction_of
from flankload.scene.discretization import Discretization, Grid
from flankload.scene.effects import effects_of, is_spatial
from flankload.scene.effects.rules import check_coast_kinds

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flankload.bodies import Body
    from flankload.bodies.shaft import CarryingShaft
    from flankload.mechanisms.toggles import Toggle
    from flankload.pairing.expansion import Growth
    from flankload.scene import Scene

    #: A shaft that the bore follows, or whether there are three dimensions; sectors; expansion.
    _Variant = tuple[CarryingShaft | bool, int | None, Growth | None]

#: Modes and cells of the screening; its mesh is that of the run.
COARSE = Discretization(flank_element_parts=1.0, modes=3, grid=Grid(1.0, 3.0))


class PairModels:
    """What the sweeps of a screening take; all that scenes have in common is made once.

    Attributes
    ----------
    screened : Scene
        The scene as it is screened.
    rates : dict of int to ElementRates
        Of the bodies, 0 and 1, whose plane elements were solved.
    prism_rates : dict of int to PrismRates
        Of those whose elements were solved in three dimensions.
    """

    def __init__(self, scene: Scene, pair: BodyPair, toggles: Mapping[str, Toggle]) -> None:
        self._scene, self._pair, self._toggles = scene, pair, toggles
        self._assemblies = {scene: pair}
        self._jobs: list[dict[Any, BodyCompliance]] = [{}, {}]
        self._meshes: dict[int, Body] = {}
        self._sections: dict[int, BodyCompliance] = {}
        self.screened = screened(scene)
        self.rates: dict[int, ElementRates] = {}
        self.prism_rates: dict[int, PrismRates] = {}
        for z in (0, 1):
            self._solve_elements(z)

    def assembly(self, scene: Scene) -> BodyPair:
        """Bodies of a scene with other effects, without those that are there already."""
        if scene not in self._assemblies:
            self._assemblies[scene] = self._assembled(scene)
        return self._assemblies[scene]

    def _assembled(self, scene: Scene) -> BodyPair:
        pair, specs = self._pair, (scene.body_1, scene.body_2)
        mine = (self._scene.body_1, self._scene.body_2)
        effects = effects_of(scene)
        moved = scene.pair != self._scene.pair
        moved |= effects.three_dimensions != pair.effects.three_dimensions
        body_1, body_2 = (self._body(scene, z, tip_contact=effects.tip_contact) for z in (0, 1))
        if moved or any(
            _geometric(one) != _geometric(two) for one, two in zip(specs, mine, strict=True)
        ):
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
        """A body as another scene has it; its elements stay, if its curve is another one."""
        body, spec = (self._pair.body_1, self._pair.body_2)[z], (scene.body_1, scene.body_2)[z]
        mine = (self._scene.body_1, self._scene.body_2)[z]
        if body.mesh is None and body.given is None and not spec.rigid:
            if z not in self._meshes:
                (self._meshes[z],) = bodies_of(scene, self._pair.discretization, (z,))
            body = replace(body, mesh=self._meshes[z].mesh)
        spatial = is_spatial(scene).on
        if body.axial is not None and not spatial:  # its transverse section
            body = replace(body, axial=None)
        elif _unplaced(spec) != _unplaced(mine) or (spatial and body.axial is None):
            rigid = with_rigid(scene, f"body_{z + 1}", rigid=True)
            (built,) = bodies_of(rigid, self._pair.discretization, (z,))
            body = replace(built, mesh=body.mesh)
        own = getattr(spec, "pitch_errors_um", ())
        if body.given is not None:  # a file has its own
            own = own or body.pitch_errors_um
        ends = replace(body, active_range_mm=None) if tip_contact else without_ends(body)
        return replace(ends, rigid=spec.rigid, pitch_errors_um=tuple(own))

    def _solve_elements(self, z: int) -> None:
        """One job for all that the elements of a body are asked for by any of the scenes."""
        asked = [scene for scene in self._possible() if self._needs_elements(scene, z)]
        if not asked:
            return
        spatial = [scene for scene in asked if is_spatial(scene).on]
        if not self._pair.effects.three_dimensions:
            self._solve_plane_elements(z, [scene for scene in asked if scene not in spatial])
        on_shafts: dict[CarryingShaft | bool, Scene] = {}
        for scene in spatial:
            on_shafts.setdefault(self._variant(scene, z)[0], scene)
        for scene in on_shafts.values():
            self._solve_prism(z, scene, friction=any(each.has_friction for each in spatial))

    def _solve_prism(self, z: int, scene: Scene, *, friction: bool) -> None:
        """A three-dimensional body on coarse elements, and the plane body on the same elements."""
        load_packages()
        body, found = coarse_compliance(scene, z, friction=friction)
        self._jobs[z][self._variant(scene, z)] = found
        if z in self.prism_rates:  # on another shaft
            return
        self.prism_rates[z] = PrismRates(body, found.job)
        assert body.mesh is not None
        plane, start = scene.accuracy.plane, process_time()
        matrix = stiffness(body.mesh.nodes, body.mesh.cells, body.material, plane)
        seconds = process_time() - start
        modes = modes_of(body, self.screened, COARSE)
        self._sections[z] = flank_compliance(
            body, JobOptions(n_modes=modes, plane=plane, friction=friction), matrix=matrix
        )
        if self._pair.effects.three_dimensions:
            self._jobs[z][False, None, None] = self._sections[z]
            self.rates[z] = ElementRates(body, seconds, self._sections[z].job)

    def _solve_plane_elements(self, z: int, asked: list[Scene]) -> None:
        """The plane elements of a body."""
        body = self._body(asked[0], z, tip_contact=True)
        if body.mesh is None:
            return
        load_packages()
        plane, cells = self._scene.accuracy.plane, linear_cells(body.mesh.cells)
        start = process_time()
        matrix = stiffness(body.mesh.nodes, cells, body.material, plane)
        seconds = process_time() - start
        variants = list(dict.fromkeys(self._variant(scene, z)[1:] for scene in asked))
        finite = not self._pair.pairing.whole_circle and "finite_influence" in self._toggles
        along = finite and self._toggles["finite_influence"].scene is not None
        found = flank_compliances(
            body,
            variants,
            JobOptions(
                n_modes=modes_of(body, self.screened, COARSE),
                plane=plane,
                friction=along or any(scene.has_friction for scene in asked),
                along=along and self._scene.has_friction,
                coast_flanks=any(scene.effects.coast_flank for scene in asked),
                linear=True,
            ),
            matrix,
        )
        for variant, compliance in zip(variants, found, strict=True):
            self._jobs[z][False, *variant] = compliance
        self.rates[z] = ElementRates.of_linear(body, seconds, found[0].job)

    def _possible(self) -> list[Scene]:
        """The scene and its toggles as they are screened, but for those that are not solved."""
        scenes = [self.screened]
        for name, toggle in self._toggles.items():
            if toggle.scene is not None and name not in ("nodal_near_field", "finite_influence"):
                with suppress(FlankloadError):  # said when its size is asked for
                    self.assembly(screened(toggle.scene))
                    scenes.append(screened(toggle.scene))
        return list(dict.fromkeys(scenes))

    def _needs_elements(self, scene: Scene, z: int) -> bool:
        pair = self.assembly(scene)
        growth = pair.growth[z]
        elastic = (pair.effects.elastic_body_1, pair.effects.elastic_body_2)[z]
        return elastic or (growth is not None and growth.needs_elements)

    def _variant(self, scene: Scene, z: int) -> _Variant:
        """What is built of a sector: in three dimensions and on which shaft, how many, growing."""
        pair = self.assembly(scene)
        axial, growth = (pair.body_1, pair.body_2)[z].axial, pair.growth[z]
        grows = growth if growth is not None and growth.needs_elements else None
        carrying = None if axial is None else axial.carrying
        return (carrying or is_spatial(scene).on), scene.sectors, grows

    def sections(self, pair: BodyPair) -> tuple[BodyCompliance, BodyCompliance]:
        """Plane compliances on the elements of coarse three-dimensional bodies."""
        bodies, coupled = (pair.body_1, pair.body_2), self._scene.effects.tooth_coupling
        one, two = (self._sections.get(z) or no_compliance(bodies[z]) for z in (0, 1))
        return (one, two) if coupled else (one.without_coupling(), two.without_coupling())

    def compliances(self, scene: Scene, pair: BodyPair) -> tuple[BodyCompliance, BodyCompliance]:
        """Compliances of both bodies."""
        return self.compliance(scene, pair, 0), self.compliance(scene, pair, 1)

    def compliance(self, scene: Scene, pair: BodyPair, z: int) -> BodyCompliance:
        """Compliance of a body, before it grows as a whole."""
        body, growth = (pair.body_1, pair.body_2)[z], pair.growth[z]
        if not self._needs_elements(scene, z):
            return no_compliance(body, growth)
        found = self._jobs[z].get(self._variant(scene, z)) or self._given(scene, body, z)
        if growth is not None and not growth.needs_elements:
            found = replace(found, expansion=Expansion(growth.strain))
        if not scene.effects.coast_flank:
            found = replace(found, coast=None)
        return found if scene.effects.tooth_coupling else found.without_coupling()

    def _given(self, scene: Scene, body: Body, z: int) -> BodyCompliance:
        """Of a body that brings its compliance along."""
        growth = self.assembly(scene).growth[z]
        key = scene.has_friction, scene.effects.influence, growth
        if key not in self._jobs[z]:
            plain = with_keys(scene, tooth_coupling=True)
            found = compliance_of(body, plain, self._pair.discretization, growth=growth)
            self._jobs[z][key] = found
        return self._jobs[z][key]


def screened(scene: Scene) -> Scene:
    """The scene as it is screened: without what changes no state, or is looked at by itself."""
    effects = structs.replace(
        scene.effects, root_stress=False, near_field="analytic", influence="small"
    )
    accuracy = structs.replace(scene.accuracy, modes=None)
    return replace(scene, effects=effects, accuracy=accuracy)


def _unplaced(spec: Any) -> Any:
    """The table of a body as far as its curve and its mesh depend on it."""
    return _with(spec, rigid=False, pitch_errors_um=())


def _geometric(spec: Any) -> Any:
    """The same, with the places of the teeth."""
    return _with(spec, rigid=False)


def _with(spec: Any, **keys: Any) -> Any:
    here = {key: value for key, value in keys.items() if key in spec.__struct_fields__}
    return structs.replace(spec, **here)
