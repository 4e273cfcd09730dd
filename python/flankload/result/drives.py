"""Quantities of a belt or a chain beyond its contact forces: tensions, lands, margins."""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass, field, fields
from math import degrees, isfinite
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from flankload.base.card import Card
from flankload.base.rounding import TIE
from flankload.base.text_table import number, text_table
from flankload.result.engagement import Engagement

if TYPE_CHECKING:
    from collections.abc import Iterator

    from flankload.base.arrays import Flags, Floats, Numbers
    from flankload.result.result import Result


#: Suffix of the row of a land that lifts.
HERE = "the land lifts here"


class Drive(Card, Engagement):
    """A belt or a chain on its wheel at P positions, with S sites from the tight strand on.

    The metadata of arrays have their unit by their axes, "P" or "PS".
    """

    #: Name of the drive in a report, and of its quantities in JSON.
    name: ClassVar[str]
    key: ClassVar[str] = "drive"
    has_mesh_orders = True
    has_pressures = False
    draws_pressures = False
    drawn_bodies: ClassVar[int | None] = 1

    @classmethod
    def units(cls, axes: str) -> dict[str, str]:
        """Units of the arrays with these axes: "P", positions, or "PS", positions and sites."""
        every = fields(cls)  # type: ignore[arg-type]
        return {item.name: item.metadata[axes] for item in every if axes in item.metadata}

    def as_dict(self) -> dict[str, Any]:
        """The drive in the form of the JSON result, without the results of its meshes."""
        names = (item.name for item in fields(self))  # type: ignore[arg-type]
        return {name: getattr(self, name) for name in names if name != "meshes"}

    def summary(self, result: Result) -> dict[str, Any]:
        """Further entries of the summary of a result."""
        return {}

    @abstractmethod
    def words(self) -> str:
        """Text of a report."""

    def _title_of_sites(self, result: Result, p: int) -> str:
        angle = degrees(result.position_rad[p])
        return f"{self.words_for_sites[1]} from the tight strand on, at {angle:.3f} deg"


def _site_angle(result: Result, p: int, s: int) -> float:
    """Polar angle of a site in a drawing."""
    return float(result.drawing.angle_1[p] + 2 * np.pi / result.drawing.teeth_1 * s)


def _position_cells(result: Result, p: int) -> tuple[str, str]:
    """Position and transmission error."""
    return f"{degrees(result.position_rad[p]):.3f}", f"{result.transmission_error_um[p]:.3f}"


def _load_cells(result: Result, p: int, s: int) -> tuple[str, str, str]:
    """Number of a site, its force and its share."""
    share = f"{100 * result.load_share[p, s]:.2f}"
    return f"{result.sites[s]}", f"{result.site_force_N[p, s]:.1f}", share


@dataclass(frozen=True, eq=False, repr=False)
class BeltDrive(Drive):
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
    tight_tension_N: Floats = field(metadata={"P": "N"})
    slack_tension_N: Floats = field(metadata={"P": "N"})
    land_friction_N: Floats = field(metadata={"P": "N"})
    last_land_N: Floats = field(metadata={"P": "N"})
    last_land_lift_um: Floats = field(metadata={"P": "um"})
    tension_behind_N: Floats = field(metadata={"PS": "N"})
    land_before_N: Floats = field(metadata={"PS": "N"})
    land_lift_um: Floats = field(metadata={"PS": "um"})
    pulley_coupling_um_per_N: Floats = field(default_factory=lambda: np.zeros(0))

    name = "belt"
    words_for_sites = ("tooth", "teeth")

    @property
    def lands_N(self) -> Floats:
        """(P, S + 1) Forces of the pulley on all lands, from the tight strand."""
        return np.column_stack([self.land_before_N, self.last_land_N])

    @property
    def lifting(self) -> Flags:
        """(P, S + 1) Lands that lift as a whole, or would lift if they were not fixed."""
        least = TIE * self.tight_tension_N[:, None]
        lift = np.column_stack([self.land_lift_um, self.last_land_lift_um])
        return np.asarray((self.lands_N < -least) | ((self.lands_N < least) & (lift > 0)))

    def drawn_force(self, result: Result, p: int, s: int) -> tuple[float, float, float]:
        """Along the circumference, at the height of the teeth."""
        angle = _site_angle(result, p, s)
        radius = result.reference_radius_mm * (1.0 + 0.35 * result.pitch_rad)
        return angle, radius, angle + 0.5 * np.pi

    def rows(self, result: Result) -> Iterator[str]:
        """A row per position if there are several, then one per tooth at the largest force."""
        p = int(np.argmax(result.site_force_N.max(axis=1)))
        if result.position_rad.size > 1:
            yield from text_table(self._rows_of_positions(result))
            yield ""
        yield self._title_of_sites(result, p)
        yield from text_table(self._rows_of_teeth(result, p))

    def _rows_of_positions(self, result: Result) -> Iterator[tuple[str, ...]]:
        yield (
            "position",
            "transm. error",
            "first tooth",
            "teeth loaded",
            "most on one",
            "least land",
        )
        yield "deg", "um", "", "", "N", "N"
        for p in range(result.position_rad.size):
            yield (
                *_position_cells(result, p),
                f"{result.sites[np.isfinite(self.tension_behind_N[p])][0]}",
                f"{result.loaded_pairs[p]}",
                f"{result.site_force_N[p].max():.1f}",
                f"{np.nanmin(self.lands_N[p]):.1f}",
                "a land lifts" * bool(self.lifting[p].any()),
            )

    def _rows_of_teeth(self, result: Result, p: int) -> Iterator[tuple[str, ...]]:
        """A row per tooth, and one per land behind the last tooth."""
        yield "tooth", "force", "share", "tension before", "land before"
        yield "", "N", "%", "N", "N"
        slack = f"{self.slack_tension_N[p]:.1f}"
        lands, lifting = self.lands_N[p], self.lifting[p]
        for s in np.flatnonzero(np.isfinite(lands)).tolist():
            land = f"{lands[s]:.1f}", HERE * bool(lifting[s])
            if s < result.sites.size and isfinite(before := self.tension_behind_N[p, s]):
                yield *_load_cells(result, p, s), f"{before:.1f}", *land
            else:
                yield "end", "", "", slack, *land

    def own_pictures(self, result: Result) -> tuple[str, ...]:
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


