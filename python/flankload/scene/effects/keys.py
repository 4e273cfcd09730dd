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
    """Effects beyond elastic bodies of given geometry; effects without keys are not computed."""

    choose: Annotated[
        Literal["auto"] | None,
        about(
            "'auto': effects that change the result by less than a quarter of accuracy.tolerance "
            "are omitted; those that change it by more are included unless the scene sets their "
            "keys; absent = effects as set by their keys"
        ),
    ] = None
    dimension: Annotated[
        Literal[2, 3] | None,
        about(
            "3: the bodies are three-dimensional, even if nothing varies along the axis; absent = "
            "3 where a helix angle, a lead modification, unequal face widths or a misalignment "
            "require it, else 2",
            "-",
        ),
    ] = None
    friction_coefficient: Annotated[
        Coefficient | Coefficients | None,
        about(
            "coefficient of Coulomb friction between the flanks: a number; or one per tooth of "
            "body 1, in the order in which the teeth come into contact, from the tooth of pair 0; "
            "or rows of roll position in mm (ascending; along the line of action from the pitch "
            "point, positive towards recess for rotation in the sense of body 1's torque, "
            "whichever body drives) and coefficient, interpolated linearly; 0 = no friction",
            "-",
        ),
    ] = None
    near_field: Annotated[
        Literal["analytic", "nodes"],
        about(
            "model of the local deformation near a force: 'analytic' = pressure modes and the "
            "logarithm of a half-plane; 'nodes' = forces at the nodes of the flanks, with tables "
            "between the nodes (spacing: a fifth of the Hertz half-width, or "
            "accuracy.flank_element_mm)"
        ),
    ] = "analytic"
    influence: Annotated[
        Literal["small", "finite"],
        about(
            "influence coefficients: 'small' = for small forces; 'finite' = for the actual "
            "forces, from the intersection of the deformed flank with the circle of a contact "
            "pair"
        ),
    ] = "small"
    root_stress: Annotated[
        bool,
        about("true: stress along both root fillets of the teeth in mesh, for each elastic body"),
    ] = False
    contact: Annotated[
        Literal["pairs", "lumped"],
        about(
            "'pairs': pressure resolved by contact pairs; 'lumped': one unknown per place of "
            "contact, with the width of a Hertz contact (two to three times as fast, no strips; "
            "not for conforming flanks; the default in three dimensions, in slices)"
        ),
    ] = "pairs"
    body: Annotated[
        Literal["whole", "segment", "tooth"],
        about(
            "elastic part of a body: 'whole'; 'segment' = the sectors of segment_teeth teeth "
            "around the loaded tooth, both ends fixed; 'tooth' = one tooth, cuts fixed. The last "
            "two are stiffer and hardly cheaper; they serve for comparison with such models"
        ),
    ] = "whole"
    segment_teeth: Annotated[
        Annotated[int, Meta(ge=3, le=9999)] | None,
        about("number of teeth of the segment, odd; with body = 'segment'", "-"),
    ] = None
    tooth_coupling: Annotated[
        bool, about("false: a load on a tooth does not deform other teeth of the body")
    ] = True
    mesh_coupling: Annotated[
        bool,
        about(
            "false: forces in a gear mesh of a stage or a train do not deform the bodies in its "
            "other meshes"
        ),
    ] = True
    temperature_rise_K: Annotated[
        Rise | PerBody[Rise] | None,
        about(
            "temperature of the bodies above the temperature of their dimensions: a number, or "
            "one for each body; the centre distance does not change",
            "K",
        ),
    ] = None
    thermal_expansion_per_K: Annotated[
        Expansion | PerBody[Expansion] | None,
        about(
            "coefficient of linear thermal expansion: one for both bodies, or one for each; "
            "absent = 11.5e-6, steel",
            "1/K",
            usual=(5e-7, 5e-4),
        ),
    ] = None
    support_expansion_per_K: Annotated[
        Expansion | PerBody[Expansion] | None,
        about(
            "the same coefficient for their supports (shaft in the bore, housing around a ring), "
            "which have the same temperature; 0 = rigid support without expansion; absent = that "
            "of the body, which then expands without stress",
            "1/K",
        ),
    ] = None
    speed_rpm: Annotated[
        Annotated[float, Meta(ge=0, le=2e5)] | None,
        about(
            "speed of body 1 for the centrifugal expansion of the bodies, and for power and power "
            "loss in W; the speed of body 2 follows from the ratio",
            "1/min",
        ),
    ] = None
    density_kg_m3: Annotated[
        Density | PerBody[Density] | None,
        about(
            "density: one for both bodies, or one for each; absent = 7850, steel",
            "kg/m^3",
            usual=(200.0, 25000.0),
        ),
    ] = None
    large_displacement: Annotated[
        bool,
        about(
            "true: equilibrium of a chain at the displaced positions of its rollers, instead of "
            "one linear solution about their positions on the pitch circle"
        ),
    ] = False
    coast_flank: Annotated[
        bool,
        about(
            "true: the coast flanks can carry load as well; teeth may then be wider than the "
            "spaces (press fit, negative backlash)"
        ),
    ] = False
    tip_contact: Annotated[
        bool,
        about(
            "false: no contact at tip corners, tip roundings, chamfers and root fillets; only the "
            "active flanks carry load"
        ),
    ] = True
    land_friction: Annotated[
        float,
        Meta(ge=-1, le=1),
        about(
            "coefficient of friction between the lands of a belt and its pulley, all of which "
            "slide; positive: friction assists the teeth, negative: it opposes them",
            "-",
        ),
    ] = 0.0
    land_lift: Annotated[
        bool,
        about("true: the lands of a belt can lift off its pulley; requires body_2.prestress_N"),
    ] = False
    beyond_limits: Annotated[
        bool,
        about(
            "true: a scene that violates a premise of the model (docs/guide/limits.md) is solved "
            "nevertheless; its error estimates are marked as outside the limits of the model"
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
