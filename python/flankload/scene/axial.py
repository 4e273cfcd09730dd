"""Keys of a body along its axis: width, position, helix, lead modifications; and their rules."""

from collections.abc import Mapping
from itertools import pairwise
from math import radians
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal

from msgspec import Meta

from flankload.scene.refusal import refuse, refuse_absent, shown
from flankload.scene.shaft import Shaft
from flankload.scene.table import (
    BODIES,
    PER_MODULE,
    PER_WIDTH,
    USUAL_ERRORS,
    USUAL_MODIFICATION,
    Deviation,
    Length,
    Relief,
    ReliefShape,
    Text,
    about,
)

if TYPE_CHECKING:
    from flankload.scene.accuracy import Accuracy
    from flankload.scene.scene import Scene, SceneFile

#: Largest helix angle, deg; above it, the edges at the end faces are sharper than 50 degrees.
LARGEST_HELIX = 40.0
#: Largest difference of the helix angles of a pair with the same lead per tooth, deg: rounding of
#: helix angles in files, and of the reference radii of meshes.
HELIX_TOLERANCE, HELIX_TOLERANCE_OF_RADII = 1e-6, 1e-4
#: Default polynomial degrees of the displacements and of the pressure modes along the axis.
AXIAL_DEGREE, LOAD_DEGREE = 8, 4
#: Least excess of the degree of the displacements over that of the pressure modes.
DEGREES_ABOVE_LOAD = 4
#: Effects of plane scenes only, with the capability that three dimensions lack.
PLANE_EFFECTS = {
    "choose": "no choice of effects for three-dimensional bodies",
    "near_field": "no nodal forces on three-dimensional bodies",
    "influence": "influence coefficients of small forces for slices",
}
#: Keys that vary along the axis and hence require three dimensions, unless they are 0.
LEAD_KEYS = (
    "lead_crowning_um",
    "helix_slope_um",
    "tooth_helix_slope_um",
    "end_relief_um",
    "profile_twist_um",
    "topography_file",
)
#: Keys of axes that are not parallel; the last one is that of splines.
MISALIGNMENTS = ("inclination_um_per_mm", "deviation_um_per_mm", "misalignment_mrad")
#: Keys of a stage by which its members lean, and of what is distributed along its pins.
STAGE_KEYS = (
    "pin_bearing_width_mm",
    "pin_tilt_stiffness_Nm_per_mrad",
    "sun_tilt_stiffness_Nm_per_mrad",
    "ring_tilt_stiffness_Nm_per_mrad",
    "pin_tangential_inclinations_um_per_mm",
    "pin_radial_inclinations_um_per_mm",
    "planet_ring_flank",
    "carrier",
)
#: Keys of regions narrower or wider than the teeth, which require three dimensions.
REGION_KEYS = ("web_width_mm", "hub_width_mm", "region_sets")
#: Tables of two bodies that mesh, unless there are planets between them.
PAIR_OF_BODIES = ("body_1", "body_2")
BothEnds = Annotated[tuple[Relief, ...], Meta(min_length=2, max_length=2)]
BothLengths = Annotated[tuple[Length, ...], Meta(min_length=2, max_length=2)]


HelixAngle = Annotated[
    float,
    Meta(ge=0, le=LARGEST_HELIX),
    about("helix angle on the reference cylinder; module_mm is then the normal module", "deg"),
]
MeshHelixAngle = Annotated[
    float,
    Meta(ge=0, le=LARGEST_HELIX),
    about(
        "helix angle on the reference circle of the profile, without a profile on the circle of "
        "reference_radius_mm; mesh and profile are the transverse section",
        "deg",
    ),
]
Hand = Annotated[
    Literal["right", "left"] | None, about("hand of the helix; required with a helix angle")
]
OwnWidth = Annotated[
    Length | None,
    about(
        "face width of this body; absent = pair.face_width_mm, which may be absent if both bodies "
        "have their own",
        "mm",
        usual=(0.05, 5000.0),
    ),
]
AxialOffset = Annotated[
    float,
    Meta(ge=-1e5, le=1e5),
    # no lower end: all small offsets are as good as 0
    about("axial position of the middle of the face width", "mm", usual=(1e-9, 5000.0)),
]
LeadCrowning = Annotated[
    Relief | None,
    about(
        "lead crowning: parabola over the face width, 0 in the middle, this amount of metal "
        "removed at both ends",
        "um",
        usual=USUAL_MODIFICATION,
        per=PER_WIDTH,
    ),
]
HelixSlope = Annotated[
    Deviation | None,
    about(
        "helix slope modification: metal removed, linear over the face width; positive: at the "
        "end of larger z, negative: at the end of smaller z",
        "um",
        usual=USUAL_ERRORS,
        per=PER_WIDTH,
    ),
]
ToothHelixSlopes = Annotated[
    tuple[Deviation, ...],
    about(
        "one helix slope per tooth, with the sign of helix_slope_um, which is added; in the order "
        "of pitch_errors_um: that in which the teeth come into contact, from the tooth of pair 0",
        "um",
        usual=USUAL_ERRORS,
    ),
]
ProfileTwist = Annotated[
    Deviation | None,
    about(
        "twist of the flank: half of a positive amount is removed at the root at the end of "
        "smaller z and at the tip at the end of larger z, half is added at the two other corners; "
        "bilinear over the arc length of the active flank and the face width",
        "um",
        usual=USUAL_MODIFICATION,
        per=PER_MODULE,
    ),
]
TopographyFile = Annotated[
    Text | None,
    about(
        ".csv file with the metal removed in um, relative to the folder of the scene file: first "
        "row = distances from the end of smaller z in mm, first column = diameters in mm"
    ),
]
EndRelief = Annotated[
    BothEnds | None,
    about(
        "end relief at the ends of smaller and of larger z",
        "um",
        usual=USUAL_MODIFICATION,
        per=PER_WIDTH,
    ),
]
EndReliefLength = Annotated[
    BothLengths | None, about("length of the end relief at both ends", "mm", usual=(0.01, 500.0))
]
EndReliefShape = Annotated[ReliefShape, about("shape of the end relief along the axis")]


