"""Gear meshes among several: place and phase of each in a common frame."""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from math import pi
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from flankload.base.rotation import directions
from flankload.errors import SceneError
from flankload.pairing.pairing import Pairing, at_sites, pair_bodies, path_sites, pitch_turns

if TYPE_CHECKING:
    from flankload.base.arrays import Floats
    from flankload.bodies.body import Body


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
    """

    names: tuple[str, str]
    pairing: Pairing
    offset_rad: float
    rate: float
    frame_rad: float
    sense: int

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
