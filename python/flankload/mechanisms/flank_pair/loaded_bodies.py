"""Fields of the elements under the contact forces of a result: displacement, stress, pressure."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import TYPE_CHECKING

import numpy as np

from flankload.base.gauss import leggauss
from flankload.base.rotation import turned
from flankload.errors import SceneError
from flankload.mechanisms.elements import prism_of
from flankload.mechanisms.flank_pair.assembly import build_bodies
from flankload.mechanisms.protocol import NodalFields
from flankload.pairing.pairing import coast_sites

if TYPE_CHECKING:
    from flankload.base.arrays import Flags, Floats, Numbers
    from flankload.bodies import Body
    from flankload.elasticity.loaded_body import LoadedBody
    from flankload.elasticity.prism.loaded_prism import LoadedPrism, SolidPart
    from flankload.mechanisms.protocol import FieldsOfBody
    from flankload.result import PairTable, Result
    from flankload.scene import Scene


#: Gauss points of a contact cell at which its force acts on the elements.
POINTS = 4


@dataclass(frozen=True, eq=False)
class PointForces:
    """Forces (n, 3) at points of the flanks of a body, N.

    Their frame is that of the body, rotated with the helix; `normal_N` (n,) are magnitudes of the
    components normal to the flank, `s_mm` (n,) arc lengths on the flank of the elements, and
    `spans_mm` (n, 2) the ends along the axis of the slice over which a force is uniform; `coast`
    (n,) whether it acts on a coast flank.
    """

    tooth: Numbers
    s_mm: Floats
    spans_mm: Floats
    force_N: Floats
    normal_N: Floats
    coast: Flags


@dataclass(frozen=True, eq=False)
class BodyOfPair:
    """Body 0 or 1 of a pair, with elements for the contact forces of results."""

    number: int
    body: Body
    other: Body
    loaded: LoadedBody | LoadedPrism

    @property
    def section_nodes(self) -> int:
        """Number of nodes of a section."""
        return len(self.loaded.nodes)

    def teeth(self, sites: Numbers, coast: bool) -> Numbers:
        """Teeth of the body at pair numbers."""
        one, two = (self.body, self.other) if self.number == 0 else (self.other, self.body)
        if coast:
            return coast_sites(sites, one, two).site_teeth[self.number]
        sense = 1 if self.number == 0 else -self.body.outward
        return np.asarray(sense * sites % self.body.teeth)

    def on_elements(self, s: Floats) -> Floats:
        """Arc lengths on the flank of the elements for those on the flank of the body."""
        low, high = self.body.mode_range_mm
        first, last = self.loaded.body.mode_range_mm
        return np.asarray(first + (s - low) * ((last - first) / (high - low)))

    def angle(self, result: Result, p: int) -> float:
        """Angle of the body's frame at position p."""
        drawing = result.drawing
        return float((drawing.angle_1, drawing.angle_2)[self.number][p])

    def center(self, result: Result) -> Floats:
        """Position (2,) of the body's axis."""
        return np.array([self.number * result.drawing.center_distance_mm, 0.0])

    def point_forces(
        self, result: Result, table: PairTable, turn: tuple[float, float], *, coast: bool = False
    ) -> PointForces:
        """Contact forces of a table, at Gauss points of its cells.

        `turn` has the angle of the body at z = 0 and its twist, rad/mm.
        """
        shape, slices = result.drawing.axial[0], result.width_loads
        carries = table.force_N > 0
        x, weights = leggauss(POINTS)
        site, cell, normal_N = table.site[carries], table.cell_mm[carries], table.force_N[carries]
        s = (table.arc_length_1_mm, table.arc_length_2_mm)[self.number][carries]
        s = self.on_elements((s[:, None] + 0.5 * cell[:, None] * x).ravel())
        normal = table.normal[carries]
        # the outward normal of body 1 has an axial component
        lever = table.x_mm[carries] * normal[:, 1] - table.y_mm[carries] * normal[:, 0]
        axial = -shape.twist_rad_per_mm * lever
        normals = np.column_stack([normal, axial])
        on_1 = -normal_N[:, None] * normals / np.linalg.norm(normals, axis=1, keepdims=True)
        if table.friction_force_N is not None:
            tangent = np.column_stack([normal[:, 1], -normal[:, 0], np.zeros(len(normal))])
            tangent *= -1.0 if coast else 1.0
            on_1 += table.friction_force_N[carries, None] * tangent
        z, half = np.zeros(site.size), np.zeros(site.size)
        if table.z_mm is not None:
            z = table.z_mm[carries]
            half = 0.5 * slices.width_mm[np.abs(slices.z_mm - z[:, None]).argmin(axis=1)]
        angle, twist = turn
        force = in_world(on_1 if self.number == 0 else -on_1, -(angle + twist * z))
        share = np.tile(0.5 * weights, site.size)
        return PointForces(
            np.repeat(self.teeth(site, coast), POINTS),
            s,
            np.repeat(np.column_stack([z - half, z + half]), POINTS, axis=0),
            share[:, None] * np.repeat(force, POINTS, axis=0),
            share * np.repeat(normal_N, POINTS),
            np.full(s.size, coast),
        )


