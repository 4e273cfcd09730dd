"""Flank modifications of a gear: tip relief, profile and helix crowning, end reliefs.

Amounts are metal removed (C of ISO 21771). A modification that a scene does not have in this form
is reported and left out as a whole.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from flankload.exchange.rexs.attributes import ENDS

if TYPE_CHECKING:
    from collections.abc import Callable

    from flankload.exchange.rexs.body import Gear
    from flankload.exchange.rexs.model import Component, Model
    from flankload.exchange.rexs.source import Source, Stock

SHAPES = ("circular", "exponential", "linear", "logarithmic", "parabolic")
#: Relations between a flank or gear and its modifications: type, role of the owner, of the part.
OWNERS = (
    ("assembly", "assembly", "part"),
    ("ordered_assembly", "assembly", "part"),
    ("reference", "origin", "referenced"),
    ("ordered_reference", "origin", "referenced"),
)
#: Modifications that are named in the database and that no scene key describes.
OTHERS = (
    "helix_deviation", "helix_slope", "profile_deviation", "profile_slope", "profile_twist",
    "topographical_modification", "triangular_root_relief", "triangular_tip_relief",
)  # fmt: skip
ONE_OF_A_KIND = ("tip_relief", "root_relief", "profile_crowning", "helix_crowning")
#: Largest relative difference of lengths that are equal.
SAME = 1e-6


def add_modifications(stock: Stock, body: Gear, width_mm: float, datum_low: bool | None) -> None:
    """Put the modifications of the flank into the table of a body.

    Parameters
    ----------
    stock : Stock
    body : Gear
    width_mm : float
        Face width of the gear.
    datum_low : bool or None
        Whether the datum face is the end of smaller z; None if the file does not define it.

    Raises
    ------
    SceneError
        If a value has a wrong kind or unit.
    """
    owners = [body.component] if body.flank is None else [body.flank.component, body.component]
    parts: dict[str, list[Component]] = {}
    for part in {
        part.id: part for owner in owners for part in modifications_of(stock.model, owner)
    }.values():
        parts.setdefault(part.type, []).append(part)
    takes: tuple[Callable[[Source], str | None], ...] = (
        lambda source: _tip_relief(body, source),
        lambda source: _root_relief(body, source),
        lambda source: _profile_crowning(body, source),
        lambda source: _helix_crowning(body, source, width_mm),
    )
    for kind, take in zip(ONE_OF_A_KIND, takes, strict=True):
        _take(stock, parts.get(kind, []), take)
    ends = [part for kind in ENDS for part in parts.get(kind, [])]
    _end_reliefs(stock, body, ends, width_mm, datum_low)
    for kind in OTHERS:
        for part in parts.get(kind, []):
            why = "a scene has no such modification of REXS"
            if kind == "helix_slope":
                why = "the public database does not define the sign of helix_slope"
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


def _take(stock: Stock, parts: list[Component], take: Callable[[Source], str | None]) -> None:
    """Take the first modification of a kind; report it if it does not fit, and all further ones."""
    for number, part in enumerate(parts):
        why = "a flank of a scene has one of this kind" if number else take(stock.source(part))
        if why is not None:
            stock.leave_all(part, why)


def _tip_relief(body: Gear, source: Source) -> str | None:
    depth = source.number("tip_relief_depth", "um")
    start = source.number("tip_relief_datum_diameter", "mm")
    shape = source.text("shape_of_relief", *SHAPES) or "linear"
    if depth is None or start is None:
        return "it has no tip_relief_depth or no tip_relief_datum_diameter"
    if depth < 0 or shape not in ("linear", "parabolic"):
        return f"a scene has linear and parabolic reliefs >= 0, no {shape} one of {depth:g} um"
    at = source.number("tip_relief_evaluation_reference", "mm")
    if at is not None:
        roll = [body.roll_length_mm(d) for d in (start, at, body.keys["tip_diameter_mm"])]
        if None in roll or roll[0] == roll[1]:
            return "its amount is given at a diameter where the involute has no relief"
        low, there, tip = (length or 0.0 for length in roll)
        factor = (tip - low) / (there - low)
        if factor <= 0:
            return "its amount is given at a diameter where the involute has no relief"
        depth *= factor ** (2 if shape == "parabolic" else 1)
    body.keys["tip_relief_um"] = float(f"{depth:.12g}")
    body.keys["tip_relief_start_diameter_mm"] = start
    if shape == "parabolic":
        body.keys["tip_relief_shape"] = shape
    return None


def _root_relief(body: Gear, source: Source) -> str | None:
    depth = source.number("root_relief_depth", "um")
    start = source.number("root_relief_datum_diameter", "mm")
    shape = source.text("shape_of_relief", *SHAPES) or "linear"
    if depth is None or start is None:
        return "it has no root_relief_depth or no root_relief_datum_diameter"
    if depth < 0 or shape not in ("linear", "parabolic"):
        return f"a scene has linear and parabolic reliefs >= 0, no {shape} one of {depth:g} um"
    at = source.number("root_relief_evaluation_reference", "mm")
    form = body.component.attributes.get("root_form_diameter")
    if at is not None and (
        form is None or abs(at - (body.source.number("root_form_diameter", "mm") or 0.0)) > 1e-3
    ):
        return "its amount is not given at the root_form_diameter of the gear"
    body.keys["root_relief_um"] = depth
    body.keys["root_relief_start_diameter_mm"] = start
    if shape == "parabolic":
        body.keys["root_relief_shape"] = shape
    return None


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
        elif shape not in ("linear", "parabolic") or len(shapes) > 1:
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
        if shapes == {"parabolic"}:
            body.keys["end_relief_shape"] = "parabolic"
