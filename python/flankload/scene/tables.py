"""The tables of a scene file: every key with its type, range, unit and meaning, once.

The reader (`form`) and the JSON schema are both made from what stands here.
"""

from typing import Annotated, Literal, TypeVar

from msgspec import Meta

from flankload.scene.belt_tables import Belt, LandFriction, LandLift, Pulley
from flankload.scene.drive_tables import Chain, SlackTension, Sprocket
from flankload.scene.table import (
    Angles,
    Length,
    NotNegative,
    Shift,
    Strips,
    Table,
    Text,
    Torques,
    about,
)


class InvoluteKeys(Table, frozen=True, kw_only=True):
    """Keys of an involute profile, transverse section, whatever makes its root."""

    module_mm: Annotated[Length, about("mm", "module")]
    pressure_angle_deg: Annotated[
        Annotated[float, Meta(ge=5, le=45)], about("deg", "pressure angle of the basic rack")
    ] = 20.0
    profile_shift: Annotated[Shift, about("-", "profile shift in modules")] = 0.0
    tip_diameter_mm: Annotated[Length, about("mm", "diameter of the tip circle")]
    tip_relief_um: Annotated[
        NotNegative | None, about("um", "tip relief at the tip circle, normal to the involute")
    ] = None
    tip_relief_start_diameter_mm: Annotated[
        Length | None, about("mm", "diameter at which the tip relief begins")
    ] = None
    tip_relief_shape: Annotated[
        Literal["linear", "parabolic"], about("", "shape of the tip relief over the roll angle")
    ] = "linear"
    tip_radius_mm: Annotated[
        Length | None, about("mm", "radius of the arc between flank and tip circle")
    ] = None
    tip_chamfer_mm: Annotated[
        Length | None, about("mm", "radial height of the chamfer between flank and tip circle")
    ] = None
    profile_crowning_um: Annotated[
        NotNegative | None, about("um", "profile crowning, normal to the involute")
    ] = None


class Geometry(InvoluteKeys, frozen=True, kw_only=True):
    """Keys of the profile of an external gear: its root is that of a generating rack."""

    dedendum_factor: Annotated[
        Annotated[float, Meta(gt=0, le=5)], about("-", "dedendum of the basic rack in modules")
    ] = 1.25
    fillet_radius_factor: Annotated[
        Annotated[float, Meta(ge=0, le=2)],
        about("-", "tip radius of the generating rack in modules; it makes the root fillet"),
    ] = 0.38


# Keys that several kinds of body have.
Teeth = Annotated[int, Meta(ge=3)]
Modulus = Annotated[float, Meta(ge=1e-3, le=1e9)]
YoungModulus = Annotated[Modulus, about("MPa", "Young's modulus")]
PoissonRatio = Annotated[Annotated[float, Meta(ge=0, lt=0.5)], about("-", "Poisson's ratio")]
Rigid = Annotated[bool, about("", "true: the body does not yield; no finite elements")]
PitchErrors = Annotated[
    tuple[float, ...],
    about(
        "um",
        "one deviation per tooth along the base tangent, positive = metal that touches early; in "
        "the order in which the teeth come into contact, from the tooth of pair 0",
    ),
]


class Gear(Geometry, frozen=True, kw_only=True, tag_field="kind", tag="gear"):
    """An external spur gear with a generated root fillet, held at its bore."""

    teeth: Annotated[Teeth, about("-", "number of teeth")]
    bore_diameter_mm: Annotated[Length, about("mm", "diameter of the bore, which is fixed")]
    young_modulus_MPa: YoungModulus = 206000.0
    poisson_ratio: PoissonRatio = 0.3
    rigid: Rigid = False
    pitch_errors_um: PitchErrors = ()

    @property
    def kind(self) -> str:
        """Kind of the body, as the scene file names it."""
        return "gear"

    @property
    def number_of_teeth(self) -> int:
        """Teeth, as every kind of body has them."""
        return self.teeth


