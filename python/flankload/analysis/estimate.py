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
lumped
    Lumped contact has no cells: those of twice as many positions (`lumped_error`).

Each source has an error with its sign, and a doubt. Modes make a body too soft or too stiff,
elements make it too stiff, positions err either way. Errors are added with their signs and may
cancel; doubts are independent and are added as squares. The estimate is the sum of both. It is
exceeded in about 1 of 20 cases if the doubt is two standard deviations.

Changes caused by the compliance hardly depend on the cells, so they are computed with coarse cells;
sweeps are repeated at the deciding positions only (`deciding_positions`).
"""

from __future__ import annotations

from contextlib import nullcontext, suppress
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import TYPE_CHECKING

import numpy as np

from flankload.analysis.error_rules import (
    COAST,
    COVERED,
    ELEMENTS,
    FACE_LOAD,
    LARGEST_PRESSURE,
    LINE_FACTOR,
    LINE_LOAD,
    NODES,
    PEAK_LINE,
    PEAK_PRESSURE,
    ROOT_STRESS,
    SERIES,
    SLICES_ORDER,
    STRIPS,
    RemainingError,
    Rule,
    at_largest_peak,
    largest_peak,
    peak_of_cells,
    peak_of_modes,
    remaining_errors,
    rule_of_modes,
)
from flankload.analysis.period_error import HARMONICS_KEY
from flankload.analysis.resolved_peaks import with_resolved_peaks
from flankload.analysis.root_error import add_root_errors
from flankload.contact.status import on_corner
from flankload.contact.sweep import join_sweeps
from flankload.errors import ContactError

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from flankload.analysis.adaptive_positions import PositionErrors
    from flankload.analysis.root_error import RootTension
    from flankload.base.arrays import Floats, Numbers
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
#: Reasons why no estimate bounds the error of the peak pressure: the pressure on sharp
#: corners has no limit; on a rounding or a chamfer the error was up to 14 times the change that the
#: estimate sees, as the modes of the tip converge slowly on what is much shorter than an element.
ON_CORNERS = (
    "contact on sharp corners, where no finite pressure exists (tip_radius_mm makes it finite)"
)
ON_ENDS = "contact on sharp ends, where no finite pressure exists (end_relief_um makes it finite)"
ON_TIPS = "contact on a rounding or a chamfer, where the pressure converges slowly"
#: Reasons why a pressure has no estimate (the first: `resolved_peaks`).
BESIDE_ENDS = "beside the end of a flank or on its tip, where pressure modes do not resolve it"
COMPARED_ON_CORNERS = "on a sharp corner in the runs that it is compared with"
#: Reason for largest line loads of adaptive positions, which are placed by the rotation.
BETWEEN = "peaks between adaptive positions have no estimate (positions.count has one)"
#: Reason for quantities without the error of a source.
MISSING = "states of the comparison do not converge: {}"
#: Largest number of sweeps of an estimate: coarser cells, modes, elements.
MOST_SWEEPS = 3


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
        Quantities whose error may be larger than estimated or has no estimate, with the reason.
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
            for quantity in (*POINTWISE, *OVERALL, COAST, ROOT_STRESS, *OF_WIDTH)
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
            peaks = [key for key in (PEAK_LINE, FACE_LOAD, LINE_FACTOR) if key in self.errors]
            all_of = Estimate(
                {**self.errors, name: both},
                {**self.by_source, "positions": doubt},
                {**self.uncertain, **dict.fromkeys(peaks, BETWEEN)},
            )
        return {
            **all_of.errors,
            "dominant_source": all_of.dominant_source,
            "by_source": {name: dict(errors) for name, errors in all_of.by_source.items()},
            **({"uncertain": dict(all_of.uncertain)} if all_of.uncertain else {}),
        }


def estimate_errors(
    found: tuple[Sweep, ...],
    run: Callable[..., tuple[Sweep, ...]],
    compliances: tuple[BodyCompliance, ...],
    cells: Grid,
    weights: Floats,
    *,
    variants: Mapping[str, Mapping[str, object]],
    at: Numbers | None = None,
    slices_ratio: float = 0.5,
    lumped: Callable[[int], dict[str, RemainingError]] | None = None,
    roots: Callable[[Sweep], RootTension | None] = lambda _: None,
    sources: Mapping[str, Callable[[Sweep], dict[str, RemainingError]]] = MappingProxyType({}),
) -> tuple[Estimate, ...]:
    """Estimate the errors of a sweep.

    Parameters
    ----------
    found : tuple of Sweep
        The sweep, one part per torque, each with its tangents.
    run : callable
        run(compliances=…, grid=…, part=…) repeats the sweep with other compliances or cells at the
        positions `at`; part counts the calls from 0.
    compliances
        Compliances of the sweep.
    cells : Grid
        Cells of the reduced sweeps: coarser ones, those of the sweep if contacts are lumped.
    weights : (n,) array
        Parts of the positions `at` in means over the period.
    variants : mapping
        Arguments of `run` for further sweeps, by the source whose error their change shows; always
        "modes".
    at : (n,) array or None
        Indices of the positions at which sweeps are repeated; None for all.
    slices_ratio : float
        Number of slices over that of the sweep that shows their error.
    lumped : callable or None
        Errors of the lumped contacts of a torque, by its index, empty if they are unknown; None if
        contacts have cells.
    roots : callable
        Tension in the roots at the positions `at`; None without root stress.
    sources : mapping
        Further sources: errors that follow from the sweep itself, by quantity; empty if the source
        has no effect.

    Returns
    -------
    tuple of Estimate, one per torque
    """
    some = found if at is None else tuple(join_sweeps([part], at) for part in found)
    all_peaks = [largest_peak(part) for part in some]
    some = tuple(with_resolved_peaks(part, compliances) for part in some)
    coarse = some if lumped is not None else run(compliances=compliances, grid=cells, part=0)
    others: dict[str, tuple[Sweep, ...]] = {}
    for number, (source, arguments) in enumerate(variants.items(), start=1):
        # the states of a repeated sweep may not converge where those of the sweep do
        with suppress(ContactError) if "slices" in variants else nullcontext():
            others[source] = run(
                **{"compliances": compliances, **arguments}, grid=cells, part=number
            )
    unknown = [source for source in variants if source not in others]
    estimates = []
    for t, (whole, part) in enumerate(zip(found, some, strict=True)):
        errors = (
            {"strips": _of_cells(part, coarse[t], weights)}
            if lumped is None
            else {"lumped": lumped(t)}
        )
        missing = ", ".join([*unknown, *(source for source in errors if not errors[source])])
        each = {source: other[t] for source, other in others.items()}
        of_modes = _rule_of_modes(part, compliances)
        errors |= _of_compliances(part, coarse[t], each, of_modes, weights, slices_ratio)
        errors |= {source: own for source, of in sources.items() if (own := of(whole))}
        tension = roots(part)
        if tension is not None:
            add_root_errors(errors, part, tension, of_modes.doubt_pressure)
        if not largest_peak(part):  # all where pressures have no estimate
            for parts in errors.values():
                parts.pop(PEAK_PRESSURE, None)
                parts.pop(LARGEST_PRESSURE, None)
        for parts in errors.values():
            if PEAK_PRESSURE in parts and LARGEST_PRESSURE not in parts:
                parts[LARGEST_PRESSURE] = at_largest_peak(parts[PEAK_PRESSURE], part)
        hidden = all_peaks[t] > largest_peak(part)
        uncertain = _uncertain_pressure(whole, compliances)
        place = np.where(on_corner(part.site_corner), 0.0, part.site_peak_N_per_mm).argmax()
        compared = (coarse[t], *each.values())
        on_corners = any(on_corner(one.site_corner).flat[place] for one in compared)
        uncertain |= _without_largest(errors, hidden=hidden, on_corners=on_corners)
        if hidden and not largest_peak(part):
            uncertain.setdefault(PEAK_PRESSURE, BESIDE_ENDS)
        if missing:
            quantities = set().union(*errors.values())
            uncertain |= dict.fromkeys(sorted(quantities), MISSING.format(missing))
        estimates.append(Estimate.of(errors, uncertain))
    return tuple(estimates)


def _without_largest(
    errors: Mapping[str, dict[str, RemainingError]], *, hidden: bool, on_corners: bool
) -> dict[str, str]:
    """Leave out the error of a largest pressure that is unknown; the reason, if so.

    `on_corners`: it is on a corner in a sweep that is compared.
    """
    each = [parts[LARGEST_PRESSURE] for parts in errors.values() if LARGEST_PRESSURE in parts]
    # without any error, no comparison has it off corners
    uncompared = on_corners and bool(each) and not any(one.size for one in each)
    if not (hidden or uncompared):
        return {}
    for parts in errors.values():
        parts.pop(LARGEST_PRESSURE, None)
    return {LARGEST_PRESSURE: BESIDE_ENDS if hidden else COMPARED_ON_CORNERS}


def _uncertain_pressure(part: Sweep, compliances: tuple[BodyCompliance, ...]) -> dict[str, str]:
    """The peak pressure with the reason if no estimate bounds its error; else nothing."""
    if on_corner(part.site_corner).any():
        on_tips = on_corner(part.slices.corner_off_ends).any()
        return {PEAK_PRESSURE: ON_CORNERS if on_tips else ON_ENDS}
    return {PEAK_PRESSURE: ON_TIPS} if _on_tip(part, compliances) else {}


def _on_tip(part: Sweep, compliances: tuple[BodyCompliance, ...]) -> bool:
    """Whether a rounding or a chamfer carries load."""
    pairs = part.pairs
    loaded = pairs.column("force") > 0
    return any(
        modes.tip is not None
        and bool((pairs.column(f"s_{z + 1}")[loaded] > modes.range_mm[1]).any())
        for z, modes in enumerate(compliance.modes for compliance in compliances)
    )


def _of_cells(part: Sweep, coarse: Sweep, weights: Floats) -> dict[str, RemainingError]:
    errors = remaining_errors(STRIPS, part, part, coarse, weights)
    errors["peak_pressure"] = peak_of_cells(part, coarse)
    # a relative error of the rotation that is the same at all torques is also that of its
    # derivative
    if "stiffness_secant" in errors:
        errors["stiffness_tangent"] = errors["stiffness_secant"]
    return errors


def _of_compliances(
    part: Sweep,
    coarse: Sweep,
    others: Mapping[str, Sweep],
    of_modes: Rule,
    weights: Floats,
    slices_ratio: float,
) -> dict[str, dict[str, RemainingError]]:
    """Errors of modes and elements, from sweeps on coarse cells with other compliances."""
    rules = {"modes": of_modes, "elements": ELEMENTS}
    if "slices" in others:
        rules["slices"] = Rule.of_order(slices_ratio, SLICES_ORDER)
    errors = {
        source: remaining_errors(rules.get(source, SERIES), part, coarse, other, weights)
        for source, other in others.items()
    }
    if of_modes is not NODES and coarse.slices.plane:
        errors["modes"]["peak_pressure"] = peak_of_modes(
            of_modes, part, coarse, others["modes"], errors["modes"]["load_share"]
        )
    return errors


def _rule_of_modes(part: Sweep, compliances: tuple[BodyCompliance, ...]) -> Rule:
    if any(compliance.modes.nodes is not None for compliance in compliances):
        return NODES
    if not part.slices.plane or any(compliance.modes.closed for compliance in compliances):
        return SERIES
    return rule_of_modes(
        min((each.flank_modes for each in compliances if not each.is_rigid), default=0),
        slow=_has_wide_contacts(part, compliances),
    )


def _has_wide_contacts(part: Sweep, compliances: tuple[BodyCompliance, ...]) -> bool:
    """Whether a contact covers a large part of the shorter flank."""
    pairs = part.pairs
    loaded = pairs.column("force") > 0
    sites = pairs.sites[loaded] + (1 + pairs.sites.max(initial=0)) * pairs.position[loaded]
    width = np.bincount(sites, pairs.column("cell")[loaded])
    length = min(high - low for low, high in (each.modes.range_mm for each in compliances))
    return bool(width.max(initial=0.0) > COVERED * length)
