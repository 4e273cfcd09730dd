"""Scenes on coarse meshes, with few modes and wide cells: good enough to tell what an effect does.

What two scenes have in common is built and solved once: bodies by their tables, compliances by
what they depend on. Bodies from files are what they are; their meshes cannot be made coarser.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
from msgspec import structs

from flankload.assembly import BodyPair, bodies_of, build_bodies
from flankload.bodies.body import Material
from flankload.compliance import BodyCompliance, no_compliance
from flankload.elasticity import condensed, stiffness
from flankload.plan.sizes import States
from flankload.resolution import Grid, Resolution
from flankload.scene.tables import EffectsAsked, Positions
from flankload.stages import compliance_of, sweep_of

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from flankload.bodies import Body
    from flankload.scene import Scene

#: Rotation of the FZG type C pair within 0.2 % of the converged one, a position in 0.15 ms.
COARSE = Resolution(flank_element_parts=0.5, modes=4, grid=Grid(4.0, 12.0))
#: Positions that a size is taken from, spread over those of the scene.
MOST_POSITIONS = 32
#: Kinds of bodies that come as files.
FROM_FILES = ("mesh", "compliance")
#: Effects that no compliance depends on.
NO_COMPLIANCE = (
    "friction_coefficient",
    "root_stress",
    "contact",
    "tip_contact",
    "influence",
    "choose",
)


class Coarse:
    """Coarse scenes at some positions of one scene.

    Parameters
    ----------
    scene : Scene
    """

    def __init__(self, scene: Scene) -> None:
        self._bodies: dict[Any, Body] = {}
        self._compliances: dict[Any, BodyCompliance] = {}
        scene = without_knobs(scene)
        bodies = (self._body(scene, 0), self._body(scene, 1))
        self.position_rad = some_of(build_bodies(scene, COARSE, bodies=bodies).position_rad)
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
        """Bodies of a scene, coarsely meshed."""
        scene = self.of(scene)
        bodies = (self._body(scene, 0), self._body(scene, 1))
        return build_bodies(scene, COARSE, bodies=bodies)

    def _body(self, scene: Scene, z: int) -> Body:
        """A body; one of another, where only its errors differ or that it does not yield."""
        spec = (scene.body_1, scene.body_2)[z]
        key = z, _placed(spec)
        if key not in self._bodies and spec.rigid:
            key = z, structs.replace(key[1], rigid=False)
        if key not in self._bodies:
            key = z, _placed(spec)
            self._bodies[key] = bodies_of(scene, COARSE, (z,))[0]
        body = self._bodies[key]
        errors = getattr(spec, "pitch_errors_um", ())
        if spec.kind == "compliance" and not errors:
            errors = body.pitch_errors_um  # those of the file
        return replace(body, rigid=spec.rigid, pitch_errors_um=tuple(errors))

    def compliances(self, scene: Scene, pair: BodyPair) -> tuple[BodyCompliance, BodyCompliance]:
        """Compliances of its bodies; with friction from the first on where elements are solved."""
        elastic = (pair.effects.elastic_body_1, pair.effects.elastic_body_2)
        found = []
        for z, body in enumerate((pair.body_1, pair.body_2)):
            if not elastic[z]:
                found.append(no_compliance(body))
                continue
            rubs = scene.has_friction or body.given is None
            asked = _for_compliance(scene, rubs=rubs)
            spec = (scene.body_1, scene.body_2)[z]
            key = (z, _placed(spec), asked.effects)
            if key not in self._compliances:
                if body.mesh is not None and not self._compliances:
                    load_elements()
                self._compliances[key] = compliance_of(body, self.of(asked), COARSE)
            found.append(self._compliances[key])
        return found[0], found[1]

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
        found = sweep_of(scene, pair)(
            compliances=self.compliances(scene, pair),
            position_rad=self.position_rad,
            torques_Nmm=[1000.0 * torque for torque in torques],
            grid=grid,
            keep_pairs=False,
        )
        sites = pair.pairing.sites
        return [
            States.of(torque, sites, part.rotation_rad, part.site_force_N)
            for torque, part in zip(torques, found, strict=True)
        ]


def without_knobs(scene: Scene) -> Scene:
    """The scene without knobs of its own, and without what changes no state.

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


def _for_compliance(scene: Scene, *, rubs: bool) -> Scene:
    plain = EffectsAsked()
    kept = {key: getattr(plain, key) for key in NO_COMPLIANCE if hasattr(plain, key)}
    if rubs:
        kept["friction_coefficient"] = 1.0
    return replace(scene, effects=structs.replace(scene.effects, **kept))