class RingKeys(InvoluteKeys, frozen=True, kw_only=True):
    """Keys of a body whose teeth stand inwards."""

    teeth: Annotated[Teeth, about("-", "number of teeth")]
    profile_shift: Annotated[
        Shift,
        about(
            "-",
            "profile shift in modules, positive outwards: the space is as wide as the tooth of an "
            "external gear with the same shift",
        ),
    ] = 0.0
    root_diameter_mm: Annotated[Length, about("mm", "diameter of the root circle")]
    outer_diameter_mm: Annotated[Length, about("mm", "outside of the rim, which is fixed")]
    young_modulus_MPa: YoungModulus = 206000.0
    poisson_ratio: PoissonRatio = 0.3
    rigid: Rigid = False
    pitch_errors_um: PitchErrors = ()


class Ring(RingKeys, frozen=True, kw_only=True, tag_field="kind", tag="ring"):
    """An internal spur gear, held at the outside of its rim."""

    root_fillet_radius_mm: Annotated[
        Length | None,
        about(
            "mm",
            "radius of the arc that touches flank and root circle; absent = the largest, which "
            "rounds the whole root",
        ),
    ] = None

    @property
    def kind(self) -> str:
        """Kind of the body, as the scene file names it."""
        return "ring"

    @property
    def number_of_teeth(self) -> int:
        """Teeth, as every kind of body has them."""
        return self.teeth


SplineAngle = Annotated[
    Annotated[float, Meta(ge=5, le=45)], about("deg", "pressure angle of the basic rack")
]
IndexErrors = Annotated[
    tuple[float, ...],
    about(
        "um",
        "one deviation per tooth along the base tangent, positive = metal that touches early; "
        "entry j is tooth j, counted in the sense of the torque from the tooth of pair 0",
    ),
]
#: Root fillet of splines in modules, that of DIN 5480 for hobbed shafts.
SPLINE_FILLET = 0.16


class SplineShaft(InvoluteKeys, frozen=True, kw_only=True, tag_field="kind", tag="spline_shaft"):
    """An involute spline on a shaft, held at its bore; its root is that of a generating rack."""

    teeth: Annotated[Teeth, about("-", "number of teeth")]
    pressure_angle_deg: SplineAngle = 30.0
    root_diameter_mm: Annotated[
        Length, about("mm", "diameter of the root circle, which says how deep the rack cuts")
    ]
    fillet_radius_factor: Annotated[
        Annotated[float, Meta(ge=0, le=2)],
        about("-", "tip radius of the generating rack in modules; it makes the root fillet"),
    ] = SPLINE_FILLET
    bore_diameter_mm: Annotated[Length, about("mm", "diameter of the bore, which is fixed")]
    young_modulus_MPa: YoungModulus = 206000.0
    poisson_ratio: PoissonRatio = 0.3
    rigid: Rigid = False
    pitch_errors_um: IndexErrors = ()

    @property
    def kind(self) -> str:
        """Kind of the body, as the scene file names it."""
        return "spline_shaft"

    @property
    def number_of_teeth(self) -> int:
        """Teeth, as every kind of body has them."""
        return self.teeth

    @property
    def dedendum_factor(self) -> float:
        """Dedendum, in modules, of the rack that cuts this root circle."""
        return 0.5 * (self.teeth - self.root_diameter_mm / self.module_mm) + self.profile_shift


class SplineHub(RingKeys, frozen=True, kw_only=True, tag_field="kind", tag="spline_hub"):
    """An involute spline in a hub, held at the outside of its rim."""

    pressure_angle_deg: SplineAngle = 30.0
    root_fillet_radius_mm: Annotated[
        Length | None,
        about(
            "mm",
            f"radius of the arc that touches flank and root circle; absent = {SPLINE_FILLET} "
            "modules",
        ),
    ] = None
    pitch_errors_um: IndexErrors = ()

    @property
    def kind(self) -> str:
        """Kind of the body, as the scene file names it."""
        return "spline_hub"

    @property
    def number_of_teeth(self) -> int:
        """Teeth, as every kind of body has them."""
        return self.teeth


class Profile(Geometry, frozen=True, kw_only=True):
    """The exact profile of a body that comes as a mesh: the geometry keys of a gear."""

    kind: Annotated[Literal["gear"], about("", "kind of the profile")] = "gear"
    teeth: Annotated[
        Teeth | None,
        about("-", "number of teeth; absent = that of the mesh, else equal to it"),
    ] = None


