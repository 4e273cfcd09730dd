"""Timing belt as a row of equal cells from tooth to tooth, with two ends at the strands.

The cells are the same at every position of the belt on its pulley: one is condensed once. The ends
depend on how far the teeth have advanced. All parts are assembled through the stiffness of the
faces between them.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import cos, sin
from typing import TYPE_CHECKING

import numpy as np

from flankload.base.rounding import round_down
from flankload.elasticity.sector_closure import row_response
from flankload.mechanisms.belt.belt_mesh import FLANK_ELEMENTS, STRAND, half_land, mesh_strip
from flankload.mechanisms.belt.columns import FlankLine, Flanks
from flankload.mechanisms.belt.strip import Kind, Piece, solve_piece

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from flankload.cost import Account
    from flankload.mechanisms.belt.belt import Strip

    Floats = NDArray[np.float64]
    Numbers = NDArray[np.int64]


#: Parts of a land that are shorter than this part of an element are omitted.
SLIVER = 0.3


@dataclass(frozen=True)
class LandColumns:
    """Response to the h shape functions of the lands under friction, or under lift.

    Attributes
    ----------
    recession : (n, h) array
        Normal displacements of the flanks under a circumferential force, or per radial
        displacement.
    reaction : (h, h) array
        Reactions of the lands.
    tight : (h,) array
        Tension of the tight strand.
    """

    recession: Floats
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
    lines : tuple of FlankLine, one per tooth
    compliance : (n, n) array
        K, normal displacements of flanks under forces on flanks, mm²/N.
    by_slack : (n,) array
        L, normal displacements of flanks under the tension of the slack strand.
    land : (h,) array
        Land of each shape function, counted from the first land.
    land_angle_rad : (h,) array
        Angle of the end node of each shape function.
    reaction : (h, n) array
        P, forces of the lands on the belt under forces on flanks.
    reaction_by_slack : (h,) array
    tight, tight_by_slack : (n,) array, float
        Tension of the tight strand.
    sliding, lifting : LandColumns or None
        If requested.
    degrees_of_freedom : int
        Sum over all pieces that were solved.
    pulley_yields : bool
        Whether teeth also influence each other through an elastic pulley.
    """

    phase: float
    first_tooth: int
    teeth: int
    first_land: int
    lands: int
    flanks: Flanks
    lines: tuple[FlankLine, ...]
    compliance: Floats
    by_slack: Floats
    land: Numbers
    land_angle_rad: Floats
    reaction: Floats
    reaction_by_slack: Floats
    tight: Floats
    tight_by_slack: float
    sliding: LandColumns | None
    lifting: LandColumns | None
    degrees_of_freedom: int
    pulley_yields: bool = False


class BeltRow:
    """A belt whose cell from tooth to tooth is solved once for all positions.

    Parameters
    ----------
    strip : Strip
        Must have teeth: a belt without teeth cannot be cut in the middle of a land.
    flank_elements : int
        On the flank of a tooth.
    sliding, lifting : bool
        Whether the columns of sliding and lifting lands are included.
    account : Account, optional
        Account in which the work is counted.
    """

    def __init__(
        self,
        strip: Strip,
        flank_elements: int = FLANK_ELEMENTS,
        *,
        sliding: bool = False,
        lifting: bool = False,
        account: Account | None = None,
    ) -> None:
        assert strip.tooth is not None
        self._strip, self._elements, self._account = strip, flank_elements, account
        self._asked = {"sliding": sliding, "lifting": lifting}
        # from the middle of tooth 0 to that of tooth 1
        self._cell = self._solved((0, 2), (True, True)) if strip.wrapped_teeth > 1 else None
        # positions with strands that begin at the edges of lands have the same pieces
        self._known: tuple[tuple[float, float], StripResponse] | None = None
        self._ends: dict[tuple[int, float], Piece] = {}

    def at(self, phase: float) -> StripResponse:
        """Response of the belt.

        Parameters
        ----------
        phase : float
            Advance of the teeth, in pitches.

        Returns
        -------
        StripResponse
        """
        teeth = -round_down(phase + 0.5)
        on = self._strip.pitch_rad * (phase + teeth)
        ends = strand_ends(self._strip, self._elements, on)
        if self._known is None or self._known[0] != ends:
            self._known = (ends, self._put_together(ends))
        return standing(self._strip, self._known[1], ends, teeth, on)

    def _put_together(self, ends: tuple[float, float]) -> StripResponse:
        last = self._strip.wrapped_teeth - 1
        tight = self._end(0, ends[0], (-STRAND, 0))
        slack = self._end(1, ends[1], (2 * last, 2 * last + STRAND))
        inner = [
            moved_on(self._cell, k, self._strip.pitch_rad * k)
            for k in range(last)
            if self._cell is not None
        ]
        return strip_response((tight, *inner, slack))

    def _end(self, side: int, end: float, places: tuple[int, int]) -> Piece:
        if (side, end) not in self._ends:
            ends = (end, 0.0) if side == 0 else (0.0, end)
            self._ends[side, end] = self._solved(places, (side == 1, side == 0), ends)
        return self._ends[side, end]

    def _solved(
        self,
        places: tuple[int, int],
        cuts: tuple[bool, bool],
        ends_rad: tuple[float, float] = (0.0, 0.0),
    ) -> Piece:
        mesh = mesh_strip(self._strip, self._elements, ends_rad=ends_rad, places=places)
        return solve_piece(self._strip, mesh, cuts, account=self._account, **self._asked)