@dataclass(frozen=True, eq=False, repr=False)
class ChainDrive(Drive):
    """A chain on its sprocket at P positions, S rollers.

    Attributes
    ----------
    mode : {"linear", "large displacement"}
    wrap_angle_rad : float
        Angle between the places where the strands leave; the tight one leaves on the positive x
        axis.
    tension_ratio : float
        q: ratio of adjacent tensions if the feet of the flanks carry the rollers.
    tight_tension_N, slack_tension_N : (P,) arrays
        Tensions of the strands.
    jump_margin_N : (P,) array
        Excess of the slack tension over T1 q^n, with n pitches in the wrap: worn chains need this
        value to be positive in order not to climb over the teeth.
    passes : (P,) array
        Number of contact problems solved at a position.
    tension_behind_N : (P, S) array
        Tension of the link, or of the tight strand, in front of each roller; NaN off the sprocket.
    roller_height_um : (P, S) array
        Height of each roller above the pitch circle; NaN off the sprocket.
    force_angle_deg : (P, S) array
        Angle of the force on a roller from the outward direction, positive in the direction of
        rotation; NaN without force.
    """

    mode: str
    wrap_angle_rad: float
    tension_ratio: float
    tight_tension_N: Floats = field(metadata={"P": "N"})
    slack_tension_N: Floats = field(metadata={"P": "N"})
    jump_margin_N: Floats = field(metadata={"P": "N"})
    passes: Numbers = field(metadata={"P": "1"})
    tension_behind_N: Floats = field(metadata={"PS": "N"})
    roller_height_um: Floats = field(metadata={"PS": "um"})
    force_angle_deg: Floats = field(metadata={"PS": "deg"})

    name = "chain"
    words_for_sites = ("roller", "rollers")

    @property
    def least_margin_N(self) -> float:
        """Least value over all positions."""
        return float(self.jump_margin_N.min())

    def drawn_force(self, result: Result, p: int, s: int) -> tuple[float, float, float]:
        """On the pitch circle, in the direction of the force."""
        angle = _site_angle(result, p, s) + float(result.rotation_rad[p])
        turn = float(np.radians(np.nan_to_num(self.force_angle_deg[p, s])))
        return angle, result.reference_radius_mm, angle + turn

    def rows(self, result: Result) -> Iterator[str]:
        """A row per position, then one per roller at the position of the largest tension."""
        p = int(np.argmax(self.tight_tension_N))
        yield from text_table(self._rows_of_positions(result))
        yield ""
        yield self._title_of_sites(result, p)
        yield from text_table(self._rows_of_rollers(result, p))

    def _rows_of_positions(self, result: Result) -> Iterator[tuple[str, ...]]:
        yield "position", "transm. error", "tight strand", "slack strand", "rollers", "most on one"
        yield "deg", "um", "N", "N", "loaded", "N"
        for p in range(result.position_rad.size):
            yield (
                *_position_cells(result, p),
                f"{self.tight_tension_N[p]:.1f}",
                f"{self.slack_tension_N[p]:.1f}",
                f"{result.loaded_pairs[p]}",
                f"{result.site_force_N[p].max():.1f}",
            )

    def _rows_of_rollers(self, result: Result, p: int) -> Iterator[tuple[str, ...]]:
        yield "roller", "force", "share", "tension before", "stands out", "force from outwards"
        yield "", "N", "%", "N", "um", "deg"
        for s in np.flatnonzero(np.isfinite(self.roller_height_um[p])).tolist():
            yield (
                *_load_cells(result, p, s),
                f"{self.tension_behind_N[p, s]:.1f}",
                f"{self.roller_height_um[p, s]:.1f}",
                number(self.force_angle_deg[p, s], ".1f"),
            )

    def own_pictures(self, result: Result) -> tuple[str, ...]:
        return ("transmission_error", "chain_on_sprocket", "tensions", "stiffness")

    def words(self) -> str:
        """Text of a report."""
        tight, margin = self.tight_tension_N, self.least_margin_N
        return (
            f"{self.mode}, tight strand {tight.min():.4g} to {tight.max():.4g} N, slack strand "
            f"{abs(margin):.4g} N {'above' if margin >= 0 else 'below'} T1 q^n "
            f"(q = {self.tension_ratio:.4f}), up to "
            f"{self.passes.max()} contact problems per position"
        )
