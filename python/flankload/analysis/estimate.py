"""Error estimates: coarser cells, omitted modes, smoothed stresses, the curve between positions.

The estimates need no further finite elements. Sources of error:

strips
    Half as many cells on the half-width. The error is proportional to the square of their width, so
    the remaining error is a third of the change.
modes
    Without the two highest pressure modes (these are orthogonal: the smaller matrix is a block of
    the larger one). The change of peak pressures is a poor measure of their error; the change of
    the load share is used instead. Tables between nodes: every second node, which also stands for
    their finite elements.
elements
    The error of the finite elements, estimated from smoothed stresses (`fe_error`).
positions
    Features of the curve between the positions (`sampling_error`).
period
    Other teeth with another compliance that come after the last position (`period_error`).
tip
    Changes by the turned force of a contact on a tip (`tip_error`).
lumped
    Lumped contact has no cells; its error is taken from measurements (`LUMPED`).

Each source has an error with its sign, and a doubt. Modes make a body too soft or too stiff,
elements make it too stiff, positions err either way. Errors are added with their signs and may
cancel; doubts are independent and are added as squares. The estimate is the sum of both. It is
exceeded in about 1 of 20 cases if the doubt is two standard deviations.

Changes caused by the compliance hardly depend on the cells, so they are computed with coarse cells.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from types import MappingProxyType
from typing import TYPE_CHECKING

import numpy as np

from flankload.analysis.error_rules import (
    AXIAL,
    COAST,
    ELEMENTS,
    FACE_LOAD,
    LARGEST_PRESSURE,
    LINE_FACTOR,
    LINE_LOAD,
    MODES,
    MODES_WITH_IMAGES,
    NODES,
    PEAK_LINE,
    PEAK_PRESSURE,
    SLICES,
    STRIPS,
    RemainingError,
    any_smooth_peak,
    at_largest_peak,
    peak_of_cells,
    peak_of_modes,
    remaining_errors,
)
from flankload.analysis.period_error import HARMONICS_KEY
from flankload.contact.status import is_marked, on_corner

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from flankload.analysis.adaptive_positions import PositionErrors
    from flankload.base.arrays import Floats
    from flankload.contact.sweep import Sweep
    from flankload.elasticity.compliance import BodyCompliance
    from flankload.scene.discretization import Grid

    Errors = dict[str, float]

#: Estimated quantities: at the worst position …
POINTWISE = ("transmission_error", "load_share", PEAK_PRESSURE, LARGEST_PRESSURE)
#: … and over all of them.
OVERALL = (
    "transmission_error_mean",
    "transmission_error_peak_to_peak",
    "stiffness_secant",
    "stiffness_tangent",
)
#: … in three dimensions.
OF_WIDTH = (LINE_LOAD, PEAK_LINE, FACE_LOAD, LINE_FACTOR)
#: Error of lumped contacts, with h/L the largest half-width over the length of the shorter flank:
#: (h/L)² times the first number plus the second; at a corner, a kink or a rounding at least h/L
#: times the third (pressures there are not estimated); in slices times the part of the load there.
#: Measured against resolved contacts on gears, rings and cams, sharp, rounded and relieved, under
#: 0.03 to 3 times their torque.
LUMPED = {
    "transmission_error": (0.7, 1e-4, 0.3),
    "load_share": (0.32, 0.0, 0.2),
    "peak_pressure": (3.0, 0.003, 0.0),
}
#: Error of slices of flanks that conform, of which one unknown spreads the force over the height:
#: measured beside unknowns on ten strips of the height, with crownings of 20 um, misalignments up
#: to 5 mrad, pitch errors and offsets.
SPREAD = {
    "transmission_error": 0.0035,
    "load_share": 0.005,
    "peak_pressure": 0.01,
    LINE_LOAD: 0.08,
    PEAK_LINE: 0.08,
    FACE_LOAD: 0.01,
    LINE_FACTOR: 0.01,
}
#: Least error of lumped contacts in slices, against cells on 40 random pairs of gears (K_Hbeta: on
#: 23): a slice does not see how the pressure changes along its width.
LUMPED_IN_SLICES = {
    "transmission_error": 0.0025,
    "load_share": 0.006,
    LINE_LOAD: 0.08,
    PEAK_LINE: 0.08,
    FACE_LOAD: 0.02,
    LINE_FACTOR: 0.05,
}
#: Why the peak pressure of a sweep may have any error beyond its estimate: the pressure on sharp
#: corners has no limit; on a rounding or a chamfer the error was up to 14 times the change that the
#: estimate sees, as the modes of the tip converge slowly on what is much shorter than an element.
ON_CORNERS = (
    "contact on sharp corners, where no finite pressure exists (tip_radius_mm makes it finite)"
)
ON_ENDS = "contact on sharp ends, where no finite pressure exists (end_relief_um makes it finite)"
ON_TIPS = "contact on a rounding or a chamfer, where the pressure converges slowly"
#: Largest number of sweeps of an estimate.
MOST_SWEEPS = 3


def n_sweeps(*, lumped: bool, elements: bool, variants: int = 0) -> int:
    """Number of sweeps: coarser cells (lumped contacts have none), modes, elements, variants."""
    return MOST_SWEEPS - lumped - (not elements) + variants


@dataclass(frozen=True)
class Estimate:
    """Estimated relative errors.

    Attributes
    ----------
    errors : dict
        By quantity. Transmission error: the largest error over the positions, relative to its
        largest value; its mean and peak to peak: relative to themselves. Load share: the largest
        error as part of the load. Peak pressure: the largest error off sharp corners, relative to
        the largest pressure, whose own error is a further quantity. Stiffnesses: the error of their
        mean. Coast flanks that can carry load: the largest error of a force, relative to the force
        on the working flanks.
    by_source : dict
        Error of each source alone. Sources may cancel.
    uncertain : dict of str to str
        Quantities whose error may be larger than estimated, with the reason.
    """

    errors: Errors
    by_source: dict[str, Errors]
    uncertain: dict[str, str] = field(default_factory=dict)

    @classmethod
    def of(
        cls, errors: dict[str, dict[str, RemainingError]], uncertain: dict[str, str] | None = None
    ) -> Estimate:
        """Estimate from the errors of each source, by quantity."""
        by_quantity = {
            quantity: [parts[quantity] for parts in errors.values() if quantity in parts]
            for quantity in (*POINTWISE, *OVERALL, COAST, *OF_WIDTH)
        }
        return cls(
            {
                quantity: RemainingError.of(parts).size
                for quantity, parts in by_quantity.items()
                if parts
            },
            {
                source: {quantity: part.size for quantity, part in parts.items()}
                for source, parts in errors.items()
            },
            uncertain or {},
        )

    @property
    def dominant_source(self) -> dict[str, str]:
        """The source with the largest error of each quantity."""
        return {
            quantity: max(self.by_source, key=lambda name: self.by_source[name].get(quantity, 0.0))
            for quantity in self.errors
        }

    def as_dict(self, *, positions: PositionErrors | None = None) -> dict[str, object]:
        """Errors by quantity and the table by source, as in the result.

        Adaptive positions are a separate source of errors of harmonics and peak to peak.
        """
        all_of = self
        if positions is not None:
            doubt = {
                HARMONICS_KEY: positions.harmonics,
                "transmission_error_peak_to_peak": positions.peak_to_peak,
            }
            name = "transmission_error_peak_to_peak"
            both = float(np.hypot(self.errors[name], positions.peak_to_peak))
            doubt = self.by_source.get("positions", {}) | doubt
            all_of = Estimate({**self.errors, name: both}, {**self.by_source, "positions": doubt})
        return {
            **all_of.errors,
            "dominant_source": all_of.dominant_source,
            "by_source": {name: dict(errors) for name, errors in all_of.by_source.items()},
            **({"uncertain": dict(self.uncertain)} if self.uncertain else {}),
        }


def estimate_errors(
    found: tuple[Sweep, ...],
    run: Callable[..., tuple[Sweep, ...]],
    compliances: tuple[BodyCompliance, BodyCompliance],
    cells: Grid,
    weights: Floats,
    *,
    variants: Mapping[str, Mapping[str, object]],
    lumped: bool = False,
    sources: Mapping[str, Callable[[Sweep], dict[str, RemainingError]]] = MappingProxyType({}),
) -> tuple[Estimate, ...]:
    """Estimate the errors of a sweep.

    Parameters
    ----------
    found : tuple of Sweep
        The sweep, one part per torque, each with its tangents.
    run : callable
        run(compliances=…, grid=…, part=…) repeats the sweep with other compliances or cells; part
        counts the calls from 0.
    compliances
        Those of the sweep.
    cells : Grid
        Cells of the reduced sweeps: coarser ones, those of the sweep if contacts are lumped.
    weights : (P,) array
        Parts of the positions in means over the period.
    variants : mapping
        Arguments of `run` for the reduced sweeps, by the source whose error their change shows;
        always "modes".
    lumped : bool
        Whether contacts are lumped; there are no cells then, and their error is taken from
        measurements.
    sources : mapping
        Further sources: errors that follow from the sweep itself, by quantity; empty if the source
        has no effect.

    Returns
    -------
    tuple of Estimate, one per torque
    """
    coarse = found if lumped else run(compliances=compliances, grid=cells, part=0)
    others = {
        source: run(**{"compliances": compliances, **arguments}, grid=cells, part=number)
        for number, (source, arguments) in enumerate(variants.items(), start=1)
    }
    estimates = []
    for t, part in enumerate(found):
        errors = _of_lumping(part, compliances) if lumped else _of_cells(part, coarse[t], weights)
        each = {source: other[t] for source, other in others.items()}
        errors |= _of_compliances(part, coarse[t], each, compliances, weights)
        errors |= {source: own for source, of in sources.items() if (own := of(part))}
        if not any_smooth_peak(part):  # all on sharp corners, where pressures have no estimate
            for parts in errors.values():
                parts.pop(PEAK_PRESSURE, None)
        for parts in errors.values():
            if PEAK_PRESSURE in parts:
                parts[LARGEST_PRESSURE] = at_largest_peak(parts[PEAK_PRESSURE], part)
        estimates.append(Estimate.of(errors, _uncertain_pressure(part, compliances)))
    return tuple(estimates)


def _uncertain_pressure(
    part: Sweep, compliances: tuple[BodyCompliance, BodyCompliance]
) -> dict[str, str]:
    """The peak pressure with the reason if no estimate bounds its error; else nothing."""
    if on_corner(part.site_corner).any():
        slices = part.slices
        ends = slices is not None and not on_corner(slices.corner_off_ends).any()
        return {"peak_pressure": ON_ENDS if ends else ON_CORNERS}
    pairs = part.pairs
    loaded = pairs.column("force") > 0
    on_tip = any(
        modes.tip is not None and (pairs.column(f"s_{z + 1}")[loaded] > modes.range_mm[1]).any()
        for z, modes in enumerate(compliance.modes for compliance in compliances)
    )
    return {"peak_pressure": ON_TIPS} if on_tip else {}


def _of_lumping(
    part: Sweep, compliances: tuple[BodyCompliance, BodyCompliance]
) -> dict[str, dict[str, RemainingError]]:
    errors = lumped_error(part, compliances)
    return {"lumped": {quantity: RemainingError(0.0, error) for quantity, error in errors.items()}}


def _of_cells(part: Sweep, coarse: Sweep, weights: Floats) -> dict[str, dict[str, RemainingError]]:
    errors = remaining_errors(STRIPS, part, part, coarse, weights)
    errors["peak_pressure"] = peak_of_cells(part, coarse)
    # a relative error of the rotation that is the same at all torques is also that of its
    # derivative
    if "stiffness_secant" in errors:
        errors["stiffness_tangent"] = errors["stiffness_secant"]
    return {"strips": errors}


def _of_compliances(
    part: Sweep,
    coarse: Sweep,
    others: Mapping[str, Sweep],
    compliances: tuple[BodyCompliance, BodyCompliance],
    weights: Floats,
) -> dict[str, dict[str, RemainingError]]:
    """Errors of modes and elements, from sweeps on coarse cells with other compliances."""
    nodal = any(compliance.modes.nodes is not None for compliance in compliances)
    imaged = all(any(compliance.near.wedge) or compliance.is_rigid for compliance in compliances)
    of_modes = MODES_WITH_IMAGES if imaged else MODES
    rules = {
        "modes": NODES if nodal else of_modes,
        "elements": ELEMENTS,
        "axial": AXIAL,
        "slices": SLICES,
    }
    errors = {
        source: remaining_errors(rules[source], part, coarse, other, weights)
        for source, other in others.items()
    }
    if not nodal:
        errors["modes"]["peak_pressure"] = peak_of_modes(part, coarse, others["modes"])
    return errors


def lumped_error(
    found: Sweep, compliances: tuple[BodyCompliance, BodyCompliance]
) -> dict[str, float]:
    """Error of a sweep (with its pairs) under lumped contacts, by quantity."""
    if found.slices is not None and found.slices.conforming:
        return SPREAD | dict.fromkeys(OVERALL, SPREAD["transmission_error"])
    loaded = found.pairs.column("force") > 0
    half_width = np.max(found.pairs.column("cell") * (2.0 / np.pi), initial=0.0, where=loaded)
    length = min(high - low for low, high in (c.modes.range_mm for c in compliances))
    ratio = float(half_width / length)
    shaped = _shaped_part(found)
    errors = {
        quantity: max(square * ratio**2 + least, linear * ratio * shaped)
        for quantity, (square, least, linear) in LUMPED.items()
    }
    if found.slices is not None:
        for quantity, least in LUMPED_IN_SLICES.items():
            errors[quantity] = max(least, errors.get(quantity, 0.0))
    if found.coast is not None:
        errors[COAST] = errors["load_share"]
    return errors | dict.fromkeys(OVERALL, errors["transmission_error"])


def _shaped_part(found: Sweep) -> float:
    """Part of the load for which contacts beside corners, kinks and ends count.

    Forces do virtual work on the errors of their places: the error of the rotation is their mean,
    weighted by the forces. In slices only some of a flank's places are of that kind; in the plane,
    and where a sharp corner carries, the whole load counts.
    """
    corner, force = found.site_corner, found.site_force_N
    if found.slices is not None:
        corner, force = found.slices.corner_off_ends, found.slices.force_N
    marked = is_marked(corner) & (force > 0)
    if not marked.any():
        return 0.0
    if found.slices is None or (marked & on_corner(corner)).any():
        return 1.0
    each = tuple(range(1, force.ndim))
    return float(np.max(np.where(marked, force, 0.0).sum(axis=each) / force.sum(axis=each)))
