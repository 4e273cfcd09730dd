"""Input deck for CalculiX of solid bodies in contact.

A pair of flanks has a contact pair for each layer of elements over the common width, so that the
output has the force of each. Names for the reader of the output: node set AXIS_1 (its first
component is the rotation of body 1), surfaces PAIR_<j>_LAYER_<l>_BODY_<z>.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flankload.studies.verification.deck import (
    CORRECTION,
    PENALTY,
    node_set,
    number,
    surface_name,
)

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import NDArray

    from flankload.studies.verification.solid import SolidPart

    Floats = NDArray[np.float64]

ELEMENT = "C3D15"
#: Defaults of CalculiX but for the third number: contacts have their whole stiffness from the first
#: increment, so that CalculiX does not append a second one.
STIFF = "0.001, 0.1, 1, 60"
INTERACTION = "FLANKS"


@dataclass(frozen=True)
class SolidDeck:
    """Content of the input file.

    Attributes
    ----------
    parts : two SolidPart
        Body 1 rotates about the z axis; body 2 is fixed.
    sites : tuple of int
        Pair number of each flank of the parts.
    edges_mm : (L + 1,) array
        Ends of the layers over the common width.
    face_width_mm : float
        Width of the scene, by which the answer divides forces.
    start_rad : float
        Initial rotation of body 1; its total rotation is this plus that of its axis.
    large_displacement : bool
        Whether the geometry follows the deformation.
    """

    title: str
    parts: tuple[SolidPart, SolidPart]
    sites: tuple[int, ...]
    edges_mm: Floats
    face_width_mm: float
    torque_Nm: float
    start_rad: float
    large_displacement: bool

    @property
    def layers(self) -> int:
        """Number of layers over the common width."""
        return self.edges_mm.size - 1

    @property
    def node_count(self) -> int:
        """Number of nodes of both bodies."""
        return sum(len(part.nodes) for part in self.parts)

    @property
    def axis_node(self) -> int:
        """Number of the node whose first component is the rotation of body 1."""
        return self.node_count + 1

    @property
    def unknowns(self) -> int:
        """Number of independent displacements, with the rotation of body 1."""
        return 1 + sum(
            3 * (len(part.nodes) - part.held.size - part.ties.nodes.size) for part in self.parts
        )


def layer_surface(site: int, layer: int, body: int) -> str:
    """Name of the surface of a flank in a layer."""
    return f"{surface_name(site)}_LAYER_{layer}_BODY_{body}"


def solid_text(deck: SolidDeck) -> str:
    """The input file."""
    return "\n".join(_lines(deck)) + "\n"


def _lines(deck: SolidDeck) -> Iterator[str]:
    yield "*HEADING"
    yield f"scene: {' '.join(deck.title.split())} [mm, N, MPa]"
    yield f"** body 1 is rotated by {deck.start_rad!r} rad from the position without load;"
    yield f"** its rotation is that angle and the first component of node {deck.axis_node}"
    first_node, first_element = 1, 1
    for z, part in enumerate(deck.parts, start=1):
        yield from _body(part, z, first_node, first_element)
        yield from _surfaces(deck, z, first_element)
        yield from node_set(f"HELD_{z}", first_node + part.held)
        yield from _ties(part, first_node)
        first_node += len(part.nodes)
        first_element += len(part.cells)
    yield from _axis(deck)
    yield from _contact(deck)
    yield from ("*BOUNDARY", "HELD_1, 3, 3", "HELD_2, 1, 3")
    yield from _step(deck)


def _body(part: SolidPart, z: int, first_node: int, first_element: int) -> Iterator[str]:
    yield "*NODE"
    for k, place in enumerate(part.nodes.tolist(), start=first_node):
        yield f"{k}, " + ", ".join(map(number, place))
    yield f"*ELEMENT, TYPE={ELEMENT}, ELSET=BODY_{z}"
    for k, row in enumerate((first_node + part.cells).tolist(), start=first_element):
        yield f"{k}, " + ", ".join(map(str, row))
    yield f"*MATERIAL, NAME=MATERIAL_{z}"
    yield "*ELASTIC"
    yield ", ".join(map(number, (part.material.young_modulus_MPa, part.material.poisson_ratio)))
    yield f"*SOLID SECTION, ELSET=BODY_{z}, MATERIAL=MATERIAL_{z}"


def _surfaces(deck: SolidDeck, z: int, first_element: int) -> Iterator[str]:
    """Faces of each flank and layer; those of body 2 include both neighbouring layers."""
    for k, site in enumerate(deck.sites):
        faces = deck.parts[z - 1].flanks[k * deck.layers : (k + 1) * deck.layers]
        for layer in range(deck.layers):
            near = 0 if z == 1 else 1
            yield f"*SURFACE, NAME={layer_surface(site, layer, z)}, TYPE=ELEMENT"
            for rows in faces[max(0, layer - near) : layer + near + 1]:
                yield from (f"{first_element + e}, S{face}" for e, face in rows.tolist())


def _ties(part: SolidPart, first_node: int) -> Iterator[str]:
    """Equations of nodes that follow the faces of thick layers."""
    ties = part.ties
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
        yield ", ".join(f"{node}, {c}, {number(f)}" for node, c, f in terms[k : k + 4])


def _axis(deck: SolidDeck) -> Iterator[str]:
    """Let the fixed nodes of body 1 rotate about its axis: u = (-y, x, 0) times rotation."""
    part, axis = deck.parts[0], deck.axis_node
    yield "*NODE, NSET=AXIS_1"
    yield f"{axis}, 0., 0., 0."
    for node in part.held.tolist():
        x, y, _ = part.nodes[node].tolist()
        yield from _equation([(1 + node, 1, 1.0), (axis, 1, y)])
        yield from _equation([(1 + node, 2, 1.0), (axis, 1, -x)])
    yield "*BOUNDARY"
    yield "AXIS_1, 2, 3"


def _contact(deck: SolidDeck) -> Iterator[str]:
    yield f"*SURFACE INTERACTION, NAME={INTERACTION}"
    yield "*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR"
    yield f"{PENALTY:g}"
    for slave, master in _pairs(deck):
        yield f"*CONTACT PAIR, INTERACTION={INTERACTION}, TYPE=SURFACE TO SURFACE"
        yield f"{slave}, {master}"


def _step(deck: SolidDeck) -> Iterator[str]:
    yield "*STEP, INC=1000" + (", NLGEOM" if deck.large_displacement else "")
    yield from ("*CONTROLS, PARAMETERS=FIELD", f", {CORRECTION:g}")
    yield from ("*CONTROLS, PARAMETERS=CONTACT", STIFF)
    yield from ("*STATIC", "1., 1.")
    yield from ("*CLOAD", f"AXIS_1, 1, {number(1000.0 * deck.torque_Nm)}")
    yield from ("*NODE PRINT, NSET=AXIS_1", "U")
    for slave, master in _pairs(deck):
        yield f"*CONTACT PRINT, SLAVE={slave}, MASTER={master}"
        yield "CF"
    yield "*END STEP"


def _pairs(deck: SolidDeck) -> Iterator[tuple[str, str]]:
    """Names of the surfaces of all contact pairs."""
    for site in deck.sites:
        for layer in range(deck.layers):
            yield layer_surface(site, layer, 1), layer_surface(site, layer, 2)