class MeshBody(Table, frozen=True, kw_only=True, tag_field="kind", tag="mesh"):
    """A body as a mesh file: one sector with its cut faces, or the whole body with many flanks."""

    file: Annotated[Text, about("", "mesh file; relative to the folder of the scene file")]
    teeth: Annotated[
        Teeth | None,
        about(
            "-",
            "number of equal sectors of the body; a whole body: absent = as many as flank_sets",
        ),
    ] = None
    flank_set: Annotated[Text, about("", "set of the working flank's edges or nodes")] = "FLANK"
    flank_sets: Annotated[
        Annotated[tuple[Text, ...], Meta(min_length=1)] | None,
        about(
            "",
            "a whole body: sets of its working flanks, that of pair 0 first; no flank_set and no "
            "cut_sets then",
        ),
    ] = None
    fixed_set: Annotated[Text, about("", "set that is held (the bore)")] = "BORE"
    cut_sets: Annotated[tuple[Text, Text], about("", "sets of the sector's two cut faces")] = (
        "CUT_LEFT",
        "CUT_RIGHT",
    )
    reference_radius_mm: Annotated[
        Length | None,
        about(
            "mm",
            "radius that turns rotation into transmission error; needed without profile, else the "
            "base radius",
        ),
    ] = None
    profile: Annotated[
        Profile | None,
        about("", "the exact profile, where it is known; else the curve goes through the nodes"),
    ] = None
    one_material: Annotated[
        bool, about("", "true: groups of elements in the file are one material all the same")
    ] = False
    young_modulus_MPa: YoungModulus = 206000.0
    poisson_ratio: PoissonRatio = 0.3
    rigid: Rigid = False
    pitch_errors_um: PitchErrors = ()

    @property
    def kind(self) -> str:
        """Kind of the body, as the scene file names it."""
        return "mesh"

    @property
    def number_of_teeth(self) -> int:
        """Teeth as given, or as many as there are flanks."""
        return self.teeth or len(self.flank_sets or ())


class ComplianceBody(Table, frozen=True, kw_only=True, tag_field="kind", tag="compliance"):
    """A body whose flank and compliance come from a file, computed before, here or elsewhere."""

    file: Annotated[
        Text,
        about("", "compliance file (.npz, .csv); relative to the folder of the scene file"),
    ]
    rigid: Rigid = False
    pitch_errors_um: Annotated[PitchErrors, about("um", "absent = those of the file")] = ()

    @property
    def kind(self) -> str:
        """Kind of the body, as the scene file names it."""
        return "compliance"


#: One row of a cam's table.
ProfileRow = tuple[
    Annotated[float, Meta(ge=-360, le=720)],
    Annotated[float, Meta(ge=1e-3, le=1e5)],
]


class CamKeys(Table, frozen=True, kw_only=True):
    """What a cam and its follower have in common."""

    bore_diameter_mm: Annotated[Length, about("mm", "diameter of the bore, which is fixed")]
    young_modulus_MPa: YoungModulus = 206000.0
    poisson_ratio: PoissonRatio = 0.3
    rigid: Rigid = False

    @property
    def number_of_teeth(self) -> int:
        """One flank all around."""
        return 1

    @property
    def pitch_errors_um(self) -> tuple[float, ...]:
        """None: there is no pitch."""
        return ()


class Cam(CamKeys, frozen=True, kw_only=True, tag_field="kind", tag="cam"):
    """A disc cam by the table of its profile, held at its bore."""

    profile: Annotated[
        tuple[ProfileRow, ...] | None,
        about(
            "",
            "rows [angle in deg, radius in mm] around the cam, counter-clockwise; a smooth closed "
            "curve goes through them (periodic cubic spline). At position 0 angle 0 points from "
            "the cam's axis to that of the follower",
        ),
    ] = None
    profile_file: Annotated[
        Text | None,
        about(
            "",
            "the same as a .csv file with two columns, angle_deg and radius_mm; relative to the "
            "folder of the scene file",
        ),
    ] = None
    sense: Annotated[
        Literal["clockwise", "counter_clockwise"],
        about(
            "",
            "how the cam turns; clockwise: at position a its angle a points to the follower's "
            "axis. The follower is pressed onto the cam counter-clockwise",
        ),
    ] = "clockwise"

    @property
    def kind(self) -> str:
        """Kind of the body, as the scene file names it."""
        return "cam"


