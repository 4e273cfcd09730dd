"""Fields of three-dimensional elements under the contact forces of a result."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flankload.errors import SceneError
from flankload.mechanisms.flank_pair.nodal_fields import POINTS, BodyOfPair, NodalFields

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from flankload.elasticity.prism.loaded_prism import LoadedPrism, SolidPart
    from flankload.result import Result

    Floats = NDArray[np.float64]
    Numbers = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class SolidBody(BodyOfPair):
    """One three-dimensional body whose elements are loaded with the contact forces of results.

    Attributes
    ----------
    number, body, other
        Number, this body of the scene, and the other one.
    loaded : LoadedPrism
    """

    loaded: LoadedPrism

    @property
    def cells(self) -> tuple[tuple[str, Numbers], ...]:
        """Elements, in the points of the fields: those of each part one after the other."""
        found, first = [], 0
        for part in self.loaded.parts:
            found += [(kind, data + first) for kind, data in part.solids]
            first += part.nodes.size * part.z_mm.size
        return tuple(found)

    def at(self, result: Result, p: int) -> NodalFields:
        """Fields of a result at position p, as of `FieldBody`."""
        drawing, loaded, twist = result.drawing, self.loaded, self.loaded.prism.twist
        angle = float((drawing.angle_1, drawing.angle_2)[self.number][p])
        forces = self.forces(result, p)
        moved = loaded.displacements(forces.tooth, forces.s_mm, forces.spans_mm, forces.force_N)
        center = np.array([self.number * drawing.center_distance_mm, 0.0])
        found: list[list[Floats]] = []
        for part in loaded.parts:
            turns = np.broadcast_to(angle + twist * part.z_mm, (part.nodes.size, part.z_mm.size))
            nodal, pressure = self._nodal(part, forces)
            section = np.broadcast_to(loaded.nodes[part.nodes][:, None], (*turns.shape, 2))
            height = np.broadcast_to(part.z_mm, turns.shape)[..., None]
            v, stress = loaded.fields(part, moved)
            columns = [
                np.concatenate([turned_by(section, turns) + center, height], axis=-1),
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

    def forces(self, result: Result, p: int) -> SliceForces:
        """Contact forces of position p, at Gauss points of the cells of each slice."""
        table, slices, drawing = result.pairs(p), result.slices, result.drawing
        angle = float((drawing.angle_1, drawing.angle_2)[self.number][p])
        if slices is None or table.z_mm is None:
            raise SceneError(
                key="results", expected="results of this scene", found="those of a plane scene"
            )
        carries = table.force_N > 0
        x, weights = np.polynomial.legendre.leggauss(POINTS)
        site, cell, z = table.site[carries], table.cell_mm[carries], table.z_mm[carries]
        s = (table.arc_length_1_mm, table.arc_length_2_mm)[self.number][carries]
        s = self.on_elements((s[:, None] + 0.5 * cell[:, None] * x).ravel(), self.loaded.body)
        normal = np.column_stack([table.normal_x, table.normal_y])[carries]
        lever = table.x_mm[carries] * normal[:, 1] - table.y_mm[carries] * normal[:, 0]
        shape = drawing.axial[0]
        assert shape is not None
        # the normal out of body 1 leans along its helix
        leaning = np.column_stack([normal, -shape.twist_rad_per_mm * lever])
        leaning /= np.linalg.norm(leaning, axis=1, keepdims=True)
        on_1 = -table.force_N[carries, None] * leaning
        if table.friction_force_N is not None:
            tangent = np.column_stack([normal[:, 1], -normal[:, 0], np.zeros(len(normal))])
            on_1 += table.friction_force_N[carries, None] * tangent
        force = on_1 if self.number == 0 else -on_1
        force = in_world(force, -(angle + self.loaded.prism.twist * z))
        number = np.abs(slices.z_mm - z[:, None]).argmin(axis=1)
        half = 0.5 * slices.width_mm[number]
        share = np.tile(0.5 * weights, site.size)
        return SliceForces(
            np.repeat(self.teeth(site, coast=False), POINTS),
            s,
            np.repeat(np.column_stack([z - half, z + half]), POINTS, axis=0),
            share[:, None] * np.repeat(force, POINTS, axis=0),
            share * np.repeat(table.force_N[carries], POINTS),
        )

    def _nodal(self, part: SolidPart, forces: SliceForces) -> tuple[Floats, Floats]:
        """Forces (n, J, 3) at the points of a part, and pressures (n, J) on its flanks."""
        loaded, count = self.loaded, part.z_mm.size
        place = np.full(len(loaded.nodes), -1)
        place[part.nodes] = np.arange(part.nodes.size)
        nodes, shapes = loaded.on_flank(forces.s_mm)
        at = place[loaded.numbers[forces.tooth[:, None] % len(loaded.numbers), nodes]]
        along = _on_layers(part.z_mm, forces.spans_mm)
        columns = np.column_stack([forces.force_N, forces.normal_N])
        found = np.zeros((part.nodes.size, count, 4))
        parts = np.einsum("na,nj,nc->najc", shapes, along, columns)
        np.add.at(found, at[at >= 0], parts[at >= 0])
        pressure, levels = found[..., 3], np.zeros(count)
        for k in range(0, count - 1, 2):  # Simpson's weights, as along the profile
            levels[k : k + 3] += (part.z_mm[k + 2] - part.z_mm[k]) / 6.0 * np.array([1, 4, 1])
        flank, widths = loaded.flank_widths()
        for tooth in np.unique(forces.tooth % len(loaded.numbers)):
            own = place[loaded.numbers[tooth, flank]]
            pressure[own[own >= 0]] /= widths[own >= 0, None] * levels
        return found[..., :3], pressure


@dataclass(frozen=True, eq=False)
class SliceForces:
    """Forces on the flanks of a body, each even over a span along the axis.

    Attributes
    ----------
    tooth, s_mm : (n,) arrays
        Teeth, and arc lengths on the flank of the elements.
    spans_mm : (n, 2) array
        Ends along the axis.
    force_N : (n, 3) array
        In the section turned with the helix, in the frame of the body.
    normal_N : (n,) array
        Magnitude of the part normal to the flank.
    """

    tooth: Numbers
    s_mm: Floats
    spans_mm: Floats
    force_N: Floats
    normal_N: Floats


def _on_layers(z_mm: Floats, spans_mm: Floats) -> Floats:
    """Means (n, J) of the shape functions of layers of three stations over spans (n, 2)."""
    found = np.zeros((len(spans_mm), z_mm.size))
    points, weights = np.polynomial.legendre.leggauss(2)  # parabolas are exact
    whole = spans_mm[:, 1] - spans_mm[:, 0]
    for k in range(0, z_mm.size - 1, 2):
        low, high = (np.clip(spans_mm, z_mm[k], z_mm[k + 2])).T
        places = 0.5 * (low + high)[:, None] + 0.5 * (high - low)[:, None] * points
        x = (2.0 * places - z_mm[k] - z_mm[k + 2]) / (z_mm[k + 2] - z_mm[k])
        shapes = np.stack([0.5 * x * (x - 1), 1 - x**2, 0.5 * x * (x + 1)], axis=-1)
        part = np.einsum("g,ngj->nj", 0.5 * weights, shapes)
        found[:, k : k + 3] += ((high - low) / whole)[:, None] * part
    return found


def turned_by(plane: Floats, turns: Floats) -> Floats:
    """Vectors (…, 2), each rotated counter-clockwise by an angle of its own (…)."""
    cosine, sine = np.cos(turns), np.sin(turns)
    x, y = plane[..., 0], plane[..., 1]
    return np.stack([cosine * x - sine * y, sine * x + cosine * y], axis=-1)


def in_world(vectors: Floats, turns: Floats) -> Floats:
    """Vectors (…, 3), each rotated about z by an angle of its own (…)."""
    return np.concatenate([turned_by(vectors[..., :2], turns), vectors[..., 2:]], axis=-1)


def stress_in_world(stress: Floats, turns: Floats) -> Floats:
    """Stresses (…, 6) as xx, yy, zz, xy, yz, xz of sections rotated by angles (…)."""
    xx, yy, zz, xy, yz, xz = np.moveaxis(stress, -1, 0)
    mean, half = 0.5 * (xx + yy), np.stack([0.5 * (xx - yy), xy], axis=-1)
    half = turned_by(half, 2.0 * turns)
    shear = turned_by(np.stack([xz, yz], axis=-1), turns)
    parts = mean + half[..., 0], mean - half[..., 0], zz, half[..., 1], shear[..., 1], shear[..., 0]
    return np.stack(parts, axis=-1)
