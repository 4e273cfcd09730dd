"""Input deck for CalculiX: two bodies in quadratic elements, contact, supports and torque.

Plane bodies are written per mm of width, solid ones with their whole width. A pair of flanks of
solid bodies has a contact pair for each layer of elements over the common width, so that the output
has the force of each. The names for the reader of the output are defined here: node set AXIS_1 (its
first component is the rotation of body 1) and surfaces PAIR_<j>_LAYER_<l>_BODY_<z>; plane bodies
have one layer.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flankload.studies.verification.bore_equations import (
    MEAN_MOTIONS,
    further_nodes,
    mean_motion_equations,
)

if TYPE_CHECKING:
    from collections.abc import Iterator

    from flankload.base.arrays import Floats, Numbers
    from flankload.bodies import Material

#: Contact pressure per mm of overlap, MPa/mm: 1000 MPa cause an overlap of 0.01 um.
PENALTY = 1e8
#: Shear stress per mm of slip before flanks slide, MPa/mm: 150 MPa are reached after 0.03 um.
STICK = 5e6
#: An iteration is the last one if its largest correction is below this part of the displacement;
#: the default of CalculiX is 0.01, which leaves 0.05 % in the rotation.
CORRECTION = 1e-5
#: Part of the nodes of a probe that is held, from one end.
PROBE_HELD = 0.1


@dataclass(frozen=True)
class Words:
    """Lines of a kind of elements: their name in CalculiX, and data of their section.

    Then supports, if they are not those of body 2 in its plane; further controls and prints of a
    step.
    """

    element: str
    section: tuple[str, ...] = ("1.",)
    supports: tuple[str, ...] = ()
    controls: tuple[str, ...] = ()
    prints: tuple[str, ...] = ("*CONTACT PRINT", "CSTR")


#: Lines of plane triangles of six nodes in plane strain and in plane stress, and of wedges of 15
#: nodes. Of these, body 1 turns about its axis alone and body 2 does not move; the controls are the
#: defaults of CalculiX but for the third number: contacts have their whole stiffness from the first
#: increment, so that CalculiX does not append a second one.
WORDS = {
    "strain": Words("CPE6"),
    "stress": Words("CPS6"),
    None: Words(
        "C3D15",
        section=(),
        supports=("HELD_1, 3, 3", "HELD_2, 1, 3"),
        controls=("*CONTROLS, PARAMETERS=CONTACT", "0.001, 0.1, 1, 60"),
        prints=(),
    ),
}


@dataclass(frozen=True)
class Ties:
    """Nodes (k,) of thin layers that move as a face of a thick layer does.

    They have masters (k, 8) with weights (k, 8); 0 for entries that are not used.
    """

    nodes: Numbers
    masters: Numbers
    weights: Floats

    @staticmethod
    def of(rows: list[tuple[int, list[int], list[float]]]) -> Ties:
        """From nodes, masters and weights of each tie."""
        masters, weights = np.zeros((len(rows), 8), dtype=np.int64), np.zeros((len(rows), 8))
        for k, (_, ours, theirs) in enumerate(rows):
            masters[k, : len(ours)], weights[k, : len(ours)] = ours, theirs
        return Ties(np.array([row[0] for row in rows], dtype=np.int64), masters, weights)


@dataclass(frozen=True)
class Part:
    """One body of a deck, at its place: nodes (N, 2) or (N, 3) in mm, cells (m, 6) or (m, 15).

    `flanks` are arrays (k, 2) of element and side (1 to 3), or face (3 to 5), of the surfaces of
    each pair, layer by layer; `axis_mm` is x of the axis of the body. Solid bodies have ties. Where
    only the mean motion of the held nodes is held, they have weights (h,), mm.
    """

    nodes: Floats
    cells: Numbers
    held: Numbers
    flanks: tuple[Numbers, ...]
    material: Material
    axis_mm: float = 0.0
    ties: Ties | None = None
    weights: Floats | None = None


@dataclass(frozen=True)
class DeckFriction:
    """Friction of a deck: flanks slide to the position so that friction acts as in motion.

    Each pair of the deck has a coefficient; `back_rad` is the rotation of body 2 from the requested
    position to the previous one, at which sliding begins.
    """

    coefficients: tuple[float, ...]
    back_rad: float


@dataclass(frozen=True)
class Deck:
    """Content of the input file.

    Body 1, the first of the parts, rotates about the origin; body 2 is fixed. `sites` are the pair
    numbers of the flanks of the parts; `torque_Nmm` acts on the width of the deck; `start_rad` is
    the initial rotation of body 1, whose total rotation is this plus that of its axis. Plane bodies
    have `plane` ("strain" or "stress") and perhaps friction; solid ones have `edges_mm` (L + 1,),
    the ends of the layers over the common width. The answer divides forces and torque by
    `width_mm`.
    """

    title: str
    parts: tuple[Part, Part]
    sites: tuple[int, ...]
    torque_Nmm: float
    start_rad: float
    large_displacement: bool
    plane: str | None = None
    friction: DeckFriction | None = None
    edges_mm: Floats | None = None
    width_mm: float = 1.0

    @property
    def words(self) -> Words:
        """Lines of its kind of elements."""
        return WORDS[self.plane]

    @property
    def layers(self) -> int:
        """Number of layers over the common width; 1 of plane bodies."""
        return 1 if self.edges_mm is None else self.edges_mm.size - 1

    @property
    def node_count(self) -> int:
        """Number of nodes of both bodies."""
        return sum(len(part.nodes) for part in self.parts)

    @property
    def unknowns(self) -> int:
        """Number of independent displacements, with the rotation of body 1."""
        found = 1
        for part in self.parts:
            tied = 0 if part.ties is None else part.ties.nodes.size
            found += part.nodes.shape[1] * (len(part.nodes) - tied)
            held = part.nodes.shape[1] * part.held.size
            found -= held if part.weights is None else MEAN_MOTIONS
        return found

    def axis_node(self, body: int) -> int:
        """Number of the node whose first component is the rotation of body 1 or 2."""
        return self.node_count + body

    def first_sum(self, body: int) -> int:
        """Number of the first further node of the mean motion of a body."""
        return self.axis_node(3) + (further_nodes(self.parts[0].held.size) if body == 2 else 0)

    def surface(self, site: int, layer: int, body: int) -> str:
        """Name of the surface of a flank in a layer."""
        return f"{pair_name(site)}_LAYER_{layer}_BODY_{body}"

    def contacts(self) -> Iterator[tuple[str, str]]:
        """Names of the surfaces of all contact pairs, by site, then layer."""
        for site in self.sites:
            for layer in range(self.layers):
                yield self.surface(site, layer, 1), self.surface(site, layer, 2)


def pair_name(site: int) -> str:
    """Name of a pair; M means minus."""
    return f"PAIR_{'M' if site < 0 else ''}{abs(site)}"


def deck_text(deck: Deck) -> str:
    """The input file."""
    return "\n".join(_lines(deck)) + "\n"


def probe_of(deck: Deck, elements: int) -> tuple[str, int]:
    """A linear deck of some neighbouring elements of body 2 of a solid deck, and its unknowns."""
    part = deck.parts[1]
    middles = part.nodes[part.cells[:, :6]].mean(axis=1)
    near = np.linalg.norm(middles - middles[0], axis=1).argsort()[:elements]
    used, cells = np.unique(part.cells[near], return_inverse=True)
    nodes = part.nodes[used]
    held = np.flatnonzero(nodes[:, 2] <= np.quantile(nodes[:, 2], PROBE_HELD))
    small = Part(nodes, cells.reshape(-1, part.cells.shape[1]), held, (), part.material)
    free = int(np.setdiff1d(np.arange(len(nodes)), held)[0])
    lines = (
        *("*HEADING", "part of a deck", *_body(small, 1, deck, 1, 1)),
        *("*NSET, NSET=HELD_1", *(f"{node}," for node in (1 + held).tolist())),
        *("*BOUNDARY", "HELD_1, 1, 3", "*STEP", "*STATIC", "*CLOAD", f"{1 + free}, 1, 1."),
        "*END STEP",
    )
    return "\n".join(lines) + "\n", nodes.size - 3 * held.size


def _lines(deck: Deck) -> Iterator[str]:
    yield "*HEADING"
    title = " ".join(deck.title.split())
    yield f"scene: {title} [mm, N, MPa; for {deck.width_mm:g} mm of width]"
    yield f"** body 1 is rotated by {deck.start_rad!r} rad from the position without load;"
    yield f"** its rotation is that angle and the first component of node {deck.axis_node(1)}"
    first_node, first_element = 1, 1
    for z, part in enumerate(deck.parts, start=1):
        yield from _body(part, z, deck, first_node, first_element)
        yield from _surfaces(deck, z, first_element)
        yield f"*NSET, NSET=HELD_{z}"
        yield from (f"{node}," for node in (first_node + part.held).tolist())
        yield from _ties(part, first_node)
        first_node += len(part.nodes)
        first_element += len(part.cells)
    by_axis = deck.friction is not None or deck.parts[1].weights is not None
    yield from _axis(deck, 1)
    if by_axis:
        yield from _axis(deck, 2)
    yield from _contact(deck)
    if deck.friction is None:
        held = "AXIS_2, 1, 1" if by_axis else "HELD_2, 1, 2"
        yield from ("*BOUNDARY", *(deck.words.supports or (held,)))
        yield from _step(deck)
    else:
        yield from _step(deck, f"AXIS_2, 1, 1, {_number(deck.friction.back_rad)}")
        yield from _step(deck, "AXIS_2, 1, 1, 0.")


def _body(part: Part, z: int, deck: Deck, first_node: int, first_element: int) -> Iterator[str]:
    yield "*NODE"
    for k, place in enumerate(part.nodes.tolist(), start=first_node):
        yield ", ".join([f"{k}", *map(_number, place), *["0."] * (3 - len(place))])
    yield f"*ELEMENT, TYPE={deck.words.element}, ELSET=BODY_{z}"
    for k, row in enumerate((first_node + part.cells).tolist(), start=first_element):
        yield f"{k}, " + ", ".join(map(str, row))
    yield f"*MATERIAL, NAME=MATERIAL_{z}"
    yield "*ELASTIC"
    yield ", ".join(map(_number, (part.material.young_modulus_MPa, part.material.poisson_ratio)))
    yield f"*SOLID SECTION, ELSET=BODY_{z}, MATERIAL=MATERIAL_{z}"
    yield from deck.words.section


def _surfaces(deck: Deck, z: int, first_element: int) -> Iterator[str]:
    """Faces of each flank and layer; those of body 2 include both neighbouring layers."""
    near = 0 if z == 1 else 1
    for k, site in enumerate(deck.sites):
        faces = deck.parts[z - 1].flanks[k * deck.layers : (k + 1) * deck.layers]
        for layer in range(deck.layers):
            yield f"*SURFACE, NAME={deck.surface(site, layer, z)}, TYPE=ELEMENT"
            for rows in faces[max(0, layer - near) : layer + near + 1]:
                yield from (f"{first_element + e}, S{face}" for e, face in rows.tolist())


def _ties(part: Part, first_node: int) -> Iterator[str]:
    """Equations of nodes that follow the faces of thick layers."""
    ties = part.ties
    if ties is None:
        return
    rows = zip(ties.nodes.tolist(), ties.masters.tolist(), ties.weights.tolist(), strict=True)
    for node, masters, weights in rows:
        terms = [(first_node + m, -w) for m, w in zip(masters, weights, strict=True) if w]
        for component in (1, 2, 3):
            own = [(first_node + node, component, 1.0)]
            yield from _equation(own + [(m, component, w) for m, w in terms])


def _equation(terms: list[tuple[int, int, float]]) -> Iterator[str]:
    """A homogeneous equation of (node, component, factor), four terms to a line."""
    yield "*EQUATION"
    yield f"{len(terms)}"
    for k in range(0, len(terms), 4):
        yield ", ".join(f"{node}, {c}, {_number(f)}" for node, c, f in terms[k : k + 4])


def _axis(deck: Deck, body: int) -> Iterator[str]:
    """Let the held nodes of a body rotate about its axis: u = (-y, x) times rotation."""
    axis, part = deck.axis_node(body), deck.parts[body - 1]
    first_node = 1 + sum(len(before.nodes) for before in deck.parts[: body - 1])
    yield f"*NODE, NSET=AXIS_{body}"
    yield f"{axis}, {_number(part.axis_mm)}, 0., 0."
    x, y = part.nodes[part.held, :2].T
    if part.weights is not None:
        places, first_sum = (x - part.axis_mm, y), deck.first_sum(body)
        yield "*NODE"
        for number in range(first_sum, first_sum + further_nodes(part.held.size)):
            yield f"{number}, {_number(part.axis_mm)}, 0., 0."
        for terms in mean_motion_equations(
            first_node + part.held, places, part.weights, axis, first_sum
        ):
            yield from _equation(terms)
    else:
        for node, x_held, y_held in zip((first_node + part.held).tolist(), x, y, strict=True):
            yield from _equation([(node, 1, 1.0), (axis, 1, y_held)])
            yield from _equation([(node, 2, 1.0), (axis, 1, part.axis_mm - x_held)])
    yield "*BOUNDARY"
    yield f"AXIS_{body}, 2, 3"


def _contact(deck: Deck) -> Iterator[str]:
    """Contact pairs; each pair of flanks has its own friction."""
    interaction = ""
    for k, (slave, master) in enumerate(deck.contacts()):
        name = pair_name(deck.sites[k // deck.layers])
        if name != interaction:
            interaction = name
            yield f"*SURFACE INTERACTION, NAME={name}"
            yield "*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR"
            yield f"{PENALTY:g}"
            if deck.friction is not None and deck.friction.coefficients[k] > 0:
                yield "*FRICTION"
                yield f"{_number(deck.friction.coefficients[k])}, {STICK:g}"
        yield f"*CONTACT PAIR, INTERACTION={name}, TYPE=SURFACE TO SURFACE"
        yield f"{slave}, {master}"


def _step(deck: Deck, boundary: str | None = None) -> Iterator[str]:
    yield "*STEP, INC=1000" + (", NLGEOM" if deck.large_displacement else "")
    yield from ("*CONTROLS, PARAMETERS=FIELD", f", {CORRECTION:g}")
    yield from deck.words.controls
    yield from ("*STATIC", "1., 1.")
    if boundary is not None:
        yield from ("*BOUNDARY", boundary)
    yield from ("*CLOAD", f"AXIS_1, 1, {_number(deck.torque_Nmm)}")
    yield from ("*NODE PRINT, NSET=AXIS_1", "U")
    for slave, master in deck.contacts():
        yield f"*CONTACT PRINT, SLAVE={slave}, MASTER={master}"
        yield "CF"
    yield from deck.words.prints
    yield "*END STEP"


def _number(value: float) -> str:
    """A number in at most 20 characters: CalculiX silently ignores further characters."""
    return f"{value:.13g}"
