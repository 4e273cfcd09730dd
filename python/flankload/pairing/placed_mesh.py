"""Gear meshes among several: place and phase of each in a common frame."""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from functools import cached_property
from math import cos, pi, sin
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from flankload.base.rotation import directions
from flankload.errors import SceneError
from flankload.pairing.pairing import Pairing, at_sites, pair_bodies, path_sites, pitch_turns

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flankload.base.arrays import Floats
    from flankload.bodies.body import Body
    from flankload.pairing.gear_pair import GearGeometry


@dataclass(frozen=True)
class PlacedMesh:
    """A gear mesh among several; the common frame of a stage is that of the carrier.

    Attributes
    ----------
    names : (str, str)
        Tables of both bodies.
    pairing : Pairing
        In the frame of the mesh. Positions are rotations of body 1 from pair 0 at the pitch point;
        teeth are those of the whole bodies: of a sun or a ring counted from pair 0 of planet 1.
    offset_rad, rate : float
        Position of the mesh at position zero of all, and its change per rad of it.
    frame_rad : float
        Angle from the common frame to that of the mesh.
    sense : int
        1; -1 if the frame of the mesh is a mirror image.
    members : (int, int)
        Numbers of both bodies among all bodies of the drive.
    """

    names: tuple[str, str]
    pairing: Pairing
    offset_rad: float
    rate: float
    frame_rad: float
    sense: int
    members: tuple[int, int]

    @property
    def phase(self) -> float:
        """Position at position zero of all, in pitches: greater than -1/2, at most 1/2."""
        return self.offset_rad / self.pairing.pitch_rad

    def positions(self, position_rad: Floats) -> Floats:
        """(P,) Positions of the mesh at positions of all."""
        return np.asarray(self.offset_rad + self.rate * position_rad)

    def turns(self, position_rad: Floats) -> Floats:
        """(P, 2) Angles of both bodies in the frame of the mesh at positions of all."""
        return np.stack(self.pairing.turns(self.positions(position_rad)), axis=-1)

    def in_common_frame(self, vectors: Floats) -> Floats:
        """Vectors (…, 2) of the frame of the mesh in the common one."""
        along, across = directions(np.array([self.frame_rad, self.frame_rad + 0.5 * pi]))
        return np.asarray(vectors[..., :1] * along + self.sense * vectors[..., 1:] * across)

    @property
    def gears(self) -> GearGeometry:
        """Geometry of its gears, whose flanks are all involutes."""
        assert self.pairing.gear_geometry is not None
        return self.pairing.gear_geometry

    @property
    def push(self) -> Floats:
        """(2,) Direction of the force of body 1 on body 2 on the line of action."""
        alpha = self.gears.pressure_angle_rad
        # flanks of a body within a ring meet on the other side of its axis
        side = np.sign(self.pairing.ratio)
        return self.in_common_frame(side * np.array([sin(alpha), cos(alpha)]))


