"""The table [stage] of planetary stages: a sun (body 1), equal planets, and a ring (body 2).

The frame is that of the carrier, with the sun at the origin. Lists have an entry per planet, in the
order of their angles.
"""

from __future__ import annotations

from collections.abc import Mapping
from itertools import pairwise
from math import floor, inf, radians, sin
from typing import TYPE_CHECKING, Annotated, Any, Literal

from msgspec import Meta

from flankload.scene.axial import MISALIGNMENTS, three_dimensional_key
from flankload.scene.carrier import Carrier
from flankload.scene.effects.keys import EffectsAsked
from flankload.scene.gear import Gear, Ring
from flankload.scene.mates import check_base_pitches
from flankload.scene.pair import USUAL_MISALIGNMENT, Misalignment
from flankload.scene.planet_flank import PlanetFlank
from flankload.scene.refusal import refuse, shown
from flankload.scene.table import (
    BODIES,
    USUAL_ERRORS,
    USUAL_MODIFICATION,
    USUAL_SIZE,
    Angle,
    Angles,
    Deviation,
    Force,
    Length,
    Relief,
    Table,
    about,
)

if TYPE_CHECKING:
    from flankload.scene.scene import SceneFile

MOST_PLANETS, MOST_BOLTS = 30, 360
Errors = tuple[Deviation, ...]
Inclinations = tuple[Misalignment, ...]
Clearances = Annotated[tuple[Relief, ...], Meta(min_length=1)]
Stiffness = Annotated[float, Meta(ge=1e-6, le=1e9)]
#: Radial and tangential. (msgspec crashes on tuple[float, float] in a union.)
TwoStiffnesses = Annotated[tuple[Stiffness, ...], Meta(min_length=2, max_length=2)]
Mass = Annotated[float, Meta(ge=1e-9, le=1e9)]
Inertia = Annotated[float, Meta(ge=1e-15, le=1e12)]
#: Usual stiffnesses of pins, bearings and bolts, N/um; 1e3 N/mm is 1 N/um.
USUAL_STIFFNESS = (0.05, 1e5)
#: Usual tilting stiffnesses, N m/mrad.
USUAL_TILTING = (1e-3, 1e5)
#: Largest distance of a planet from an angle at which it can be assembled, in pitches: the rounding
#: of an angle in a file.
ASSEMBLED = 1e-6
#: Effects that a stage may have; others act on a pair of bodies.
EFFECTS = frozenset(
    {
        *("contact", "tooth_coupling", "mesh_coupling", "tip_contact"),
        *("beyond_limits", "dimension", "root_stress"),
    }
)
#: Reasons why a stage has no other effects.
WITHOUT = {
    "friction_coefficient": "that friction between several meshes has one solution is not proven",
    "choose": "the choice of effects compares runs of a pair",
}
#: Keys of bodies that no member of a stage has, with the reason.
WITHOUT_IN_BODIES = {
    "shaft": "the members of a stage are on the supports of [stage]",
    "tooth_helix_slope_um": "this version has helix slopes of single teeth for two bodies",
}