Place = Annotated[float, Meta(ge=-1e5, le=1e5)]


class Follower(CamKeys, frozen=True, kw_only=True, tag_field="kind", tag="follower"):
    """A lever that turns about its own axis and follows a cam with a roller or a flat."""

    arm_mm: Annotated[
        Length | None, about("mm", "distance of the roller's centre from the follower's axis")
    ] = None
    roller_radius_mm: Annotated[
        Length | None, about("mm", "radius of the roller, which is one piece with its arm")
    ] = None
    flat_offset_mm: Annotated[
        Place | None,
        about(
            "mm",
            "distance of the flat's line from the follower's axis, positive towards the cam",
        ),
    ] = None
    flat_from_mm: Annotated[
        Length | None,
        about("mm", "where the flat begins, along its line from the foot of the axis"),
    ] = None
    flat_to_mm: Annotated[Length | None, about("mm", "where it ends")] = None
    arm_width_mm: Annotated[
        Length | None,
        about(
            "mm",
            "width of the arm; absent = the roller's radius, or a fifth of the flat's end "
            "(flat_to_mm)",
        ),
    ] = None
    hub_diameter_mm: Annotated[
        Length | None,
        about("mm", "outside of the hub; absent = as large as bore and arm need it"),
    ] = None

    @property
    def kind(self) -> str:
        """Kind of the body, as the scene file names it."""
        return "follower"

    @property
    def has_roller(self) -> bool:
        """Whether it follows with a roller, not with a flat."""
        return self.roller_radius_mm is not None


class Pair(Table, frozen=True, kw_only=True):
    """How the bodies stand to each other."""

    center_distance_mm: Annotated[
        Length | None,
        about(
            "mm",
            "distance of the two axes as they stand: a centre-distance error is part of it, while "
            "teeth and flanks stay what they are; needed, but for splines",
        ),
    ] = None
    center_offset_mm: Annotated[
        Annotated[float, Meta(ge=0, le=1e5)] | None,
        about("mm", "distance of a spline's two axes; absent = 0, they are one"),
    ] = None
    face_width_mm: Annotated[Length, about("mm", "width over which the flanks touch")]

    @property
    def axes_apart_mm(self) -> float:
        """Distance of the two axes."""
        return self.center_distance_mm or self.center_offset_mm or 0.0


class Load(Table, frozen=True, kw_only=True):
    """What body 1 carries."""

    torque_Nm: Annotated[
        NotNegative | Torques,
        about(
            "N m", "torque on body 1, or a list: one result per torque; 0 is the unloaded motion"
        ),
    ]
    slack_tension_N: SlackTension | None = None


class Positions(Table, frozen=True, kw_only=True):
    """Where the pair is looked at."""

    count: Annotated[
        Annotated[int, Meta(ge=1, le=100000)],
        about(
            "-",
            "positions per tooth pitch of body 1 (per turn of a cam), equally spaced; with "
            "adaptive those to begin with; concentric splines have one",
        ),
    ] = 32
    angles_deg: Annotated[
        Angles | None,
        about(
            "deg", "angles of body 1 (of a cam: of the cam) from position zero, instead of count"
        ),
    ] = None
    pitches: Annotated[
        Annotated[int, Meta(ge=1, le=10000)] | Literal["hunting"],
        about(
            "-",
            "tooth pitches of body 1 that the positions run over; 'hunting' = until all repeats: "
            "with pitch errors on both bodies the least common multiple of their tooth numbers, "
            "without any one pitch",
        ),
    ] = 1
    adaptive: Annotated[
        bool,
        about(
            "",
            "true: more positions where the transmission error bends, the same for all torques, "
            "until its harmonics 1 to 3 and its peak to peak are known to the tolerance",
        ),
    ] = False
    tolerance: Annotated[
        Annotated[float, Meta(ge=1e-5, le=0.1)] | None,
        about(
            "-",
            "with adaptive: what the positions may leave in doubt of a harmonic (of a tenth of "
            "the largest, where it is smaller) and of the peak to peak; absent = 0.3 of "
            "accuracy.tolerance",
        ),
    ] = None
    max_count: Annotated[
        Annotated[int, Meta(ge=1, le=100000)] | None,
        about(
            "-",
            "with adaptive: most positions per tooth pitch; where they do not suffice a warning "
            "says what is left in doubt; absent = 8 count",
        ),
    ] = None
    driver: Annotated[
        Literal["body_1", "body_2"], about("", "the driving body; decides the sliding direction")
    ] = "body_1"

    @property
    def most_per_pitch(self) -> int:
        """Most adaptive positions per tooth pitch."""
        return self.max_count or 8 * self.count


