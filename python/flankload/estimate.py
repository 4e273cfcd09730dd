"""Error estimates: coarser cells, modes left out, smoothed stresses, the curve between positions.

No source needs further finite elements:

strips
    Half as many cells to the half-width. The error falls with the square of their width, so the
    change is three times what is left; it is told as it stands, which is the safety that two grids
    call for (P. J. Roache, J. Fluids Eng. 116, 1994).
modes
    Without the two highest pressure modes (they are orthogonal: the smaller matrix is a block of
    the larger). Tables between nodes: with every second node, which stands for their elements, too.
elements
    With what the elements miss by their smoothed stresses (`element_error`).
positions
    What the curve through the positions finds between them.
lumped
    Lumped contact has no cells; what it leaves is taken from what was measured of it.

The sources of the compliance change the answer by little, and so by the same on coarse cells, on
which they are swept. Of independent sources the squares add up.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flankload.sweep import END_WOULD_TOUCH

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from flankload.adaptive_positions import PositionErrors, Window
    from flankload.compliance import BodyCompliance
    from flankload.position_curve import PositionCurve
    from flankload.resolution import Grid
    from flankload.sweep import Sweep

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
#: What follows the two highest modes, over their change. At the tip, where the compliance grows
#: like a logarithm towards a corner, terms hardly fall until the contact is resolved: with 5 modes
#: the rest was up to 2.5 times the last two terms. Elsewhere two stand for one that follows.
MODES_POINTWISE, MODES_OVERALL = 2.5, 0.5
#: Half as many nodes: where the error falls only in proportion to their distance, the change is it.
NODES_POINTWISE, NODES_OVERALL = 1.0, 1.0
#: Smoothed stresses tell the loss from above or below: anywhere on a flank the true one was up to
#: 2.2 times as large, in the mean over it 0.3 to 1.7 times.
ELEMENTS_POINTWISE, ELEMENTS_OVERALL = 2.0, 1.0
#: What a curve finds between positions is a correction, and as such in doubt by all of it.
POSITIONS = 2.0
#: A step anywhere in an interval moves the mean by this part of it, twice the standard deviation.
STEP = 1.0 / np.sqrt(3.0)
#: Places in an interval between positions at which a curve is looked at.
BETWEEN = 16
#: A half-ellipse of pressure whose middle lies on the edge of two cells seems lower by 0.5 % with
#: five cells on its half. A peak that changes by more than twice that has something in it that the
#: cells do not resolve (a kink, a small rounding), and may grow by as much at each halving of the
#: cells until they do; so many of them are reckoned with.
LARGEST_SMOOTH_CHANGE, HALVINGS = 0.01, 8.0
#: What lumping contacts leaves, by the largest half-width h over the length L of the shorter flank:
#: measured against pairs on gears, rings and cams, sharp, rounded and relieved, under 0.03 to 3
#: times their torque. (h/L)² times the first number, and the second in any case; where a corner, a
#: kink or a rounding takes part, h/L times the third (the pressure there is not told).
LUMPED = {
    "transmission_error": (0.7, 1e-4, 0.3),
    "load_share": (0.3, 0.0, 0.2),
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
        to the largest pressure; of the stiffnesses that of their mean.
    by_source : dict
        The same by source.
    """

    errors: Errors
    by_source: dict[str, Errors]

    @classmethod
    def of(cls, by_source: dict[str, Errors]) -> Estimate:
        """Of independent sources, whose squares add up."""
        errors = {
            quantity: float(
                np.linalg.norm([source.get(quantity, 0.0) for source in by_source.values()])
            )
            for quantity in (*POINTWISE, *OVERALL)
        }
        return cls(errors, by_source)

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
                "transmission_error_harmonics": positions.harmonics,
                "transmission_error_peak_to_peak": positions.peak_to_peak,
            }
            all_of = Estimate.of({**self.by_source, "positions": doubt})
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
    kinds = {"modes": "nodes" if nodal else "modes", "elements": "elements"}
    estimates = []
    for t, part in enumerate(found):
        by_source: dict[str, Errors] = {}
        if lumped:
            by_source["lumped"] = lumped_error(part, compliances)
        else:
            by_source["strips"] = strips = _changes(part, coarse[t], cells_differ=True)
            # cells that miss a part of the rotation under every torque miss that of its derivative
            strips["stiffness_tangent"] = strips["transmission_error"]
        for source, other in others.items():
            by_source[source] = _told(kinds[source], _changes(coarse[t], other[t]))
        if window is not None:
            by_source["positions"] = _between_positions(part, window, position_rad)
        estimates.append(Estimate.of(by_source))
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
    return errors | dict.fromkeys(OVERALL, errors["transmission_error"])