class Stage(Table, frozen=True, kw_only=True):
    """A planetary stage: numbers, errors and supports of its planets, its sun and its ring."""

    planets: Annotated[
        Annotated[int, Meta(ge=1, le=MOST_PLANETS)] | None,
        about("number of equally spaced planets; planet 1 is on the positive x axis", "-"),
    ] = None
    angles_deg: Annotated[
        Angles | None,
        about(
            "polar angles of the planets about the sun, counter-clockwise from the positive x "
            "axis, ascending, instead of planets",
            "deg",
        ),
    ] = None
    floating: Annotated[
        Literal["none", "sun", "ring", "carrier"],
        about(
            "the member that is free to move in the plane, 'carrier' with all pins; the others are "
            "centred"
        ),
    ] = "none"
    pin_tangential_errors_um: Annotated[
        Errors,
        about(
            "displacement of each pin along the circumference, positive against the push of the "
            "sun: this planet carries more",
            "um",
            usual=USUAL_ERRORS,
        ),
    ] = ()
    pin_radial_errors_um: Annotated[
        Errors,
        about(
            "displacement of each pin along the radius, positive towards the axis",
            "um",
            usual=USUAL_ERRORS,
        ),
    ] = ()
    planet_thickness_errors_um: Annotated[
        Errors,
        about(
            "excess of the normal thickness of all teeth of each planet, half of it on either side",
            "um",
            usual=USUAL_ERRORS,
        ),
    ] = ()
    pin_stiffness_N_per_um: Annotated[
        Stiffness | TwoStiffnesses | None,
        about(
            "stiffness of each pin with its bearing: a number, or radial and tangential; absent = "
            "rigid",
            "N/um",
            usual=USUAL_STIFFNESS,
        ),
    ] = None
    pin_clearance_um: Annotated[
        Relief | Clearances,
        about(
            "clearance of the bearing of each planet on its pin, difference of the diameters: a "
            "number, or one per planet",
            "um",
            usual=USUAL_ERRORS,
        ),
    ] = 0.0
    pin_bearing_width_mm: Annotated[
        Length | None,
        about(
            "length over which the bearing of a planet carries, in the middle of the planet; "
            "absent = width of the planet",
            "mm",
            usual=USUAL_SIZE,
        ),
    ] = None
    pin_tangential_inclinations_um_per_mm: Annotated[
        Inclinations,
        about(
            "inclination of each pin along the circumference: its tangential error grows by this "
            "amount per length along z, 0 in the middle of the planet",
            "um/mm",
            usual=USUAL_MISALIGNMENT,
        ),
    ] = ()
    pin_radial_inclinations_um_per_mm: Annotated[
        Inclinations,
        about(
            "inclination of each pin along the radius: its radial error grows by this amount per "
            "length along z",
            "um/mm",
            usual=USUAL_MISALIGNMENT,
        ),
    ] = ()
    planet_ring_flank: Annotated[
        PlanetFlank | None,
        about(
            "modifications along the axis of the flanks of the planets in mesh with the ring; "
            "absent = those of [planet], which otherwise belong to the other flanks"
        ),
    ] = None
    carrier: Annotated[
        Carrier | None,
        about("elastic carrier and pins; absent = rigid, but for the stiffness of pins"),
    ] = None
    pin_tilt_stiffness_Nm_per_mrad: Annotated[
        Stiffness | TwoStiffnesses | None,
        about(
            "tilting stiffness of each pin with its bearing: a number, or about its radial and "
            "about its tangential axis; absent = rigid",
            "N m/mrad",
            usual=USUAL_TILTING,
        ),
    ] = None
    sun_tilt_stiffness_Nm_per_mrad: Annotated[
        Stiffness | TwoStiffnesses | None,
        about(
            "tilting stiffness of the support of the sun: a number, or about x and about y of the "
            "carrier; absent = the sun does not tilt",
            "N m/mrad",
            usual=USUAL_TILTING,
        ),
    ] = None
    ring_tilt_stiffness_Nm_per_mrad: Annotated[
        Stiffness | TwoStiffnesses | None,
        about(
            "tilting stiffness of the support of the ring, as that of the sun",
            "N m/mrad",
            usual=USUAL_TILTING,
        ),
    ] = None
    sun_run_out_um: Annotated[
        Relief,
        about(
            "radial run-out of the teeth of the sun, twice their eccentricity",
            "um",
            usual=USUAL_MODIFICATION,
        ),
    ] = 0.0
    sun_run_out_angle_deg: Annotated[
        Angle,
        about(
            "direction of the eccentricity of the sun at position 0, counter-clockwise from the "
            "positive x axis; it turns with the sun",
            "deg",
        ),
    ] = 0.0
    ring_run_out_um: Annotated[
        Relief,
        about(
            "radial run-out of the teeth of the ring, twice their eccentricity",
            "um",
            usual=USUAL_MODIFICATION,
        ),
    ] = 0.0
    ring_run_out_angle_deg: Annotated[
        Angle, about("direction of the eccentricity of the ring, as that of the sun", "deg")
    ] = 0.0
    sun_stiffness_N_per_um: Annotated[
        Stiffness | None,
        about(
            "radial stiffness of the support of a floating sun; absent = it moves without "
            "resistance",
            "N/um",
            usual=USUAL_STIFFNESS,
        ),
    ] = None
    sun_weight_N: Annotated[Force, about("weight of a floating sun", "N")] = 0.0
    sun_weight_angle_deg: Annotated[
        Angle,
        about("direction of the weight, counter-clockwise from the positive x axis", "deg"),
    ] = -90.0
    ring_support: Annotated[
        Literal["clamped", "bolts", "free"],
        about(
            "support of the outside of the ring's rim: 'clamped' = no point of it moves relative "
            "to the others; 'bolts' = it is on springs; 'free' = the rim bends and floats, only "
            "its mean rotation is held"
        ),
    ] = "clamped"
    bolts: Annotated[
        Annotated[int, Meta(ge=2, le=MOST_BOLTS)] | None,
        about(
            "number of equally spaced bolts of the ring; the first one is behind the space of the "
            "ring that planet 1 meets at position 0",
            "-",
        ),
    ] = None
    bolt_stiffness_N_per_um: Annotated[
        Stiffness | TwoStiffnesses | None,
        about(
            "stiffness of each bolt: a number, or radial and tangential",
            "N/um",
            usual=USUAL_STIFFNESS,
        ),
    ] = None

    sun_mass_kg: Annotated[
        Mass | None, about("mass of the sun, for modes; absent = by its shape", "kg")
    ] = None
    sun_inertia_kg_m2: Annotated[
        Inertia | None,
        about("moment of inertia of the sun with what it drives; absent = by its shape", "kg m2"),
    ] = None
    planet_mass_kg: Annotated[
        Mass | None, about("mass of a planet with its bearing; absent = by its shape", "kg")
    ] = None
    planet_inertia_kg_m2: Annotated[
        Inertia | None, about("moment of inertia of a planet; absent = by its shape", "kg m2")
    ] = None
    ring_mass_kg: Annotated[
        Mass | None, about("mass of a ring that floats; absent = by its shape", "kg")
    ] = None
    carrier_mass_kg: Annotated[
        Mass | None, about("mass of a floating carrier without its planets", "kg")
    ] = None
    carrier_inertia_kg_m2: Annotated[
        Inertia | None,
        about(
            "moment of inertia of the carrier without its planets, with what it drives; absent = "
            "it does not turn in modes",
            "kg m2",
        ),
    ] = None

    @property
    def count(self) -> int:
        """Number of planets."""
        return len(self.angles_deg) if self.angles_deg is not None else (self.planets or 0)

    @property
    def nominal_angles_deg(self) -> tuple[float, ...]:
        """Polar angle of each planet as in the scene, deg."""
        if self.angles_deg is not None:
            return self.angles_deg
        return tuple(360.0 * j / self.count for j in range(self.count))

    def errors_mm(self, name: str) -> tuple[float, ...]:
        """A list of errors (n,), 0 without one, mm; inclinations per mm."""
        values = getattr(self, name) or (0.0,) * self.count
        return tuple(value / 1000.0 for value in values)

    @property
    def play_mm(self) -> tuple[float, ...]:
        """Largest displacement (n,) of each planet on its pin from the middle, mm."""
        both = self.pin_clearance_um
        every = both if isinstance(both, tuple) else (both,) * self.count
        return tuple(0.5 * value / 1000.0 for value in every)

    @property
    def pin_stiffness_N_per_mm(self) -> tuple[float, float] | None:
        """Radial and tangential stiffness of a pin, N/mm; None if it is rigid."""
        return _N_per_mm(self.pin_stiffness_N_per_um)

    def tilt_Nmm_per_rad(self, member: str) -> tuple[float, float] | None:
        """Tilting stiffness of "sun", "pin" or "ring" about two axes, N mm/rad; None if rigid."""
        stiffness = _N_per_mm(getattr(self, f"{member}_tilt_stiffness_Nm_per_mrad"))
        return None if stiffness is None else (1000.0 * stiffness[0], 1000.0 * stiffness[1])

    @property
    def bolt_stiffness_N_per_mm(self) -> tuple[float, float] | None:
        """Radial and tangential stiffness of a bolt of the ring, N/mm; None without bolts."""
        return _N_per_mm(self.bolt_stiffness_N_per_um)

    def check(self, given: Mapping[str, Any] | None = None) -> None:
        """Check the rules between the keys of this table; `given`: keys that the scene sets."""
        if (self.planets is None) == (self.angles_deg is None):
            both = self.planets is not None
            refuse("stage.planets", "either planets or angles_deg", "both" if both else "neither")
        for one, two in pairwise(self.angles_deg or ()):
            if two <= one:
                refuse("stage.angles_deg", f"ascending angles, after {one:g}", f"{two:g}")
        for name in (*ERRORS, "pin_clearance_um"):
            values = getattr(self, name)
            if values and isinstance(values, tuple) and len(values) != self.count:
                expected = f"one entry per planet: {self.count}"
                refuse(f"stage.{name}", expected, f"{len(values)} entries")
        if self.carrier is not None:
            self.carrier.check((given or {}).get("carrier", {}), "stage.carrier", self.count)
        self._check_sun()
        self._check_balance()
        self._check_bolts()
        self._check_rim()

    def _check_bolts(self) -> None:
        """Check that bolts have their keys, and that the ring on them does not float."""
        for name in ("bolts", "bolt_stiffness_N_per_um"):
            value, wanted = getattr(self, name), self.ring_support == "bolts"
            if wanted and value is None:
                refuse(f"stage.{name}", "a value, with stage.ring_support = 'bolts'", None)
            if value is not None and not wanted:
                refuse(f"stage.{name}", "nothing, unless stage.ring_support is 'bolts'", value)
        if self.ring_support == "bolts" and self.floating == "ring":
            expected = "'none', 'sun' or 'carrier': bolts hold the ring"
            refuse("stage.floating", expected, "'ring'")

    def _check_sun(self) -> None:
        """Check that support and weight belong to a floating sun."""
        for name in ("sun_stiffness_N_per_um", "sun_weight_N"):
            if getattr(self, name) and self.floating != "sun":
                expected = "nothing, unless stage.floating is 'sun'"
                refuse(f"stage.{name}", expected, getattr(self, name))

    def _check_balance(self) -> None:
        """Check that planets on all sides hold a member that floats without springs."""
        held = self.floating == "none" or self.sun_stiffness_N_per_um is not None
        if held or widest_apart_deg(self) < 180.0 - ASSEMBLED:
            return
        expected = "'none', unless there are planets on all sides of the axis: nothing else "
        refuse("stage.floating", f"{expected}holds the {self.floating}", f"'{self.floating}'")

    def _check_rim(self) -> None:
        """Check that a free rim floats, and that no second member floats without springs."""
        if self.ring_support != "free" or self.floating == "ring":
            return
        if self.floating == "none":
            expected = "'clamped', or stage.floating = 'ring': nothing centres a free rim"
            refuse("stage.ring_support", expected, "'free'")
        if self.floating == "sun" and self.sun_stiffness_N_per_um is not None:
            return
        expected = "'clamped': a free rim floats beside the floating "
        expected += f"{self.floating}, so that the position of both is undetermined"
        if self.floating == "sun":
            expected += " without stage.sun_stiffness_N_per_um"
        refuse("stage.ring_support", expected, "'free'")


