"""Bodies and compliances of a scene with each of its effects the other way.

The bodies are those of the run. Their elements are linear, which leaves a quarter of the unknowns;
segments, growth, friction and coast flanks are other closures and columns of one factorisation.
Three-dimensional bodies have larger elements and lower degrees along the axis.

Cost of these: each number of a factor belongs to two nodes and two functions of z. The nodes meet
in n log n pairs as in the plane (`element_rates`), the functions in (p + 1)² pairs. On meshes of
530 to 4000 nodes with degrees 4 to 8 the seconds follow that to a factor of 1.5. The closure of the
ring solves as many unknowns as the cuts have, one harmonic after the other. For stress in the
roots, fronts are kept and the nodes of the fillets substituted back.
"""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass, replace
from math import log
from time import process_time
from typing import TYPE_CHECKING, Any

from msgspec import structs

from flankload.bodies import SectorMesh
from flankload.cost import Account
from flankload.elasticity.compliance import (
    BodyCompliance,
    Expansion,
    JobOptions,
    flank_compliance,
    flank_compliances,
    no_compliance,
)
from flankload.elasticity.finite_elements import linear_cells, stiffness
from flankload.elasticity.prism import Prism, carried_and_held
from flankload.errors import FlankloadError
from flankload.mechanisms.element_rates import ElementRates, load_packages
from flankload.mechanisms.flank_pair.assembly import bodies_of, build_bodies, without_ends
from flankload.mechanisms.flank_pair.stages import compliance_of, modes_of
from flankload.mechanisms.toggles import with_keys, with_rigid
from flankload.pairing.body_pair import BodyPair
from flankload.pairing.expansion import body_loads_of
from flankload.pairing.friction import friction_of
from flankload.pairing.pairing import coast_sites
from flankload.scene.axial import degrees_of
from flankload.scene.discretization import Discretization, Grid
from flankload.scene.effects import effects_of, is_spatial
from flankload.scene.effects.rules import check_coast_kinds

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flankload.bodies import Body
    from flankload.bodies.shaft import FlexibleShaft
    from flankload.elasticity.job_log import JobCost
    from flankload.mechanisms.flank_pair.stages import Compliances
    from flankload.mechanisms.toggles import Toggle
    from flankload.pairing.expansion import BodyLoad
    from flankload.scene import BodySpec, Scene

    #: With friction or not, influence numbers.
    _FileVariant = tuple[bool, str]
    #: Number, table, whether it is three-dimensional and touches with its tip.
    _BodyVariant = tuple[int, BodySpec, bool, bool]

#: Modes and cells of the screening; its mesh is that of the run.
COARSE = Discretization(flank_element_parts=1.0, modes=3, grid=Grid(1.0, 3.0))
#: Elements, modes and degrees along the axis of coarse bodies: a tenth of the seconds of the
#: default, within 0.5 % of its transmission error and 0.06 of its face load factor.
COARSE_PRISM = Discretization(flank_element_parts=0.5, modes=3, grid=Grid())
DEGREE, LOAD_DEGREE, CUT_DEGREE = 4, 2, 3
#: Seconds of the back substitution for the fillets relative to those of the factorisation, and
#: bytes of the fronts relative to its workspace: 0.27 to 0.33 and 1.0 to 1.6, measured on gears of
#: 16 to 60 teeth, spur and helical.
RECOVERY_SECONDS, RECOVERY_BYTES = 0.3, 1.3


@dataclass(frozen=True)
class Variant:
    """What is built of the elements of a body.

    Attributes
    ----------
    spatial : bool
        Whether they are solved in three dimensions.
    shaft : FlexibleShaft or None
        What the bore follows.
    sectors : int or None
        Number of teeth of a segment.
    growth : BodyLoad or None
        Expansion, where it needs the elements.
    """

    spatial: bool = False
    shaft: FlexibleShaft | None = None
    sectors: int | None = None
    growth: BodyLoad | None = None


