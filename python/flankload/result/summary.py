"""Summary beyond transmission error, load sharing and pressure."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from flankload.result.harmonics import over_positions

if TYPE_CHECKING:
    from flankload.result.result import Result

#: Stiffnesses and the names of their means.
STIFFNESS_MEANS = {
    "stiffness_tangent_N_per_um": "stiffness_tangent_mean_N_per_um",
    "stiffness_secant_N_per_um": "stiffness_secant_mean_N_per_um",
    "stiffness_tangent_Nm_per_rad": "stiffness_tangent_mean_Nm_per_rad",
    "stiffness_secant_Nm_per_rad": "stiffness_secant_mean_Nm_per_rad",
}


def stiffness_means(result: Result) -> dict[str, float | None]:
    """Means over the period; None if the positions do not cover it."""
    means: dict[str, float | None] = {}
    over = over_positions(result)
    for key, name in STIFFNESS_MEANS.items():
        values = getattr(result, key)
        known = (over.covers_period or result.stands_alike) and np.isfinite(values).all()
        means[name] = over.mean(values) if known else None
    return means


def summary_of_contacts(result: Result) -> dict[str, Any]:
    """Largest line load and its place, largest sliding, least distance of the coast flanks."""
    load = result.slice_line_load_N_per_mm.max(axis=2)
    p, s = np.unravel_index(np.argmax(load), load.shape)
    loaded = float(load[p, s]) > 0
    sliding = np.abs(result.sliding_mm_per_rad)
    coast = result.coast_flank_gap_um
    return {
        "peak_line_load_N_per_mm": float(load[p, s]),
        "peak_line_load_position_rad": float(result.position_rad[p]) if loaded else None,
        "peak_line_load_pair": int(result.sites[s]) if loaded else None,
        "largest_sliding_mm_per_rad": _finite(np.nanmax, sliding),
        "coast_flank_gap_min_um": None if coast is None else _finite(np.nanmin, coast),
    }


def _finite(choose: Any, values: Any) -> float | None:
    """The least or largest finite value."""
    return float(choose(values)) if np.isfinite(values).any() else None
