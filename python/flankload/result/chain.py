"""Result quantities of a chain drive beyond its contact forces: tensions, places, margins."""

from __future__ import annotations

from dataclasses import dataclass
from math import degrees
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from flankload.base.card import Card
from flankload.base.text_table import number, text_table

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import NDArray

    from flankload.result.result import Result

    Floats = NDArray[np.float64]

#: Arrays over the positions, with their units.
ALONG_POSITIONS = {
    "tight_tension_N": "N",
    "slack_tension_N": "N",
    "jump_margin_N": "N",
    "passes": "1",
}
#: Arrays over positions and sites, with their units; NaN if a roller is off the sprocket.
OVER_SITES = {
    "tension_behind_N": "N",
    "roller_height_um": "um",
    "force_angle_deg": "deg",
}


@dataclass(frozen=True, eq=False, repr=False)
class ChainDrive(Card):
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
    tight_tension_N: Floats
    slack_tension_N: Floats
    jump_margin_N: Floats
    passes: NDArray[np.int64]
    tension_behind_N: Floats
    roller_height_um: Floats
    force_angle_deg: Floats

    #: Name of the drive in a report.
    name: ClassVar[str] = "chain"
    #: Word for a site, and for several.
    words_for_sites: ClassVar[tuple[str, str]] = ("roller", "rollers")
    along: ClassVar[dict[str, str]] = ALONG_POSITIONS
    over_sites: ClassVar[dict[str, str]] = OVER_SITES

    def as_dict(self) -> dict[str, Any]:
        """The drive in the form of the JSON result."""
        single = {key: getattr(self, key) for key in ("mode", "wrap_angle_rad", "tension_ratio")}
        return single | {key: getattr(self, key) for key in (*ALONG_POSITIONS, *OVER_SITES)}

    @property
    def least_margin_N(self) -> float:
        """Least value over all positions."""
        return float(self.jump_margin_N.min())

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
        turn = float(np.radians(np.nan_to_num(self.force_angle_deg[p, s])))
        angle += float(result.rotation_rad[p])
        return angle, result.reference_radius_mm, angle + turn

    def rows(self, result: Result) -> Iterator[str]:
        """A row per position, then one per roller at the position of the largest tension.

        Parameters
        ----------
        result : Result
            Result of this drive.
        """
        yield from _rows_of_chain(result, self)

    def pictures(self, result: Result) -> tuple[str, ...]:
        """Names of the plots of the drive."""
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


def _rows_of_chain(result: Result, drive: ChainDrive) -> Iterator[str]:
    yield from text_table(
        [
            ("position", "transm. error", "tight strand", "slack strand", "rollers", "most on one"),
            ("deg", "um", "N", "N", "loaded", "N"),
            *(
                (
                    f"{degrees(result.position_rad[p]):.3f}",
                    f"{result.transmission_error_um[p]:.3f}",
                    f"{drive.tight_tension_N[p]:.1f}",
                    f"{drive.slack_tension_N[p]:.1f}",
                    f"{result.loaded_pairs[p]}",
                    f"{result.site_force_N[p].max():.1f}",
                )
                for p in range(result.position_rad.size)
            ),
        ]
    )
    p = int(np.argmax(drive.tight_tension_N))
    yield ""
    yield f"rollers from the tight strand on, at {degrees(result.position_rad[p]):.3f} deg"
    on_sprocket = np.flatnonzero(np.isfinite(drive.roller_height_um[p]))
    yield from text_table(
        [
            ("roller", "force", "share", "tension before", "stands out", "force from outwards"),
            ("", "N", "%", "N", "um", "deg"),
            *(
                (
                    f"{result.sites[s]}",
                    f"{result.site_force_N[p, s]:.1f}",
                    f"{100 * result.load_share[p, s]:.2f}",
                    f"{drive.tension_behind_N[p, s]:.1f}",
                    f"{drive.roller_height_um[p, s]:.1f}",
                    number(drive.force_angle_deg[p, s], ".1f"),
                )
                for s in on_sprocket
            ),
        ]
    )
