"""Positions of a scene, the periods that they cover, and notes on uncovered teeth."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flankload.errors import SceneError
from flankload.pairing.friction import coefficients_by_tooth
from flankload.pairing.pairing import Period, period_of

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import NDArray

    from flankload.bodies import Body
    from flankload.scene import Scene
    from flankload.scene.pair import Positions

#: Largest product of positions and flank pairs (each pitch adds a flank pair): the number of
#: entries that an array of the result may have.
MOST_NUMBERS = 1e7


@dataclass(frozen=True)
class ScenePositions:
    """Positions (P,) of a scene.

    `pitches`, which they cover, is None for single angles; `period` is that of the curves;
    `closed`: several cover whole periods.
    """

    position_rad: NDArray[np.float64]
    pitches: int | None
    period: Period
    closed: bool
    notes: tuple[str, ...]


def positions_of(
    scene: Scene, bodies: tuple[Body, Body], groups: tuple[int, int]
) -> ScenePositions:
    """Positions of a scene; the compliances of its bodies repeat after groups of teeth."""
    wanted = scene.positions
    geometric = period_of(*bodies, by_tooth=coefficients_by_tooth(scene, bodies[0]))
    whole = geometric.with_compliance(groups)
    pitches = _pitches(wanted, _reached(geometric, groups, bodies))
    period = geometric if _represents_all(wanted, pitches, geometric) else whole
    closed = pitches is not None and pitches % period.pitches == 0
    position_rad = _positions(wanted, period.pitch_rad, pitches, closed=closed)
    notes: tuple[str, ...] = ()
    if not scene.is_concentric:
        notes = (
            *_beyond_window(pitches, geometric),
            *_beyond_teeth(pitches, whole, groups, bodies),
        )
    elif wanted.angles_deg is None and position_rad.size > 1:
        # the same teeth meet at every position, in the same state
        note = (
            f"on a common axis all positions are equal: one is computed instead of "
            f"{position_rad.size} (pair.center_offset_mm separates the axes)"
        )
        notes = (note,)
        position_rad = position_rad[:1]
    closed &= position_rad.size > 1
    return ScenePositions(position_rad, pitches, period, closed, notes)


def _pitches(wanted: Positions, period: Period) -> int | None:
    """Tooth pitches covered by the positions; None for single angles."""
    if wanted.angles_deg is not None:
        return None
    pitches = period.pitches if wanted.pitches == "hunting" else wanted.pitches
    per_pitch = wanted.count if not wanted.adaptive else wanted.most_per_pitch
    if per_pitch * pitches**2 > MOST_NUMBERS and pitches > 1:
        raise SceneError(
            key="positions.pitches",
            expected="fewer pitches, so that positions times flank pairs (one more per pitch) stay "
            f"below {MOST_NUMBERS:g}",
            found=f"{pitches} pitches of {per_pitch} positions",
        )
    return pitches


def _positions(
    wanted: Positions, pitch_rad: float, pitches: int | None, *, closed: bool
) -> NDArray[np.float64]:
    """Angles of body 1 (P,); adaptive ones include the end of a window that is not periodic."""
    if pitches is None:
        return np.radians(np.asarray(wanted.angles_deg, dtype=float))
    last = 1 if wanted.adaptive and not closed else 0
    return pitch_rad * np.arange(wanted.count * pitches + last) / wanted.count


def _represents_all(wanted: Positions, pitches: int | None, period: Period) -> bool:
    """Whether the positions are to represent teeth that differ only in compliance.

    This holds for positions within one period of the geometry; more positions are only needed to
    resolve the differences.
    """
    if pitches is not None:
        return pitches == period.pitches
    angles = np.radians(np.asarray(wanted.angles_deg, dtype=float))
    return bool(np.ptp(angles) < period.rad * (1.0 + 1e-9))


def _reached(period: Period, groups: tuple[int, int], bodies: tuple[Body, Body]) -> Period:
    """Period that positions can cover; teeth without a flank in their file carry no load."""
    one, two = (
        1 if body.named_teeth else group for body, group in zip(bodies, groups, strict=True)
    )
    return period.with_compliance((one, two))


def _beyond_window(pitches: int | None, period: Period) -> Iterator[str]:
    """Note on the part of the period outside the window."""
    if pitches is not None and pitches % period.pitches:
        pitch = "pitch" if pitches == 1 else "pitches"
        yield (
            f"with pitch deviations the curves repeat after {period.pitches} pitches; these "
            f"positions cover {pitches} {pitch} (positions.pitches = 'hunting' covers all)"
        )


def _beyond_teeth(
    pitches: int | None, whole: Period, groups: tuple[int, int], bodies: tuple[Body, Body]
) -> Iterator[str]:
    """Note on teeth of different compliance outside the window."""
    if groups == (1, 1) or pitches is None or pitches % whole.pitches == 0:
        return
    unlike = [z for z in (0, 1) if groups[z] > 1]
    repetitions = " and ".join(
        f"that of body_{z + 1} after {groups[z]} of {bodies[z].teeth} teeth" for z in unlike
    )
    cure = "positions.pitches = 'hunting' covers all"
    for z in unlike:
        if bodies[z].named_teeth:
            cure = f"name the flanks of all teeth of body_{z + 1}, then {cure}"
    window = "one" if pitches == 1 else f"{pitches}"
    yield (
        f"the compliance does not repeat from tooth to tooth, {repetitions}: the curves repeat "
        f"after {whole.pitches} pitches, these positions cover {window}; their mean, peak to peak "
        f"and harmonics are not those of all teeth ({cure})"
    )
