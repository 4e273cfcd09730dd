"""What a timing belt has beyond the forces on its teeth: tensions, lands, its row of springs."""

from __future__ import annotations

from dataclasses import dataclass, field, fields
from math import degrees, isfinite
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import NDArray

    from flankload.result.result import Result

    Floats = NDArray[np.float64]


#: Forces below this part of the tight tension are none.
ROUNDING = 1e-9


@dataclass(frozen=True, eq=False)
class BeltDrive:
    """A belt on its pulley at P positions, S teeth; a land before each tooth and one behind all.

    What is not on the pulley at a position has no number there.

    Attributes
    ----------
    wrap_angle_rad : float
    tooth_stiffness_N_per_mm, cord_stiffness_N : float
        Of the row of springs that stands for the belt: of a tooth, and tension over strain from
        tooth to tooth.
    prestress_N : float
        Mean tension that the elements know of.
    land_friction : float
    tight_tension_N, slack_tension_N : (P,) arrays
        Of the strands.
    land_friction_N : (P,) array
        That all lands together take off the teeth, on the pitch circle.
    last_land_N, last_land_lift_um : (P,) arrays
        Force of the pulley on the land behind the last of the S teeth, and its way off the pulley.
    tension_behind_N : (P, S) array
        Of the cord, or the tight strand, before each tooth.
    land_before_N : (P, S) array
        Force of the pulley on the land before each tooth; negative: the land lifts here, or would.
    land_lift_um : (P, S) array
        Largest way of that land off the pulley; 0 where lands are held.
    pulley_coupling_um_per_N : (w - 1,) array
        Of the row of springs: by how much the pulley lets teeth go that stand 1, 2, … pitches from
        a loaded one; empty where it is rigid.
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

    #: What the thing is called in a report.
    name: ClassVar[str] = "belt"
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
        """As the JSON of a result has it."""
        return {item.name: getattr(self, item.name) for item in fields(self)}

    @property
    def lands_N(self) -> Floats:
        """(P, S + 1) Forces of the pulley on all lands, from the tight strand."""
        return np.column_stack([self.land_before_N, self.last_land_N])

    @property
    def lifting(self) -> NDArray[np.bool_]:
        """(P, S + 1) Lands that lift as a whole, or would if they were not held."""
        least = ROUNDING * self.tight_tension_N[:, None]
        lift = np.column_stack([self.land_lift_um, self.last_land_lift_um])
        return np.asarray((self.lands_N < -least) | ((self.lands_N < least) & (lift > 0)))

    def rows(self, result: Result) -> Iterator[str]:
        """A row per position if there are several, then one per tooth where one carries most.

        Parameters
        ----------
        result : Result
            Of this drive.

        Yields
        ------
        str
        """
        p = int(np.argmax(result.site_force_N.max(axis=1)))
        if result.position_rad.size > 1:
            yield from _rows_of_positions(result, self)
            yield ""
        yield f"teeth from the tight strand on, at {degrees(result.position_rad[p]):.3f} deg"
        heads = ("tooth", "   force", "share", "tension before", "land before")
        units = ("", "N", "%", "N", "N")
        for texts in (heads, units):
            yield _line(texts, heads)
        for s, site in enumerate(result.sites):
            if not isfinite(self.land_before_N[p, s]):
                continue
            on = isfinite(self.tension_behind_N[p, s])
            values = (
                f"{site}" if on else "end",
                f"{result.site_force_N[p, s]:.1f}" if on else "",
                f"{100 * result.load_share[p, s]:.2f}" if on else "",
                f"{self.tension_behind_N[p, s] if on else self.slack_tension_N[p]:.1f}",
                f"{self.land_before_N[p, s]:.1f}",
            )
            mark = "  the land lifts here" if self.lifting[p, s] else ""
            yield _line(values, heads) + mark
        if isfinite(self.last_land_N[p]):
            ends = ("end", "", "", f"{self.slack_tension_N[p]:.1f}", f"{self.last_land_N[p]:.1f}")
            yield _line(ends, heads) + ("  the land lifts here" if self.lifting[p, -1] else "")

    def words(self) -> str:
        """What a report quotes."""
        text = (
            f"strands {self.tight_tension_N.max():.4g} and {self.slack_tension_N.max():.4g} N, as "
            f"springs: a tooth {self.tooth_stiffness_N_per_mm:.4g} N/mm, the cord on its lands "
            f"{self.cord_stiffness_N:.4g} N"
        )
        if self.land_friction:
            text += f", friction of the lands takes {self.land_friction_N.max():.4g} N"
        return text


def _rows_of_positions(result: Result, drive: BeltDrive) -> Iterator[str]:
    heads = (
        "position",
        "transm. error",
        "first tooth",
        "teeth loaded",
        "most on one",
        "least land",
    )
    units = ("deg", "um", "", "", "N", "N")
    for texts in (heads, units):
        yield _line(texts, heads)
    for p in range(result.position_rad.size):
        values = (
            f"{degrees(result.position_rad[p]):.3f}",
            f"{result.transmission_error_um[p]:.3f}",
            f"{result.sites[np.isfinite(drive.tension_behind_N[p])][0]}",
            f"{result.loaded_pairs[p]}",
            f"{result.site_force_N[p].max():.1f}",
            f"{np.nanmin(drive.lands_N[p]):.1f}",
        )
        yield _line(values, heads) + ("  a land lifts" if drive.lifting[p].any() else "")


def _line(texts: tuple[str, ...], heads: tuple[str, ...]) -> str:
    return "  ".join(f"{text:>{len(head)}}" for text, head in zip(texts, heads, strict=True))
