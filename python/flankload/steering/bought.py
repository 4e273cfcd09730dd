"""What a tolerance has bought: which knob stands where, for which error, and what is missed."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from flankload.steering.knobs import MOST_MODES, SOURCES
from flankload.steering.laws import BOUND, UNRESOLVED
from flankload.steering.pick import STRIPS, finest_part
from flankload.steering.told import OF_LARGEST

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from flankload.result import Result
    from flankload.scene import Scene
    from flankload.steering.knobs import Knobs
    from flankload.steering.pick import Pick

    Table = Mapping[str, Mapping[str, float]]

#: Why finer steps help little: what is added to a reason.
CORNERS = "; pairs work on sharp corners, beside which all converges slowly (a warning names them)"
BELT_CORNERS = "; beside the corners of teeth and lands errors fall hardly faster than elements do"
#: Sources that no knob answers for, and what does.
LEFT_BY = {
    "tip": "forces on tips turn from the normal of the flank, along which its modes push",
    "lumped": "effects.contact = 'lumped' leaves it",
    "period": "positions.pitches leaves out teeth that yield differently",
    "one solution": "effects.large_displacement = false leaves it",
}


def bought(
    scene: Scene,
    knobs: Knobs,
    picks: Sequence[Pick],
    results: Sequence[Result],
    errors: Sequence[Mapping[str, float]],
    by_source: Table,
) -> dict[str, Any]:
    """All of it as plain data, the form of `result.accuracy`.

    Parameters
    ----------
    scene : Scene
        As it asks.
    knobs : Knobs
    picks : sequence of Pick
        What was run, one after the other.
    results : sequence of Result
        Of the last one.
    errors : sequence of mapping of str to float
        What the estimate of each run tells, by bound quantity; empty where there is none.
    by_source : mapping
        The same of the last one by source.

    Returns
    -------
    dict
    """
    tolerance, last, left = scene.accuracy.tolerance, picks[-1], errors[-1]
    rows = {
        knob: _row(knob, knobs, last, results, by_source)
        for knob in SOURCES
        if _value(knob, knobs, last, results) is not None
    }
    found: dict[str, Any] = {
        "tolerance": tolerance,
        "met": max(left.values()) <= tolerance if left else None,
        "largest_error": max(left.values(), default=None),
        "errors": dict(left),
        "peak_to_peak_of_itself": _of_itself(results),
        "not_estimated": _not_estimated(left, knobs) if left else [],
        "knobs": rows,
        "keys": last.setting.tables(),
        "tightened": _tightened(picks),
        "errors_before": dict(errors[0]) if len(errors) > 1 else None,
        "missed": [
            _missed(quantity, error, tolerance, knobs, picks, results, by_source)
            for quantity, error in left.items()
            if error > tolerance
        ],
    }
    if not left:
        found["unchecked"] = _unchecked(results)
    return found


def _not_estimated(left: Mapping[str, float], knobs: Knobs) -> list[str]:
    """Bound quantities of which nothing is told; belts and chains have no pressures."""
    has_none = ("peak_pressure",) if knobs.kind in ("belts", "chains") else ()
    return [quantity for quantity in BOUND if quantity not in (*left, *has_none)]


def _of_itself(results: Sequence[Result]) -> float | None:
    """What the estimates tell of the peak to peak as a part of itself."""
    told = [(result.estimate or {}).get(OF_LARGEST) for result in results]
    return max((error for error in told if error is not None), default=None)


def _unchecked(results: Sequence[Result]) -> str:
    if not any(result.torque_Nm > 0 for result in results):
        return "without torque nothing is approximated"
    return "knobs as predicted, not checked (accuracy.estimate = false)"


def _value(knob: str, knobs: Knobs, pick: Pick, results: Sequence[Result]) -> float | int | None:
    if knob == "positions":
        return int(results[0].position_rad.size)
    if knobs.kind == "chains":
        return None
    if knob == "flank_element_mm":
        if pick.setting.flank_element_mm is not None:
            return pick.setting.flank_element_mm
        length = knobs.element_mm
        return None if length is None else float(f"{knobs.part * length:.3g}")
    if knobs.kind == "belts":
        return None
    return pick.modes if knob == "modes" else pick.strips


def _row(
    knob: str, knobs: Knobs, pick: Pick, results: Sequence[Result], by_source: Table
) -> dict[str, Any]:
    source = SOURCES[knob]
    errors = by_source.get(source)
    return {
        "value": _value(knob, knobs, pick, results),
        "source": source,
        "error": max(errors.values()) if errors else None,
        "left_as_it_is": knobs.closed.get(knob),
    }


def _tightened(picks: Sequence[Pick]) -> dict[str, list[float | int | None]]:
    first, last = picks[0].setting, picks[-1].setting
    steps: dict[str, list[float | int | None]] = {
        "flank_element_mm": [first.flank_element_mm, last.flank_element_mm],
        "modes": [first.modes, last.modes],
        "strips_per_half_width": [first.strips_per_half_width, last.strips_per_half_width],
        "positions.tolerance": [first.adaptive, last.adaptive],
    }
    return {knob: both for knob, both in steps.items() if both[0] != both[1]}


def _missed(
    quantity: str,
    error: float,
    tolerance: float,
    knobs: Knobs,
    picks: Sequence[Pick],
    results: Sequence[Result],
    by_source: Table,
) -> dict[str, Any]:
    source = max(by_source, key=lambda name: by_source[name].get(quantity, 0.0))
    return {
        "quantity": quantity,
        "error": error,
        "source": source,
        "beside": sorted(
            name
            for name, errors in by_source.items()
            if name != source and errors.get(quantity, 0.0) > tolerance
        ),
        "why": _why(source, quantity, tolerance, knobs, picks, results, by_source),
    }


def _why(
    source: str,
    quantity: str,
    tolerance: float,
    knobs: Knobs,
    picks: Sequence[Pick],
    results: Sequence[Result],
    by_source: Table,
) -> str:
    """Why a source is as large as it is."""
    pick = picks[-1]
    knob = next((knob for knob, name in SOURCES.items() if name == source), None)
    if knob is None:
        return LEFT_BY.get(source, "no knob answers for it")
    if knob in knobs.closed:
        return knobs.closed[knob]
    if source == "modes" and pick.modes >= knobs.most_modes < MOST_MODES:
        return "meshes and compliances from files bear no more of them"
    if source == "strips" and by_source[source][quantity] > UNRESOLVED:
        return "a rounding, a chamfer or a kink that so many strips do not resolve"
    ends = {
        "elements": pick.part <= finest_part(tolerance),
        "modes": pick.modes >= knobs.most_modes,
        "strips": pick.strips >= STRIPS[-1],
    }
    if ends.get(source):
        why = "the finest step of its ladder"
    elif len(picks) == 1 or pick.errors[quantity] > tolerance:
        why = "no step of its ladder is likely to bring this below the tolerance"
    else:
        why = "more than could be foreseen"
    if knobs.kind == "belts":
        return why + BELT_CORNERS
    return why + CORNERS * any(result.corner_contact.any() for result in results)
