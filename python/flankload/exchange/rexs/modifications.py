"""Flank modifications of a gear: tip relief, profile and helix crowning, end reliefs.

Amounts are metal removed (C of ISO 21771). A modification that a scene does not have in this form
is reported and left out as a whole.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, get_args

from flankload.exchange.rexs.attributes import ENDS
from flankload.scene.table import RELIEF_EXPONENTS, ReliefShape

if TYPE_CHECKING:
    from collections.abc import Callable

    from flankload.exchange.rexs.body import Gear
    from flankload.exchange.rexs.model import Component, Model
    from flankload.exchange.rexs.source import Source, Stock

SHAPES = ("circular", "exponential", "linear", "logarithmic", "parabolic")
TAKEN_SHAPES = get_args(ReliefShape)
#: Relations between a flank or gear and its modifications: type, role of the owner, of the part.
OWNERS = (
    ("assembly", "assembly", "part"),
    ("ordered_assembly", "assembly", "part"),
    ("reference", "origin", "referenced"),
    ("ordered_reference", "origin", "referenced"),
)
#: Modifications that are named in the database and that no scene key describes, with the reason.
OTHERS = dict.fromkeys(
    (
        "helix_deviation", "helix_slope", "profile_deviation", "profile_slope", "profile_twist",
        "topographical_modification", "triangular_root_relief", "triangular_tip_relief",
    ),
    "a scene has no such modification of REXS",
)  # fmt: skip
OTHERS["helix_slope"] = "the public database does not define the sign of helix_slope"
ONE_OF_A_KIND = ("tip_relief", "root_relief", "profile_crowning", "helix_crowning")
#: Largest relative difference of lengths that are equal.
SAME = 1e-6


def add_modifications(stock: Stock, body: Gear, width_mm: float, datum_low: bool | None) -> None:
    """Put the modifications of the flank into the table of a body.

    `width_mm` is the face width of the gear; `datum_low`: whether the datum face is the end of
    smaller z, None if the file does not define it.
    """
    owners = [body.component] if body.flank is None else [body.flank.component, body.component]
    found = {part.id: part for owner in owners for part in modifications_of(stock.model, owner)}
    takes: dict[str, Callable[[Source], str | None]] = {
        "tip_relief": lambda source: _relief(body, source, "tip"),
        "root_relief": lambda source: _relief(body, source, "root"),
        "profile_crowning": lambda source: _profile_crowning(body, source),
        "helix_crowning": lambda source: _helix_crowning(body, source, width_mm),
    }
    for kind, take in takes.items():
        for number, part in enumerate(part for part in found.values() if part.type == kind):
            why = "a flank of a scene has one of this kind" if number else take(stock.source(part))
            if why is not None:
                stock.leave_all(part, why)
    ends = [part for kind in ENDS for part in found.values() if part.type == kind]
    _end_reliefs(stock, body, ends, width_mm, datum_low)
    for kind, why in OTHERS.items():
        for part in (part for part in found.values() if part.type == kind):
            stock.leave_all(part, why)


def modifications_of(model: Model, owner: Component) -> list[Component]:
    """Modifications of a flank, or of both flanks of a gear."""
    known = (*ONE_OF_A_KIND, *ENDS, *OTHERS)
    return [
        part
        for kind, role, wanted in OWNERS
        for part in model.partners(kind, role, owner.id, wanted)
        if part.type in known
    ]


def _relief(body: Gear, source: Source, end: str) -> str | None:
    """Relief of the end "tip" or "root" of the profile."""
    depth = source.number(f"{end}_relief_depth", "um")
    start = source.number(f"{end}_relief_datum_diameter", "mm")
    shape = source.text("shape_of_relief", *SHAPES) or "linear"
    if depth is None or start is None:
        return f"it has no {end}_relief_depth or no {end}_relief_datum_diameter"
    if depth < 0 or shape not in TAKEN_SHAPES:
        return f"a scene has linear and parabolic reliefs >= 0, no {shape} one of {depth:g} um"
    at = source.number(f"{end}_relief_evaluation_reference", "mm")
    if at is not None and end == "root":
        form = body.component.attributes.get("root_form_diameter")
        if form is None or abs(at - (body.source.number("root_form_diameter", "mm") or 0.0)) > 1e-3:
            return "its amount is not given at the root_form_diameter of the gear"
    elif at is not None:
        diameters = (start, at, body.keys["tip_diameter_mm"])
        factor = _growth(*(body.roll_length_mm(diameter) for diameter in diameters))
        if factor is None:
            return "its amount is given at a diameter where the involute has no relief"
        depth = float(f"{depth * factor ** RELIEF_EXPONENTS[shape]:.12g}")
    body.keys[f"{end}_relief_um"] = depth
    body.keys[f"{end}_relief_start_diameter_mm"] = start
    if shape != "linear":
        body.keys[f"{end}_relief_shape"] = shape
    return None


def _growth(start: float | None, there: float | None, tip: float | None) -> float | None:
    """Linear relief at the tip over that at another roll length; None if there is no relief."""
    if start is None or there is None or tip is None or start == there:
        return None
    factor = (tip - start) / (there - start)
    return factor if factor > 0 else None


def _profile_crowning(body: Gear, source: Source) -> str | None:
    amounts = [source.number(f"profile_crowning_at_{end}", "um") for end in ("tip", "root")]
    amount = _equal(amounts)
    if amount is None:
        return "a scene has the same profile crowning >= 0 at tip and root"
    body.keys["profile_crowning_um"] = amount
    return None


def _helix_crowning(body: Gear, source: Source, width_mm: float) -> str | None:
    ends = ("datum_face", "non_datum_face")
    amount = _equal([source.number(f"helix_crowning_amount_{end}", "um") for end in ends])
    if amount is None:
        return "a scene has the same helix crowning >= 0 at both ends"
    places = [
        source.number(f"coordinate_where_helix_crowning_is_specified_{end}", "mm") for end in ends
    ]
    if places != [None, None]:
        one, two = places
        if one is None or two is None or abs(abs(one - two) - width_mm) > SAME * width_mm:
            return "a scene has the amounts at both ends of the face width"
    body.keys["lead_crowning_um"] = amount
    return None


def _equal(amounts: list[float | None]) -> float | None:
    """The amount that both ends have; None if they differ, one is missing or negative."""
    one, two = amounts
    if one is None or two is None or one < 0 or abs(one - two) > SAME * abs(one):
        return None
    return one


def _end_reliefs(
    stock: Stock, body: Gear, parts: list[Component], width_mm: float, datum_low: bool | None
) -> None:
    """End reliefs at both faces; an end without one has no relief."""
    amounts, lengths, shapes = [0.0, 0.0], [0.0, 0.0], set()
    why = None
    if datum_low is None and parts:
        why = "the gear has no datum_face_orientation and u_axis_vector"
    if len({part.type for part in parts}) < len(parts):
        why = why or "a face of a scene has one end relief"
    for part in parts:
        source = stock.source(part)
        face = part.type.removeprefix("end_relief_")
        depth = source.number(f"end_relief_depth_{face}", "um")
        length = source.number(f"end_relief_length_{face}", "mm")
        shape = source.text("shape_of_relief", *SHAPES) or "linear"
        place = source.number(f"end_relief_evaluation_reference_{face}", "mm")
        shapes.add(shape)
        if depth is None or length is None or depth < 0:
            why = why or "an end relief needs an amount >= 0 and a length"
        elif shape not in TAKEN_SHAPES or len(shapes) > 1:
            why = why or "a scene has linear or parabolic end reliefs, the same at both ends"
        elif place is not None and not any(
            abs(abs(place) - end) <= SAME * width_mm for end in (0.0, 0.5 * width_mm, width_mm)
        ):
            why = why or "its amount is not given at an end of the face width"
        else:
            end = int((face == "datum_face") != bool(datum_low))
            amounts[end], lengths[end] = depth, length
    if why is not None:
        for part in parts:
            stock.leave_all(part, why)
    elif any(amounts):
        body.keys["end_relief_um"] = amounts
        # a face without relief needs a length as well
        body.keys["end_relief_length_mm"] = [length or max(lengths) for length in lengths]
        (shape,) = shapes
        if shape != "linear":
            body.keys["end_relief_shape"] = shape