def strand_ends(strip: Strip, flank_elements: int, on_rad: float) -> tuple[float, float]:
    """Places where the strands begin, from the middles of the first and the last land.

    If the tangent points of the strands lie on these lands, the strands begin there. Over grooves
    the belt is free: a strand is straight up to the edge of the nearest land, of which a small part
    is always fixed. This part has the default element length and does not decrease with shorter
    elements, because the displacement of a belt held at a point would be unbounded.

    Parameters
    ----------
    strip : Strip
    flank_elements : int
    on_rad : float
        Position of the middles of both lands beyond the tangent points, in the direction of
        rotation.

    Returns
    -------
    tight, slack : float
    """
    land = half_land(strip, flank_elements)
    edge, element = float(land[-1]), float(land[1])

    def near(end: float) -> float:
        # avoid very thin elements
        for known in (-edge, 0.0, edge):
            if abs(end - known) < SLIVER * element:
                return known
        return end

    inside = edge - float(half_land(strip, FLANK_ELEMENTS)[1])
    return near(min(max(-on_rad, -edge), inside)), near(min(max(-on_rad, -inside), edge))


def standing(
    strip: Strip, response: StripResponse, ends: tuple[float, float], teeth: int, on_rad: float
) -> StripResponse:
    """Response at a position, from the response with strands that begin at the same places.

    The free length of a strand ends at its tangent point: any extra length of the tight strand
    moves all teeth. It leaves along the tangent: the edge of the land resists any bending beyond
    that of the belt on the pulley.

    Parameters
    ----------
    strip : Strip
    response : StripResponse
        Response with the middle of the first land at angle 0.
    ends : (float, float)
        Places where the strands begin, from the middles of the first and the last land, rad.
    teeth : int
        Added to the numbers.
    on_rad : float
        Angle of the middle of the first land.

    Returns
    -------
    StripResponse
    """
    radius = strip.pitch_radius_mm
    follow = (
        response.flanks.levers_mm / radius * (radius * (ends[0] + on_rad) / strip.strand_N_per_mm)
    )
    bent = np.zeros((2, response.land.size))
    bent[0, 0], bent[1, -1] = sin(ends[0] + on_rad), -sin(ends[1] + on_rad)

    def lands(known: LandColumns | None) -> LandColumns | None:
        if known is None:
            return None
        return replace(
            known,
            recession=known.recession + np.outer(follow, known.tight),
            reaction=known.reaction + np.outer(bent[0], known.tight),
        )

    angle = on_rad
    return replace(
        response,
        phase=on_rad / strip.pitch_rad - teeth,
        first_tooth=response.first_tooth + teeth,
        first_land=response.first_land + teeth,
        flanks=_turned_flanks(response.flanks, angle),
        lines=_turned_lines(response.lines, teeth, angle),
        compliance=response.compliance + np.outer(follow, response.flanks.levers_mm / radius),
        by_slack=response.by_slack + follow * response.tight_by_slack,
        land_angle_rad=response.land_angle_rad + angle,
        reaction=response.reaction + np.outer(bent[0], response.tight),
        reaction_by_slack=response.reaction_by_slack + bent[0] * response.tight_by_slack + bent[1],
        sliding=lands(response.sliding),
        lifting=lands(response.lifting),
    )