@dataclass(frozen=True, eq=False)
class FieldBody(BodyOfPair):
    """A body of a plane pair, with elements for the contact forces of results."""

    loaded: LoadedBody

    @property
    def cells(self) -> tuple[tuple[str, Numbers], ...]:
        """Elements, by index of the points of the fields."""
        return self.loaded.cells

    def at(self, result: Result, p: int) -> NodalFields:
        """Fields of a result at position p.

        Parameters
        ----------
        result : Result
            Of the scene of the bodies; its discretization may be another one.
        p : int
            Index of the position.
        """
        loaded, angle = self.loaded, self.angle(result, p)
        tables = [(result.pairs(p), False)]
        if result.coast is not None:
            tables.append((result.coast.pair_tables[p], True))
        forces = np.zeros(2 * len(loaded.nodes))
        pressure = np.zeros(len(loaded.nodes))
        for table, coast in tables:
            on = self.point_forces(result, table, (angle, 0.0), coast=coast)
            forces += loaded.nodal_forces(on.tooth, on.s_mm, on.force_N[:, :2], coast=coast)
            along = np.column_stack([on.normal_N, np.zeros_like(on.normal_N)])
            at_nodes = loaded.nodal_forces(on.tooth, on.s_mm, along, coast=coast)[::2]
            for each in np.unique(on.tooth):
                nodes, widths = loaded.flank_widths(int(each), coast=coast)
                pressure[nodes] = at_nodes[nodes] / (widths * result.face_width_mm)
        moved = loaded.solve(forces / result.face_width_mm)
        return NodalFields(
            points_mm=turned(loaded.nodes, angle) + self.center(result),
            displacement_mm=turned(moved.reshape(-1, 2), angle),
            stress_MPa=stress_in_world(loaded.stress_MPa(moved), angle),
            contact_pressure_MPa=pressure,
            force_N=turned(forces.reshape(-1, 2), angle),
        )


@dataclass(frozen=True, eq=False)
class SolidBody(BodyOfPair):
    """A three-dimensional body, with elements for the contact forces of results."""

    loaded: LoadedPrism

    @property
    def cells(self) -> tuple[tuple[str, Numbers], ...]:
        """Elements, by index of the points of the fields, part by part."""
        found, first = [], 0
        for part in self.loaded.parts:
            found += [(kind, data + first) for kind, data in part.solids]
            first += part.nodes.size * part.z_mm.size
        return tuple(found)

    def at(self, result: Result, p: int) -> NodalFields:
        """Fields of a result at position p, as of `FieldBody`."""
        loaded, twist, angle = self.loaded, self.loaded.prism.twist, self.angle(result, p)
        forces = self.forces(result, p)
        moved = loaded.displacements(
            forces.tooth, forces.s_mm, forces.spans_mm, forces.force_N, coast=forces.coast
        )
        center = self.center(result)
        found: list[list[Floats]] = []
        for part in loaded.parts:
            turns = np.broadcast_to(angle + twist * part.z_mm, (part.nodes.size, part.z_mm.size))
            nodal, pressure = self._nodal(part, forces)
            section = np.broadcast_to(loaded.nodes[part.nodes][:, None], (*turns.shape, 2))
            height = np.broadcast_to(part.z_mm, turns.shape)[..., None]
            v, stress = loaded.fields(part, moved)
            columns = [
                np.concatenate([turned(section, turns) + center, height], axis=-1),
                in_world(v, turns),
                stress_in_world(stress, turns),
                pressure[..., None],
                in_world(nodal, turns),
            ]
            found.append([column.reshape(turns.size, -1) for column in columns])
        points, moved_to, stresses, pressures, nodal_forces = map(
            np.concatenate, zip(*found, strict=True)
        )
        return NodalFields(points, moved_to, stresses, pressures[:, 0], nodal_forces)

    def forces(self, result: Result, p: int) -> PointForces:
        """Contact forces of position p, at Gauss points of the cells of each slice."""
        table = result.pairs(p)
        if table.z_mm is None:
            raise SceneError(
                key="results", expected="results of this scene", found="those of a plane scene"
            )
        turn = (self.angle(result, p), self.loaded.prism.twist)
        found = self.point_forces(result, table, turn)
        if result.coast is None:
            return found
        more = self.point_forces(result, result.coast.pair_tables[p], turn, coast=True)
        joined = {
            item.name: np.concatenate([getattr(part, item.name) for part in (found, more)])
            for item in fields(PointForces)
        }
        return PointForces(**joined)

    def _nodal(self, part: SolidPart, forces: PointForces) -> tuple[Floats, Floats]:
        """Forces (n, J, 3) at the points of a part, and pressures (n, J) on its flanks."""
        loaded, count = self.loaded, part.z_mm.size
        place = np.full(len(loaded.nodes), -1)
        place[part.nodes] = np.arange(part.nodes.size)
        sector, nodes, shapes = loaded.on_flank(forces.tooth, forces.s_mm, forces.coast)
        at = place[loaded.numbers[sector[:, None], nodes]]
        along = _on_layers(part.z_mm, forces.spans_mm)
        columns = np.column_stack([forces.force_N, forces.normal_N])
        found = np.zeros((part.nodes.size, count, 4))
        parts = np.einsum("na,nj,nc->najc", shapes, along, columns)
        np.add.at(found, at[at >= 0], parts[at >= 0])
        pressure, levels = found[..., 3], np.zeros(count)
        for k in range(0, count - 1, 2):  # Simpson's weights, as along the profile
            levels[k : k + 3] += (part.z_mm[k + 2] - part.z_mm[k]) / 6.0 * np.array([1, 4, 1])
        for coast in np.unique(forces.coast).tolist():
            flank, widths = loaded.flank_widths(coast=coast)
            for number in np.unique(sector[forces.coast == coast]):
                own = place[loaded.numbers[number, flank]]
                pressure[own[own >= 0]] /= widths[own >= 0, None] * levels
        return found[..., :3], pressure


