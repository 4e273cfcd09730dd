"""Relative position of the gears of a stage: centre distance, widths, axial offset."""

from __future__ import annotations

from math import acos, cos, radians, sqrt, tan
from typing import TYPE_CHECKING, Any

from flankload.exchange.rexs.modifications import add_modifications

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flankload.exchange.rexs.body import Gear
    from flankload.exchange.rexs.source import Source, Stock
    from flankload.exchange.rexs.stages import Stage

#: Largest relative difference between the distance of the positions and the centre distance.
SAME_DISTANCE = 1e-3
#: Axial distances below this are rounding, mm.
LEAST_OFFSET = 1e-6


def pair_of(stock: Stock, stage: Stage, bodies: Sequence[Gear]) -> dict[str, float]:
    """Table [pair]; puts widths, offset, modifications and a ring's shift into the bodies.

    Values that are missing, or have a wrong kind or unit, are refused.
    """
    source = stock.source(stage.component)
    pair: dict[str, float] = {}
    key = "pair.center_distance_mm"
    distance = source.number("center_distance", "mm")
    if distance is None:
        stock.missing(source, "center_distance", key)
    # a distance that the scene shall not have still tells signs and positions
    if distance is None or stock.settings.get(key) is not None:
        stock.replace(key, distance)
        distance = _given(stock, key)
    distance = abs(distance) if stage.is_internal else distance
    if distance <= 0:
        source.refuse("center_distance", "a number > 0", distance)
    pair["center_distance_mm"] = distance
    if stage.is_internal and bodies[1].keys.get("profile_shift"):
        _sign_shift(stock, bodies, distance)
    offset, directions = _offset(stock, stage, distance)
    common = source.number("common_face_width", "mm")
    widths = [
        body.source.number("face_width", "mm") or _width_from(stock, body, common)
        for body in bodies
    ]
    if common is None:
        low = max(-0.5 * widths[0], offset - 0.5 * widths[1])
        high = min(0.5 * widths[0], offset + 0.5 * widths[1])
        common = float(f"{high - low:.12g}")
        if common <= 0:
            stock.model.refuse(
                f"{stage.component.label}: common_face_width",
                "face widths that overlap",
                f"{widths[0]:g} and {widths[1]:g} mm, {offset:g} mm apart",
            )
    pair["face_width_mm"] = common
    for body, width in zip(bodies, widths, strict=True):
        if width != common:
            body.keys["face_width_mm"] = width
    if abs(offset) > LEAST_OFFSET:
        bodies[1].keys["axial_offset_mm"] = offset
    for body, width, direction in zip(bodies, widths, directions, strict=True):
        add_modifications(stock, body, width, _datum_is_low(body.source, direction))
    return pair


def _given(stock: Stock, key: str) -> float:
    """A number that is given beside the file."""
    value = stock.settings[key]
    if not isinstance(value, int | float):
        stock.model.refuse(key, "a number", "nothing" if value is None else value)
    return float(value)


def _width_from(stock: Stock, body: Gear, common: float | None) -> float:
    """Face width of a gear without one: the common width, or what is given otherwise."""
    if common is not None:
        return common
    own, pair = f"{body.name}.face_width_mm", "pair.face_width_mm"
    if own not in stock.settings and pair not in stock.settings:
        what = f"{body.component.label}: face_width"
        stock.model.refuse(what, f"a value, or --set {pair}=…", "nothing")
    return _given(stock, own if own in stock.settings else pair)


