"""Deck of a scene at a position: whole bodies with fine meshes near possible contacts."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from msgspec import structs

from flankload.base.rotation import turned
from flankload.bodies import SectorMesh
from flankload.errors import SceneError
from flankload.mechanisms.registry import mechanism_of
from flankload.scene.effects import is_spatial
from flankload.scene.refusal import refuse, shown
from flankload.studies.verification.contact_places import Place, contact_places, fine_sizes
from flankload.studies.verification.deck import Deck, DeckFriction, Part
from flankload.studies.verification.triangles import (
    border_owners,
    held_nodes,
    held_weights,
    moved,
    quadratic,
    refined,
    whole_body,
)

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from flankload.base.arrays import Floats
    from flankload.bodies import Body
    from flankload.pairing.gear_mesh import GearMesh
    from flankload.result import Result
    from flankload.scene import Scene

#: Element length of the coarse mesh along the flanks in modules, and on splines; kept on far teeth.
COARSE_PART, COARSE_SPLINE_PART = 0.35, 0.25
#: Growth of the sides per mm of distance from the contact.
GROWTH = 0.2
#: Initial rotation of body 1 into its mate, relative to its deflection: without contact at the
#: start it would be free.
START_PART = 0.05
#: Rotation of body 1 by which flanks with friction slide before they reach the position.
SLIDING_RAD = 2e-3
#: Flanks get a contact pair if their gap is below this multiple of the deflection.
REACH = 3.0

#: Keys of three-dimensional bodies that solid decks do not contain.
SHAFT = "the deck turns the bore of body 1 about a fixed axis and holds that of body 2"
WIDE = "all of a body in the deck is as wide as its teeth"
NOT_SOLID = {"shaft": SHAFT, "web_width_mm": WIDE, "hub_width_mm": WIDE, "region_sets": WIDE}


@dataclass(frozen=True)
class Model:
    """A deck and data for its reader.

    `finest_mm` is the length of the elements at the contacts, across the flank, `half_width_mm` the
    half-width of the most loaded contact of solid bodies; NaN of plane ones.
    """

    deck: Deck
    finest_mm: float
    half_width_mm: float = float("nan")


def check_bodies(scene: Scene) -> None:
    """Raise a SceneError for bodies without finite elements and for what decks do not contain."""
    for key, expected, found in _refusals(scene):
        refuse(key, expected, found, scene.file)


def _refusals(scene: Scene) -> Iterator[tuple[str, str, str]]:
    """Key, expected and found of all that is refused."""
    bodies, effects = (("body_1", scene.body_1), ("body_2", scene.body_2)), scene.effects
    if scene.stage is not None:
        yield "stage", "nothing: decks contain two bodies", "a planetary stage"
    if not scene.body_2.has_teeth:
        no_cams = "bodies with teeth: no deck is written for a cam and its follower"
        yield "body_2.kind", no_cams, "'cam'"
    if is_spatial(scene).on:
        if effects.friction_coefficient:
            smooth = "nothing, since solid decks have no friction"
            yield "effects.friction_coefficient", smooth, shown(effects.friction_coefficient)
        for key, spec in bodies:
            if spec.kind not in ("gear", "mesh"):
                external = "'gear' or 'mesh', since solid decks have external teeth"
                yield f"{key}.kind", external, shown(spec.kind)
            if spec.has_free_bore:
                own = "rim" if spec.kind == "ring" else "bore"
                yield f"{key}.{own}", f"'held', since {SHAFT}", "'torque'"
            for name, reason in NOT_SOLID.items():
                if value := getattr(spec, name, None):
                    found = "a table" if name == "shaft" else shown(value)
                    yield f"{key}.{name}", f"nothing, since {reason}", found
    for name in ("temperature_rise_K", "speed_rpm"):
        if value := getattr(effects, name):
            unheated = "nothing: expanding bodies are not written for another program"
            yield f"effects.{name}", unheated, shown(value)
    if effects.coast_flank:
        working = "false: a deck has contact on the working flanks only"
        yield "effects.coast_flank", working, "true"
    for key, spec in bodies:
        if spec.brings_compliance:
            solvable = "a body with elements, for another program to solve them"
            yield f"{key}.kind", solvable, "'compliance': its file contains no elements"
        if spec.rigid:
            elastic = "an elastic body: rigid flanks are not written for another program"
            yield f"{key}.rigid", elastic, "true"


def model_of(
    scene: Scene,
    result: Result,
    position: int,
    *,
    elements_per_half_width: float,
    large_displacement: bool,
) -> Model:
    """Deck of one position.

    Flankload's result only determines the element size, by the number of elements on the half-width
    of a Hertz contact, and the range of the search for contacts.

    Raises SceneError or FlankloadError if a body cannot be meshed or no flanks meet.
    """
    pair = coarse_bodies(scene)
    plane = scene.accuracy.plane
    turns = turns_of(pair, float(result.position_rad[position]))
    loads = result.site_force_N[position] / result.face_width_mm
    rotation = float(result.rotation_rad[position])
    places = contact_places(
        pair,
        turns,
        force_N_per_mm=dict(zip(result.sites.tolist(), loads.tolist(), strict=True)),
        rotation_rad=rotation,
        reach=REACH,
        elements_per_half_width=elements_per_half_width,
        plane=plane,
    )
    touch = min(place.gap_rad for place in places)
    start = touch + START_PART * (rotation - touch)
    sites, size = tuple(place.site for place in places), _sizes(places)
    distance = pair.pairing.center_distance_mm
    deck = Deck(
        title=f"{result.name}, position {position}",
        parts=(
            _part(pair.bodies[0], flanks_of(pair, 0, sites), (turns[0], start, 0.0), size),
            _part(pair.bodies[1], flanks_of(pair, 1, sites), (turns[1], 0.0, distance), size),
        ),
        sites=sites,
        torque_Nmm=result.torque_Nmm / result.face_width_mm,
        start_rad=start,
        plane=plane,
        large_displacement=large_displacement,
        friction=friction_of_deck(scene, pair, places),
    )
    return Model(deck, min(place.element_mm for place in places))


def friction_of_deck(
    scene: Scene, pair: GearMesh, places: tuple[Place, ...]
) -> DeckFriction | None:
    """Friction of the pairs in the deck; None without friction or sliding.

    Raises SceneError if a coefficient varies along a flank.
    """
    friction, pairing = pair.friction, pair.pairing
    if friction is None or pairing.center_distance_mm == 0.0:
        return None
    if np.ptp(friction.coefficients, axis=0).any():
        expected = "a number, or one per tooth: the deck has one coefficient for each pair"
        found = "a table over the roll position"
        refuse("effects.friction_coefficient", expected, found, scene.file)
    rows = np.searchsorted(pairing.sites, [place.site for place in places])
    return DeckFriction(
        coefficients=tuple(friction.coefficients[0, rows].tolist()),
        back_rad=friction.sense * pairing.ratio * SLIDING_RAD,
    )


def coarse_bodies(scene: Scene, part: float | None = None) -> GearMesh:
    """Both bodies, with coarse elements on the modified flanks if flankload makes their meshes.

    `part` is the length of the elements along the flanks in modules.

    Raises SceneError for a mesh from a file whose flank lacks the modifications of its profile.
    """
    pair = _with_coarse_elements(scene, part)
    for z, body in enumerate(pair.bodies, start=1):
        if body.elements is not None:
            expected = "a profile on which the nodes of the flank lie, since the deck has them"
            refuse(f"body_{z}.profile", expected, "modifications that they lack", scene.file)
    return pair


def _with_coarse_elements(scene: Scene, part: float | None) -> GearMesh:
    """As `coarse_bodies`, unchecked."""
    module = next(
        (spec.module_mm for spec in (scene.body_1, scene.body_2) if hasattr(spec, "module_mm")),
        None,
    )
    if module is None:
        return with_modified_elements(scene)
    if part is None:
        part = COARSE_SPLINE_PART if scene.body_1.conforms else COARSE_PART
    accuracy = structs.replace(scene.accuracy, flank_element_mm=part * module)
    try:
        return with_modified_elements(replace(scene, accuracy=accuracy))
    except SceneError:  # too coarse for this rim or tooth
        return with_modified_elements(scene)


def with_modified_elements(scene: Scene) -> GearMesh:
    """Both bodies with elements on the modified flanks."""
    mechanism = mechanism_of(scene)
    (mesh,) = mechanism.build(scene, modified_elements=True).meshes
    return mesh


def turns_of(pair: GearMesh, position_rad: float) -> tuple[float, float]:
    """Rotations of both bodies at a position, rad."""
    turn_1, turn_2 = pair.pairing.turns(np.float64(position_rad))  # type: ignore[arg-type]
    return float(turn_1), float(turn_2)


def flanks_of(pair: GearMesh, z: int, sites: tuple[int, ...]) -> tuple[tuple[int, float], ...]:
    """Tooth and angle of the flank of a body (0 or 1) at each site."""
    rows = np.searchsorted(pair.pairing.sites, sites)
    teeth, angles = pair.pairing.site_teeth[z][rows], pair.pairing.site_angles_rad[z][rows]
    return tuple(zip(teeth.tolist(), angles.tolist(), strict=True))


def _sizes(places: tuple[Place, ...]) -> Callable[[Floats], Floats]:
    """Function for the longest side of an element, by its place."""
    from scipy.spatial import cKDTree

    tree = cKDTree(np.vstack([place.points for place in places]))
    finest = fine_sizes(places)

    def size_at(points: Floats) -> Floats:
        distance, nearest = tree.query(points)
        return np.asarray(finest[nearest] + GROWTH * np.maximum(distance - finest[nearest], 0.0))

    return size_at


def _part(
    body: Body,
    flanks: tuple[tuple[int, float], ...],
    stand: tuple[float, float, float],
    size: Callable[[Floats], Floats],
) -> Part:
    """One body: refined at its place at the position, then rotated by the initial angle."""
    turn, further, shift = stand
    axis = np.array([shift, 0.0])
    mesh = refined(whole_body(body, flanks), lambda points: size(turned(points, turn) + axis))
    mesh = moved(mesh, turn + further, shift)
    nodes, cells, middles = quadratic(mesh)
    faces = border_owners(mesh) + np.array([0, 1])
    sides = tuple(faces[mesh.border.flank == k] for k in range(len(flanks)))
    held, weights = held_nodes(mesh, middles), None
    if isinstance(body.mesh, SectorMesh) and body.mesh.has_free_bore:
        weights = held_weights(mesh, middles)
    return Part(nodes, cells, held, sides, body.material, axis_mm=shift, weights=weights)