def _N_per_mm(stiffness: float | tuple[float, ...] | None) -> tuple[float, float] | None:
    """Radial and tangential stiffness, N/mm, of a number or of both, N/um."""
    if stiffness is None:
        return None
    radial, tangential = stiffness if isinstance(stiffness, tuple) else (stiffness, stiffness)
    return 1000.0 * radial, 1000.0 * tangential


#: Keys with one entry per planet.
ERRORS = (
    *("pin_tangential_errors_um", "pin_radial_errors_um", "planet_thickness_errors_um"),
    *("pin_tangential_inclinations_um_per_mm", "pin_radial_inclinations_um_per_mm"),
)


def check_stage(asked: SceneFile, given: Mapping[str, Any]) -> None:
    """Check the tables of a stage together; `given`: scene as in the file."""
    stage, planet = asked.stage, asked.planet
    if stage is None or planet is None:
        for there, missing in (("stage", "planet"), ("planet", "stage")):
            if getattr(asked, there) is not None:
                refuse(missing, f"a table, beside [{there}]", None)
        return
    _check_members(asked, planet)
    stage.check(given.get("stage"))
    _check_effects(asked, given.get("effects", {}))
    _check_states(asked)
    assert isinstance(asked.body_1, Gear)
    assert isinstance(asked.body_2, Ring)
    assembled_places(stage, asked.body_1.teeth + asked.body_2.teeth)
    _check_neighbours(asked, stage, planet)


