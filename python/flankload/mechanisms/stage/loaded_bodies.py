"""Fields of the elements of sun, planets and ring under the contact forces of a result."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flankload.base.gauss import leggauss
from flankload.base.rotation import turned
from flankload.mechanisms.flank_pair.loaded_bodies import POINTS, stress_in_world
from flankload.mechanisms.protocol import NodalFields

if TYPE_CHECKING:
    from flankload.base.arrays import Floats, Numbers
    from flankload.elasticity.loaded_body import LoadedBody
    from flankload.mechanisms.protocol import FieldsOfBody
    from flankload.mechanisms.stage.assembly import StageAssembly
    from flankload.result import Result
    from flankload.scene import Scene


@dataclass(frozen=True, eq=False)
class MemberOfStage:
    """A member of a plane stage, with elements for the contact forces of results.

    The ring is solved in its mirror image, in which its working flanks touch.

    Attributes
    ----------
    assembly : StageAssembly
    loaded : LoadedBody
    number : int
        0 of the sun, 1 to n of the planets, n + 1 of the ring.
    """

    assembly: StageAssembly
    loaded: LoadedBody
    number: int

    @property
    def cells(self) -> tuple[tuple[str, Numbers], ...]:
        """Elements, by index of the points of the fields."""
        return self.loaded.cells

    @property
    def section_nodes(self) -> int:
        """Number of nodes of a section."""
        return len(self.loaded.nodes)

    @property
    def is_ring(self) -> bool:
        """Whether the member is the ring."""
        return self.number > self.assembly.pairing.count

    @property
    def meshes(self) -> tuple[int, ...]:
        """Numbers of the meshes of the member."""
        n = self.assembly.pairing.count
        if self.number == 0:
            return tuple(range(n))
        return tuple(range(n, 2 * n)) if self.is_ring else (self.number - 1, n + self.number - 1)

    def at(self, result: Result, p: int) -> NodalFields:
        """Fields of a result of the scene at position p, in the frame of the carrier."""
        loaded, pairing = self.loaded, self.assembly.pairing
        first = pairing.meshes[pairing.count]
        turn = first.turns(result.position_rad)[p, 1]
        if not self.is_ring:
            turn = pairing.body_angles(result.position_rad)[p, self.number]
        forces = np.zeros(2 * len(loaded.nodes))
        pressure = np.zeros(len(loaded.nodes))
        for m in self.meshes:
            self._add(result, p, m, float(turn), forces, pressure)
        moved = loaded.solve(forces / result.face_width_mm)
        points = turned(loaded.nodes, turn)
        vectors = [turned(part.reshape(-1, 2), turn) for part in (moved, forces)]
        stress = stress_in_world(loaded.stress_MPa(moved), turn)
        if self.is_ring:  # out of the mirror image, which is that of the mesh of planet 1
            points, *vectors = (first.in_common_frame(part) for part in (points, *vectors))
            stress[:, 3] *= -1.0
            stress = stress_in_world(stress, first.frame_rad)
        elif self.number > 0:
            points = points + pairing.centers_mm[self.number - 1]
        return NodalFields(points, vectors[0], stress, pressure, vectors[1])

    def _add(
        self, result: Result, p: int, m: int, turn: float, forces: Floats, pressure: Floats
    ) -> None:
        """Add the forces of a mesh, in the frame of the body, and their pressure at the nodes."""
        loaded, pairing = self.loaded, self.assembly.pairing
        mesh, first = pairing.meshes[m], pairing.meshes[pairing.count]
        assert result.stage is not None
        table = result.stage.meshes[m].pairs(p)
        carries = table.force_N > 0
        own = 0 if self.number == 0 or (mesh.with_ring and not self.is_ring) else 1
        x, weights = leggauss(POINTS)
        at = np.searchsorted(mesh.pairing.sites, table.site[carries])
        tooth = mesh.pairing.site_teeth[own][at]
        s = (table.arc_length_1_mm, table.arc_length_2_mm)[own][carries]
        s = (s[:, None] + 0.5 * table.cell_mm[carries, None] * x).ravel()
        body = self.assembly.bodies[0 if self.number == 0 else 2 if self.is_ring else 1]
        (low, high), (begin, end) = body.mode_range_mm, loaded.body.mode_range_mm
        s = begin + (s - low) * ((end - begin) / (high - low))
        amount = np.outer(table.force_N[carries], 0.5 * weights).ravel()
        force = mesh.in_common_frame(table.normal[carries]) * (1.0 if own == 1 else -1.0)
        if self.is_ring:
            tooth = -tooth % body.teeth
            force = turned(force, -first.frame_rad) * np.array([1.0, first.sense])
        tooth = np.repeat(tooth, POINTS)
        force = amount[:, None] * np.repeat(turned(force, -turn), POINTS, axis=0)
        coast = mesh.with_ring and not self.is_ring
        forces += loaded.nodal_forces(tooth, s, force, coast=coast)
        along = np.column_stack([amount, np.zeros_like(amount)])
        nodal = loaded.nodal_forces(tooth, s, along, coast=coast)[::2]
        for each in np.unique(tooth).tolist():
            nodes, widths = loaded.flank_widths(each, coast=coast)
            pressure[nodes] += nodal[nodes] / (widths * result.face_width_mm)


def fields_of_members(scene: Scene, assembly: StageAssembly) -> dict[str, FieldsOfBody | str]:
    """Members of a stage by name, or the reason why one has no fields."""
    from flankload.elasticity.loaded_body import loaded_body

    n, found = assembly.pairing.count, dict[str, "FieldsOfBody | str"]()
    numbers = {"body_1": (0,), "planet": range(1, n + 1), "body_2": (n + 1,)}
    for z, (table, body) in enumerate(zip(assembly.names, assembly.bodies, strict=True)):
        why = ""
        if not body.axial.plane:
            why = "this version has fields of plane stages"
        elif body.mesh is None or not assembly.jobs[z].elastic:
            why = "rigid, so it has no fields"
        elif z == 2 and assembly.jobs[z].rim:
            why = "its rim is not clamped, so it has no fields in this version"
        if why:
            found[table] = why
            continue
        loaded = loaded_body(body, scene.accuracy.plane)
        for number in numbers[table]:
            name = table if table != "planet" else f"planet_{number}"
            found[name] = MemberOfStage(assembly, loaded, number)
    return found
