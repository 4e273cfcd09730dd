"""Elements of the bodies of several gear meshes under the contact forces of a result."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from flankload.elasticity.loaded_body import loaded_body
from flankload.mechanisms.elements import prism_of
from flankload.mechanisms.loaded_bodies import BodyInContact, Contacts, Frame

if TYPE_CHECKING:
    from flankload.base.arrays import Floats
    from flankload.mechanisms.protocol import FieldsOfBody
    from flankload.mechanisms.several.states import AnyAssembly
    from flankload.result import Result
    from flankload.scene import Scene


@dataclass(frozen=True, eq=False)
class BodyOfMeshes(BodyInContact):
    """A body of a drive with several gear meshes, in the frame of its first mesh.

    The working flanks of a ring touch in the mirror image, in which it is solved.
    """

    assembly: AnyAssembly

    sense: int

    def place(self, result: Result, p: int) -> tuple[Frame, Floats]:
        """Frame of the body at position p, and the place (2,) of its axis."""
        pairing = self.assembly.pairing
        turn = pairing.body_angles(result.position_rad[p : p + 1])[0, self.number]
        frame = Frame(float(turn), self.sense, self.loaded.section.twist)
        return frame, pairing.axes_mm[self.number]

    def contacts(self, result: Result, p: int) -> list[Contacts]:
        """Contacts of all its meshes."""
        found: list[Contacts] = []
        drive: Any = result.drive
        for m, own in self.assembly.pairing.meshes_of(self.number):
            mesh, of_mesh = self.assembly.pairing.meshes[m], drive.meshes[m]
            table = of_mesh.pairs(p)
            at = np.searchsorted(mesh.pairing.sites, table.site)
            teeth = self.sense * mesh.pairing.site_teeth[own][at] % self.body.teeth
            frame = Frame(mesh.frame_rad, mesh.sense)
            coast = mesh.sense != self.sense
            found.append(Contacts(of_mesh, table, own, teeth, coast, frame))
        return found


def fields_of_bodies(scene: Scene, assembly: AnyAssembly) -> dict[str, FieldsOfBody | str]:
    """Bodies by name, or the reason why one has no fields."""
    found, pairing = dict[str, "FieldsOfBody | str"](), assembly.pairing
    for z, (table, body, job) in enumerate(
        zip(assembly.names, assembly.bodies, assembly.jobs, strict=True)
    ):
        why = ""
        numbers = np.flatnonzero(np.equal(pairing.tables, z)).tolist()
        if body.mesh is None or not job.elastic:
            why = "rigid, so it has no fields"
        elif job.rim:
            why = "its rim is not clamped, so it has no fields in this version"
        elif table.startswith("body_") and len(numbers) > 1:
            why = "this version has no fields of double helical gears"
        if why:
            found[table] = why
            continue
        sense = pairing.meshes[pairing.meshes_of(numbers[0])[0][0]].sense
        own = body.in_mirror_image() if sense < 0 else body
        loaded = loaded_body(
            own,
            scene.accuracy.plane,
            prism=prism_of(own, scene),
            width_mm=assembly.face_width_mm,
        )
        for j, number in enumerate(numbers):
            name = table if table.startswith("body_") else f"{table}_{j + 1}"
            found[name] = BodyOfMeshes(number, body, loaded, assembly, sense)
    return found
