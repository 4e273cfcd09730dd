"""Fields of the elements under the contact forces of a result: displacement, stress, pressure."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from flankload.base.gauss import leggauss
from flankload.base.rotation import turned
from flankload.elasticity.compliance.modified_flank import on_elements
from flankload.elasticity.loaded_body import PointForces
from flankload.mechanisms.protocol import NodalFields

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flankload.base.arrays import Floats, Numbers
    from flankload.bodies import Body
    from flankload.elasticity.loaded_body import LoadedBody
    from flankload.result import PairTable, Result

#: Gauss points of a contact cell at which its force acts on the elements.
POINTS = 4


class Frame(NamedTuple):
    """A frame in the world: with the mirror image of y, then turned about z.

    Attributes
    ----------
    turn_rad : float
        Angle at z = 0.
    sense : int
        -1 with the mirror image, else 1.
    twist : float
        Increase of the angle along z in the frame, rad/mm.
    """

    turn_rad: float = 0.0
    sense: int = 1
    twist: float = 0.0

    def in_world(self, vectors: Floats, z_mm: Floats) -> Floats:
        """Vectors (…, 3) of the frame at heights (…) in the world."""
        return in_world(vectors * [1, self.sense, 1], self._turns(z_mm))

    def from_world(self, vectors: Floats, z_mm: Floats) -> Floats:
        """Vectors (…, 3) of the world at heights (…) in the frame."""
        return in_world(vectors, -self._turns(z_mm)) * [1, self.sense, 1]

    def stress_in_world(self, stress: Floats, z_mm: Floats) -> Floats:
        """Stresses (…, 6) of the frame at heights (…) in the world."""
        signs = [1, 1, 1, self.sense, self.sense, 1]
        return stress_in_world(stress * signs, self._turns(z_mm))

    def _turns(self, z_mm: Floats) -> Floats:
        """Angles at heights (…)."""
        return self.turn_rad + self.sense * self.twist * z_mm


class Contacts(NamedTuple):
    """Contacts of a body in the table of a result.

    Attributes
    ----------
    result : Result
        Result of the mesh of the table.
    table : PairTable
    number : int
        0 or 1: the number of the body in the table.
    teeth : (n,) array
        Its tooth at each row.
    coast : bool
        Whether contacts are on its coast flanks.
    frame : Frame
        Frame of the vectors of the table.
    """

    result: Result
    table: PairTable
    number: int
    teeth: Numbers
    coast: bool = False
    frame: Frame = Frame()


@dataclass(frozen=True, eq=False)
class BodyInContact(ABC):
    """A body with elements for the contact forces of results.

    Attributes
    ----------
    number : int
        Among the bodies of the drive.
    body : Body
        With the flanks of the contacts, which those of the elements may differ from.
    loaded : LoadedBody
        Its elements.
    """

    number: int
    body: Body
    loaded: LoadedBody

    @abstractmethod
    def contacts(self, result: Result, p: int) -> Sequence[Contacts]:
        """Contacts of the body at position p."""

    @abstractmethod
    def place(self, result: Result, p: int) -> tuple[Frame, Floats]:
        """Frame of the body at position p, and the place (2,) of its axis."""

    @property
    def cells(self) -> tuple[tuple[str, Numbers], ...]:
        """Elements, by index of the points of the fields."""
        return self.loaded.cells

    @property
    def section_nodes(self) -> int:
        """Number of nodes of a section."""
        return len(self.loaded.nodes)

    def forces(self, result: Result, p: int) -> PointForces:
        """Contact forces of position p, at Gauss points of the cells of each slice."""
        frame, _ = self.place(result, p)
        return PointForces.joined(
            [self._point_forces(each, frame) for each in self.contacts(result, p)]
        )

    def at(self, result: Result, p: int) -> NodalFields:
        """Fields of a result at position p.

        Parameters
        ----------
        result : Result
            Result of the scene of the bodies, possibly with another discretization.
        p : int
            Index of the position.
        """
        loaded, forces = self.loaded, self.forces(result, p)
        frame, center = self.place(result, p)
        moved, found = loaded.displacements(forces), []
        for part in loaded.parts:
            z = np.broadcast_to(part.z_mm, (part.nodes.size, part.z_mm.size))
            nodal, pressure = loaded.nodal(part, forces)
            v, stress = loaded.fields(part, moved)
            section = np.broadcast_to(loaded.nodes[part.nodes, None], (*z.shape, 2))
            points = np.dstack([section, z])
            columns = [
                frame.in_world(points, z) + np.append(center, 0.0),
                frame.in_world(v, z),
                frame.stress_in_world(stress, z),
                pressure[..., None],
                frame.in_world(nodal, z),
            ]
            found.append([column.reshape(z.size, -1) for column in columns])
        places, motions, stresses, pressures, on_nodes = map(
            np.concatenate, zip(*found, strict=True)
        )
        return NodalFields(places, motions, stresses, pressures[:, 0], on_nodes)

    def _point_forces(self, contacts: Contacts, frame: Frame) -> PointForces:
        """Contact forces of a table, at Gauss points of its cells, in the frame of the body."""
        table, number, result = contacts.table, contacts.number, contacts.result
        carries = table.force_N > 0
        x, weights = leggauss(POINTS)
        cell, normal_N = table.cell_mm[carries], table.force_N[carries]
        s = (table.arc_length_1_mm, table.arc_length_2_mm)[number][carries]
        s = on_elements(self.body, (s[:, None] + 0.5 * cell[:, None] * x).ravel())
        normal = table.normal[carries]
        # the outward normal of body 1 has an axial component
        lever = table.x_mm[carries] * normal[:, 1] - table.y_mm[carries] * normal[:, 0]
        axial = -result.drawing.axial[0].twist_rad_per_mm * lever
        normals = np.column_stack([normal, axial])
        on_1 = -normal_N[:, None] * normals / np.linalg.norm(normals, axis=1, keepdims=True)
        if table.friction_force_N is not None:
            tangent = np.column_stack([normal[:, 1], -normal[:, 0], np.zeros(len(normal))])
            tangent *= -1.0 if contacts.coast else 1.0
            on_1 += table.friction_force_N[carries, None] * tangent
        z, half = np.zeros((2, len(normal)))
        if table.z_mm is not None:
            z, slices = table.z_mm[carries], result.width_loads
            half = 0.5 * slices.width_mm[np.abs(slices.z_mm - z[:, None]).argmin(axis=1)]
        force = frame.from_world(contacts.frame.in_world(on_1 if number == 0 else -on_1, z), z)
        share = np.tile(0.5 * weights, len(normal))
        return PointForces(
            np.repeat(contacts.teeth[carries], POINTS),
            s,
            np.repeat(np.column_stack([z - half, z + half]), POINTS, axis=0),
            share[:, None] * np.repeat(force, POINTS, axis=0),
            share * np.repeat(normal_N, POINTS),
            np.full(s.size, contacts.coast),
        )


def in_world(vectors: Floats, turns: Floats) -> Floats:
    """Vectors (…, 3), rotated about z by angles (…)."""
    return np.concatenate([turned(vectors[..., :2], turns), vectors[..., 2:]], axis=-1)


def stress_in_world(stress: Floats, turns: Floats) -> Floats:
    """Stresses (…, 6) as xx, yy, zz, xy, yz, xz of sections rotated by angles (…)."""
    xx, yy, zz, xy, yz, xz = np.moveaxis(stress, -1, 0)
    mean, half = 0.5 * (xx + yy), np.stack([0.5 * (xx - yy), xy], axis=-1)
    half = turned(half, 2.0 * turns)
    across = turned(np.stack([xz, yz], axis=-1), turns)
    parts = [mean + half[..., 0], mean - half[..., 0], zz, half[..., 1]]
    return np.stack([*parts, across[..., 1], across[..., 0]], axis=-1)