class PairModels:
    """What the sweeps of a screening take; all that scenes have in common is made once.

    `screened` is the scene as it is screened. `rates` are those of the bodies (0, 1) whose plane
    elements were solved, `prism_rates` of those whose elements were solved in three dimensions.
    """

    def __init__(self, scene: Scene, pair: BodyPair, toggles: Mapping[str, Toggle]) -> None:
        self._scene, self._pair, self._toggles = scene, pair, toggles
        self._assemblies = {scene: pair}
        self._jobs: tuple[dict[Variant, BodyCompliance], ...] = ({}, {})
        self._of_files: tuple[dict[_FileVariant, BodyCompliance], ...] = ({}, {})
        self._meshes: dict[int, Body] = {}
        self._bodies: dict[_BodyVariant, Body] = {}
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
        if moved or any(_differ(one, two, "rigid") for one, two in zip(specs, mine, strict=True)):
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
            body_loads=body_loads_of(scene, pairing),
        )

    def _body(self, scene: Scene, z: int, *, tip_contact: bool) -> Body:
        """A body as another scene has it, made once."""
        key = z, (scene.body_1, scene.body_2)[z], is_spatial(scene).on, tip_contact
        if key not in self._bodies:
            self._bodies[key] = self._made(scene, z, tip_contact=tip_contact)
        return self._bodies[key]

    def _made(self, scene: Scene, z: int, *, tip_contact: bool) -> Body:
        """A body as another scene has it; its elements stay, if its curve is another one."""
        body, spec = self._pair.bodies[z], (scene.body_1, scene.body_2)[z]
        mine = (self._scene.body_1, self._scene.body_2)[z]
        if body.mesh is None and body.imported is None and not spec.rigid:
            if z not in self._meshes:
                (self._meshes[z],) = bodies_of(scene, self._pair.discretization, (z,))
            body = replace(body, mesh=self._meshes[z].mesh)
        spatial = is_spatial(scene).on
        if body.axial is not None and not spatial:  # its transverse section
            body = replace(body, axial=None)
        elif _differ(spec, mine, "rigid", "pitch_errors_um") or (spatial and body.axial is None):
            rigid = with_rigid(scene, f"body_{z + 1}", rigid=True)
            (built,) = bodies_of(rigid, self._pair.discretization, (z,))
            body = replace(built, mesh=body.mesh)
        own = getattr(spec, "pitch_errors_um", ())
        if body.imported is not None:  # a file has its own
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
        friction = any(each.has_friction for each in spatial)
        for scene in spatial:  # those on a shaft first: a held bore is solved with them
            if self._variant(scene, z).shaft is not None:
                self._solve_prism(z, scene, friction=friction)
        for scene in spatial:
            self._solve_prism(z, scene, friction=friction)

    def _solve_prism(self, z: int, scene: Scene, *, friction: bool) -> None:
        """A three-dimensional body on coarse elements, and the plane body on the same elements."""
        variant = self._variant(scene, z)
        if variant in self._jobs[z]:
            return
        load_packages()
        body, (found, *held) = coarse_compliances(scene, z, friction=friction)
        self._jobs[z][variant] = found
        for each in held:
            self._jobs[z].setdefault(replace(variant, shaft=None), each)
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
            self._jobs[z][Variant()] = self._sections[z]
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
        variants = list(dict.fromkeys(self._variant(scene, z) for scene in asked))
        finite = not self._pair.pairing.whole_circle and "finite_influence" in self._toggles
        along = finite and self._toggles["finite_influence"].scene is not None
        found = flank_compliances(
            body,
            [(variant.sectors, variant.growth) for variant in variants],
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
            self._jobs[z][variant] = compliance
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
        growth = pair.body_loads[z]
        elastic = pair.elastic[z]
        return elastic or (growth is not None and growth.needs_elements)

    def _variant(self, scene: Scene, z: int) -> Variant:
        """What is built of the elements of a body for a scene."""
        pair = self.assembly(scene)
        axial, growth = pair.bodies[z].axial, pair.body_loads[z]
        grows = growth if growth is not None and growth.needs_elements else None
        flexible = None if axial is None else axial.flexible
        return Variant(is_spatial(scene).on, flexible, scene.sectors, grows)

    def sections(self, pair: BodyPair) -> Compliances:
        """Plane compliances on the elements of coarse three-dimensional bodies."""
        bodies, coupled = pair.bodies, self._scene.effects.tooth_coupling
        one, two = (self._sections.get(z) or no_compliance(bodies[z]) for z in (0, 1))
        return (one, two) if coupled else (one.without_coupling(), two.without_coupling())

    def compliances(self, scene: Scene, pair: BodyPair) -> Compliances:
        """Compliances of both bodies."""
        return self.compliance(scene, pair, 0), self.compliance(scene, pair, 1)

    def compliance(self, scene: Scene, pair: BodyPair, z: int) -> BodyCompliance:
        """Compliance of a body, before it grows as a whole."""
        body, growth = pair.bodies[z], pair.body_loads[z]
        if not self._needs_elements(scene, z):
            return no_compliance(body, growth)
        found = self._jobs[z].get(self._variant(scene, z)) if self._jobs[z] else None
        found = found or self._from_file(scene, body, z)
        if growth is not None and (body.imported is not None or not growth.needs_elements):
            found = replace(found, expansion=Expansion(growth.strain))
        if not scene.effects.coast_flank:
            found = replace(found, coast=None)
        return found if scene.effects.tooth_coupling else found.without_coupling()

    def _from_file(self, scene: Scene, body: Body, z: int) -> BodyCompliance:
        """Compliance that a body has from its file, without expansion."""
        key = scene.has_friction, scene.effects.influence
        if key not in self._of_files[z]:
            plain = with_keys(scene, tooth_coupling=True)
            self._of_files[z][key] = compliance_of(body, plain, self._pair.discretization)
        return self._of_files[z][key]


def screened(scene: Scene) -> Scene:
    """The scene as it is screened: without what changes no state, or is looked at by itself."""
    effects = structs.replace(
        scene.effects, root_stress=False, near_field="analytic", influence="small"
    )
    accuracy = structs.replace(scene.accuracy, modes=None)
    return replace(scene, effects=effects, accuracy=accuracy)


def _differ(one: Any, two: Any, *left_out: str) -> bool:
    """Whether two tables of a body differ, other than in some keys."""
    names = [name for name in one.__struct_fields__ if name not in left_out]
    return type(one) is not type(two) or any(getattr(one, n) != getattr(two, n) for n in names)


# --- three-dimensional bodies on coarse elements --------------------------------------------------
def coarse_compliances(
    scene: Scene, z: int, *, friction: bool = False
) -> tuple[Body, tuple[BodyCompliance, ...]]:
    """Body z (0, 1) of a three-dimensional scene on coarse elements, and its compliance.

    With a flexible shaft, the compliance with a held bore is the second one.

    Elements that the scene names coarser, or a file gives, stay. `friction`: loads along the flank
    are solved, too.
    """
    spec, named_mm = (scene.body_1, scene.body_2)[z], scene.accuracy.flank_element_mm
    if named_mm is not None:
        named_mm = max(named_mm, COARSE_PRISM.flank_element_parts * getattr(spec, "module_mm", 0.0))
    accuracy = structs.replace(scene.accuracy, flank_element_mm=named_mm, modes=None)
    scene = replace(scene, accuracy=accuracy)
    (body,) = bodies_of(scene, COARSE_PRISM, (z,))
    assert body.axial is not None
    prism = Prism(
        body.axial.range_mm,
        body.axial.twist_rad_per_mm,
        degree=DEGREE,
        load_degree=LOAD_DEGREE,
        cut_degree=CUT_DEGREE,
        screening=True,
        regions=body.axial.regions,
        shaft=body.axial.flexible,
    )
    modes = modes_of(body, scene, COARSE_PRISM)
    return body, carried_and_held(body, prism, n_modes=modes, friction=friction)


@dataclass(frozen=True)
class PrismRates:
    """Measured cost of coarse elements in three dimensions, of a body with the coarse mesh."""

    body: Body
    job: JobCost

    def price(self, scene: Scene, body: Body, counters: Mapping[str, int]) -> Account:
        """CPU seconds and bytes of the elements of a run, by the counters of the stage."""
        degree, _ = degrees_of(scene.accuracy)
        coarse, mesh = self.body.mesh, body.mesh
        assert isinstance(coarse, SectorMesh)
        assert isinstance(mesh, SectorMesh)
        steps = self.job.seconds
        modes, rubbing = (counters[f"unit_loads_{each}"] for each in ("normal", "tangential"))
        nodes, own = (
            unknowns / (p + 1)
            for unknowns, p in (
                (counters["fe_unknowns"], degree),
                (self.job.degrees_of_freedom, DEGREE),
            )
        )
        pairs = nodes * log(nodes) / (own * log(own)) * ((degree + 1) / (DEGREE + 1)) ** 2
        cuts = len(mesh.left_nodes) / len(coarse.left_nodes)
        cuts *= (min(Prism.cut_degree, degree) + 1) / (CUT_DEGREE + 1)
        places = counters["stress_recoveries"]
        more_s, more_bytes = (RECOVERY_SECONDS, RECOVERY_BYTES) if places else (0.0, 0.0)
        seconds = (
            steps["assembly"] * nodes / own
            + steps["factorisation"] * pairs * (1.0 + more_s)
            + steps["ring"] * cuts**3
            + steps["near field"] * (modes + rubbing) / self.job.counters["fe_solutions"]
        )
        return Account(
            cpu_s=seconds,
            bytes=8 * mesh.teeth * modes * (modes + rubbing + places * (degree + 1)),
            workspace_bytes=round(self.job.workspace_bytes * pairs * (1.0 + more_bytes)),
        )
