"""Input deck for CalculiX: bodies in quadratic plane elements, contact, supports and torque.

Everything is per mm of face width. The names for the reader of the output are defined here: node
set AXIS_1 (its first component is the rotation of body 1), surfaces PAIR_<j>_BODY_<z>.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flankload.studies.verification.triangles import quadratic

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import NDArray

    from flankload.bodies import Material
    from flankload.studies.verification.triangles import Triangles

    Floats = NDArray[np.float64]
    Numbers = NDArray[np.int64]

#: Contact pressure per mm of overlap, MPa/mm: 1000 MPa cause an overlap of 0.01 um.
PENALTY = 1e8
#: Shear stress per mm of slip before flanks slide, MPa/mm: 150 MPa are reached after 0.03 um.
STICK = 5e6
#: An iteration is the last one if its largest correction is below this part of the displacement;
#: the default of CalculiX is 0.01, which leaves 0.05 % in the rotation.
CORRECTION = 1e-5
#: Six-node plane elements of CalculiX.
ELEMENT = {"strain": "CPE6", "stress": "CPS6"}


@dataclass(frozen=True)
class Part:
    """One body of a deck.

    Attributes
    ----------
    nodes : (N, 2) array
        mm, at the place of the body.
    cells : (m, 6) array
    held : array
        Fixed nodes.
    flanks : tuple of (k, 2) arrays
        Element and side (1 to 3) of each pair's surface.
    """

    nodes: Floats
    cells: Numbers
    held: Numbers
    flanks: tuple[Numbers, ...]
    material: Material


@dataclass(frozen=True)
class DeckFriction:
    """Friction of a deck: flanks slide to the position so that friction acts as in motion.

    Attributes
    ----------
    coefficients : tuple of float
        Coefficient of each pair of the deck.
    center_distance_mm : float
        Distance to the axis of body 2.
    back_rad : float
        Rotation of body 2 from the requested position to the previous one, at which sliding begins.
    """

    coefficients: tuple[float, ...]
    center_distance_mm: float
    back_rad: float


@dataclass(frozen=True)
class Deck:
    """Content of the input file.

    Attributes
    ----------
    parts : two Part
        Body 1 rotates about the origin; body 2 is fixed.
    sites : tuple of int
        Pair number of each of `Part.flanks`.
    torque_N : float
        Torque per mm of width, N mm/mm.
    start_rad : float
        Initial rotation of body 1; its total rotation is this plus that of its axis.
    plane : {"strain", "stress"}
    large_displacement : bool
        Whether the geometry follows the deformation.
    friction : DeckFriction or None
        None without friction.
    """

    title: str
    parts: tuple[Part, Part]
    sites: tuple[int, ...]
    torque_N: float
    start_rad: float
    plane: str
    large_displacement: bool
    friction: DeckFriction | None = None

    @property
    def node_count(self) -> int:
        """Number of nodes of both bodies."""
        return sum(len(part.nodes) for part in self.parts)

    def axis_node(self, body: int) -> int:
        """Number of the node whose first component is the rotation of body 1 or 2."""
        return self.node_count + body


def part_of(mesh: Triangles, n_flanks: int, material: Material) -> Part:
    """A body of the deck from its triangles.

    Parameters
    ----------
    mesh : Triangles
        Mesh at the place of the body.
    n_flanks : int
        Number of flanks that may touch.
    """
    nodes, cells, middles = quadratic(mesh)
    border = mesh.border
    held = np.unique(np.concatenate([border.ends[border.held].ravel(), middles[border.held]]))
    # element and side that contain each middle node of the border
    owner = np.zeros((len(nodes), 2), dtype=np.int64)
    for side in range(3):
        owner[cells[:, 3 + side]] = np.stack(
            [np.arange(len(cells)), np.full(len(cells), side + 1)], axis=1
        )
    flanks = tuple(owner[middles[border.flank == k]] for k in range(n_flanks))
    return Part(nodes, cells, held, flanks, material)


def surface_name(site: int, body: int | None = None) -> str:
    """Name of a pair, or of its surface on body 1 or 2; M means minus."""
    name = f"PAIR_{'M' if site < 0 else ''}{abs(site)}"
    return name if body is None else f"{name}_BODY_{body}"


def deck_text(deck: Deck) -> str:
    """The input file."""
    return "\n".join(_lines(deck)) + "\n"


def _lines(deck: Deck) -> Iterator[str]:
    yield "*HEADING"
    yield f"scene: {' '.join(deck.title.split())} [mm, N, MPa; per mm of width]"
    yield f"** body 1 is rotated by {deck.start_rad!r} rad from the position without load;"
    yield f"** its rotation is that angle and the first component of node {deck.axis_node(1)}"
    first_node, first_element = 1, 1
    for z, part in enumerate(deck.parts, start=1):
        yield from _body(part, z, ELEMENT[deck.plane], first_node, first_element)
        for site, faces in zip(deck.sites, part.flanks, strict=True):
            yield f"*SURFACE, NAME={surface_name(site, z)}, TYPE=ELEMENT"
            yield from (f"{first_element + e}, S{side}" for e, side in faces.tolist())
        yield from node_set(f"HELD_{z}", first_node + part.held)
        first_node += len(part.nodes)
        first_element += len(part.cells)
    yield from _axis(deck, 1, 0.0)
    if deck.friction is not None:
        yield from _axis(deck, 2, deck.friction.center_distance_mm)
    yield from _contact(deck)
    if deck.friction is None:
        yield from ("*BOUNDARY", "HELD_2, 1, 2")
        yield from _step(deck)
    else:
        yield from _step(deck, f"AXIS_2, 1, 1, {number(deck.friction.back_rad)}")
        yield from _step(deck, "AXIS_2, 1, 1, 0.")


def _axis(deck: Deck, body: int, center_mm: float) -> Iterator[str]:
    """Constrain the fixed nodes of a body to rotate about its axis: u = (-y, x) times rotation."""
    axis = deck.axis_node(body)
    part = deck.parts[body - 1]
    first_node = 1 + sum(len(before.nodes) for before in deck.parts[: body - 1])
    yield f"*NODE, NSET=AXIS_{body}"
    yield f"{axis}, {number(center_mm)}, 0., 0."
    for node in part.held.tolist():
        x, y = part.nodes[node].tolist()
        for component, arm in ((1, y), (2, center_mm - x)):
            yield "*EQUATION"
            yield "2"
            yield f"{first_node + node}, {component}, 1., {axis}, 1, {number(arm)}"
    yield "*BOUNDARY"
    yield f"AXIS_{body}, 2, 3"


def _contact(deck: Deck) -> Iterator[str]:
    for k, site in enumerate(deck.sites):
        name = surface_name(site)
        yield f"*SURFACE INTERACTION, NAME={name}"
        yield "*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR"
        yield f"{PENALTY:g}"
        if deck.friction is not None and deck.friction.coefficients[k] > 0:
            yield "*FRICTION"
            yield f"{number(deck.friction.coefficients[k])}, {STICK:g}"
        yield f"*CONTACT PAIR, INTERACTION={name}, TYPE=SURFACE TO SURFACE"
        yield f"{surface_name(site, 1)}, {surface_name(site, 2)}"


def _step(deck: Deck, boundary: str | None = None) -> Iterator[str]:
    yield "*STEP, INC=1000" + (", NLGEOM" if deck.large_displacement else "")
    yield from ("*CONTROLS, PARAMETERS=FIELD", f", {CORRECTION:g}")
    yield from ("*STATIC", "1., 1.")
    if boundary is not None:
        yield from ("*BOUNDARY", boundary)
    yield from ("*CLOAD", f"AXIS_1, 1, {number(deck.torque_N)}")
    yield from ("*NODE PRINT, NSET=AXIS_1", "U")
    for site in deck.sites:
        yield f"*CONTACT PRINT, SLAVE={surface_name(site, 1)}, MASTER={surface_name(site, 2)}"
        yield "CF"
    yield from ("*CONTACT PRINT", "CSTR")
    yield "*END STEP"


def _body(part: Part, z: int, kind: str, first_node: int, first_element: int) -> Iterator[str]:
    yield "*NODE"
    for k, (x, y) in enumerate(part.nodes.tolist(), start=first_node):
        yield f"{k}, {number(x)}, {number(y)}, 0."
    yield f"*ELEMENT, TYPE={kind}, ELSET=BODY_{z}"
    for k, row in enumerate((first_node + part.cells).tolist(), start=first_element):
        yield f"{k}, " + ", ".join(map(str, row))
    yield f"*MATERIAL, NAME=MATERIAL_{z}"
    yield "*ELASTIC"
    yield ", ".join(map(number, (part.material.young_modulus_MPa, part.material.poisson_ratio)))
    yield f"*SOLID SECTION, ELSET=BODY_{z}, MATERIAL=MATERIAL_{z}"
    yield "1."


def number(value: float) -> str:
    """A number in at most 20 characters: CalculiX silently ignores further characters."""
    return f"{value:.13g}"


def node_set(name: str, nodes: Numbers) -> Iterator[str]:
    yield f"*NSET, NSET={name}"
    yield from (f"{node}," for node in nodes.tolist())