LARGEST_COEFFICIENT = 2.0
Coefficient = Annotated[float, Meta(ge=0, le=LARGEST_COEFFICIENT)]
#: Roll position and coefficient there. (msgspec crashes on tuple[float, float] in a list.)
CoefficientRow = Annotated[tuple[float, ...], Meta(min_length=2, max_length=2)]
Coefficients = Annotated[tuple[Coefficient | CoefficientRow, ...], Meta(min_length=1)]


Rise = Annotated[float, Meta(ge=-273, le=2000)]
Expansion = Annotated[float, Meta(ge=0, le=1e-3)]
Density = Annotated[float, Meta(ge=1, le=1e5)]
Number = TypeVar("Number")
#: One for body 1, one for body 2. (msgspec crashes on tuple[float, float] in a union.)
PerBody = Annotated[tuple[Number, ...], Meta(min_length=2, max_length=2)]


class EffectsAsked(Table, frozen=True, kw_only=True):
    """Effects beyond elastic bodies and their given geometry; what is absent is not simulated."""

    choose: Annotated[
        Literal["auto"] | None,
        about(
            "",
            "'auto': effects that change less than a quarter of accuracy.tolerance are left out, "
            "those that change more are put in where the scene leaves them open; absent = effects "
            "are as the keys say",
        ),
    ] = None
    friction_coefficient: Annotated[
        Coefficient | Coefficients | None,
        about(
            "-",
            "Coulomb friction between the flanks: a number; or one per tooth of body 1, in the "
            "order in which the teeth come into contact, from the tooth of pair 0; or rows of roll "
            "position in mm (along the line of action from the pitch point, positive towards "
            "recess as body 1's torque turns it, whoever drives; ascending) and coefficient, "
            "linear between; 0 = no friction",
        ),
    ] = None
    near_field: Annotated[
        Literal["analytic", "nodes"],
        about(
            "",
            "how flanks give way near a force: 'analytic' = pressure modes and a half-plane's "
            "logarithm; 'nodes' = forces at the nodes of the flanks, with tables between these "
            "(a fifth of the Hertz half-width apart, or accuracy.flank_element_mm)",
        ),
    ] = "analytic"
    influence: Annotated[
        Literal["small", "finite"],
        about(
            "",
            "influence numbers: 'small' = of small forces; 'finite' = of the forces found, by "
            "where the deformed flank cuts the circle of a pair",
        ),
    ] = "small"
    root_stress: Annotated[
        bool,
        about(
            "",
            "true: stress along both root fillets of the teeth in mesh, of each body that yields",
        ),
    ] = False
    contact: Annotated[
        Literal["pairs", "lumped"],
        about(
            "",
            "lumped: one unknown for each place of contact, as wide as Hertz contact (two to "
            "three times as fast, no strips; not where flanks conform); pairs: pressure as it is",
        ),
    ] = "pairs"
    body: Annotated[
        Literal["whole", "segment", "tooth"],
        about(
            "",
            "how much of a body yields: all of it; 'segment': the sectors of segment_teeth around "
            "the teeth in question, both ends held; 'tooth': one tooth, its cuts held. Stiffer, "
            "and hardly cheaper: for comparison with such models",
        ),
    ] = "whole"
    segment_teeth: Annotated[
        Annotated[int, Meta(ge=3, le=9999)] | None,
        about("-", "teeth of the segment, an odd number, with body = 'segment'"),
    ] = None
    tooth_coupling: Annotated[
        bool, about("", "false: a load on a tooth moves no other tooth of the body")
    ] = True
    temperature_rise_K: Annotated[
        Rise | PerBody[Rise] | None,
        about(
            "K",
            "temperature of the bodies above that at which their dimensions hold: a number, or one "
            "for each body; the centre distance stays what it is",
        ),
    ] = None
    thermal_expansion_per_K: Annotated[
        Expansion | PerBody[Expansion] | None,
        about("1/K", "linear thermal expansion of the bodies, or of each; absent = 11.5e-6, steel"),
    ] = None
    support_expansion_per_K: Annotated[
        Expansion | PerBody[Expansion] | None,
        about(
            "1/K",
            "the same of what holds them (shaft in the bore, housing around a ring), which is as "
            "warm; 0 = it stays as it is; absent = as the body, which then grows without stress",
        ),
    ] = None
    speed_rpm: Annotated[
        Annotated[float, Meta(ge=0, le=2e5)] | None,
        about(
            "1/min",
            "speed of body 1, which stretches the bodies; body 2 turns by the ratio of the teeth",
        ),
    ] = None
    density_kg_m3: Annotated[
        Density | PerBody[Density] | None,
        about("kg/m^3", "density of the bodies, or of each; absent = 7850, steel"),
    ] = None
    large_displacement: Annotated[
        bool,
        about(
            "",
            "true: a chain's rollers are followed to where they stand, in place of one linear "
            "solution about their places on the pitch circle",
        ),
    ] = False
    coast_flank: Annotated[
        bool,
        about(
            "",
            "true: the flanks on the other side of the teeth can carry, too; teeth may then be "
            "wider than the spaces (press fit, negative backlash)",
        ),
    ] = False
    tip_contact: Annotated[
        bool,
        about(
            "",
            "false: tip corners, tip roundings and chamfers, and root fillets touch nothing; the "
            "active flanks alone carry",
        ),
    ] = True
    land_friction: LandFriction = 0.0
    land_lift: LandLift = False


