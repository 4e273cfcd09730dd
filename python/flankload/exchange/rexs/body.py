"""A gear of a stage as a body of a scene: profile, root, helix and material."""

from __future__ import annotations

from dataclasses import dataclass
from math import atan, cos, radians, sqrt, tan
from typing import TYPE_CHECKING, Any

from flankload.exchange.rexs.attributes import PLAIN, TABLE

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flankload.exchange.rexs.model import Component
    from flankload.exchange.rexs.source import Source, Stock

#: Relations by which a component has a tool, up to REXS 1.2 and since REXS 1.3.
OF_TOOL = (
    ("ordered_reference", "origin", "referenced"),
    ("manufacturing_step", "workpiece", "tool"),
)


@dataclass
class Gear:
    """A gear while its table is filled; `name` is that of the table, body_1 or body_2.

    `flank` is the flank whose profile is taken, if there is one.
    """

    source: Source
    flank: Source | None
    name: str
    keys: dict[str, Any]

    @property
    def component(self) -> Component:
        """The component of the gear."""
        return self.source.component

    @property
    def is_ring(self) -> bool:
        """Whether the teeth point inwards."""
        return self.component.type == "ring_gear"

    @property
    def reference_mm(self) -> float:
        """Reference diameter, mm."""
        return self.keys["teeth"] * self.keys["module_mm"] / cos(self.helix_rad)

    @property
    def helix_rad(self) -> float:
        """Helix angle on the reference cylinder, rad."""
        return radians(self.keys.get("helix_angle_deg", 0.0))

    @property
    def transverse_rad(self) -> float:
        """Transverse pressure angle, rad."""
        return atan(tan(radians(self.keys["pressure_angle_deg"])) / cos(self.helix_rad))

    def roll_length_mm(self, diameter_mm: float) -> float | None:
        """Length of roll at a diameter, mm; None inside the base circle."""
        base = self.reference_mm * cos(self.transverse_rad)
        if diameter_mm < base:
            return None
        return 0.5 * sqrt(diameter_mm**2 - base**2)


def body_of(stock: Stock, gear: Component, name: str, flank: Component | None) -> Gear:
    """The table of a gear without its modifications and widths; refuses missing or wrong values."""
    body = Gear(stock.source(gear), None if flank is None else stock.source(flank), name, {})
    body.keys["kind"] = "ring" if body.is_ring else "gear"
    _teeth(stock, body)
    _plain(body, body.source)
    _helix(stock, body)
    _profile(stock, body)
    _required(stock, body)
    _thickness(stock, body)
    _root(stock, body)
    _material(stock, body)
    return body


def _plain(body: Gear, source: Source) -> None:
    """Read the attributes of a component that are keys as they are."""
    for entry in TABLE:
        if entry.how == PLAIN and source.component.type in entry.types:
            value = source.number(entry.attribute, entry.unit)
            if value is not None:
                body.keys[entry.key.removeprefix("body.")] = value


def _teeth(stock: Stock, body: Gear) -> None:
    teeth = body.source.number("number_of_teeth", "")
    if teeth is None:
        stock.missing(body.source, "number_of_teeth", f"{body.name}.teeth")
        return
    if teeth != round(teeth) or (teeth < 0 and not body.is_ring):
        body.source.refuse("number_of_teeth", "a positive integer", teeth)
    body.keys["teeth"] = abs(round(teeth))


def _required(stock: Stock, body: Gear) -> None:
    """Refuse a gear without what every scene needs, and put in what is given otherwise."""
    of_flank = body.flank or body.source
    wanted = {
        "module_mm": (body.source, "normal_module"),
        "tip_diameter_mm": (body.source, "tip_diameter"),
        "root_diameter_mm": (body.source, "root_diameter"),
        "outer_diameter_mm": (body.source, "outer_diameter"),
        "bore_diameter_mm": (body.source, "inner_diameter"),
        "pressure_angle_deg": (of_flank, "normal_pressure_angle"),
        "profile_shift": (of_flank, "addendum_modification_coefficient"),
    }
    for key in ("bore_diameter_mm",) if body.is_ring else ("root_diameter_mm", "outer_diameter_mm"):
        del wanted[key]
    for key, (source, attribute) in wanted.items():
        if key not in body.keys:
            stock.missing(source, attribute, f"{body.name}.{key}")
    for path, value in stock.settings.items():
        table, _, key = path.partition(".")
        if table == body.name and isinstance(value, int | float):
            stock.replace(path, body.keys.get(key))
            body.keys[key] = value
    for key in ("teeth", *wanted):
        value = body.keys.get(key)
        if value is None or (key != "profile_shift" and value <= 0 and key != "bore_diameter_mm"):
            path = f"{body.name}.{key}"
            place = path if path in stock.settings else f"{body.component.label}: {key}"
            stock.model.refuse(place, "a number > 0", stock.settings.get(path, value))


def _helix(stock: Stock, body: Gear) -> None:
    name = "helix_angle_reference_diameter"
    angle = body.source.number(name, "deg")
    if angle is None and not body.is_ring:
        stock.missing(body.source, name, f"{body.name}.helix_angle_deg")
    if not angle:
        return
    body.keys["helix_angle_deg"] = abs(angle)
    body.keys["hand"] = "right" if angle > 0 else "left"
    stock.assume(
        body.component,
        f"{name} {angle:g} deg is a {body.keys['hand']}-hand helix (the sign of ISO 21771; the "
        "public database does not define it)",
    )


