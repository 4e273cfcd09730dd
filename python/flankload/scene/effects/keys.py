"""The table [effects]: the keys by which a scene requests effects."""

from typing import Annotated, Any, Literal, TypeVar

from msgspec import Meta

from flankload.scene.table import Table, about

LARGEST_COEFFICIENT = 2.0
Coefficient = Annotated[float, Meta(ge=0, le=LARGEST_COEFFICIENT)]
#: Roll position and friction coefficient. (msgspec crashes on tuple[float, float] in a list.)
CoefficientRow = Annotated[tuple[float, ...], Meta(min_length=2, max_length=2)]
Coefficients = Annotated[tuple[Coefficient | CoefficientRow, ...], Meta(min_length=1)]
Rise = Annotated[float, Meta(ge=-273, le=2000)]
Expansion = Annotated[float, Meta(ge=0, le=1e-3)]
Density = Annotated[float, Meta(ge=1, le=1e5)]
Number = TypeVar("Number")
#: One value per body. (msgspec crashes on tuple[float, float] in a union.)
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
    dimension: Annotated[
        Literal[2, 3] | None,
        about(
            "-",
            "3: the bodies are three-dimensional, even if nothing varies along the axis; absent = "
            "3 where a helix angle, a lead modification, unequal face widths or a misalignment "
            "require it, else 2",
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
        about(
            "1/K",
            "linear thermal expansion of the bodies, or of each; absent = 11.5e-6, steel",
            usual=(5e-7, 5e-4),
        ),
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
        about(
            "kg/m^3",
            "density of the bodies, or of each; absent = 7850, steel",
            usual=(200.0, 25000.0),
        ),
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
    land_friction: Annotated[
        Annotated[float, Meta(ge=-1, le=1)],
        about(
            "-",
            "coefficient of friction between the lands of a belt and its pulley, all of them "
            "sliding; positive: helps the teeth, negative: opposes them",
        ),
    ] = 0.0
    land_lift: Annotated[
        bool,
        about("", "true: the lands of a belt may lift off its pulley; needs body_2.prestress_N"),
    ] = False
    beyond_limits: Annotated[
        bool,
        about(
            "",
            "true: a scene that breaks a premise of the model (docs/guide/limits.md) is solved all "
            "the same, its error estimates marked as outside the model's limits",
        ),
    ] = False

    @property
    def has_friction(self) -> bool:
        """Whether any friction coefficient of the flanks is not 0."""
        return has_amount(self.friction_coefficient)


def has_amount(value: float | tuple[Any, ...] | None) -> bool:
    """Whether a number, any number of a list, or any second entry of its rows is not 0."""
    if not isinstance(value, tuple):
        return bool(value)
    return any(row[1] if isinstance(row, tuple) else row for row in value)