def _offset(stock: Stock, stage: Stage, distance: float) -> tuple[float, tuple[int, int]]:
    """Axial position of gear 2 from gear 1, mm, and the senses of both u axes along z.

    z is the u axis of gear 1; the origin of a gear is the middle of its face width.
    """
    sources = [stock.source(gear) for gear in stage.gears]
    names = ("support_vector", "u_axis_vector", "reference_component_for_position")
    places = [source.vector(names[0]) for source in sources]
    axes = [source.vector(names[1]) for source in sources]
    frames = [source.component.attributes.get(names[2]) for source in sources]
    one, two = axes
    if one is None or two is None or None in places or None in frames:
        return _centred(stock, stage, "no positions")
    if _float_of(frames[0]) != _float_of(frames[1]):
        return _centred(stock, stage, "positions relative to different components")
    along, lengths = _dot(one, two), [sqrt(_dot(axis, axis)) for axis in axes if axis]
    if min(lengths) == 0 or abs(abs(along) / (lengths[0] * lengths[1]) - 1) > SAME_DISTANCE**2:
        return _centred(stock, stage, "u axes that are not parallel")
    first, second = places
    assert first is not None
    assert second is not None
    apart = tuple(b - a for a, b in zip(first, second, strict=True))
    offset = _dot(apart, one) / lengths[0]
    radial = sqrt(max(0.0, _dot(apart, apart) - offset**2))
    if abs(radial - distance) > SAME_DISTANCE * distance:
        return _centred(stock, stage, f"positions {radial:g} mm apart")
    for source in sources:
        source.read |= set(names)
    return float(f"{offset:.12g}"), (1, 1 if along > 0 else -1)


def _centred(stock: Stock, stage: Stage, why: str) -> tuple[float, tuple[int, int]]:
    what = f"the middles of both face widths are in one plane: the gears have {why}"
    stock.assume(stage.component, what)
    return 0.0, (1, 0)


def _float_of(attribute: Any) -> float | None:
    """Number of a component in an attribute, as text or number."""
    try:
        return float(attribute.value)
    except (TypeError, ValueError):
        return None


def _dot(one: tuple[float, ...], two: tuple[float, ...]) -> float:
    return sum(a * b for a, b in zip(one, two, strict=True))


def _datum_is_low(source: Source, direction: int) -> bool | None:
    """Whether the datum face is the end of smaller z; None if it is not defined."""
    side = source.text("datum_face_orientation", "positive", "negative")
    if side is None or direction == 0:
        return None
    return (side == "negative") == (direction > 0)


def _sign_shift(stock: Stock, bodies: Sequence[Gear], distance: float) -> None:
    """Give the profile shift of a ring the sign of a scene, in which it counts outwards.

    Programs write it with either sign. At the centre distance only one of them leaves about no
    backlash: inv a_wt = inv a_t + 2 tan a_n (x_2 - x_1) / (z_2 - z_1) (ISO 21771, internal pair).
    """
    pinion, ring = (body.keys for body in bodies)
    if not pinion.keys() >= {"teeth", "module_mm", "pressure_angle_deg", "profile_shift"}:
        return
    shift, number = abs(ring["profile_shift"]), ring["teeth"] - pinion["teeth"]
    pressure, normal = bodies[0].transverse_rad, radians(pinion["pressure_angle_deg"])
    module = pinion["module_mm"] / cos(bodies[0].helix_rad)
    working = 0.5 * number * module * cos(pressure) / distance
    what = f"{bodies[1].component.label}: addendum_modification_coefficient"
    if not 0 < working < 1:
        stock.model.refuse(what, "a centre distance at which the flanks can touch", f"{distance:g}")
    angle = acos(working)
    wanted = (tan(angle) - angle - tan(pressure) + pressure) * number / (2 * tan(normal))
    errors = {sign: abs(sign * shift - pinion["profile_shift"] - wanted) for sign in (1.0, -1.0)}
    sign = min(errors, key=lambda key: errors[key])
    if errors[sign] > 0.5 * errors[-sign]:
        stock.model.refuse(
            what,
            "a value whose sign the centre distance determines, or --set body_2.profile_shift=…",
            ring["profile_shift"],
        )
    if "body_2.profile_shift" not in stock.settings:
        ring["profile_shift"] = sign * shift
        stock.assume(
            bodies[1].component,
            f"profile shift {sign * shift:g}, positive outwards: with the other sign the centre "
            "distance does not fit",
        )