def _profile(stock: Stock, body: Gear) -> None:
    """Pressure angle, profile shift and tip chamfer of the flank."""
    flank = body.flank
    if flank is None:
        return
    _plain(body, flank)
    nominal = flank.number("addendum_modification_coefficient", "")
    finished = flank.number("addendum_modification_coefficient_after_finishing", "")
    in_mm = flank.number("addendum_modification", "mm")
    if nominal is None and in_mm is not None and body.keys.get("module_mm"):
        nominal = in_mm / body.keys["module_mm"]
    if finished is not None and nominal is not None and finished != nominal:
        why = "the coefficient after finishing is taken"
        stock.leave(flank.component, "addendum_modification_coefficient", why)
    shift = nominal if finished is None else finished
    if shift is not None:
        body.keys["profile_shift"] = shift
    chamfer = flank.number("tooth_tip_chamfer", "mm")
    if chamfer:
        body.keys["tip_chamfer_mm"] = chamfer


def _root(stock: Stock, body: Gear) -> None:
    """Dedendum and tip rounding of the rack of an external gear."""
    tools = [
        part
        for kind, role, wanted in OF_TOOL
        for part in stock.model.partners(kind, role, body.component.id, wanted)
        if part.type.endswith("_tool")
    ]
    step = "manufacturing_step"
    steps = stock.model.partners(step, "workpiece", body.component.id, step)
    made = [stock.source(part) for part in steps]
    if body.is_ring:
        for tool in tools:
            stock.leave_all(tool, "the root of a ring is given by its diameter")
        return
    racks = [tool for tool in tools if tool.type == "rack_shaped_tool"]
    for tool in tools:
        if tool not in racks[:1]:
            stock.leave_all(tool, "one rack_shaped_tool for each gear is read")
    dedendum = None
    if racks:
        rack = stock.source(racks[0])
        _plain(body, rack)
        dedendum = rack.number("addendum_coefficient_reference_profile", "")
        _protuberance(stock, body, rack, made)
    root = body.source.number("root_diameter", "mm")
    if root is not None and body.keys.keys() >= {"teeth", "module_mm", "profile_shift"}:
        depth = 0.5 * (body.reference_mm - root) / body.keys["module_mm"]
        if dedendum is not None:
            why = f"root_diameter of {body.component.label} is taken"
            stock.leave(racks[0], "addendum_coefficient_reference_profile", why)
        # the rack cuts deeper by the share of the thickness allowance (x_E of DIN 3960)
        allowance = body.keys.get("tooth_thickness_allowance_um", 0.0) / 1000.0
        pressure = tan(radians(body.keys["pressure_angle_deg"]))
        shift = body.keys["profile_shift"] + 0.5 * allowance / (body.keys["module_mm"] * pressure)
        dedendum = float(f"{depth + shift:.12g}")
    if dedendum is not None:
        body.keys["dedendum_factor"] = dedendum
    for key, what in (("dedendum_factor", "dedendum"), ("fillet_radius_factor", "tip radius")):
        if key not in body.keys and f"{body.name}.{key}" not in stock.settings:
            stock.assume(body.component, f"default of {key}: no {what} of a rack in the file")


def _protuberance(stock: Stock, body: Gear, rack: Source, made: Sequence[Source]) -> None:
    """Protuberance of the rack, with the stock that is ground off."""
    amount = rack.number("protuberance_amount", "mm")
    angle = rack.number("protuberance_angle", "deg")
    if not amount:
        return
    found = [source.number("machining_allowance", "mm") for source in made]
    stock_mm = max((value for value in found if value is not None), default=None)
    if stock_mm is None:
        stock.assume(body.component, "grinding_stock_mm = 0: no machining_allowance in the file")
    if amount <= (stock_mm or 0.0):
        why = f"it is not more than the machining allowance of {stock_mm:g} mm"
        stock.leave(rack.component, "protuberance_amount", why)
        return
    body.keys["protuberance_mm"] = amount
    if angle is not None:
        body.keys["protuberance_angle_deg"] = angle
    if stock_mm:
        body.keys["grinding_stock_mm"] = stock_mm


def _thickness(stock: Stock, body: Gear) -> None:
    """Tooth thickness in the middle of the tolerance of the base tangent length."""
    finished = "addendum_modification_coefficient_after_finishing"
    if body.is_ring or (body.flank and finished in body.flank.component.attributes):
        return
    names = [f"{end}_backlash_allowance_referenced_to_span" for end in ("upper", "lower")]
    if not all(name in body.component.attributes for name in names):
        return
    upper, lower = (body.source.number(name, "um") or 0.0 for name in names)
    # DIN 3960: A_W = A_sn cos a_n
    mean = 0.5 * (upper + lower) / cos(radians(body.keys["pressure_angle_deg"]))
    if mean:
        body.keys["tooth_thickness_allowance_um"] = float(f"{mean:.12g}")
        stock.assume(
            body.component,
            f"tooth_thickness_allowance_um = {mean:.4g}: the middle of both deviations of the base "
            "tangent length",
        )


def _material(stock: Stock, body: Gear) -> None:
    parts = stock.model.partners("reference", "origin", body.component.id, "referenced")
    found = [part for part in parts if part.type == "material"]
    if found:
        _plain(body, stock.source(found[0]))
    for key in ("young_modulus_MPa", "poisson_ratio"):
        if key not in body.keys and f"{body.name}.{key}" not in stock.settings:
            stock.assume(body.component, f"default of {key}: no material with it in the file")
