"""A planetary stage of a REXS model: sun, equal planets and ring, with a gear mesh for each pair.

The component `planetary_stage` has a `cylindrical_stage` for each planet with the sun, and one with
the ring. Each planet is a gear of its own, at its place.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import atan2, degrees, hypot
from typing import TYPE_CHECKING, Any

from flankload.exchange.rexs.attributes import BEARING
from flankload.exchange.rexs.body import body_of
from flankload.exchange.rexs.flanks import content_of, data_of, flank_of
from flankload.exchange.rexs.pair import SAME_DISTANCE, pair_of
from flankload.exchange.rexs.stages import Stage, stage_of, stages_within, torque_of_shaft

if TYPE_CHECKING:
    from flankload.exchange.rexs.model import Component, Model
    from flankload.exchange.rexs.source import Stock

#: Attributes in which equal planets differ: their places.
PLACES = frozenset({"support_vector", "w_axis_vector", "u_coordinate_on_shaft"})
#: Largest deviation of equally spaced planets, deg: rounding errors.
EVEN_DEG = 1e-9
#: Largest distance of a planet from an angle at which it can be assembled, in parts of the distance
#: of these angles: rounding of positions in a file.
ROUNDED = 0.01


@dataclass(frozen=True)
class Planets:
    """Gears of a planetary stage, and the meshes of its first planet with the sun and the ring."""

    sun: Component
    planets: tuple[Component, ...]
    ring: Component
    with_sun: tuple[Stage, ...]
    with_ring: Stage


def tables_of_planets(
    stock: Stock, component: Component, flank: str | None
) -> tuple[dict[str, Any], float | None]:
    """Tables of the scene of a planetary stage, and the torque on the sun."""
    gears = _gears_of(stock, component)
    in_sun = data_of(stock, gears.with_sun[0], 0), data_of(stock, gears.with_sun[0], 1)
    in_ring = data_of(stock, gears.with_ring, 1)
    parts = {
        "body_1": (gears.sun, in_sun[0]),
        "planet": (gears.planets[0], in_sun[1]),
        "body_2": (gears.ring, in_ring),
    }
    sun, planet, ring = (
        body_of(stock, gear, name, flank_of(stock, gear, data, flank))
        for name, (gear, data) in parts.items()
    )
    pair = pair_of(stock, gears.with_sun[0], (sun, planet))
    # modifications of the planet are those of its flank in mesh with the sun
    again = body_of(
        stock, gears.planets[0], "planet", None if planet.flank is None else planet.flank.component
    )
    beside = pair_of(stock, gears.with_ring, (again, ring))
    one, two = pair["center_distance_mm"], beside["center_distance_mm"]
    if abs(one - two) > SAME_DISTANCE * one:
        stock.model.refuse(
            f"{gears.with_ring.component.label}: center_distance",
            f"{one:g} mm as in {gears.with_sun[0].component.label}",
            f"{two:g}",
        )
    width = ring.source.number("face_width", "mm") or beside["face_width_mm"]
    ring.keys.pop("face_width_mm", None)
    if width != pair["face_width_mm"]:
        ring.keys["face_width_mm"] = width
    offset = planet.keys.get("axial_offset_mm", 0.0) + ring.keys.get("axial_offset_mm", 0.0)
    ring.keys.pop("axial_offset_mm", None)
    if offset:
        ring.keys["axial_offset_mm"] = offset
    tree = {
        "body_1": sun.keys,
        "planet": planet.keys,
        "body_2": ring.keys,
        "stage": _spacing(stock, component, gears) | _on_bearings(stock, gears),
        "pair": pair,
    }
    return tree, _torque_on_sun(stock, gears)


def _gears_of(stock: Stock, component: Component) -> Planets:
    """Sun, planets and ring; refused if they are not those of one sun and one ring."""
    model = stock.model
    meshes = [stage_of(model, part) for part in stages_within(model, component)]
    outside = [mesh for mesh in meshes if not mesh.is_internal]
    inside = {mesh.gears[0].id: mesh for mesh in meshes if mesh.is_internal}
    rings = {mesh.gears[1].id for mesh in inside.values()}
    common = set.intersection(*({g.id for g in mesh.gears} for mesh in outside)) if outside else {}
    suns = [number for number in common if number not in inside]
    if len(suns) != 1 or len(rings) != 1:
        expected = (
            "cylindrical stages of one sun with each planet, and of each planet with one ring"
        )
        found = f"{len(outside)} external and {len(inside)} internal ones"
        model.refuse(component.label, expected, found)
    by_planet = {_planet(mesh, suns[0]).id: mesh for mesh in outside}
    if by_planet.keys() != inside.keys():
        expected = "planets that are in mesh with the sun and with the ring"
        model.refuse(component.label, expected, f"{sorted(by_planet)} and {sorted(inside)}")
    planets = tuple(model.components[number] for number in by_planet)
    for other in planets[1:]:
        if _content(model, other) != _content(model, planets[0]):
            model.refuse(other.label, f"a planet equal to {planets[0].label}", "another one")
        stock.leave_all(other, f"equal to {planets[0].label}")
    first = planets[0].id
    used = by_planet[first].component, inside[first].component
    for mesh in meshes:
        if mesh.component not in used:
            stock.leave_all(mesh.component, f"equal to those of {planets[0].label}")
    sun, ring = model.components[suns[0]], model.components[rings.pop()]
    ordered = tuple(_with_sun_first(mesh, suns[0]) for mesh in by_planet.values())
    return Planets(sun, planets, ring, ordered, inside[planets[0].id])


def _planet(mesh: Stage, sun: int) -> Component:
    return mesh.gears[1] if mesh.gears[0].id == sun else mesh.gears[0]


def _with_sun_first(mesh: Stage, sun: int) -> Stage:
    one, two = mesh.gears
    return mesh if one.id == sun else Stage(mesh.component, (two, one))


def _content(model: Model, gear: Component) -> str:
    """Attributes of a gear and of its flanks, without ids, names and places."""
    own = sorted((name, value) for name, value in gear.attributes.items() if name not in PLACES)
    flanks = [
        content_of(model, flank)
        for side in ("left", "right")
        for flank in model.partners("flank", "gear", gear.id, side)
    ]
    return repr((own, flanks))


def _spacing(stock: Stock, component: Component, gears: Planets) -> dict[str, Any]:
    """Table [stage]: number of planets, or their angles if they are not equally spaced.

    Angles are counter-clockwise about the u axis of the sun, from the first planet on.
    """
    n = len(gears.planets)
    if "stage.floating" not in stock.settings:
        stock.assume(component, "stage.floating = 'none': supports are not read")
    angles = _angles_deg(stock, gears)
    if angles is None:
        stock.assume(component, "the planets are equally spaced: they have no positions")
        return {"planets": n}
    numbers = [stock.source(gear).number("number_of_teeth", "") for gear in (gears.sun, gears.ring)]
    whole = sum(abs(number or 0.0) for number in numbers)
    places = [angle * whole / 360.0 for angle in angles]
    if all(abs(place - round(place)) < ROUNDED for place in places):
        angles = [360.0 * round(place) / whole for place in places]
    if all(abs(n * angle - 360.0 * j) < EVEN_DEG for j, angle in enumerate(angles)):
        return {"planets": n}
    stock.assume(component, "angles of the planets: the torque turns the sun about its u axis")
    return {"angles_deg": angles}


def _on_bearings(stock: Stock, gears: Planets) -> dict[str, Any]:
    """Keys of the bearings of the planets, side by side on their pins: stiffness and clearance."""
    sources = [
        [stock.source(part) for part in _bearings_of(stock.model, planet)]
        for planet in gears.planets
    ]
    found: dict[str, Any] = {}
    sums = [_sum([one.number("radial_stiffness", "N/um") for one in each]) for each in sources]
    if sums[0] and sums.count(sums[0]) == len(sums):
        found["pin_stiffness_N_per_um"] = sums[0]
    elif any(sums):
        lacks = "planets have different bearings, or some without this attribute"
        for one in (one for each in sources for one in each):
            if "radial_stiffness" in one.component.attributes:
                stock.leave(one.component, "radial_stiffness", lacks)
    largest = [
        max((one.number("radial_bearing_clearance", "um") or 0.0 for one in each), default=0.0)
        for each in sources
    ]
    if any(largest):
        stock.assume(gears.planets[0], "the clearance of its bearings is that before mounting")
        alike = largest.count(largest[0]) == len(largest)
        found["pin_clearance_um"] = largest[0] if alike else largest
    return found


def _sum(values: list[float | None]) -> float | None:
    """Sum of numbers; None without any, or if one is unknown."""
    known = [value for value in values if value is not None]
    return sum(known) if known and len(known) == len(values) else None


def _bearings_of(model: Model, planet: Component) -> list[Component]:
    """Bearings beside a planet, or beside the shaft to which it belongs."""
    shafts = model.partners("assembly", "part", planet.id, "assembly")
    parts = {
        part.id: part
        for body in (planet, *shafts)
        for role in ("inner_part", "outer_part")
        for part in model.partners("side", role, body.id, "assembly")
        if part.type in BEARING
    }
    return list(parts.values())


def _angles_deg(stock: Stock, gears: Planets) -> list[float] | None:
    """Ascending polar angles of the planets from the first one on, deg; None if unknown."""
    axis = stock.source(gears.sun).vector("u_axis_vector")
    at = [stock.source(gear).vector("support_vector") for gear in (gears.sun, *gears.planets)]
    if axis is None or None in at:
        return None
    length = hypot(*axis)
    center, *places = (place for place in at if place is not None)
    if length == 0.0:
        return None
    u = [x / length for x in axis]
    arms = []
    for place in places:
        apart = [a - b for a, b in zip(place, center, strict=True)]
        along = sum(a * b for a, b in zip(apart, u, strict=True))
        arms.append([a - along * b for a, b in zip(apart, u, strict=True)])
    first = arms[0]
    across = [u[i - 2] * first[i - 1] - u[i - 1] * first[i - 2] for i in range(3)]
    found = []
    for arm in arms:
        x, y = (sum(a * b for a, b in zip(arm, e, strict=True)) for e in (first, across))
        found.append(float(f"{degrees(atan2(y, x)) % 360.0:.9g}") % 360.0)
    stock.source(gears.sun).read |= {"support_vector", "u_axis_vector"}
    stock.source(gears.planets[0]).read |= {"support_vector", "u_axis_vector"}
    return sorted(found)


def _torque_on_sun(stock: Stock, gears: Planets) -> float | None:
    """Sum of the torques of the sun in its meshes, or the load on its shaft, N m."""
    data = [data_of(stock, mesh, 0) for mesh in gears.with_sun]
    torques = [None if one is None else one.number("torque", "N m") for one in data]
    known = [abs(value) for value in torques if value is not None]
    if len(known) == len(torques) and sum(known) > 0.0:
        return float(f"{sum(known):.12g}")
    found = torque_of_shaft(stock, gears.sun, len(gears.planets))
    return abs(found) if found else None
