"""Result quantities of a timing belt beyond its tooth forces: tensions, lands, row of springs."""

from __future__ import annotations

from dataclasses import dataclass, field, fields
from math import degrees, isfinite
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from flankload.base.card import Card
from flankload.base.text_table import text_table

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import NDArray

    from flankload.result.result import Result

    Floats = NDArray[np.float64]


#: Suffix of the row of a land that lifts.
HERE = "the land lifts here"
#: Forces below this part of the tight tension count as zero.
ROUNDING = 1e-9


@dataclass(frozen=True, eq=False, repr=False)
class BeltDrive(Card):
    """A belt on its pulley at P positions, S teeth; a land before each tooth and a last one.

    Entries of teeth and lands that are not on the pulley at a position are NaN.

    Attributes
    ----------
    wrap_angle_rad : float
    tooth_stiffness_N_per_mm, cord_stiffness_N : float
        Equivalent row of springs: stiffness of a tooth, and tension divided by strain from tooth
        to tooth.
    prestress_N : float
        Mean tension in the geometric stiffness of the elements.
    land_friction : float
    tight_tension_N, slack_tension_N : (P,) arrays
        Tensions of the strands.
    land_friction_N : (P,) array
        Sum of the friction forces of the lands that relieve the teeth, on the pitch circle.
    last_land_N, last_land_lift_um : (P,) arrays
        Force of the pulley on the land behind the last of the S teeth, and its lift off the pulley.
    tension_behind_N : (P, S) array
        Tension of the cord, or of the tight strand, before each tooth.
    land_before_N : (P, S) array
        Force of the pulley on the land before each tooth; negative: a fixed land that would lift.
    land_lift_um : (P, S) array
        Largest lift of that land off the pulley; 0 for fixed lands.
    pulley_coupling_um_per_N : (w - 1,) array
        Row of springs: displacement of the teeth 1, 2, … pitches from a loaded one because
        of an elastic pulley; empty for a rigid pulley.
    """

    wrap_angle_rad: float
    tooth_stiffness_N_per_mm: float
    cord_stiffness_N: float
    prestress_N: float
    land_friction: float
    tight_tension_N: Floats
    slack_tension_N: Floats
    land_friction_N: Floats
    last_land_N: Floats
    last_land_lift_um: Floats
    tension_behind_N: Floats
    land_before_N: Floats
    land_lift_um: Floats
    pulley_coupling_um_per_N: Floats = field(default_factory=lambda: np.zeros(0))

    #: Name of the drive in a report.
    name: ClassVar[str] = "belt"
    #: Word for a site, and for several.
    words_for_sites: ClassVar[tuple[str, str]] = ("tooth", "teeth")
    #: Arrays over the positions, with their units.
    along: ClassVar[dict[str, str]] = {
        "tight_tension_N": "N",
        "slack_tension_N": "N",
        "land_friction_N": "N",
        "last_land_N": "N",
        "last_land_lift_um": "um",
    }
    #: Arrays over positions and sites, with their units.
    over_sites: ClassVar[dict[str, str]] = {
        "tension_behind_N": "N",
        "land_before_N": "N",
        "land_lift_um": "um",
    }

    def as_dict(self) -> dict[str, Any]:
        """The drive in the form of the JSON result."""
        return {item.name: getattr(self, item.name) for item in fields(self)}

    @property
    def lands_N(self) -> Floats:
        """(P, S + 1) Forces of the pulley on all lands, from the tight strand."""
        return np.column_stack([self.land_before_N, self.last_land_N])

    @property
    def lifting(self) -> NDArray[np.bool_]:
        """(P, S + 1) Lands that lift as a whole, or would lift if they were not fixed."""
        least = ROUNDING * self.tight_tension_N[:, None]
        lift = np.column_stack([self.land_lift_um, self.last_land_lift_um])
        return np.asarray((self.lands_N < -least) | ((self.lands_N < least) & (lift > 0)))

    def drawn_force(self, result: Result, p: int, s: int) -> tuple[float, float, float]:
        """Polar angle, radius and direction of a force on the wheel, for a drawing.

        Parameters
        ----------
        result : Result
            Result of this drive.
        p, s : int
            Indices of the position and of the site.

        Returns
        -------
        angle_rad, radius_mm, direction_rad : float
            The direction is an angle, too.
        """
        drawing = result.drawing
        angle = float(drawing.angle_1[p] + 2 * np.pi / drawing.teeth_1 * s)
        radius = result.reference_radius_mm * (1.0 + 0.35 * result.pitch_rad)
        return angle, radius, angle + 0.5 * np.pi

    def rows(self, result: Result) -> Iterator[str]:
        """A row per position if there are several, then one per tooth at the largest force.

        Parameters
        ----------
        result : Result
            Result of this drive.
        """
        p = int(np.argmax(result.site_force_N.max(axis=1)))
        if result.position_rad.size > 1:
            yield from _rows_of_positions(result, self)
            yield ""
        yield f"teeth from the tight strand on, at {degrees(result.position_rad[p]):.3f} deg"
        yield from text_table(
            [
                ("tooth", "force", "share", "tension before", "land before"),
                ("", "N", "%", "N", "N"),
                *_cells_of_teeth(result, self, p),
            ]
        )

    def pictures(self, result: Result) -> tuple[str, ...]:
        """Names of the plots of the drive."""
        several = result.position_rad.size > 1
        names = ("belt_on_pulley", "load_around_wrap")
        return (*names, *("transmission_error", "force_through_wrap") * several)

    def words(self) -> str:
        """Text of a report."""
        text = (
            f"strand tensions {self.tight_tension_N.max():.4g} and "
            f"{self.slack_tension_N.max():.4g} N; equivalent springs: tooth "
            f"{self.tooth_stiffness_N_per_mm:.4g} N/mm, cord on its lands "
            f"{self.cord_stiffness_N:.4g} N"
        )
        if self.land_friction:
            text += f", friction of the lands carries {self.land_friction_N.max():.4g} N"
        return text


