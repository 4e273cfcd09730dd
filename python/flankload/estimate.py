"""Error estimates from embedded pairs: the same sweep with coarser cells and with a mode less.

Lumped contact has no cells; what it leaves is taken from what was measured of it.

Both coarser sweeps use what is there already (no further finite elements): halving the number of
strips shows the error of the cells, dropping the highest pressure mode (the Legendre modes are
orthogonal, so the smaller matrix is a block of the larger) that of the load modes. The error of
the mesh has no embedded pair and is not seen; with the default resolution it is smaller than that
of the modes (FZG type C pair: 0.03 % of the rotation against 0.1 %).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from flankload.sweep import END_WOULD_TOUCH

if TYPE_CHECKING:
    from collections.abc import Callable

    from flankload.adaptive_positions import PositionErrors
    from flankload.compliance import BodyCompliance
    from flankload.resolution import Grid
    from flankload.sweep import Sweep


#: Sweeps of an estimate: with coarser cells, with a mode less; of lumped contacts with that alone.
N_SWEEPS, N_SWEEPS_LUMPED = 2, 1
#: What lumping contacts leaves, by the largest half-width h over the length L of the shorter flank:
#: measured against pairs on gears, rings and cams, sharp, rounded and relieved, under 0.03 to 3
#: times their torque. (h/L)² times the first number, and the second in any case; where a corner, a
#: kink or a rounding takes part, h/L times the third (the pressure there is not told).
LUMPED = {
    "transmission_error": (0.7, 1e-4, 0.3),
    "load_share": (0.3, 0.0, 0.2),
    "peak_pressure": (3.0, 0.003, 0.0),
}


@dataclass(frozen=True)
class Estimate:
    """Estimated relative errors.

    Attributes
    ----------
    transmission_error, load_share, peak_pressure : float
        Largest over the positions: relative to the value (transmission error, peak pressure; the
        latter off sharp corners), or share of the load (load share).
    by_source : dict
        The same by source.
    """

    transmission_error: float
    load_share: float
    peak_pressure: float
    by_source: dict[str, dict[str, float]]

    def as_dict(self, *, positions: PositionErrors | None = None) -> dict[str, object]:
        """The form of the result: one number per quantity, and the table by source.

        Adaptive positions are a source of its own, of what follows from the whole curve.
        """
        by_source = dict(self.by_source)
        if positions is not None:
            by_source["positions"] = {
                "transmission_error_harmonics": positions.harmonics,
                "transmission_error_peak_to_peak": positions.peak_to_peak,
            }
        return {
            "transmission_error": self.transmission_error,
            "load_share": self.load_share,
            "peak_pressure": self.peak_pressure,
            "by_source": by_source,
        }


def estimate_errors(
    found: tuple[Sweep, ...],
    run: Callable[..., tuple[Sweep, ...]],
    compliances: tuple[BodyCompliance, BodyCompliance],
    grid: Grid,
    *,
    lumped: bool = False,
) -> tuple[Estimate, ...]:
    """Estimate the errors of a sweep.

    Parameters
    ----------
    found : tuple of Sweep
        The sweep in question, one part per torque.
    run : callable
        run(compliances=…, grid=…, part=…) sweeps the same positions and torques with other ones;
        part counts its calls from 0.
    compliances, grid
        Those of the sweep in question.
    lumped : bool
        Contacts are lumped: there are no cells, in their place stands what is known of that level.

    Returns
    -------
    tuple of Estimate, one per torque
    """
    fewer = tuple(compliance.fewer_modes() for compliance in compliances)
    if lumped:
        modes = run(compliances=fewer, grid=grid, part=0)
        return tuple(
            _estimate(
                {"modes": _differences(fine, modes[t]), "lumped": lumped_error(fine, compliances)}
            )
            for t, fine in enumerate(found)
        )
    coarse_grid = replace(
        grid,
        strips_per_half_width=grid.strips_per_half_width / 2,
        corner_strips_per_half_width=grid.corner_strips_per_half_width / 2,
    )
    others = {
        "strips": run(compliances=compliances, grid=coarse_grid, part=0),
        "modes": run(compliances=fewer, grid=grid, part=1),
    }
    return tuple(
        _estimate({source: _differences(fine, other[t]) for source, other in others.items()})
        for t, fine in enumerate(found)
    )


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
    return {
        quantity: max(square * ratio**2 + least, linear * ratio if shaped else 0.0)
        for quantity, (square, least, linear) in LUMPED.items()
    }


def _estimate(by_source: dict[str, dict[str, float]]) -> Estimate:
    total = {
        quantity: float(np.linalg.norm([source[quantity] for source in by_source.values()]))
        for quantity in ("transmission_error", "load_share", "peak_pressure")
    }
    return Estimate(**total, by_source=by_source)


def _differences(fine: Sweep, coarse: Sweep) -> dict[str, float]:
    """Largest differences between two sweeps, per quantity."""
    rotation = np.abs(coarse.rotation_rad - fine.rotation_rad) / np.max(np.abs(fine.rotation_rad))
    total = np.maximum(fine.site_force_N.sum(axis=1, keepdims=True), np.finfo(float).tiny)
    share = np.abs(coarse.site_force_N - fine.site_force_N) / total
    smooth = (fine.site_corner <= 0) & (coarse.site_corner <= 0) & (fine.site_peak_N_per_mm > 0)
    peak = np.abs(coarse.site_peak_N_per_mm - fine.site_peak_N_per_mm)[smooth]
    scale = np.max(fine.site_peak_N_per_mm[smooth], initial=np.finfo(float).tiny)
    return {
        "transmission_error": float(rotation.max()),
        "load_share": float(share.max()),
        "peak_pressure": float(np.max(peak / scale, initial=0.0)),
    }
