"""Numbers and arrays that leave a result, by their names in files and with their units."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from flankload.base.number_text import percent
from flankload.result.friction import ALONG_POSITIONS as FRICTION
from flankload.result.optional_results import OVER_COAST_SITES
from flankload.result.root_stress import root_arrays, slice_root_arrays

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator, Sequence

    from flankload.result.forms import ResultForms
    from flankload.result.result import Result

    #: Values and unit of arrays by their names.
    Arrays = dict[str, tuple[Any, str]]

SINGLE_NUMBERS = {
    "torque_Nm": "N m",
    "reference_radius_mm": "mm",
    "face_width_mm": "mm",
    "pitch_rad": "rad",
    "period_rad": "rad",
}
#: Arrays over the positions, with their units.
ALONG_POSITIONS = {
    "position_rad": "rad",
    "rotation_rad": "rad",
    "transmission_error_um": "um",
    "stiffness_secant_Nm_per_rad": "N m/rad",
    "stiffness_tangent_Nm_per_rad": "N m/rad",
    "stiffness_secant_N_per_um": "N/um",
    "stiffness_tangent_N_per_um": "N/um",
    "loaded_pairs": "1",
    "potential_pairs": "1",
    "coast_flank_gap_um": "um",
    "status": "1",
}
#: Arrays over the positions that only some pairs have.
ALONG_SOME_POSITIONS = {
    "follower_angle_rad": "rad",
    "unloaded_transmission_error_um": "um",
    "tilt_um_per_mm": "um/mm",
}
#: Arrays over positions and sites, with their units.
OVER_SITES = {
    "load_share": "1",
    "site_force_N": "N",
    "line_load_N_per_mm": "N/mm",
    "peak_pressure_MPa": "MPa",
    "corner_contact": "1",
    "contact_half_width_mm": "mm",
    "sliding_mm_per_rad": "mm/rad",
    "specific_sliding_1": "1",
    "specific_sliding_2": "1",
}
#: Arrays over positions, sites and slices, with their units.
OVER_SLICES = {"slice_line_load_N_per_mm": "N/mm", "slice_peak_pressure_MPa": "MPa"}
#: Arrays that are NaN if a pair is open.
ONLY_LOADED = (
    "contact_half_width_mm",
    "sliding_mm_per_rad",
    "specific_sliding_1",
    "specific_sliding_2",
)
#: Least possible values of numbers of the summary and of curves that have one; a path of several
#: names is that of its last one.
LEAST = {
    **dict.fromkeys(
        (
            *("transmission_error_peak_to_peak_um", "transmission_error_harmonics_um"),
            *("transmission_error_mesh_harmonics_um", "contact_ratio_under_load"),
            *("loaded_pairs", "loaded_pairs_min", "loaded_pairs_max", "potential_pairs"),
            *("peak_pressure_MPa", "corner_pressure_MPa", "peak_line_load_N_per_mm"),
            *("coast_flanks_loaded_min", "coast_flanks_loaded_max", "coast_force_N"),
            *("coast_peak_pressure_MPa", "coast_corner_pressure_MPa"),
            *("largest_sliding_mm_per_rad", "range_MPa"),
            *("axial_force_N", "tilting_moment_Nm", "friction_loss_J_per_rad"),
            *("power_W", "power_loss_W"),
        ),
        0.0,
    ),
    **dict.fromkeys(("face_load_factor", "line_load_factor"), 1.0),
}
#: Values of a pair at a torque that never loads it; NaN in all other arrays.
UNLOADED = {
    **dict.fromkeys((*OVER_SITES, *OVER_SLICES, *OVER_COAST_SITES), 0),
    **dict.fromkeys(ONLY_LOADED, np.nan),
    "mean_line_load_N_per_mm": 0,
    "flank_face_load_factor": 1,
}


def plus_minus(estimate: Mapping[str, Any] | None, quantity: str, sign: str = "+-") -> str:
    """Estimated relative error of a quantity, behind its value; empty without an estimate."""
    error = (estimate or {}).get(quantity)
    return "" if error is None else f" {sign} {percent(error)}"


def least_of(name: str) -> float:
    """Least possible value of a quantity by its name; minus infinity if there is none."""
    return LEAST.get(name.rpartition(".")[2], -np.inf)


def torques_of(results: ResultForms | Sequence[Result]) -> tuple[Result, ...]:
    """A result per torque."""
    several: Sequence[Result] = getattr(results, "by_torque", results)  # type: ignore[arg-type]
    return tuple(several)


def curves_of(result: Result) -> dict[str, tuple[object, str, str]]:
    """Owner, attribute and unit of each array (P,), also of friction and of a drive.

    The arrays themselves take time, and a result may have None in place of some.
    """
    some = {
        key: unit for key, unit in ALONG_SOME_POSITIONS.items() if getattr(result, key) is not None
    }
    found: dict[str, tuple[object, str, str]] = {
        key: (result, key, unit) for key, unit in (ALONG_POSITIONS | some).items()
    }
    if result.friction is not None:
        for key, unit in FRICTION.items():
            found[f"friction_{key}"] = result.friction, key, unit
    if result.drive is not None:
        found |= {key: (result.drive, key, unit) for key, unit in result.drive.units("P").items()}
    return found


def along_positions(result: Result) -> Arrays:
    """Arrays (P,) that the result has, also of friction and of a drive."""
    found = {
        name: (getattr(owner, key), unit) for name, (owner, key, unit) in curves_of(result).items()
    }
    return {name: array for name, array in found.items() if array[0] is not None}


def _arrays(owner: object, units: Mapping[str, str]) -> Arrays:
    return {key: (getattr(owner, key), unit) for key, unit in units.items()}


def over_sites(result: Result) -> Arrays:
    """Arrays (P, S), in three dimensions without slices."""
    over = _arrays(result, OVER_SITES) | over_some_sites(result)
    over["line_load_N_per_mm"] = result.site_force_N / result.face_width_mm, "N/mm"
    return over | ({} if result.drive is None else _arrays(result.drive, result.drive.units("PS")))


def over_some_sites(result: Result) -> Arrays:
    """Arrays (P, S) of coast flanks and of root stress, if requested."""
    found = {} if result.coast is None else _arrays(result, OVER_COAST_SITES)
    for z, stress in enumerate(result.root_stress):
        if stress is not None:
            found |= root_arrays(stress, z)
    return found


def over_slices(result: Result) -> Arrays:
    """Arrays (P, S, J)."""
    found = _arrays(result, OVER_SLICES)
    if result.slices is not None:
        for z, stress in enumerate(result.root_stress):
            if stress is not None:
                found |= slice_root_arrays(stress, z)
    return found


def units_of(every: Iterable[Arrays], always: Mapping[str, str]) -> dict[str, str]:
    """Units of the arrays of several results: those of all results first."""
    return {**always, **{key: unit for arrays in every for key, (_, unit) in arrays.items()}}


def column(result: Result, arrays: Arrays, key: str) -> Any:
    """(P,) An array over the positions; NaN if the result has none."""
    return arrays[key][0] if key in arrays else np.full(result.position_rad.size, np.nan)


def site_column(result: Result, arrays: Arrays, key: str, site: int) -> Any:
    """(P,) Values of a pair, also of one that the torque of the result never loads."""
    own = np.flatnonzero(result.sites == site)
    if own.size == 0:
        return np.full(result.position_rad.size, UNLOADED.get(key, np.nan))
    return arrays[key][0][:, own[0]] if key in arrays else column(result, arrays, key)


def by_path(
    values: Mapping[str, Any], of_item: Callable[[int], str], before: str = ""
) -> Iterator[tuple[str, Any]]:
    """Entries of nested mappings and sequences by their path; `of_item`: step to the n-th item."""
    for key, value in values.items():
        path = f"{before}{key}"
        if isinstance(value, Mapping):
            yield from by_path(value, of_item, f"{path}.")
        elif isinstance(value, list | tuple | np.ndarray):
            yield from by_path({of_item(n): one for n, one in enumerate(value)}, of_item, path)
        else:
            yield path, value