def _cells_of_teeth(result: Result, drive: BeltDrive, p: int) -> Iterator[tuple[str, ...]]:
    """A row per tooth, and one per land behind the last tooth."""
    slack = f"{drive.slack_tension_N[p]:.1f}"
    for s, site in enumerate(result.sites):
        if not isfinite(drive.land_before_N[p, s]):
            continue
        land = (f"{drive.land_before_N[p, s]:.1f}", HERE * bool(drive.lifting[p, s]))
        if not isfinite(drive.tension_behind_N[p, s]):
            yield "end", "", "", slack, *land
            continue
        yield (
            f"{site}",
            f"{result.site_force_N[p, s]:.1f}",
            f"{100 * result.load_share[p, s]:.2f}",
            f"{drive.tension_behind_N[p, s]:.1f}",
            *land,
        )
    if isfinite(drive.last_land_N[p]):
        lifts = HERE * bool(drive.lifting[p, -1])
        yield "end", "", "", slack, f"{drive.last_land_N[p]:.1f}", lifts


def _rows_of_positions(result: Result, drive: BeltDrive) -> Iterator[str]:
    rows: list[tuple[str, ...]] = [
        ("position", "transm. error", "first tooth", "teeth loaded", "most on one", "least land"),
        ("deg", "um", "", "", "N", "N"),
    ]
    for p in range(result.position_rad.size):
        rows.append(
            (
                f"{degrees(result.position_rad[p]):.3f}",
                f"{result.transmission_error_um[p]:.3f}",
                f"{result.sites[np.isfinite(drive.tension_behind_N[p])][0]}",
                f"{result.loaded_pairs[p]}",
                f"{result.site_force_N[p].max():.1f}",
                f"{np.nanmin(drive.lands_N[p]):.1f}",
                "a land lifts" * bool(drive.lifting[p].any()),
            )
        )
    yield from text_table(rows)