OnShaft = Annotated[
    Shaft | None,
    about("shaft and bearings, by dimensions or by a compliance; absent = the bore does not move"),
]


class AxialKeys:
    """Mixin of bodies with keys along their axis; end I is the end of smaller z.

    Attributes
    ----------
    inward : bool or None
        Whether the teeth point inwards; None if this follows from a file.
    """

    __slots__ = ()

    inward: ClassVar[bool | None] = False

    # defaults for splines, which lack these keys
    helix_angle_deg: HelixAngle = 0.0
    hand: Hand = None
    profile_twist_um: ProfileTwist = None
    topography_file: TopographyFile = None
    shaft: OnShaft = None

    if TYPE_CHECKING:
        brings_compliance: ClassVar[bool]
        face_width_mm: OwnWidth
        axial_offset_mm: AxialOffset
        lead_crowning_um: LeadCrowning
        helix_slope_um: HelixSlope
        tooth_helix_slope_um: ToothHelixSlopes
        end_relief_um: EndRelief
        end_relief_length_mm: EndReliefLength
        end_relief_shape: EndReliefShape

        @property
        def number_of_teeth(self) -> int:
            """Number of teeth; 0 if only a file has it."""

        @property
        def turn_per_mm(self) -> float:
            """Rotation of the section along the axis times half the number of teeth, rad/mm."""

        def helix_deg_of(self, turn_per_mm: float) -> float:
            """Helix angle for a rotation of the section along the axis in rad/mm, deg."""

    @property
    def helix_rad(self) -> float:
        """Helix angle on the reference cylinder, rad; positive for both hands."""
        return radians(self.helix_angle_deg)

    @property
    def hand_sign(self) -> int:
        """1 for a right-hand helix, -1 for a left-hand one, 0 without a helix."""
        return {"right": 1, "left": -1, None: 0}[self.hand]

    @property
    def helix_tolerance_deg(self) -> float:
        """Largest difference from the helix angle of the other body, deg."""
        return HELIX_TOLERANCE

    def regions_of(
        self, range_mm: tuple[float, float]
    ) -> tuple[tuple[str, tuple[float, float]], ...]:
        """Names and axial ranges of regions that are not as wide as the teeth."""
        return ()

    def check_extents(self, range_mm: tuple[float, float], key: str) -> None:
        """Check the axial ranges of the regions against that of the teeth."""

    def bore_of(self, range_mm: tuple[float, float]) -> tuple[tuple[float, float], float] | None:
        """Axial range and diameter of the bore; None if the diameter is unknown."""
        return None

    def check_solid(self, key: str, why: str) -> None:
        """Refuse features that this version has in plane scenes only."""

    def check_axial(self, given: Mapping[str, Any], key: str) -> None:
        """Check helix and hand, end relief and its lengths, the slopes of all teeth, the shaft."""
        if self.shaft is not None:
            self.shaft.check(given["shaft"], f"{key}.shaft", helical=bool(self.helix_angle_deg))
        if self.helix_angle_deg and self.hand is None:
            refuse_absent(key, "hand", "'right' or 'left'", "helix_angle_deg")
        if self.hand is not None and not self.helix_angle_deg:
            refuse(f"{key}.hand", f"nothing, unless {key}.helix_angle_deg is > 0", shown(self.hand))
        slopes = self.tooth_helix_slope_um
        if slopes and self.number_of_teeth not in (0, len(slopes)):
            expected = f"one entry per tooth: {self.number_of_teeth}, as in {key}.teeth"
            refuse(f"{key}.tooth_helix_slope_um", expected, f"{len(slopes)} entries")
        reliefs = ("end_relief_um", "end_relief_length_mm")
        for missing, there in (reliefs, reliefs[::-1]):
            if getattr(self, missing) is None and getattr(self, there) is not None:
                refuse_absent(key, missing, "a list of 2 numbers", there)