def field_bodies(scene: Scene) -> dict[str, FieldsOfBody | str]:
    """Both bodies of a scene by name, for the contact forces of its results.

    A string gives the reason why a body has no fields.
    """
    from flankload.elasticity.loaded_body import loaded_body
    from flankload.elasticity.prism.loaded_prism import loaded_prism

    pair = build_bodies(scene)
    found: dict[str, FieldsOfBody | str] = {}
    for z, (name, body) in enumerate(zip(pair.names, pair.bodies, strict=True)):
        other = pair.bodies[1 - z]
        if body.imported is not None:
            found[name] = "its compliance comes from a file, so it has no elements and no fields"
        elif body.mesh is None or not pair.jobs[z].elastic:
            found[name] = "rigid, so it has no fields"
        elif pair.effects.three_dimensions:
            loaded_solid = loaded_prism(body, prism_of(body, scene))
            found[name] = SolidBody(z, body, other, loaded_solid)
        else:
            loaded = loaded_body(body, scene.accuracy.plane)
            found[name] = FieldBody(z, body, other, loaded)
    return found


def _on_layers(z_mm: Floats, spans_mm: Floats) -> Floats:
    """Means (n, J) of the quadratic shape functions along the axis over spans (n, 2)."""
    found = np.zeros((len(spans_mm), z_mm.size))
    points, weights = leggauss(2)  # parabolas are exact
    whole = spans_mm[:, 1] - spans_mm[:, 0]
    for k in range(0, z_mm.size - 1, 2):
        low, high = (np.clip(spans_mm, z_mm[k], z_mm[k + 2])).T
        places = 0.5 * (low + high)[:, None] + 0.5 * (high - low)[:, None] * points
        x = (2.0 * places - z_mm[k] - z_mm[k + 2]) / (z_mm[k + 2] - z_mm[k])
        shapes = np.stack([0.5 * x * (x - 1), 1 - x**2, 0.5 * x * (x + 1)], axis=-1)
        part = np.einsum("g,ngj->nj", 0.5 * weights, shapes)
        found[:, k : k + 3] += ((high - low) / whole)[:, None] * part
    return found


def in_world(vectors: Floats, turns: Floats) -> Floats:
    """Vectors (…, 3), rotated about z by angles (…)."""
    return np.concatenate([turned(vectors[..., :2], turns), vectors[..., 2:]], axis=-1)


def stress_in_world(stress: Floats, turns: Floats | float) -> Floats:
    """Stresses (…, 4 or 6) as xx, yy, zz, xy, yz, xz of sections rotated by angles (…)."""
    xx, yy, zz, xy, *shear = np.moveaxis(stress, -1, 0)
    mean, half = 0.5 * (xx + yy), np.stack([0.5 * (xx - yy), xy], axis=-1)
    half = turned(half, 2.0 * turns)
    parts = [mean + half[..., 0], mean - half[..., 0], zz, half[..., 1]]
    if shear:
        across = turned(np.stack(shear[::-1], axis=-1), turns)
        parts += [across[..., 1], across[..., 0]]
    return np.stack(parts, axis=-1)
