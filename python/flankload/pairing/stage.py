"""The gear meshes of a planetary stage in the frame of its carrier, and their phases.

The sun is at the origin, planet j at the polar angle psi_j on the radius of the centre distance.
Positions are rotations of the sun, counter-clockwise, in the sense of its torque; at position zero
pair 0 of the mesh of the sun with planet 1 is at the pitch point.

The mesh of the sun with planet j is a pair in a frame turned by psi_j. The torque turns a planet
clockwise, so that its coast flanks drive the ring: their mesh is a pair in the mirror image, in
which planet and ring turn counter-clockwise. Its frame is at the planet, with the ring's axis on
its positive x axis: turned by psi_j + pi, with the sign of y reversed.

Planets can be assembled at multiples k_j of a turn over the sum of the tooth numbers of sun and
ring. So all phases follow from tooth numbers, and the teeth of the sun and of the ring in the
meshes from sums of integers.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import gcd, lcm, pi
from typing import TYPE_CHECKING

import numpy as np

from flankload.base.rotation import directions
from flankload.pairing.pairing import teeth_until_alike
from flankload.pairing.placed_mesh import (
    MeshPlace,
    PlacedMesh,
    PlacedMeshes,
    named_warnings,
    paired,
)
from flankload.pairing.slices import reached_positions

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flankload.base.arrays import Floats
    from flankload.bodies.body import Body

#: Names of the bodies of both kinds of mesh, as tables of the scene.
SUN_MESH, RING_MESH = ("body_1", "planet"), ("planet", "body_2")


@dataclass(frozen=True)
class StageMesh(PlacedMesh):
    """A gear mesh of a stage; its names are `SUN_MESH` or `RING_MESH`.

    Attributes
    ----------
    planet : int
        Number of the planet, from 0.
    """

    planet: int = 0

    @property
    def with_ring(self) -> bool:
        """Whether the mesh is that of the planet with the ring."""
        return self.names == RING_MESH


@dataclass(frozen=True)
class StagePairing(PlacedMeshes):
    """All gear meshes of a stage: bodies are the sun, n planets, and the ring.

    Meshes are those with the sun in the order of the planets, then those with the ring.

    Attributes
    ----------
    angles_rad : (n,) array
        Polar angles of the planets.
    places : tuple of n int
        Their angles from planet 1, in parts of a turn over the teeth of sun and ring.
    center_distance_mm : float
    ring_turn_rad : float
        Angle of the centre line of a space in the frame of the ring.
    """

    meshes: tuple[StageMesh, ...]
    angles_rad: Floats
    places: tuple[int, ...]
    center_distance_mm: float
    ring_turn_rad: float

    @property
    def count(self) -> int:
        """Number of planets."""
        return len(self.places)

    @property
    def tables(self) -> tuple[int, ...]:
        """(n + 2,) Number of the table of each body, from 0."""
        return (0, *(1 for _ in self.places), 2)

    @property
    def body_names(self) -> tuple[str, ...]:
        """(n + 2,) Names of the bodies in files."""
        return ("sun", *(f"planet_{j + 1}" for j in range(self.count)), "ring")

    @property
    def site_meshes(self) -> tuple[tuple[int, ...], ...]:
        """(n, 2) Meshes of each planet, with the sun and with the ring."""
        return tuple((j, self.count + j) for j in range(self.count))

    @property
    def centers_mm(self) -> Floats:
        """(n, 2) Axes of the planets in the frame of the carrier."""
        return self.axes_mm[1:-1]

    @property
    def equally_spaced(self) -> bool:
        """Whether all neighbouring planets are equally far apart."""
        whole, n = self.teeth[0] + self.teeth[2], self.count
        return all(n * place == j * whole for j, place in enumerate(self.places))

    @property
    def drawn_second(self) -> int:
        """The ring is drawn beside the sun."""
        return self.count + 1

    def title(self, m: int) -> str:
        """Words for a mesh."""
        mesh = self.meshes[m]
        return f"planet {mesh.planet + 1} with the {'ring' if mesh.with_ring else 'sun'}"

    def body_angles(self, position_rad: Floats) -> Floats:
        """(P, n + 2) Angles of the frames of sun, planets and ring in that of the carrier."""
        found = super().body_angles(position_rad)
        # the mirror image of a ring, whose space has its centre line on the axis of its frame
        found[:, -1] -= 2.0 * self.ring_turn_rad
        return found

    def path_errors(self, displacements_mm: Floats) -> Floats:
        """(n,) Earlier contact on each path by displacements (n, 2) of the pins, mm.

        A planet turns freely, so that those of its two meshes add up.
        """
        rows = self.rows((1.0, 1.0, 1.0))[:, 1:-1, :2]
        closing = np.einsum("mnx,nx->m", rows, displacements_mm)
        return np.asarray(closing[: self.count] + closing[self.count :])

    @property
    def sun_phases(self) -> Floats:
        """(n,) Phases of the meshes with the sun, in pitches."""
        return np.array([mesh.phase for mesh in self.meshes[: self.count]])

    @property
    def ring_phases(self) -> Floats:
        """(n,) Phases of the meshes with the ring, in pitches."""
        return np.array([mesh.phase for mesh in self.meshes[self.count :]])


def surviving_order(count: int, sun_teeth: int) -> int:
    """N = n/gcd(n, z_s) of n equally spaced planets: only multiples of N survive.

    These are the orders of the mesh frequency in the transmission error and in all other scalars,
    also with lift-off and contact on corners: an advance by z_s/n of a pitch renumbers the planets.
    """
    return count // gcd(count, sun_teeth)


def orbit_orders(count: int, sun_teeth: int, highest: int) -> tuple[int, ...]:
    """Orders l of w = x + i y = sum of w_l e^(2 pi i l t) in the orbit of the sun, up to a highest.

    These are l with l z_s = 1 modulo n, of either sign, by magnitude; none if n and z_s have a
    common factor.
    """
    orders = (order for order in range(-highest, highest + 1) if order)
    found = [order for order in orders if count > 1 and (order * sun_teeth - 1) % count == 0]
    return tuple(sorted(found, key=abs))


def repeating_pitches(bodies: tuple[Body, ...], run_outs: tuple[bool, bool]) -> int:
    """Tooth pitches of the sun after which everything repeats.

    `bodies`: sun, planet, ring; `run_outs`: whether sun and ring have a run-out.
    """
    repeat = [teeth_until_alike(body) for body in bodies]
    repeat += [body.teeth for body, out in zip(bodies[::2], run_outs, strict=True) if out]
    return lcm(*repeat)


def stage_pairing(
    bodies: tuple[Body, ...],
    places: Sequence[int],
    first_rad: float,
    center_distance_mm: float,
    position_rad: Floats,
) -> StagePairing:
    """Gear meshes of sun, planet and ring.

    Parameters
    ----------
    bodies : Body, Body, Body
        Sun, planet, ring.
    places : sequence of n int
        Angles of the planets from the first one, in parts of a turn over the sum of the tooth
        numbers of sun and ring (`scene.stage.assembled_places`).
    first_rad : float
        Polar angle of planet 1.
    position_rad : (P,) array
        Positions, which determine the number of pairs.

    Raises
    ------
    SceneError
        If flanks cannot mesh.
    """
    sun, planet, ring = bodies
    whole = sun.teeth + ring.teeth
    angles = first_rad + 2.0 * pi * np.asarray(places, dtype=float) / whole
    suns = [_sun_phase(sun.teeth, place, whole) for place in places]
    pair_sun = paired(SUN_MESH, (sun, planet), center_distance_mm)
    pair_ring = paired(RING_MESH, (planet, ring), center_distance_mm)
    rate = sun.teeth / planet.teeth
    assert planet.involute is not None
    image = planet.in_mirror_image()
    # the planet's frame in the mirror image at position zero of its mesh with the sun
    mirrored = pi - pair_sun.turns_at_zero_rad[1] - 2.0 * planet.involute.turn_rad
    base = (mirrored - pair_ring.turns_at_zero_rad[0]) / pair_ring.pitch_rad
    meshes: dict[tuple[str, str], list[StageMesh]] = {SUN_MESH: [], RING_MESH: []}
    first_turn = 0
    for j, (phase, turn) in enumerate(suns):
        offset, frame = phase * pair_sun.pitch_rad, float(angles[j])
        place = MeshPlace((sun, planet), (turn, 0), (1, -1), (-1, 1))
        own = place.of(pair_sun, reached_positions(offset + position_rad, sun))
        meshes[SUN_MESH].append(StageMesh(SUN_MESH, own, offset, 1.0, frame, 1, (0, 1 + j), j))
        back = -round(base + phase)
        first_turn = back if j == 0 else first_turn
        ring_turn = places[j] - turn - (back - first_turn)
        offset = (base + phase + back) * pair_ring.pitch_rad
        place = MeshPlace((planet, ring), (-back, ring_turn), (-1, -1), (0, 1))
        reached = reached_positions(offset + rate * position_rad, image)
        own = place.of(pair_ring, reached)
        members = 1 + j, 1 + len(suns)
        meshes[RING_MESH].append(
            StageMesh(RING_MESH, own, offset, rate, frame + pi, -1, members, j)
        )
    return StagePairing(
        axes_mm=center_distance_mm * np.pad(directions(angles), ((1, 1), (0, 0))),
        angles_rad=angles,
        places=tuple(places),
        teeth=(sun.teeth, planet.teeth, ring.teeth),
        center_distance_mm=center_distance_mm,
        meshes=(*meshes[SUN_MESH], *meshes[RING_MESH]),
        ring_turn_rad=0.0 if ring.involute is None else ring.involute.turn_rad,
        warnings=(
            *named_warnings(pair_sun, SUN_MESH, "sun and planet"),
            *named_warnings(pair_ring, RING_MESH, "planet and ring"),
        ),
    )


def _sun_phase(sun_teeth: int, place: int, whole: int) -> tuple[float, int]:
    """Phase of a planet's mesh with the sun in pitches, and the tooth of the sun in its pair 0."""
    part = -sun_teeth * place % whole
    part -= whole if 2 * part > whole else 0
    return part / whole, (part + sun_teeth * place) // whole