def axial_range(body: AxialKeys, pair_width_mm: float, key: str = "body") -> tuple[float, float]:
    """Axial range of the teeth of a body, mm.

    Raises
    ------
    SceneError
        If an end relief is longer than the body, or a web, hub or shaft does not fit.
    """
    width = body.face_width_mm or pair_width_mm
    for k, length in enumerate(body.end_relief_length_mm or ()):
        if length > width:
            expected = f"at most the face width of the body, {width:g}"
            refuse(f"{key}.end_relief_length_mm[{k}]", expected, length)
    ends = _ends(body, width)
    body.check_extents(ends, key)
    if body.shaft is not None and body.shaft.is_flexible:
        _check_flexible(body, body.shaft, ends, key)
    return ends


def common_range(
    one: AxialKeys,
    two: AxialKeys,
    pair_width_mm: float = 0.0,
    names: tuple[str, str] = PAIR_OF_BODIES,
) -> tuple[float, float]:
    """Axial range in which the face widths of two bodies overlap, mm.

    `pair_width_mm` is that of bodies without their own. Raises SceneError without an overlap.
    """
    (low_1, high_1), (low_2, high_2) = (
        _ends(body, body.face_width_mm or pair_width_mm) for body in (one, two)
    )
    low, high = max(low_1, low_2), min(high_1, high_2)
    if high <= low:
        refuse(
            f"{names[1]}.axial_offset_mm",
            f"an offset at which the face widths overlap: {names[0]} extends from {low_1:g} to "
            f"{high_1:g} mm",
            f"{two.axial_offset_mm:g}, where {names[1]} extends from {low_2:g} to {high_2:g} mm",
        )
    return low, high


def _ends(body: AxialKeys, width_mm: float) -> tuple[float, float]:
    return body.axial_offset_mm - 0.5 * width_mm, body.axial_offset_mm + 0.5 * width_mm


def _check_flexible(body: AxialKeys, shaft: Shaft, ends: tuple[float, float], key: str) -> None:
    """Check that a flexible shaft fills the bore."""
    bore = body.bore_of(ends)
    if bore is None:
        expected = f"'rigid', since there is no {key}.bore_diameter_mm"
        refuse(f"{key}.shaft.under_teeth", expected, shown(shaft.under_teeth))
    shaft.check_bore(*bore, 0.5 * (ends[0] + ends[1]), key)


def degrees_of(accuracy: "Accuracy") -> tuple[int, int]:
    """Degrees of the displacements and of the pressure modes along the axis."""
    degree = accuracy.axial_degree or AXIAL_DEGREE
    if accuracy.load_degree_z is not None:
        return degree, accuracy.load_degree_z
    return degree, min(LOAD_DEGREE, degree - DEGREES_ABOVE_LOAD)


def three_dimensional_key(scene: "Scene | SceneFile") -> str | None:
    """The key for which a scene needs three dimensions; None if nothing varies along the axis."""
    return "effects.dimension = 3" if scene.effects.dimension == 3 else _varying_key(scene)


def _varying_key(scene: "Scene | SceneFile") -> str | None:
    """The first key that varies along the axis."""
    pair, widths = scene.pair, []
    for name in STAGE_KEYS:
        value = getattr(scene.stage, name, None)
        if any(value) if isinstance(value, tuple) else value:
            return f"stage.{name}"
    for key in BODIES:
        body = getattr(scene, key)
        if not isinstance(body, AxialKeys):
            continue
        for name in ("helix_angle_deg", *LEAD_KEYS, "axial_offset_mm", "shaft", *REGION_KEYS):
            value = getattr(body, name, None)
            if any(value) if isinstance(value, tuple) else value:
                return f"{key}.{name}"
        widths.append((key, body.face_width_mm))
    if pair is None:
        return None
    for key, width in widths:
        if width is not None and width != pair.face_width_mm:
            return f"{key}.face_width_mm"
    return next((f"pair.{name}" for name in MISALIGNMENTS if getattr(pair, name)), None)


