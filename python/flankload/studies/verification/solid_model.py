"""Solid deck of a three-dimensional scene at a position."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flankload.base.rotation import turned
from flankload.elasticity.near_field import logarithm_strength
from flankload.studies.verification.contact_places import Place, fine_sizes, meetings, reachable
from flankload.studies.verification.deck import Deck, Part
from flankload.studies.verification.deck_model import (
    START_PART,
    Model,
    coarse_bodies,
    flanks_of,
    turns_of,
)
from flankload.studies.verification.solid import Layers, Stand, beyond, layers_of, solid_part
from flankload.studies.verification.triangles import Triangles, refined, whole_body, without

if TYPE_CHECKING:
    from scipy.spatial import cKDTree

    from flankload.base.arrays import Flags, Floats, Numbers
    from flankload.bodies import Body
    from flankload.pairing.gear_mesh import GearMesh
    from flankload.pairing.slices import Slices
    from flankload.result import Result
    from flankload.scene import Scene

#: Element length of the coarse mesh along the flanks in modules: the coarsest that can be meshed.
COARSE_PART = 5.0
#: Growth of the sides per mm of distance, beside the contacts and far from them.
GROWTH = 0.4
#: Middle zone (loaded teeth and their roots): edge length over flank length, growth per mm, and
#: distance from the contacts in flank lengths.
MIDDLE_PART, MIDDLE_GROWTH, MIDDLE_REACH = 0.06, 0.12, 1.6
#: Triangles have thin layers up to this distance from the contacts, as part of a flank's length.
NEAR_PART = 0.6
#: Teeth are cut off at the root circle beyond this distance, in lengths of the flank.
TEETH_REACH, SAME_RADIUS = 3.0, 1e-6
#: Flanks get a contact pair if their gap is below this multiple of the deflection.
REACH = 1.5
#: Layers over the common width per element on the half-width; number of thick layers elsewhere.
LAYERS, THICK_LAYERS = 17.0, 2
#: Largest movement of a contact line across the flank within a layer, in elements.
ELEMENTS_PER_LAYER = 2.0


def solid_model_of(
    scene: Scene,
    result: Result,
    position: int,
    *,
    elements_per_half_width: float,
    large_displacement: bool,
) -> Model:
    """Deck of one position.

    The result only determines the element size and the range of the search for contacts. All
    elements and the layers follow from the number of elements on the half-width of a contact.

    Raises SceneError or FlankloadError if a body cannot be meshed or no flanks meet.
    """
    pair = coarse_bodies(scene, COARSE_PART)
    elements = elements_per_half_width
    places = _places(pair, result, position, elements)
    half_width = max(place.half_width_mm for place in places)
    touch = min(place.gap_rad for place in places)
    start = touch + START_PART * (float(result.rotation_rad[position]) - touch)
    low, high = pair.slices.edges_mm[[0, -1]].tolist()
    edges = layers_of(low, high, _layer_count(result, high - low, half_width, elements))
    turns = turns_of(pair, float(result.position_rad[position]))
    shear = 1e-3 * scene.pair.inclination_um_per_mm, 1e-3 * scene.pair.deviation_um_per_mm
    stands = (
        Stand(turns[0] + start, 0.0, (0.0, 0.0)),
        Stand(turns[1], pair.pairing.center_distance_mm, shear),
    )
    sites = tuple(sorted({place.site for place in places}))
    deck = Deck(
        title=f"{result.name}, position {position}",
        parts=(
            _part(pair, 0, places, edges, stands[0], elements),
            _part(pair, 1, places, edges, stands[1], elements),
        ),
        sites=sites,
        torque_Nmm=result.torque_Nmm,
        start_rad=start,
        large_displacement=large_displacement,
        edges_mm=edges,
        width_mm=result.face_width_mm,
    )
    return Model(deck, min(place.element_mm for place in places), half_width)


def _layer_count(result: Result, width_mm: float, half_width_mm: float, elements: float) -> int:
    """Layers over the width: contact lines that run across the flank need more of them."""
    across = abs(result.width_loads.tangent_helix_base) * width_mm
    steps = across * elements / (ELEMENTS_PER_LAYER * half_width_mm)
    return max(1, round(LAYERS * elements), round(steps))


def _places(pair: GearMesh, result: Result, position: int, elements: float) -> tuple[Place, ...]:
    """Places where flanks may touch in all slices, with the length of elements there."""
    slices, turns = pair.slices, turns_of(pair, float(result.position_rad[position]))
    largest = float(result.width_loads.line_load_N_per_mm[position].max())
    compliance = sum(logarithm_strength(body.material, "strain") for body in pair.bodies)
    places = []
    for j in range(slices.count):
        stand = turns[0] + float(slices.turns_rad[0][j]), turns[1] + float(slices.turns_rad[1][j])
        for meeting in meetings(pair, stand):
            late = _removed(slices, meeting.site, j) / pair.bodies[0].reference_radius_mm
            places.append(meeting.place(compliance * largest, elements, late))
    return reachable(places, float(result.rotation_rad[position]), REACH)


def _removed(slices: Slices, site: int, j: int) -> float:
    """Upper bound of the metal removed from both flanks of a site in a slice, mm."""
    total = 0.0
    for z in (0, 1):
        total += float(slices.removed_mm[z][j])
        of_tooth = slices.tooth_deviations(np.array([site]), z)[0]
        total -= float(of_tooth[min(j, of_tooth.size - 1)])
        surface = slices.surfaces_mm[z]
        if surface is not None:
            total += float(surface[j].max())
    return total


def _part(
    pair: GearMesh, z: int, places: tuple[Place, ...], edges: Floats, stand: Stand, elements: float
) -> Part:
    """One body: its section refined, then in layers at its place."""
    from scipy.spatial import cKDTree

    body = pair.bodies[z]
    sites = tuple(sorted({place.site for place in places}))
    axis = [z * pair.pairing.center_distance_mm, 0.0]
    points = [turned(place.points - axis, -place.turns_rad[z]) for place in places]
    tree, sizes = cKDTree(np.vstack(points)), fine_sizes(places)
    length = body.curve.length_mm

    def size_at(points: Floats) -> Floats:
        distance, nearest = tree.query(points)
        beside = sizes[nearest] + GROWTH / elements * np.maximum(distance - sizes[nearest], 0.0)
        around = MIDDLE_PART * length + MIDDLE_GROWTH * distance
        far = np.maximum(distance - MIDDLE_REACH * length, 0.0)
        return np.minimum(beside, (around + GROWTH * far) / elements)

    whole = whole_body(body, flanks_of(pair, z, sites))
    mesh = refined(without(whole, _far_teeth(body, whole, tree)), size_at)
    every = beyond(edges, body.axial.range_mm)
    first = int(np.searchsorted(every, edges[0] - 1e-9))
    near = tree.query(mesh.vertices[mesh.corners].mean(axis=1))[0] < NEAR_PART * length
    layers = Layers(
        edges_mm=every,
        coarse=_thick(every),
        common=(first, first + edges.size - 1),
        near=near | _on_flanks(mesh),
    )
    # in the order of pitch errors the tooth after that of pair 0 meets as pair -1
    teeth = tuple(-site % body.teeth for site in sites)
    return solid_part(body, mesh, teeth, layers, stand)


def _far_teeth(body: Body, mesh: Triangles, tree: cKDTree) -> Flags:
    """Triangles beyond the root circle far from all contacts: they carry nothing."""
    root = float(np.linalg.norm(body.curve.point([0.0])[0])) * (1.0 - SAME_RADIUS)
    teeth = (np.linalg.norm(mesh.vertices, axis=1)[mesh.corners] >= root).all(axis=1)
    distance, _ = tree.query(mesh.vertices[mesh.corners].mean(axis=1))
    teeth &= body.outward > 0
    return np.asarray(teeth & (distance > TEETH_REACH * body.curve.length_mm))


def _thick(edges: Floats) -> Numbers:
    """Ends of thick layers, about equal in width, among those of thin layers."""
    wanted = np.linspace(edges[0], edges[-1], min(THICK_LAYERS, edges.size - 1) + 1)
    return np.unique(np.abs(edges[:, None] - wanted).argmin(axis=0))


def _on_flanks(mesh: Triangles) -> Flags:
    """Triangles with a side or a vertex on a flank."""
    on = np.zeros(len(mesh.vertices), dtype=bool)
    on[mesh.border.ends[mesh.border.flank >= 0]] = True
    return np.asarray(on[mesh.corners].any(axis=1))