@dataclass(frozen=True)
class PlacedMeshes:
    """All gear meshes of B bodies in a common frame, in which body 1 turns counter-clockwise.

    Attributes
    ----------
    meshes : tuple of PlacedMesh
    axes_mm : (B, 2) array
        Axes of the bodies.
    teeth : tuple of int
        Tooth numbers of the tables of the scene.
    warnings : tuple of str
    """

    meshes: tuple[PlacedMesh, ...]
    axes_mm: Floats
    teeth: tuple[int, ...]
    warnings: tuple[str, ...]

    @property
    def tables(self) -> tuple[int, ...]:
        """(B,) Number of the table of each body, from 0."""
        return tuple(range(len(self.axes_mm)))

    @property
    def body_names(self) -> tuple[str, ...]:
        """(B,) Names of the bodies in files."""
        return tuple(f"body_{b + 1}" for b in range(len(self.axes_mm)))

    @property
    def site_meshes(self) -> tuple[tuple[int, ...], ...]:
        """Meshes of each site of a result, whose force is that in the first one."""
        return tuple((m,) for m in range(len(self.meshes)))

    @property
    def paths(self) -> int:
        """Number of meshes that share the torque: those of the first table."""
        first = [b for b, table in enumerate(self.tables) if table == 0]
        return sum(len(self.meshes_of(b)) for b in first)

    @property
    def pitch_rad(self) -> float:
        """Tooth pitch of body 1, rad."""
        return 2.0 * pi / self.teeth[0]

    @property
    def drawn_second(self) -> int:
        """The body that is drawn beside body 1: the other one of its first mesh, on the x axis."""
        return self.meshes[0].members[1]

    def title(self, m: int) -> str:
        """Words for a mesh."""
        return " and ".join(self.meshes[m].names)

    def body_angles(self, position_rad: Floats) -> Floats:
        """(P, B) Angles of the frames of the bodies in the common frame."""
        found = np.zeros((position_rad.size, len(self.axes_mm)))
        for mesh in self.meshes[::-1]:
            for body, angle in zip(mesh.members, mesh.turns(position_rad).T, strict=True):
                found[:, body] = mesh.frame_rad + mesh.sense * angle
        return found

    def is_image(self, m: int) -> bool:
        """Whether a mesh is in the mirror image of the first one: its flanks are coast flanks."""
        return self.meshes[m].sense != self.meshes[0].sense

    def meshes_of(self, body: int) -> list[tuple[int, int]]:
        """Number of each mesh of a body, and of the body in it."""
        every = enumerate(mesh.members for mesh in self.meshes)
        return [(m, both.index(body)) for m, both in every if body in both]

    @cached_property
    def _levers(self) -> Floats:
        """(M, B, 3) Rows of base radii of 1 mm."""
        found = np.zeros((len(self.meshes), len(self.axes_mm), 3))
        for row, mesh in zip(found, self.meshes, strict=True):
            # a body and the ring around it approach each other in opposite rotations
            turns = mesh.sense, mesh.sense * np.sign(mesh.pairing.ratio)
            for body, side, turn in zip(mesh.members, (1.0, -1.0), turns, strict=True):
                row[body] = *(side * mesh.push), turn
        return found

    def rows(self, base_radii_mm: Sequence[float]) -> Floats:
        """(M, B, 3) Approach of the flanks of each mesh by x, y and rotation of each body."""
        turning = np.array([base_radii_mm[table] for table in self.tables])
        return self._levers * np.stack([np.ones_like(turning)] * 2 + [turning], axis=-1)


def paired(names: tuple[str, str], bodies: tuple[Body, Body], distance_mm: float) -> Pairing:
    """Pair of two bodies at its position zero; errors name their tables."""
    even = (replace(body, pitch_errors_um=()) for body in bodies)
    try:
        return pair_bodies(*even, center_distance_mm=distance_mm, position_rad=np.zeros(1))
    except SceneError as error:
        texts = (_named(text, names) for text in (error.key, error.expected, error.found))
        key, expected, found = texts
        raise type(error)(key=key, expected=expected, found=found, file=error.file) from None


def named_warnings(pairing: Pairing, names: tuple[str, str], mesh: str) -> tuple[str, ...]:
    """Warnings about a pair, with the mesh to which they apply."""
    return tuple(f"{mesh}: {_named(line, names)}" for line in pairing.warnings)


def _named(text: str, names: tuple[str, str]) -> str:
    """A text about body_1 and body_2 with other names in their place."""
    return re.sub(r"body_([12])", lambda found: names[int(found[1]) - 1], text)


class MeshPlace(NamedTuple):
    """Two bodies of a mesh among all meshes.

    Attributes
    ----------
    first : (int, int)
        Tooth of each whole body in pair 0.
    senses : (int, int)
        Change of the tooth from a pair to the next.
    entries : (int, int)
        Number of the pitch error of a tooth over the number of the tooth; 0: none applies.
    """

    bodies: tuple[Body, Body]
    first: tuple[int, int]
    senses: tuple[int, int]
    entries: tuple[int, int]

    def of(self, pairing: Pairing, position_rad: Floats) -> Pairing:
        """The pairing with the sites at positions of the mesh, and with teeth of whole bodies."""
        one, two = self.bodies
        sites = path_sites(
            pairing.gear_geometry, one.teeth, two.teeth, position_rad, coast_flanks=False
        )
        teeth, angles = [], []
        for z, body in enumerate(self.bodies):
            even = replace(body, pitch_errors_um=())
            teeth.append((self.first[z] + self.senses[z] * sites) % body.teeth)
            turns = pitch_turns(body, self.entries[z] * teeth[z]) if self.entries[z] else 0.0
            angles.append(at_sites(even, sites, (1, -two.outward)[z])[1] + turns)
        none = np.zeros(sites.size)
        return replace(
            pairing,
            sites=sites,
            site_teeth=(teeth[0], teeth[1]),
            site_angles_rad=(angles[0], angles[1]),
            site_deviations_mm=(none, none),
        )