def _told(kind: str, changes: Errors) -> Errors:
    """What a change of the compliance stands for."""
    pointwise, overall = {
        "modes": (MODES_POINTWISE, MODES_OVERALL),
        "nodes": (NODES_POINTWISE, NODES_OVERALL),
        "elements": (ELEMENTS_POINTWISE, ELEMENTS_OVERALL),
    }[kind]
    return {
        quantity: (pointwise if quantity in POINTWISE else overall) * change
        for quantity, change in changes.items()
    }


def _changes(fine: Sweep, other: Sweep, *, cells_differ: bool = False) -> Errors:
    """Changes of all quantities between two sweeps of the same positions."""
    rotation, other_rotation = fine.rotation_rad, other.rotation_rad
    return {
        "transmission_error": _part(
            np.abs(other_rotation - rotation).max(), np.abs(rotation).max()
        ),
        "load_share": float(np.abs(_shares(other) - _shares(fine)).max()),
        "peak_pressure": _peak_change(fine, other, cells_differ=cells_differ),
        "transmission_error_mean": _part(
            abs(other_rotation.mean() - rotation.mean()), abs(rotation.mean())
        ),
        "transmission_error_peak_to_peak": _part(
            abs(np.ptp(other_rotation) - np.ptp(rotation)), np.ptp(rotation)
        ),
        "stiffness_secant": _change_of_mean(rotation, other_rotation),
        "stiffness_tangent": _change_of_mean(fine.tangent_rad_per_Nmm, other.tangent_rad_per_Nmm),
    }


def _shares(part: Sweep) -> Floats:
    total = part.site_force_N.sum(axis=1, keepdims=True)
    return np.asarray(part.site_force_N / np.maximum(total, np.finfo(float).tiny))


def _peak_change(fine: Sweep, other: Sweep, *, cells_differ: bool) -> float:
    """Largest change of a peak off sharp corners, relative to the largest peak."""
    smooth = (fine.site_corner <= 0) & (other.site_corner <= 0) & (fine.site_peak_N_per_mm > 0)
    peak = fine.site_peak_N_per_mm[smooth]
    change = np.abs(other.site_peak_N_per_mm[smooth] - peak)
    if cells_differ:
        change = np.where(change > LARGEST_SMOOTH_CHANGE * peak, HALVINGS * change, change)
    return _part(np.max(change, initial=0.0), np.max(peak, initial=0.0))


def _between_positions(part: Sweep, window: Window, position_rad: Floats) -> Errors:
    """What curves find between the positions, of what follows from all of them."""
    loaded = part.site_force_N != 0
    rotation = part.rotation_rad

    def curve(values: Floats) -> PositionCurve:
        return window.curve_of(position_rad, values, loaded)

    through = curve(rotation)
    between = through.values(np.linspace(*through.ends, BETWEEN * rotation.size))
    found = {
        "transmission_error_mean": (through.mean(), rotation.mean()),
        "transmission_error_peak_to_peak": (np.ptp(between), np.ptp(rotation)),
    }
    secant = _stiffness(rotation)
    if secant is not None:
        found["stiffness_secant"] = (curve(secant).mean(), secant.mean())
    errors = {
        name: POSITIONS * _part(abs(better - mean), abs(mean))
        for name, (better, mean) in found.items()
    }
    tangent = _stiffness(part.tangent_rad_per_Nmm)
    if tangent is not None:
        # it has a step where the loaded pairs change, somewhere in that interval
        steps = np.diff(tangent, append=tangent[0])[window.changes(loaded)]
        errors["stiffness_tangent"] = _part(
            STEP * np.linalg.norm(steps) / tangent.size, tangent.mean()
        )
    return errors


def _change_of_mean(softness: Floats, other: Floats) -> float:
    """Relative change of a mean stiffness."""
    one, two = _stiffness(softness), _stiffness(other)
    return 0.0 if one is None or two is None else abs(float(two.mean() / one.mean()) - 1.0)


def _stiffness(softness: Floats) -> Floats | None:
    """What is inverse to rotation over torque; None where that is not known everywhere."""
    return 1.0 / softness if (softness > 0).all() else None


def _part(change: float | np.floating, whole: float | np.floating) -> float:
    return float(change / whole) if whole > 0 else 0.0
