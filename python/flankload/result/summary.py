"""Key figures and summary of a result."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from flankload.base.rounding import TIE
from flankload.result.corners import off_corners, on_corners
from flankload.result.harmonics import over_positions

if TYPE_CHECKING:
    from flankload.base.arrays import Floats
    from flankload.result.optional_results import CoastContact
    from flankload.result.result import Result
    from flankload.result.root_stress import RootStress


#: Stiffnesses by the names of their means.
STIFFNESS_MEANS = {
    f"stiffness_{kind}_mean_{unit}": f"stiffness_{kind}_{unit}"
    for unit in ("N_per_um", "Nm_per_rad")
    for kind in ("tangent", "secant")
}
#: Stresses that differ by less, relative to the largest, are those of the same tooth.
EQUAL_STRESS = 1e-12
#: Why an entry is None in a result under load.
NO_VALUE = {
    "peak_pressure_MPa": "all contact is on sharp corners, where no finite pressure exists",
}


def key_figures(result: Result) -> dict[str, Any]:
    """Entries of the summary that follow from few curves."""
    error, loaded, geometry = result.transmission_error_um, result.loaded_pairs, result.geometry
    by_load = 1000.0 * result.turned_by_load_rad * result.reference_radius_mm
    over = over_positions(result)
    return {
        "transmission_error_mean_um": over.mean(error),
        "transmission_error_by_load_mean_um": over.mean(by_load),
        "transmission_error_peak_to_peak_um": float(np.ptp(error)),
        "transmission_error_harmonics_um": over.harmonics(error),
        "transmission_error_mesh_harmonics_um": over.harmonics(error, every=result.period_pitches),
        "contact_ratio_under_load": over.mean_of_steps(loaded)
        if over.covers_period and not result.engagement.sites_stay
        else None,
        "contact_ratio_geometric": geometry.contact_ratio if geometry else None,
        "contact_ratio_usable": geometry.usable_contact_ratio if geometry else None,
        "overlap_ratio": geometry.overlap_ratio if geometry else None,
        "contact_ratio_total": geometry.total_contact_ratio if geometry else None,
        "loaded_pairs_min": int(loaded.min()),
        "loaded_pairs_max": int(loaded.max()),
        "load_share_max": float(result.load_share.max()),
        **_largest(result, "peak_pressure", "MPa", off_corners(result)),
        **_on_corners(result, "corner_pressure", result),
    }


def summary(result: Result) -> dict[str, Any]:
    """`Result.summary`."""
    line_load = result.mean_line_load_N_per_mm.max(axis=2)
    sliding, gap = np.abs(result.sliding_mm_per_rad), result.coast_flank_gap_um
    return {
        **result.key_figures,
        **_stiffness_means(result),
        **_largest(result, "peak_line_load", "N_per_mm", line_load),
        "largest_sliding_mm_per_rad": _finite(np.nanmax, sliding),
        "coast_flank_gap_min_um": None if gap is None else _finite(np.nanmin, gap),
        **_of_coast_flanks(result),
        **{
            f"root_stress_{z + 1}": _of_roots(result, stress)
            for z, stress in enumerate(result.root_stress)
            if stress is not None
        },
        **result.width_loads.summary(),
        **_of_shafts(result),
        **_of_power(result),
        **({} if result.drive is None else result.drive.summary(result)),
    }


def _largest(
    result: Result, key: str, unit: str, values: Floats, *, same: float = 0.0
) -> dict[str, Any]:
    """The first of the largest values (P, S) with its position and pair.

    Position and pair are None if all values are 0, the value as well if all are NaN.
    """
    p, s = np.unravel_index(np.argmax(values >= (1.0 - same) * values.max()), values.shape)
    found = float(values[p, s])
    return {
        f"{key}_{unit}": None if np.isnan(found) else found,
        f"{key}_position_rad": float(result.position_rad[p]) if found > 0 else None,
        f"{key}_pair": int(result.sites[s]) if found > 0 else None,
    }


def _on_corners(result: Result, key: str, contact: Result | CoastContact) -> dict[str, Any]:
    """The largest pressure on sharp corners with its position and pair; None without one."""
    found = _largest(result, key, "MPa", on_corners(contact))
    return found if found[f"{key}_pair"] is not None else dict.fromkeys(found)


def _finite(choose: Any, values: Floats) -> float | None:
    """The least or largest finite value."""
    return float(choose(values)) if np.isfinite(values).any() else None


def _stiffness_means(result: Result) -> dict[str, float | None]:
    """Means over the period; None if the positions do not cover it."""
    over = over_positions(result)
    covered = over.covers_period or result.stands_alike
    every = {name: getattr(result, key) for name, key in STIFFNESS_MEANS.items()}
    return {
        name: over.mean(values) if covered and np.isfinite(values).all() else None
        for name, values in every.items()
    }


def _of_coast_flanks(result: Result) -> dict[str, Any]:
    """Numbers of coast flanks that carry load at once, largest force, largest pressure."""
    coast = result.coast
    if coast is None:
        return {}
    # of equal values the first one, independent of roundoff
    return {
        "coast_flanks_loaded_min": int(coast.loaded.min()),
        "coast_flanks_loaded_max": int(coast.loaded.max()),
        **_largest(result, "coast_force", "N", coast.force_N, same=TIE),
        **_largest(result, "coast_peak_pressure", "MPa", off_corners(coast), same=TIE),
        **_on_corners(result, "coast_corner_pressure", coast),
    }


def _of_roots(result: Result, stress: RootStress) -> dict[str, Any]:
    """Largest tension and compression with their places, and the largest stress range."""
    found: dict[str, Any] = {}
    for name, sign in (("tension", 1.0), ("compression", -1.0)):
        extremes = getattr(stress, name)
        values = sign * extremes.stress_MPa
        places = np.argwhere(values >= values.max() - EQUAL_STRESS * np.abs(values).max())
        # of sites with the same tooth, a loaded one is reported
        p, s = places[result.site_force_N[tuple(places.T)].argmax()]
        found[name] = {
            "stress_MPa": float(extremes.stress_MPa[p, s]),
            "position_rad": float(result.position_rad[p]),
            "pair": int(result.sites[s]),
            "arc_length_mm": float(extremes.arc_length_mm[p, s]),
            "radius_mm": float(extremes.radius_mm[p, s]),
            "slant_deg": float(extremes.slant_deg[p, s]),
            "side": "working" if extremes.working[p, s] else "coast",
        }
        if extremes.z_mm is not None:
            found[name]["z_mm"] = float(extremes.z_mm[p, s])
    span = stress.stress_MPa.max(axis=(0, 1)) - stress.stress_MPa.min(axis=(0, 1))
    found["range_MPa"] = float(span.max())
    return found


def _of_shafts(result: Result) -> dict[str, Any]:
    """Mean tilt, largest force on each bearing, and the factor of ISO 6336 if it applies."""
    shafts = result.shafts
    if shafts is None:
        return {}
    largest = {
        name.replace("_N", "_max_N"): np.linalg.norm(force, axis=2).max(axis=0).tolist()
        for name, force in shafts.bearing_forces.items()
    }
    compared = {} if shafts.k_h_beta_iso is None else {"k_h_beta_iso": shafts.k_h_beta_iso}
    tilt = over_positions(result).mean(shafts.tilt_um_per_mm)
    return {"tilt_mean_um_per_mm": tilt, **largest, **compared}


def _of_power(result: Result) -> dict[str, float]:
    """Power of the torque on body 1 and of friction, if the scene gives a speed."""
    geometry, friction = result.geometry, result.friction
    if geometry is None or not geometry.speed_rpm:
        return {}
    rad_per_s = geometry.speed_rpm * np.pi / 30.0
    found = {"power_W": float(result.torque_Nm * rad_per_s)}
    if friction is not None and friction.loss_work_J is not None:
        found["power_loss_W"] = float(friction.loss_work_J / result.period_rad * rad_per_s)
    return found
