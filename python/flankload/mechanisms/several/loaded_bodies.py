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

    The working flanks of a ring touch in the mirror image; the ring is solved in a frame that is
    turned over, in which they do as well, and in which its helix has the same hand.
    """

    assembly: AnyAssembly

    @property
    def _sense(self) -> int:
        """-1 if the body is turned over."""
        pairing = self.assembly.pairing
        first, _ = pairing.meshes_of(self.number)[0]
        return pairing.meshes[first].sense

    def place(self, result: Result, p: int) -> tuple[Frame, Floats]:
        """Frame of the body at position p, and the place (2,) of its axis."""
        pairing = self.assembly.pairing
        turn = pairing.body_angles(result.position_rad[p : p + 1])[0, self.number]
        return Frame(
            float(turn), (1, self._sense, self._sense), self.loaded.section.twist
        ), pairing.axes_mm[self.number]

    def contacts(self, result: Result, p: int) -> list[Contacts]:
        """Contacts of all its meshes."""
        found: list[Contacts] = []
        drive: Any = result.drive
        for m, own in self.assembly.pairing.meshes_of(self.number):
            mesh, of_mesh = self.assembly.pairing.meshes[m], drive.meshes[m]
            table = of_mesh.pairs(p)
            at = np.searchsorted(mesh.pairing.sites, table.site)
            teeth = self._sense * mesh.pairing.site_teeth[own][at] % self.body.teeth
            frame = Frame(mesh.frame_rad, (1, mesh.sense, 1))
            coast = mesh.sense != self._sense
            found.append(Contacts(of_mesh, table, own, teeth, coast, frame))
        return found


def fields_of_bodies(scene: Scene, assembly: AnyAssembly) -> dict[str, FieldsOfBody | str]:
    """Bodies by name, or the reason why one has no fields."""
    found, tables = dict[str, "FieldsOfBody | str"](), np.array(assembly.pairing.tables)
    for z, (table, body, job) in enumerate(
        zip(assembly.names, assembly.bodies, assembly.jobs, strict=True)
    ):
        why = ""
        numbers = np.flatnonzero(tables == z).tolist()
        if body.mesh is None or not job.elastic:
            why = "rigid, so it has no fields"
        elif job.rim:
            why = "its rim is not clamped, so it has no fields in this version"
        elif table.startswith("body_") and len(numbers) > 1:
            why = "this version has no fields of double helical gears"
        if why:
            found[table] = why
            continue
        loaded = loaded_body(
            body,
            scene.accuracy.plane,
            prism=prism_of(body, scene),
            width_mm=assembly.face_width_mm,
        )
        for j, number in enumerate(numbers):
            name = table if table.startswith("body_") else f"{table}_{j + 1}"
            found[name] = BodyOfMeshes(number, body, loaded, assembly)
    return found
