"""Fields of the elements under the contact forces of a result: displacement, stress, pressure."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flankload.base.rotation import turned
from flankload.elasticity.loaded_body import loaded_body
from flankload.elasticity.prism.loaded_prism import loaded_prism
from flankload.mechanisms.flank_pair.assembly import build_bodies
from flankload.mechanisms.flank_pair.loaded_solids import SolidBody
from flankload.mechanisms.flank_pair.nodal_fields import POINTS, BodyOfPair, NodalFields
from flankload.mechanisms.flank_pair.stages import prism_of

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from flankload.elasticity.loaded_body import LoadedBody
    from flankload.result import PairTable, Result
    from flankload.scene import Scene

    Floats = NDArray[np.float64]
    Numbers = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class FieldBody(BodyOfPair):
    """One body of a plane pair whose elements are loaded with the contact forces of results.

    Attributes
    ----------
    number, body, other
        Number, this body of the scene, and the other one.
    loaded : LoadedBody
    """

    loaded: LoadedBody

    @property
    def cells(self) -> tuple[tuple[str, Numbers], ...]:
        """Elements, in the points of the fields."""
        return self.loaded.cells

    def at(self, result: Result, p: int) -> NodalFields:
        """Fields of a result at position p.

        Parameters
        ----------
        result : Result
            Of the scene of the bodies; its discretization may be another one.
        p : int
            Index of the position.

        Returns
        -------
        NodalFields
        """
        drawing, loaded = result.drawing, self.loaded
        angle = float((drawing.angle_1, drawing.angle_2)[self.number][p])
        tables = [(result.pairs(p), False)]
        if result.coast is not None:
            tables.append((result.coast.pair_tables[p], True))
        forces = np.zeros(2 * len(loaded.nodes))
        pressure = np.zeros(len(loaded.nodes))
        for table, coast in tables:
            tooth, s, force, normal = self._points(table, coast, angle)
            forces += loaded.nodal_forces(tooth, s, force, coast=coast)
            along = np.column_stack([normal, np.zeros_like(normal)])
            at_nodes = loaded.nodal_forces(tooth, s, along, coast=coast)[::2]
            for each in np.unique(tooth):
                nodes, widths = loaded.flank_widths(int(each), coast=coast)
                pressure[nodes] = at_nodes[nodes] / (widths * result.face_width_mm)
        moved = loaded.solve(forces / result.face_width_mm)
        center = np.array([self.number * drawing.center_distance_mm, 0.0])
        return NodalFields(
            points_mm=turned(loaded.nodes, angle) + center,
            displacement_mm=turned(moved.reshape(-1, 2), angle),
            stress_MPa=_turned_stress(loaded.stress_MPa(moved), angle),
            contact_pressure_MPa=pressure,
            force_N=turned(forces.reshape(-1, 2), angle),
        )

    def _points(
        self, table: PairTable, coast: bool, angle: float
    ) -> tuple[Numbers, Floats, Floats, Floats]:
        """Teeth, arc lengths (n,), forces (n, 2) in the body's frame, N, and normal forces (n,)."""
        carries = table.force_N > 0
        x, weights = np.polynomial.legendre.leggauss(POINTS)
        site, cell = table.site[carries], table.cell_mm[carries]
        s = (table.arc_length_1_mm, table.arc_length_2_mm)[self.number][carries]
        s = self.on_elements((s[:, None] + 0.5 * cell[:, None] * x).ravel(), self.loaded.body)
        normal = np.column_stack([table.normal_x, table.normal_y])[carries]
        on_1 = -table.force_N[carries, None] * normal
        if table.friction_force_N is not None:
            tangent = np.column_stack([normal[:, 1], -normal[:, 0]]) * (-1.0 if coast else 1.0)
            on_1 += table.friction_force_N[carries, None] * tangent
        force = turned(on_1 if self.number == 0 else -on_1, -angle)
        share = np.tile(0.5 * weights, site.size)
        return (
            np.repeat(self.teeth(site, coast), POINTS),
            s,
            share[:, None] * np.repeat(force, POINTS, axis=0),
            share * np.repeat(table.force_N[carries], POINTS),
        )


def field_bodies(scene: Scene) -> dict[str, FieldBody | SolidBody | str]:
    """Both bodies of a scene, ready for the contact forces of its results.

    Parameters
    ----------
    scene : Scene
        Of flank pairs.

    Returns
    -------
    dict of str to FieldBody, SolidBody or str
        By name (body_1, body_2); a text says why a body has no fields.
    """
    pair = build_bodies(scene)
    bodies = (pair.body_1, pair.body_2)
    elastic = (pair.effects.elastic_body_1, pair.effects.elastic_body_2)
    found: dict[str, FieldBody | SolidBody | str] = {}
    for z, body in enumerate(bodies):
        name = f"body_{z + 1}"
        if body.given is not None:
            found[name] = "its compliance comes from a file, so it has no elements and no fields"
        elif body.mesh is None or not elastic[z]:
            found[name] = "rigid, so it has no fields"
        elif pair.effects.three_dimensions:
            loaded_solid = loaded_prism(body, prism_of(body, scene))
            found[name] = SolidBody(z, body, bodies[1 - z], loaded_solid)
        else:
            loaded = loaded_body(body, scene.accuracy.plane)
            found[name] = FieldBody(z, body, bodies[1 - z], loaded)
    return found


def _turned_stress(stress: Floats, angle: float) -> Floats:
    """Stress (M, 4) as xx, yy, zz, xy in axes against which the body is turned by an angle."""
    xx, yy, zz, xy = stress.T
    cosine, sine = np.cos(angle), np.sin(angle)
    across = 2.0 * sine * cosine * xy
    return np.stack(
        [
            cosine**2 * xx + sine**2 * yy - across,
            sine**2 * xx + cosine**2 * yy + across,
            zz,
            sine * cosine * (xx - yy) + (cosine**2 - sine**2) * xy,
        ],
        axis=1,
    )
