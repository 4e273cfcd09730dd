"""The table [accuracy]: the tolerance and parameters of the discretization."""

from typing import Annotated, Literal

from msgspec import Meta

from flankload.scene.table import Length, Table, about

Strips = Annotated[float, Meta(ge=2, le=200)]


class Accuracy(Table, frozen=True, kw_only=True):
    """Tolerance and discretization; parameters that are absent follow from the tolerance."""

    tolerance: Annotated[
        float,
        Meta(ge=1e-4, le=0.1),
        about(
            "requested relative error of transmission error, load share, peak pressure off sharp "
            "corners and secant stiffness; if set, it determines the discretization parameters "
            "that are not set",
            "-",
        ),
    ] = 0.01
    plane: Annotated[
        Literal["strain", "stress"], about("plane strain (wide gears) or plane stress (discs)")
    ] = "strain"
    estimate: Annotated[bool, about("false: no error estimate")] = True
    tangents: Annotated[
        bool,
        about(
            "false: the tangent stiffness keeps the contact zones fixed: 0.1 to 0.3 % smaller, in "
            "three quarters of the time of the sweep"
        ),
    ] = True
    flank_element_mm: Annotated[
        Length | None, about("length of the finite elements along the flank", "mm")
    ] = None
    modes: Annotated[
        Annotated[int, Meta(ge=3, le=12)] | None, about("pressure modes per flank", "-")
    ] = None
    strips_per_half_width: Annotated[
        Strips | None, about("contact strips per Hertz half-width", "-")
    ] = None
    corner_strips_per_half_width: Annotated[
        Strips | None, about("the same at sharp tip corners that carry load", "-")
    ] = None
    zone_half_widths: Annotated[
        Annotated[float, Meta(gt=1, le=20)] | None,
        about("half-width of the zone of strips in Hertz half-widths", "-"),
    ] = None
    slices: Annotated[
        Annotated[int, Meta(ge=1, le=200)] | None,
        about("three dimensions: slices over the common face width", "-"),
    ] = None
    line_load_length_mm: Annotated[
        Length | None,
        about(
            "three dimensions: length over which the largest line load, K_Hbeta and the line load "
            "factors are means (absent: a 28th of the common face width)",
            "mm",
        ),
    ] = None
    axial_degree: Annotated[
        Annotated[int, Meta(ge=4, le=16)] | None,
        about("three dimensions: degree of the displacements along the axis", "-"),
    ] = None
    load_degree_z: Annotated[
        Annotated[int, Meta(ge=0, le=12)] | None,
        about(
            "three dimensions: degree of the pressure modes along the axis, at most "
            "accuracy.axial_degree - 4",
            "-",
        ),
    ] = None
