"""Error estimates: coarser cells, modes left out, smoothed stresses, the curve between positions.

No source needs further finite elements:

strips
    Half as many cells to the half-width. The error falls with the square of their width, so a third
    of the change is left.
modes
    Without the two highest pressure modes (they are orthogonal: the smaller matrix is a block of
    the larger). Of peak pressures these two tell little: what is left goes with the load share.
    Tables between nodes: with every second node, which stands for their elements, too.
elements
    With what the elements miss by their smoothed stresses (`element_error`).
positions
    What the curve through the positions finds between them (`position_error`).
period
    What other teeth do that yield differently and come later than the last position
    (`period_error`).
tip
    Where a contact works on a tip, what its turned force changes (`tip_error`).
lumped
    Lumped contact has no cells; what it leaves is taken from what was measured of it.

Each source tells an error with its sign, and a doubt. Modes leave a body too soft or too stiff,
elements leave it too stiff, positions miss either way: errors add up with their signs, and may
cancel; doubts are independent, and add up by their squares. What is told is the sum of both, which
holds in 19 of 20 cases where the doubt is two standard deviations.

The sources of the compliance change the answer by little, and so by the same on coarse cells, on
which they are swept.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flankload.analysis.error_rules import (
    COAST,
    ELEMENTS,
    MODES,
    MODES_WITH_IMAGES,
    NODES,
    STRIPS,
    Left,
    any_smooth_peak,
    peak_of_cells,
    peak_of_modes,
    what_is_left,
)
from flankload.analysis.period_error import HARMONICS_KEY, OtherTeeth, of_other_teeth
from flankload.analysis.sampling_error import between_positions
from flankload.contact.sweep import END_WOULD_TOUCH

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from flankload.analysis.adaptive_positions import PositionErrors, Window
    from flankload.contact.sweep import Sweep
    from flankload.elasticity.compliance import BodyCompliance
    from flankload.scene.discretization import Grid

    Floats = NDArray[np.float64]
    Errors = dict[str, float]

#: What is estimated: at the worst position …
POINTWISE = ("transmission_error", "load_share", "peak_pressure")
#: … and over all of them.
OVERALL = (
    "transmission_error_mean",
    "transmission_error_peak_to_peak",
    "stiffness_secant",
    "stiffness_tangent",
)
#: Modes left out: their terms alternate in size, and at places one of two vanishes.
MODES_DROPPED = 2
#: What lumping contacts leaves, by the largest half-width h over the length L of the shorter flank:
#: measured against pairs on gears, rings and cams, sharp, rounded and relieved, under 0.03 to 3
#: times their torque. (h/L)² times the first number, and the second in any case; where a corner, a
#: kink or a rounding takes part, h/L times the third (the pressure there is not told).
LUMPED = {
    "transmission_error": (0.7, 1e-4, 0.3),
    "load_share": (0.32, 0.0, 0.2),
    "peak_pressure": (3.0, 0.003, 0.0),
}
#: Sweeps of an estimate at the most.
MOST_SWEEPS = 3


def n_sweeps(*, lumped: bool, elements: bool) -> int:
    """Sweeps of an estimate: coarser cells (lumped contacts have none), modes, elements."""
    return MOST_SWEEPS - lumped - (not elements)


@dataclass(frozen=True)
class Estimate:
    """Estimated relative errors.

    Attributes
    ----------
    errors : dict
        Of each quantity: of the transmission error the largest over the positions relative to its
        largest value, of its mean and its peak to peak relative to them; of the load share the
        largest in parts of the load; of the peak pressure the largest, off sharp corners, relative
        to the largest pressure; of the stiffnesses that of their mean; of forces on coast flanks,
        where these can carry, the largest over all force on the working ones there.
    by_source : dict
        What each source alone would leave. Sources may cancel.
    """

    errors: Errors
    by_source: dict[str, Errors]

    @classmethod
    def of(cls, left: dict[str, dict[str, Left]]) -> Estimate:
        """Of what each source leaves in each quantity."""
        told = {
            quantity: [parts[quantity] for parts in left.values() if quantity in parts]
            for quantity in (*POINTWISE, *OVERALL, COAST)
        }
        return cls(
            {quantity: Left.of(parts).size for quantity, parts in told.items() if parts},
            {
                source: {quantity: part.size for quantity, part in parts.items()}
                for source, parts in left.items()
            },
        )

    @property
    def dominant_source(self) -> dict[str, str]:
        """The source that adds most to each quantity."""
        return {
            quantity: max(self.by_source, key=lambda name: self.by_source[name].get(quantity, 0.0))
            for quantity in self.errors
        }

    def as_dict(self, *, positions: PositionErrors | None = None) -> dict[str, object]:
        """The form of the result: a number for each quantity, and the table by source.

        Adaptive positions are a source of their own, of what follows from the whole curve.
        """
        all_of = self
        if positions is not None:
            doubt = {
                HARMONICS_KEY: positions.harmonics,
                "transmission_error_peak_to_peak": positions.peak_to_peak,
            }
            name = "transmission_error_peak_to_peak"
            both = float(np.hypot(self.errors[name], positions.peak_to_peak))
            all_of = Estimate({**self.errors, name: both}, {**self.by_source, "positions": doubt})
        return {
            **all_of.errors,
            "dominant_source": all_of.dominant_source,
            "by_source": {name: dict(errors) for name, errors in all_of.by_source.items()},
        }


def estimate_errors(
    found: tuple[Sweep, ...],
    run: Callable[..., tuple[Sweep, ...]],
    compliances: tuple[BodyCompliance, BodyCompliance],
    grid: Grid,
    *,
    lumped: bool = False,
    position_rad: Floats,
    window: Window | None = None,
    unlike: OtherTeeth | None = None,
    tip: Callable[[Sweep], dict[str, Left]] | None = None,
) -> tuple[Estimate, ...]:
    """Estimate the errors of a sweep.

    Parameters
    ----------
    found : tuple of Sweep
        The sweep in question, one part per torque, each with its tangents.
    run : callable
        run(compliances=…, grid=…, part=…) sweeps the same positions and torques with other ones;
        part counts its calls from 0.
    compliances, grid
        Those of the sweep in question.
    lumped : bool
        Contacts are lumped: there are no cells, in their place stands what is known of that level.
    position_rad : (P,) array
    window : Window, optional
        What the positions run over; absent where nothing is claimed of what is between them.
    unlike : OtherTeeth, optional
        Teeth that yield differently, of which the positions see some.
    tip : callable, optional
        What turned forces on tips leave in a sweep; nothing where none is.

    Returns
    -------
    tuple of Estimate, one per torque
    """
    cells = grid if lumped else grid.coarser()
    coarse = found if lumped else run(compliances=compliances, grid=cells, part=0)
    fewer = tuple(compliance.fewer_modes(MODES_DROPPED) for compliance in compliances)
    others = {"modes": run(compliances=fewer, grid=cells, part=1)}
    if any(compliance.missed is not None for compliance in compliances):
        better = tuple(compliance.with_missed(1.0) for compliance in compliances)
        others["elements"] = run(compliances=better, grid=cells, part=2)
    nodal = any(compliance.nodes is not None for compliance in compliances)
    imaged = all(any(compliance.wedge) or compliance.is_rigid for compliance in compliances)
    of_modes = MODES_WITH_IMAGES if imaged else MODES
    rules = {"modes": NODES if nodal else of_modes, "elements": ELEMENTS}
    estimates = []
    for t, part in enumerate(found):
        left: dict[str, dict[str, Left]] = {}
        if lumped:
            known = lumped_error(part, compliances)
            left["lumped"] = {quantity: Left(0.0, error) for quantity, error in known.items()}
        else:
            left["strips"] = what_is_left(STRIPS, part, part, coarse[t])
            left["strips"]["peak_pressure"] = peak_of_cells(part, coarse[t])
            # cells that miss a part of the rotation under every torque miss that of its derivative
            if "stiffness_secant" in left["strips"]:
                left["strips"]["stiffness_tangent"] = left["strips"]["stiffness_secant"]
        for source, other in others.items():
            left[source] = what_is_left(rules[source], part, coarse[t], other[t])
        if not nodal:
            left["modes"]["peak_pressure"] = peak_of_modes(part, coarse[t], others["modes"][t])
        on_tips = tip(part) if tip is not None else {}
        if on_tips:
            left["tip"] = on_tips
        if window is not None:
            missed = between_positions(part, window, position_rad)
            if missed:
                left["positions"] = {name: Left(*both) for name, both in missed.items()}
        if unlike is not None:
            left["period"] = of_other_teeth(part, unlike)
        if not any_smooth_peak(part):  # all on sharp corners: of those nothing is told
            for parts in left.values():
                parts.pop("peak_pressure", None)
        estimates.append(Estimate.of(left))
    return tuple(estimates)


def lumped_error(
    found: Sweep, compliances: tuple[BodyCompliance, BodyCompliance]
) -> dict[str, float]:
    """What lumping its contacts leaves in a sweep, per quantity.

    Parameters
    ----------
    found : Sweep
        With its pairs.
    compliances : two BodyCompliance

    Returns
    -------
    dict
    """
    loaded = found.pairs.column("force") > 0
    half_width = np.max(found.pairs.column("cell") * (2.0 / np.pi), initial=0.0, where=loaded)
    length = min(high - low for low, high in (c.mode_range_mm for c in compliances))
    ratio = float(half_width / length)
    marked = (found.site_corner != 0) & (found.site_corner != END_WOULD_TOUCH)
    shaped = (marked & (found.site_force_N > 0)).any()
    errors = {
        quantity: max(square * ratio**2 + least, linear * ratio if shaped else 0.0)
        for quantity, (square, least, linear) in LUMPED.items()
    }
    if found.coast is not None:
        errors[COAST] = errors["load_share"]
    return errors | dict.fromkeys(OVERALL, errors["transmission_error"])