def moved_on(piece: Piece, teeth: int, angle_rad: float) -> Piece:
    """A piece at a place further around the pulley.

    Parameters
    ----------
    piece : Piece
    teeth : int
        Added to its numbers.
    angle_rad : float

    Returns
    -------
    Piece
    """
    return replace(
        piece,
        flanks=replace(_turned_flanks(piece.flanks, angle_rad), tooth=piece.flanks.tooth + teeth),
        lines=_turned_lines(piece.lines, teeth, angle_rad),
        land=piece.land + teeth,
        land_angle_rad=piece.land_angle_rad + angle_rad,
    )


def _turned_flanks(flanks: Flanks, angle_rad: float) -> Flanks:
    turn = _turn(angle_rad)
    return replace(flanks, places=flanks.places @ turn, normals=flanks.normals @ turn)


def _turned_lines(
    lines: tuple[FlankLine, ...], teeth: int, angle_rad: float
) -> tuple[FlankLine, ...]:
    turn = _turn(angle_rad)
    return tuple(
        replace(line, tooth=line.tooth + teeth, places=line.places @ turn) for line in lines
    )


def _turn(angle_rad: float) -> Floats:
    """Rotation matrix for places as rows, applied from the right: counter-clockwise."""
    cosine, sine = cos(angle_rad), sin(angle_rad)
    return np.array([[cosine, sine], [-sine, cosine]])


def _joined_flanks(pieces: Sequence[Piece]) -> Flanks:
    return Flanks(
        *(
            np.concatenate([getattr(piece.flanks, name) for piece in pieces])
            for name in Flanks.__dataclass_fields__
        )
    )


def strip_response(pieces: Sequence[Piece]) -> StripResponse:
    """Assemble consecutive pieces.

    Parameters
    ----------
    pieces : sequence of Piece
        The first contains the tight strand, the last the slack one; both may be the same piece.

    Returns
    -------
    StripResponse
    """
    row = row_response([piece.cell for piece in pieces])
    kinds = np.concatenate([piece.kinds for piece in pieces])
    loads = np.concatenate([piece.kinds[: piece.cell.loads] for piece in pieces])
    rows = {kind: np.flatnonzero(kinds == kind) for kind in Kind}
    columns = {kind: np.flatnonzero(loads == kind) for kind in Kind}

    def seen(one: Kind, other: Kind) -> Floats:
        return np.asarray(row[np.ix_(rows[one], columns[other])])

    def lands(kind: Kind) -> LandColumns | None:
        if not columns[kind].size:
            return None
        reaction = -seen(Kind.RADIAL, kind)
        if kind is Kind.RADIAL:
            reaction = 0.5 * (reaction + reaction.T)
        return LandColumns(seen(Kind.PAIR, kind), reaction, seen(Kind.TIGHT, kind)[0])

    flanks = _joined_flanks(pieces)
    land = np.concatenate([piece.land for piece in pieces])
    first = int(flanks.tooth.min()) if flanks.tooth.size else 0
    compliance = seen(Kind.PAIR, Kind.PAIR)
    slack = {kind: seen(kind, Kind.SLACK)[:, 0] for kind in (Kind.PAIR, Kind.RADIAL, Kind.TIGHT)}
    return StripResponse(
        phase=0.0,
        first_tooth=first,
        teeth=int(np.ptp(flanks.tooth)) + 1 if flanks.tooth.size else 0,
        first_land=int(land.min()),
        lands=int(np.ptp(land)) + 1,
        flanks=replace(flanks, tooth=flanks.tooth - first),
        lines=tuple(line for piece in pieces for line in piece.lines),
        compliance=0.5 * (compliance + compliance.T),
        by_slack=slack[Kind.PAIR],
        land=land - land.min(),
        land_angle_rad=np.concatenate([piece.land_angle_rad for piece in pieces]),
        reaction=-seen(Kind.RADIAL, Kind.PAIR),
        reaction_by_slack=-slack[Kind.RADIAL],
        tight=seen(Kind.TIGHT, Kind.PAIR)[0],
        tight_by_slack=float(slack[Kind.TIGHT][0]),
        sliding=lands(Kind.SLIDING),
        lifting=lands(Kind.RADIAL),
        degrees_of_freedom=sum(
            {id(piece.cell): piece.degrees_of_freedom for piece in pieces}.values()
        ),
    )
