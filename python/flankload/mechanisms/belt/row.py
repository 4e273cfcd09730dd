"""Timing belt as a row of equal cells from tooth to tooth, with two ends at the strands.

The cells are equal at all positions, so that one is condensed once. The ends depend on the advance
of the teeth. All parts are assembled through the stiffness of the faces between them.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import sin
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from flankload.base.rounding import round_down
from flankload.elasticity.sector_row import row_response
from flankload.mechanisms.belt.belt_mesh import FLANK_ELEMENTS, STRAND, half_land, mesh_strip
from flankload.mechanisms.belt.columns import Flanks
from flankload.mechanisms.belt.strip import Kind, Piece, solve_piece

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flankload.base.arrays import Floats, Numbers
    from flankload.cost import Account
    from flankload.mechanisms.belt.belt import Strip
    from flankload.mechanisms.belt.belt_mesh import BeltMesh

#: Least length of a part of a land, relative to an element; shorter parts are omitted.
LEAST_LENGTH_RATIO = 0.3


@dataclass(frozen=True)
class Columns:
    """Response to k unit loads of one kind; n pairs, h shape functions on the lands.

    Attributes
    ----------
    displacement : (n, k) array
        Normal displacements of the flanks.
    reaction : (h, k) array
        Forces of the lands on the belt.
    tight : (k,) array
        Tension of the tight strand.
    """

    displacement: Floats
    reaction: Floats
    tight: Floats


@dataclass(frozen=True)
class StripResponse:
    """Response of a belt on its pulley, per mm of width; n pairs, h shape functions on the lands.

    Attributes
    ----------
    phase : float
        Advance of the teeth, in pitches, since the strands met the belt in mid-land.
    first_tooth, teeth : int
        Number of the first tooth with contact pairs, and the number of such teeth.
    first_land, lands : int
        The same for lands on the pulley; a land has the number of the tooth behind it.
    flanks : Flanks
        Teeth counted from the first one.
    land : (h,) array
        Land of each shape function, counted from the first land.
    land_angle_rad : (h,) array
        Angle of the end node of each shape function.
    by : dict of Kind to Columns
        Responses to forces on pairs (K and P, mm²/N), to the tension of the slack strand (L and p)
        and, if requested, to circumferential forces and radial displacements of the lands.
    degrees_of_freedom : int
        Sum over all pieces that were solved.
    elastic_pulley : bool
        Whether the pulley is elastic: teeth influence each other through it as well.
    """

    phase: float
    first_tooth: int
    teeth: int
    first_land: int
    lands: int
    flanks: Flanks
    land: Numbers
    land_angle_rad: Floats
    by: dict[Kind, Columns]
    degrees_of_freedom: int
    elastic_pulley: bool = False


@dataclass(frozen=True)
class PieceSize:
    """Unknowns and columns of a piece of belt, known from its mesh.

    Attributes
    ----------
    pairs, land_functions : int
        Number of contact pairs on its flanks, and of shape functions on its lands.
    held, pulled : int
        Whether the tight strand fixes it, and whether the slack one pulls it: 0 or 1.
    kept : int
        Unknowns of its cuts.
    unknowns : int
        Unknowns inside.
    """

    pairs: int
    land_functions: int
    held: int
    pulled: int
    kept: int
    unknowns: int

    @classmethod
    def of(cls, mesh: BeltMesh, cuts: tuple[bool, bool]) -> PieceSize:
        """Size of a piece with these cuts on its left and its right."""
        pairs, lands = (
            sum(nodes.size // 2 + 1 for nodes in lines.values())
            for lines in (mesh.flanks, mesh.lands)
        )
        held, pulled = mesh.tight.size, mesh.slack.size
        kept = 2 * (cuts[0] * mesh.left.size + cuts[1] * mesh.right.size)
        return cls(pairs, lands, held, pulled, kept, 2 * len(mesh.nodes) - kept - lands - held)

    def work(self, *, sliding: bool, lifting: bool) -> dict[str, int]:
        """Counted work of its solution."""
        normal, along = self.pairs + self.pulled, sliding * self.land_functions
        columns = normal + along + self.land_functions + self.held
        normal += lifting * self.land_functions
        return condensation_work(self.unknowns, columns, normal, along)


def condensation_work(unknowns: int, columns: int, normal: int, along: int) -> dict[str, int]:
    """Counters of condensed elements, by the names of `cost.COUNTERS`.

    `columns` are loads and readings; unit loads are normal and tangential.
    """
    return {
        "fe_factorisations": 1,
        "fe_unknowns": unknowns,
        "fe_solutions": columns,
        "unit_loads_normal": normal,
        "unit_loads_tangential": along,
    }


def phases(strip: Strip, position_rad: Floats) -> Floats:
    """(P,) Position of the middle of the first land beyond the tangent point, in pitches."""
    at = position_rad / strip.pitch_rad
    return np.asarray(at - round_down(at + 0.5))


class BeltRow:
    """A belt whose cell from tooth to tooth is solved once; pieces are solved on demand.

    Parameters
    ----------
    strip : Strip
        With teeth: a belt without teeth cannot be cut in the middle of a land.
    flank_elements : int
        Number on the flank of a tooth.
    sliding, lifting : bool
        Whether the columns of sliding and lifting lands are included.
    """

    #: Faces at which other pieces adjoin: left, right.
    CUTS: ClassVar = {"cell": (True, True), "tight": (False, True), "slack": (True, False)}

    def __init__(
        self,
        strip: Strip,
        flank_elements: int = FLANK_ELEMENTS,
        *,
        sliding: bool = False,
        lifting: bool = False,
    ) -> None:
        assert strip.tooth is not None
        self.strip, self.elements = strip, flank_elements
        self._columns = {"sliding": sliding, "lifting": lifting}
        self._meshes: dict[tuple[str, float], BeltMesh] = {}
        self._pieces: dict[tuple[str, float], Piece] = {}
        # positions with strands that begin at the edges of lands have the same pieces
        self._known: tuple[tuple[float, float], StripResponse] | None = None

    def at(self, phase: float, account: Account | None = None) -> StripResponse:
        """Response of the belt after an advance of its teeth, in pitches; work is counted."""
        teeth = -round_down(phase + 0.5)
        on = self.strip.pitch_rad * (phase + teeth)
        ends = strand_ends(self.strip, self.elements, on)
        if self._known is None or self._known[0] != ends:
            self._known = ends, self._joined(ends, account)
        return at_position(self.strip, self._known[1], ends, teeth, on)

    def solve_cell(self, account: Account) -> None:
        """Solve the cell; a belt of one tooth has none."""
        if self.strip.wrapped_teeth > 1:
            self._piece("cell", 0.0, account)

    @property
    def pairs(self) -> int:
        """Number of contact pairs of the whole wrap."""
        return self.strip.wrapped_teeth * (self.elements + 1)

    def sizes(self, position_rad: Floats) -> list[PieceSize]:
        """Sizes of all pieces that are solved for these positions."""
        on = self.strip.pitch_rad * phases(self.strip, position_rad)
        both = [strand_ends(self.strip, self.elements, float(angle)) for angle in on]
        tight, slack = map(set, zip(*both, strict=True))
        keys = [("tight", end) for end in tight] + [("slack", end) for end in slack]
        if self.strip.wrapped_teeth > 1:
            keys.append(("cell", 0.0))
        return [PieceSize.of(self._mesh(*key), self.CUTS[key[0]]) for key in keys]

    def _joined(self, ends: tuple[float, float], account: Account | None) -> StripResponse:
        last = self.strip.wrapped_teeth - 1
        cell = self._piece("cell", 0.0, account) if last else None
        return strip_response(
            (
                self._piece("tight", ends[0], account),
                *(moved_on(cell, k, self.strip.pitch_rad * k) for k in range(last) if cell),
                self._piece("slack", ends[1], account),
            )
        )

    def _piece(self, name: str, end_rad: float, account: Account | None) -> Piece:
        """A piece, solved once; the end of its strand is that of `strand_ends`."""
        key = name, end_rad
        if key not in self._pieces:
            mesh = self._mesh(*key)
            self._pieces[key] = solve_piece(
                self.strip, mesh, self.CUTS[name], account=account, **self._columns
            )
            del self._meshes[key]
        return self._pieces[key]

    def _mesh(self, name: str, end_rad: float) -> BeltMesh:
        key = name, end_rad
        if key not in self._meshes:
            last = 2 * (self.strip.wrapped_teeth - 1)
            # the cell extends from the middle of tooth 0 to that of tooth 1
            places = {"cell": (0, 2), "tight": (-STRAND, 0), "slack": (last, last + STRAND)}[name]
            ends = (0.0, end_rad) if name == "slack" else (end_rad, 0.0)
            self._meshes[key] = mesh_strip(self.strip, self.elements, ends_rad=ends, places=places)
        return self._meshes[key]


def strand_ends(strip: Strip, flank_elements: int, on_rad: float) -> tuple[float, float]:
    """Places where the strands begin, from the middles of the first and the last land.

    Strands begin at their tangent points if these lie on lands. Over grooves a strand is straight
    up to the edge of the nearest land, of which a part of the default element length is always
    fixed, because the displacement of a belt fixed at a point would be unbounded. The middles of
    both lands are `on_rad` beyond the tangent points, in the direction of rotation.
    """
    land = half_land(strip, flank_elements)
    edge, element = float(land[-1]), float(land[1])

    def near(end: float) -> float:
        # avoid very thin elements
        for known in (-edge, 0.0, edge):
            if abs(end - known) < LEAST_LENGTH_RATIO * element:
                return known
        return end

    inside = edge - float(half_land(strip, FLANK_ELEMENTS)[1])
    return near(min(max(-on_rad, -edge), inside)), near(min(max(-on_rad, -inside), edge))


def at_position(
    strip: Strip, response: StripResponse, ends: tuple[float, float], teeth: int, on_rad: float
) -> StripResponse:
    """Response at a position, from the response with strands that begin at the same places.

    The free length of a strand ends at its tangent point, so an extra length of the tight strand
    moves all teeth. A strand leaves along the tangent: the edge of the land prevents more bending
    than on the pulley.

    The middle of the first land moves from angle 0 to `on_rad`, and `teeth` is added to all
    numbers. Strands begin at `ends` from the middles of the first and the last land, rad.
    """
    along = response.flanks.levers_mm / strip.pitch_radius_mm
    follow = along * (strip.pitch_radius_mm * (ends[0] + on_rad) / strip.strand_N_per_mm)
    bent = np.zeros((2, response.land.size))
    bent[0, 0], bent[1, -1] = sin(ends[0] + on_rad), -sin(ends[1] + on_rad)
    by = {
        kind: Columns(
            columns.displacement + np.outer(follow, columns.tight),
            columns.reaction + np.outer(bent[0], columns.tight),
            columns.tight,
        )
        for kind, columns in response.by.items()
    }
    pairs, slack = by[Kind.PAIR], by[Kind.SLACK]
    # the balance of torque gives the tension exactly, and a symmetric matrix
    whole = response.by[Kind.PAIR].displacement + np.outer(follow, along)
    by[Kind.PAIR] = replace(pairs, displacement=whole)
    by[Kind.SLACK] = replace(slack, reaction=slack.reaction + bent[1][:, None])
    return replace(
        response,
        phase=on_rad / strip.pitch_rad - teeth,
        first_tooth=response.first_tooth + teeth,
        first_land=response.first_land + teeth,
        flanks=response.flanks.turned(on_rad),
        land_angle_rad=response.land_angle_rad + on_rad,
        by=by,
    )


def moved_on(piece: Piece, teeth: int, angle_rad: float) -> Piece:
    """A piece moved around the pulley by an angle and a number of teeth."""
    return replace(
        piece,
        flanks=replace(piece.flanks.turned(angle_rad), tooth=piece.flanks.tooth + teeth),
        land=piece.land + teeth,
        land_angle_rad=piece.land_angle_rad + angle_rad,
    )


def strip_response(pieces: Sequence[Piece]) -> StripResponse:
    """Assemble consecutive pieces; the first has the tight strand, the last the slack one."""
    row = row_response([piece.cell for piece in pieces])
    kinds = np.concatenate([piece.kinds for piece in pieces])
    loads = np.concatenate([piece.kinds[: piece.cell.loads] for piece in pieces])
    rows = {kind: np.flatnonzero(kinds == kind) for kind in Kind}
    columns = {kind: np.flatnonzero(loads == kind) for kind in Kind}

    def seen(one: Kind, other: Kind) -> Floats:
        return np.asarray(row[np.ix_(rows[one], columns[other])])

    by = {
        kind: Columns(seen(Kind.PAIR, kind), -seen(Kind.RADIAL, kind), seen(Kind.TIGHT, kind)[0])
        for kind in Kind
        if columns[kind].size or kind is Kind.PAIR
    }
    flanks = Flanks.joined([piece.flanks for piece in pieces])
    land = np.concatenate([piece.land for piece in pieces])
    first = int(flanks.tooth.min()) if flanks.tooth.size else 0
    return StripResponse(
        phase=0.0,
        first_tooth=first,
        teeth=int(np.ptp(flanks.tooth)) + 1 if flanks.tooth.size else 0,
        first_land=int(land.min()),
        lands=int(np.ptp(land)) + 1,
        flanks=replace(flanks, tooth=flanks.tooth - first),
        land=land - land.min(),
        land_angle_rad=np.concatenate([piece.land_angle_rad for piece in pieces]),
        by=made_symmetric(by),
        degrees_of_freedom=sum(
            {id(piece.cell): piece.degrees_of_freedom for piece in pieces}.values()
        ),
    )


def made_symmetric(by: dict[Kind, Columns]) -> dict[Kind, Columns]:
    """The same responses without the roundoff in symmetric matrices: K, and that of lifts."""
    pairs = by[Kind.PAIR].displacement
    found = by | {Kind.PAIR: replace(by[Kind.PAIR], displacement=0.5 * (pairs + pairs.T))}
    if Kind.RADIAL in by:
        lifts = by[Kind.RADIAL].reaction
        found[Kind.RADIAL] = replace(by[Kind.RADIAL], reaction=0.5 * (lifts + lifts.T))
    return found