def _check_members(asked: SceneFile, planet: Gear) -> None:
    """Check kinds, base pitches, tooth numbers and plane bodies."""
    for name, form in (("body_1", Gear), ("body_2", Ring)):
        body = getattr(asked, name)
        if not isinstance(body, form):
            expected = (
                f"'{form.__struct_config__.tag}' with [stage]: body_1 is the sun, body_2 the "
            )
            refuse(f"{name}.kind", expected + "ring", f"'{body.kind}'")
    if asked.body_2.rigid and asked.stage is not None and asked.stage.ring_support == "bolts":
        refuse("body_2.rigid", "false, with stage.ring_support = 'bolts'", shown(True))
    check_base_pitches(asked.body_1, planet, names=("body_1", "planet"))
    if three_dimensional_key(asked) is not None:
        _check_width(asked)


def _check_width(asked: SceneFile) -> None:
    """Refuse keys that a stage with width does not have."""
    assert asked.stage is not None
    for body in BODIES:
        for name, instead in WITHOUT_IN_BODIES.items():
            if getattr(getattr(asked, body), name, None):
                refuse(f"{body}.{name}", f"nothing with [stage]: {instead}", "a value")
    for name in MISALIGNMENTS:
        if asked.pair is not None and getattr(asked.pair, name):
            expected = "nothing with [stage], which has several axes"
            refuse(f"pair.{name}", expected, getattr(asked.pair, name))
    flank, pair = asked.stage.planet_ring_flank, asked.pair
    if flank is not None and asked.planet is not None and pair is not None:
        width = asked.planet.face_width_mm or pair.face_width_mm
        flank.check(width, "stage.planet_ring_flank")


