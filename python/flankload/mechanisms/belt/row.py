"""A timing belt as a row: equal cells from tooth to tooth, and the two ends where strands leave.

The cells are the same wherever the belt stands on its pulley: one is condensed once. The ends
differ by how far teeth have gone on. All is put together by the stiffness of the faces between.
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


#: Parts of a land that are shorter than this part of an element are none.
SLIVER = 0.3


@dataclass(frozen=True)
class LandColumns:
    """What the h hats of the lands do when they rub, or when they give way.

    Attributes
    ----------
    recession : (n, h) array
        Of the flanks under a force along the turn, or per way outwards.
    reaction : (h, h) array
        Of the lands.
    tight : (h,) array
        Of the tight strand.
    """

    recession: Floats
    reaction: Floats
    tight: Floats


@dataclass(frozen=True)
class StripResponse:
    """A belt on its pulley by its forces per mm of width; n pairs, h hats on the lands.

    Attributes
    ----------
    phase : float
        By which teeth have gone on, in pitches, since the strands met the belt in mid-land.
    first_tooth, teeth : int
        Number of the first tooth that has pairs, and how many have.
    first_land, lands : int
        The same of lands on the pulley; a land has the number of the tooth behind it.
    flanks : Flanks
        Teeth counted from the first one.
    lines : tuple of FlankLine, one per tooth
    compliance : (n, n) array
        K, by which flanks recede under forces on flanks, mm²/N.
    by_slack : (n,) array
        L, the same under the tension of the slack strand.
    land : (h,) array
        On which land each hat stands, counted from the first one.
    land_angle_rad : (h,) array
        Where it has its end.
    reaction : (h, n) array
        P, forces of the lands on the belt under forces on flanks.
    reaction_by_slack : (h,) array
    tight, tight_by_slack : (n,) array, float
        The tension of the tight strand.
    rubbing, lifting : LandColumns or None
        Where they were asked for.
    degrees_of_freedom : int
        Of all pieces that were solved.
    pulley_yields : bool
        Teeth do something to each other through the pulley, too.
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
    rubbing: LandColumns | None
    lifting: LandColumns | None
    degrees_of_freedom: int
    pulley_yields: bool = False


class BeltRow:
    """A belt whose cell from tooth to tooth is solved once, for all positions.

    Parameters
    ----------
    strip : Strip
        With teeth: in the middle of a land none could be cut.
    flank_elements : int
        On the flank of a tooth.
    rubbing, lifting : bool
        Also what lands do that rub, or that give way.
    account : Account, optional
        Where the work is counted.
    """

    def __init__(
        self,
        strip: Strip,
        flank_elements: int = FLANK_ELEMENTS,
        *,
        rubbing: bool = False,
        lifting: bool = False,
        account: Account | None = None,
    ) -> None:
        assert strip.tooth is not None
        self._strip, self._elements, self._account = strip, flank_elements, account
        self._asked = {"rubbing": rubbing, "lifting": lifting}
        # from the middle of tooth 0 to that of tooth 1
        self._cell = self._solved((0, 2), (True, True)) if strip.wrapped_teeth > 1 else None
        # positions at which strands begin at the edges of lands have all of it in common
        self._known: tuple[tuple[float, float], StripResponse] | None = None
        self._ends: dict[tuple[int, float], Piece] = {}

    def at(self, phase: float) -> StripResponse:
        """What the belt answers.

        Parameters
        ----------
        phase : float
            By which teeth have gone on, in pitches.

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
    """Where the strands begin, from the middles of the first and the last land.

    Where the tangent points of the strands stand on these lands, it is there. Over grooves nothing
    holds the belt: a strand is straight up to the edge of the nearest land, of which a small part
    is held at least, as long as an element by default, and no shorter with shorter elements: what
    a point holds would give way without end.

    Parameters
    ----------
    strip : Strip
    flank_elements : int
    on_rad : float
        By which the middles of both lands stand beyond the tangent points, along the turn.

    Returns
    -------
    tight, slack : float
    """
    land = half_land(strip, flank_elements)
    edge, element = float(land[-1]), float(land[1])

    def near(end: float) -> float:
        # slivers of elements are none
        for known in (-edge, 0.0, edge):
            if abs(end - known) < SLIVER * element:
                return known
        return end

    inside = edge - float(half_land(strip, FLANK_ELEMENTS)[1])
    return near(min(max(-on_rad, -edge), inside)), near(min(max(-on_rad, -inside), edge))


def standing(
    strip: Strip, response: StripResponse, ends: tuple[float, float], teeth: int, on_rad: float
) -> StripResponse:
    """A belt at a position, from what it answers with its strands beginning where they do there.

    Up to its tangent point a strand is as long as it is: what the tight one is longer, all teeth
    follow it. It leaves as a tangent does: what it bends more than the belt on the pulley, the edge
    of the land holds.

    Parameters
    ----------
    strip : Strip
    response : StripResponse
        As if the middle of the first land stood at angle 0.
    ends : (float, float)
        Where the strands begin, from the middles of the first and the last land, rad.
    teeth : int
        To be added to the numbers.
    on_rad : float
        Where the middle of the first land stands.

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
        rubbing=lands(response.rubbing),
        lifting=lands(response.lifting),
    )


def moved_on(piece: Piece, teeth: int, angle_rad: float) -> Piece:
    """A piece further on around the pulley.

    Parameters
    ----------
    piece : Piece
    teeth : int
        To be added to its numbers.
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
    """From the right on places as rows: counter-clockwise."""
    cosine, sine = cos(angle_rad), sin(angle_rad)
    return np.array([[cosine, sine], [-sine, cosine]])


def strip_response(pieces: Sequence[Piece]) -> StripResponse:
    """Pieces that follow one another, put together.

    Parameters
    ----------
    pieces : sequence of Piece
        The first with the tight strand, the last with the slack one; both may be the same.

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
        reaction = -seen(Kind.WAY, kind)
        if kind is Kind.WAY:
            reaction = 0.5 * (reaction + reaction.T)
        return LandColumns(seen(Kind.PAIR, kind), reaction, seen(Kind.TIGHT, kind)[0])

    flanks = Flanks(
        *(
            np.concatenate([getattr(piece.flanks, name) for piece in pieces])
            for name in Flanks.__dataclass_fields__
        )
    )
    land = np.concatenate([piece.land for piece in pieces])
    first = int(flanks.tooth.min()) if flanks.tooth.size else 0
    compliance = seen(Kind.PAIR, Kind.PAIR)
    slack = {kind: seen(kind, Kind.SLACK)[:, 0] for kind in (Kind.PAIR, Kind.WAY, Kind.TIGHT)}
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
        reaction=-seen(Kind.WAY, Kind.PAIR),
        reaction_by_slack=-slack[Kind.WAY],
        tight=seen(Kind.TIGHT, Kind.PAIR)[0],
        tight_by_slack=float(slack[Kind.TIGHT][0]),
        rubbing=lands(Kind.RUB),
        lifting=lands(Kind.WAY),
        degrees_of_freedom=sum(
            {id(piece.cell): piece.degrees_of_freedom for piece in pieces}.values()
        ),
    )