class Accuracy(Table, frozen=True, kw_only=True):
    """How exact, and with which knobs; a knob that is absent follows from the tolerance."""

    tolerance: Annotated[
        Annotated[float, Meta(ge=1e-4, le=0.1)], about("-", "wanted relative error")
    ] = 0.01
    plane: Annotated[
        Literal["strain", "stress"], about("", "plane strain (wide gears) or plane stress (discs)")
    ] = "strain"
    estimate: Annotated[bool, about("", "false skips the error estimate")] = True
    flank_element_mm: Annotated[
        Length | None, about("mm", "length of the finite elements along the flank")
    ] = None
    modes: Annotated[
        Annotated[int, Meta(ge=3, le=12)] | None, about("-", "pressure modes per flank")
    ] = None
    strips_per_half_width: Annotated[
        Strips | None, about("-", "contact strips per Hertz half-width")
    ] = None
    corner_strips_per_half_width: Annotated[
        Strips | None, about("-", "the same where a sharp tip corner carries")
    ] = None
    zone_half_widths: Annotated[
        Annotated[float, Meta(gt=1, le=20)] | None,
        about("-", "half-width of the strips' zone in Hertz half-widths"),
    ] = None


class SceneFile(Table, frozen=True, kw_only=True):
    """A whole scene file."""

    name: Annotated[Text | None, about("", "name of the scene; absent = name of the file")] = None
    body_1: Annotated[
        Gear | SplineShaft | Follower | Sprocket | Pulley | MeshBody | ComplianceBody,
        about("", "free to turn, carries the torque"),
    ]
    body_2: Annotated[
        Gear | Ring | SplineHub | Cam | Chain | Belt | MeshBody | ComplianceBody,
        about("", "stands at its kinematic angle"),
    ]
    pair: Annotated[
        Pair | None, about("", "needed, but for chains and belts, which know none of it")
    ] = None
    load: Load
    positions: Positions = Positions()
    effects: EffectsAsked = EffectsAsked()
    accuracy: Accuracy = Accuracy()