def _check_effects(asked: SceneFile, given: Mapping[str, Any]) -> None:
    """Refuse the effects that a stage does not have."""
    plain = EffectsAsked()
    for key, value in given.items():
        if key in EFFECTS or value == getattr(plain, key):
            continue
        why = WITHOUT.get(key, "this version has it for two bodies")
        refuse(f"effects.{key}", f"nothing with [stage]: {why}", shown(value))
    assert asked.stage is not None
    if asked.effects.root_stress and asked.stage.ring_support == "bolts":
        expected = "false with stage.ring_support = 'bolts': forces of bolts are not in it"
        refuse("effects.root_stress", expected, shown(value=True))


def _check_states(asked: SceneFile) -> None:
    """Refuse a weight on a sun that nothing holds without torque, and adaptive positions."""
    stage = asked.stage
    assert stage is not None
    heavy = stage.sun_weight_N and stage.sun_stiffness_N_per_um is None
    if heavy and not all(asked.load.torques_Nm):
        expected = "a number > 0 with stage.sun_weight_N: nothing else carries the sun"
        refuse("load.torque_Nm", expected, "0")
    if asked.positions.adaptive:
        expected = "false with [stage]: this version has it for two bodies"
        refuse("positions.adaptive", expected, shown(True))


def assembled_places(stage: Stage, teeth: int) -> tuple[int, ...]:
    """Place (n,) of each planet from the first one, in parts 1/teeth of a turn.

    Planets can be assembled at these places only; `teeth` is the sum of those of sun and ring.

    Raises
    ------
    SceneError
        At the first planet at another angle; names the two nearest possible angles.
    """
    angles = stage.nominal_angles_deg
    key, found = "stage.planets", f"{stage.count}: "
    if stage.angles_deg is not None:
        key, found = "stage.angles_deg", ""
    places = []
    for j, angle in enumerate(angles):
        place = (angle - angles[0]) * teeth / 360.0
        if abs(place - round(place)) > ASSEMBLED:
            low, high = (
                f"{angles[0] + 360.0 * k / teeth:.10g}" for k in (floor(place), floor(place) + 1)
            )
            at = key if not found else "stage.angles_deg"
            expected = f"an angle of planet {j + 1} at which its teeth fit those of sun and ring "
            expected += f"(multiples of 360/{teeth} deg from planet 1); the nearest are {low} and "
            expected += f"{high}" + (f" deg in {at}" if found else "")
            refuse(key if found else f"{key}[{j}]", expected, f"{found}{angle:.10g} deg")
        places.append(round(place))
    return tuple(places)


def least_apart_deg(stage: Stage) -> float:
    """Least angle between neighbouring planets, deg; 360 for a single one."""
    return min(_angles_between(stage))


def widest_apart_deg(stage: Stage) -> float:
    """Largest angle between neighbouring planets, deg; 360 for a single one."""
    return max(_angles_between(stage))


def _angles_between(stage: Stage) -> tuple[float, ...]:
    """Angles between neighbouring planets around the axis, deg."""
    angles = stage.nominal_angles_deg
    return tuple(two - one for one, two in pairwise((*angles, angles[0] + 360.0)))


def clearance_mm(stage: Stage, center_distance_mm: float, tip_diameter_mm: float) -> float:
    """Least distance of the tip circles of neighbouring planets; infinite for a single one."""
    if stage.count == 1:
        return inf
    half = 0.5 * radians(min(180.0, least_apart_deg(stage)))
    return 2.0 * center_distance_mm * sin(half) - tip_diameter_mm


def _check_neighbours(asked: SceneFile, stage: Stage, planet: Gear) -> None:
    """Check that neighbouring planets do not touch."""
    assert asked.pair is not None
    distance = asked.pair.center_distance_mm
    if distance is None or stage.count == 1:
        return
    clear = clearance_mm(stage, distance, planet.tip_diameter_mm)
    if clear <= 0.0:
        expected = (
            f"less than {planet.tip_diameter_mm + clear:.4f}, at which neighbouring planets, "
        )
        expected += f"{least_apart_deg(stage):g} deg apart, touch"
        refuse("planet.tip_diameter_mm", expected, planet.tip_diameter_mm)
