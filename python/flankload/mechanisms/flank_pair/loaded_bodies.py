"""Elements of both bodies of a pair under the contact forces of its results."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flankload.elasticity.loaded_body import loaded_body
from flankload.errors import SceneError
from flankload.mechanisms.elements import prism_of
from flankload.mechanisms.flank_pair.assembly import build_bodies
from flankload.mechanisms.loaded_bodies import BodyInContact, Contacts, Frame
from flankload.pairing.pairing import coast_sites

if TYPE_CHECKING:
    from flankload.base.arrays import Floats, Numbers
    from flankload.bodies import Body
    from flankload.mechanisms.protocol import FieldsOfBody
    from flankload.result import Result
    from flankload.scene import Scene


@dataclass(frozen=True, eq=False)
class BodyOfPair(BodyInContact):
    """Body 0 or 1 of a pair; `other` is its mate."""

    other: Body

    def place(self, result: Result, p: int) -> tuple[Frame, Floats]:
        """Frame of the body at position p, and the place (2,) of its axis."""
        drawing = result.drawing
        angle = (drawing.angle_1, drawing.angle_2)[self.number][p]
        center = np.array([self.number * drawing.center_distance_mm, 0.0])
        return Frame(float(angle), twist=self.loaded.section.twist), center

    def contacts(self, result: Result, p: int) -> list[Contacts]:
        """Contacts on working and coast flanks."""
        table, number = result.pairs(p), self.number
        if table.z_mm is None and self.loaded.axial.degree:
            raise SceneError(
                key="results", expected="results of this scene", found="those of a plane scene"
            )
        found = [Contacts(result, table, number, self._teeth(table.site))]
        if result.coast is not None:
            table = result.coast.pair_tables[p]
            pair = (self.body, self.other)[:: 1 if number == 0 else -1]
            teeth = coast_sites(table.site, *pair).site_teeth[number]
            found.append(Contacts(result, table, number, teeth, coast=True))
        return found

    def _teeth(self, sites: Numbers) -> Numbers:
        """Teeth of the body at pair numbers."""
        sense = 1 if self.number == 0 else -self.body.outward
        return np.asarray(sense * sites % self.body.teeth)


def field_bodies(scene: Scene) -> dict[str, FieldsOfBody | str]:
    """Both bodies of a scene by name, for the contact forces of its results.

    A string gives the reason why a body has no fields.
    """
    pair = build_bodies(scene)
    found: dict[str, FieldsOfBody | str] = {}
    for z, (name, body) in enumerate(zip(pair.names, pair.bodies, strict=True)):
        if body.imported is not None:
            found[name] = "its compliance comes from a file, so it has no elements and no fields"
        elif body.mesh is None or not pair.jobs[z].elastic:
            found[name] = "rigid, so it has no fields"
        else:
            loaded = loaded_body(
                body,
                scene.accuracy.plane,
                prism=prism_of(body, scene),
                width_mm=pair.face_width_mm,
            )
            found[name] = BodyOfPair(z, body, loaded, pair.bodies[1 - z])
    return found