def check_dimension(asked: "SceneFile", given: Mapping[str, Any]) -> None:
    """Check the keys of a three-dimensional scene, and that a plane scene has none of them."""
    dimension, needed_by = asked.effects.dimension, _varying_key(asked)
    if dimension == 2 and needed_by is not None:
        refuse("effects.dimension", f"3 or nothing, since there is a {needed_by}", 2)
    accuracy = asked.accuracy
    if needed_by is None and dimension != 3:
        for name in ("slices", "line_load_length_mm", "axial_degree", "load_degree_z"):
            if getattr(accuracy, name) is not None:
                refuse(
                    f"accuracy.{name}",
                    "nothing in a plane scene (effects.dimension = 3 makes it three-dimensional)",
                    getattr(accuracy, name),
                )
        return
    why = needed_by or "effects.dimension = 3"
    bodies: dict[str, Any] = {name: getattr(asked, name) for name in BODIES}
    bodies = {name: body for name, body in bodies.items() if body is not None}
    for name, body in bodies.items():
        if not isinstance(body, AxialKeys):
            refuse(
                f"{name}.kind",
                f"'gear', 'ring', 'mesh', 'compliance' or a spline, since {why} requires three "
                "dimensions, which this version has for these bodies",
                f"'{body.kind}'",
            )
        body.check_solid(name, why)
    assert asked.pair is not None
    # in a stage the planets meet both
    for names in pairwise(bodies) if asked.train is None else asked.train.meshes:
        _check_pair(bodies[names[0]], bodies[names[1]], asked.pair.face_width_mm, names)
    _check_effects(asked, given.get("effects", {}), why)
    degree = accuracy.axial_degree or AXIAL_DEGREE
    if (accuracy.load_degree_z or 0) > degree - DEGREES_ABOVE_LOAD:
        expected = f"at most {degree - DEGREES_ABOVE_LOAD}, {DEGREES_ABOVE_LOAD} less than "
        expected += f"accuracy.axial_degree ({degree})"
        refuse("accuracy.load_degree_z", expected, accuracy.load_degree_z)


def _check_effects(asked: "SceneFile", given: Mapping[str, Any], why: str) -> None:
    """Refuse effects and keys that this version has in plane scenes only."""
    since = f"since {why} requires three dimensions"
    plain = type(asked.effects)()
    cells = given.get("contact") == "pairs"
    if cells and asked.body_1.conforms:
        expected = f"nothing, {since}: slices of splines have one unknown each"
        refuse("effects.contact", expected, "'pairs'")
    for key, what in PLANE_EFFECTS.items():
        value = getattr(asked.effects, key)
        if value != getattr(plain, key):
            default = shown(getattr(plain, key)) if getattr(plain, key) else "nothing"
            refuse(f"effects.{key}", f"{default}, {since}: this version has {what}", shown(value))
    if cells:
        return
    for key in ("strips_per_half_width", "corner_strips_per_half_width", "zone_half_widths"):
        if getattr(asked.accuracy, key) is not None:
            expected = f"nothing, {since}: their contact has slices instead of cells"
            expected += " (effects.contact = 'pairs' for cells)"
            refuse(f"accuracy.{key}", expected, getattr(asked.accuracy, key))


def check_hands(
    sign_1: int, sign_2: int, *, inward: bool, names: tuple[str, str] = PAIR_OF_BODIES
) -> None:
    """Check the hands of two helices: equal if body 2 has internal teeth, opposite otherwise.

    The signs are 1 for a right hand, -1 for a left hand, 0 without a helix.
    """
    first, second = names
    wanted, how = -sign_1, f"the opposite of {first}.hand"
    if inward:
        wanted, how = sign_1, f"as {first}.hand, since {second} has internal teeth"
    hands = {1: "'right'", -1: "'left'", 0: "nothing"}
    if sign_2 != wanted:
        refuse(f"{second}.hand", f"{hands[wanted]}, {how}", hands[sign_2])


def _check_pair(
    one: AxialKeys, two: AxialKeys, pair_width_mm: float, names: tuple[str, str]
) -> None:
    """Check that the helices of two bodies mesh and that their widths overlap."""
    for name, body in zip(names, (one, two), strict=True):
        axial_range(body, pair_width_mm, name)
    common_range(one, two, pair_width_mm, names)
    if one.brings_compliance or two.brings_compliance:
        return  # whose file has the helix
    first, second = names
    # the rotations of both sections along the axis are in the ratio of the tooth numbers
    expected = two.helix_deg_of(one.turn_per_mm)
    if abs(expected - two.helix_angle_deg) > max(one.helix_tolerance_deg, two.helix_tolerance_deg):
        same = abs(expected - one.helix_angle_deg) <= HELIX_TOLERANCE
        refuse(
            f"{second}.helix_angle_deg",
            f"{one.helix_angle_deg:g}, as in {first}.helix_angle_deg (parallel axes)"
            if same
            else f"{expected:.8g}, which on its reference circle has the lead per tooth of {first} "
            "(parallel axes)",
            two.helix_angle_deg,
        )
    if two.inward is not None:
        check_hands(one.hand_sign, two.hand_sign, inward=two.inward, names=names)
