"""Export of results: strict JSON, CSV, labelled arrays."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from flankload.base.files import write_atomically
from flankload.base.optional import optional
from flankload.result.coast_contact import OVER_SITES as COAST
from flankload.result.coast_contact import coast_arrays
from flankload.result.csv_form import CsvForm
from flankload.result.friction import ALONG_POSITIONS as FRICTION
from flankload.result.root_stress import root_arrays, slice_root_arrays
from flankload.result.warning_lines import warning_lines

if TYPE_CHECKING:
    from flankload.result.result import Result

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
#: Arrays that are NaN if a pair is open; the others are 0 there.
ONLY_LOADED = {
    "contact_half_width_mm",
    "sliding_mm_per_rad",
    "specific_sliding_1",
    "specific_sliding_2",
}

SINGLE_NUMBERS = {
    "torque_Nm": "N m",
    "reference_radius_mm": "mm",
    "face_width_mm": "mm",
    "pitch_rad": "rad",
    "period_rad": "rad",
}


def along_positions(*results: Result) -> dict[str, str]:
    """Arrays over the positions of a result (or of several of one scene), with their units."""
    some = {
        key: unit
        for key, unit in ALONG_SOME_POSITIONS.items()
        if all(getattr(result, key) is not None for result in results)
    }
    return ALONG_POSITIONS | some


def results_to_json(results: Result | Sequence[Result], path: str | Path | None = None) -> str:
    """A result, or results of single torques, as strict JSON.

    Parameters
    ----------
    results : Result or sequence of Result
        A list of torques, or a sequence, gives {"torques_Nm": [...], "results": [...]}.
    path : path, optional
        File to write.

    Returns
    -------
    str
    """
    if isinstance(results, Sequence) or results.has_torque_list:
        results = results if isinstance(results, Sequence) else results.by_torque
        tree: Any = {
            "torques_Nm": [result.torque_Nm for result in results],
            "results": [_tree(result) for result in results],
        }
    else:
        tree = _tree(results)
    text = json.dumps(_plain(tree), allow_nan=False, ensure_ascii=False) + "\n"
    if path is not None:
        write_atomically(path, text)
    return text


def _tree(result: Result) -> dict[str, Any]:
    keys = [
        "name",
        *SINGLE_NUMBERS,
        "closed",
        "whole_circle",
        "sites",
        *along_positions(result),
        *OVER_SITES,
    ]
    keys += ["summary", "estimate", "cost", "warnings"]
    tree = {key: getattr(result, key) for key in keys}
    if result.outside_limits:
        tree["outside_limits"] = result.outside_limits
    if result.slices is not None:
        tree["slice_z_mm"] = result.slice_z_mm
        tree |= {key: values for key, (values, _) in slice_arrays(result).items()}
        tree["axial_force_N"] = result.slices.axial_force_N
        tree["tilting_moment_Nm"] = result.slices.tilting_moment_Nm
        if result.slices.tilting_moments_Nm is not None:
            tree["tilting_moments_Nm"] = result.slices.tilting_moments_Nm
    if result.shafts is not None:
        tree |= result.shafts.bearing_forces
    tree["friction"] = result.friction.as_dict() if result.friction is not None else None
    if result.accuracy is not None:
        tree["accuracy"] = result.accuracy
    if result.drive is not None:
        tree["drive"] = result.drive.as_dict()
    tree |= {name: values for name, (values, _) in _arrays_asked_for(result).items()}
    tree["pairs"] = [table.columns() for table in result.pair_tables]
    if result.coast is not None:
        tree["coast_pairs"] = [table.columns() for table in result.coast.pair_tables]
    return tree


def more_arrays(result: Result) -> dict[str, tuple[Any, str]]:
    """Arrays (P, S) that only some results have, with their units."""
    found = _arrays_asked_for(result)
    if result.drive is not None:
        found |= {
            key: (getattr(result.drive, key), unit) for key, unit in result.drive.over_sites.items()
        }
    return found


def slice_arrays(result: Result) -> dict[str, tuple[Any, str]]:
    """Arrays (P, S, J), with their units."""
    found = {key: (getattr(result, key), unit) for key, unit in OVER_SLICES.items()}
    if result.slices is not None:
        for z, stress in enumerate(result.root_stress):
            if stress is not None:
                found |= slice_root_arrays(stress, z)
    return found


def _arrays_asked_for(result: Result) -> dict[str, tuple[Any, str]]:
    """Arrays (P, S) of coast flanks and of root stress, with their units, if requested."""
    found = coast_arrays(result)
    for z, stress in enumerate(result.root_stress):
        if stress is not None:
            found |= root_arrays(stress, z)
    return found


def _plain(value: Any) -> Any:
    """Plain lists, numbers and None, as JSON allows them."""
    if isinstance(value, np.ndarray | np.generic):
        value = value.tolist()
    if isinstance(value, float):
        return value if isfinite(value) else None
    if isinstance(value, Mapping):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    if value is None or isinstance(value, str | int):
        return value
    raise TypeError(f"the result contains {type(value).__name__}, which JSON cannot represent")


def results_to_csv(
    results: Result | Sequence[Result],
    path: str | Path | None = None,
    form: CsvForm | None = None,
) -> str:
    """A result, or results of single torques, as CSV: a row per position (and torque).

    Parameters
    ----------
    results : Result or sequence of Result
    path : path, optional
        File to write.
    form : CsvForm, optional
        Separator, decimal sign and unit of angles.

    Returns
    -------
    str
        Column names contain units, and the pair number for columns of a single pair; an empty cell
        is not a number.
    """
    several = results if isinstance(results, Sequence) else results.by_torque
    form = CsvForm() if form is None else form
    friction_units = FRICTION if any(result.friction is not None for result in several) else {}
    drives = several[0].drive.along if several[0].drive is not None else {}
    sites = sorted({int(site) for result in several for site in result.sites})
    keys = over_sites(*several)
    along = along_positions(*several)
    units = {
        "torque_Nm": "N m",
        **along,
        **{f"friction_{key}": unit for key, unit in friction_units.items()},
        **drives,
        **{f"{key}_pair_{j}": unit for j in sites for key, unit in keys.items()},
    }
    rows = [[form.head(key, unit) for key, unit in units.items()]]
    for result in several:
        at_sites = SiteValues(result)
        for p in range(result.position_rad.size):
            row = [result.torque_Nm, *(at_position(result, key, p) for key in along)]
            row += [getattr(result.friction, key)[p] for key in friction_units]
            row += [getattr(result.drive, key)[p] for key in drives]
            row += [at_sites(key, p, j) for j in sites for key in keys]
            rows.append(list(map(form.cell, row, units.values())))
    text = form.lines(rows)
    if path is not None:
        write_atomically(path, text)
    return text


def over_sites(*results: Result) -> dict[str, str]:
    """Arrays over positions and sites of any of several results, with their units."""
    more = {key: unit for r in results for key, (_, unit) in more_arrays(r).items()}
    return {**OVER_SITES, **more}


class SiteValues:
    """Values of a result by quantity, position and pair number.

    Parameters
    ----------
    result : Result
    """

    def __init__(self, result: Result) -> None:
        self._over = {key: getattr(result, key) for key in OVER_SITES}
        # not by slices
        self._over["line_load_N_per_mm"] = result.site_force_N / result.face_width_mm
        self._over |= {key: values for key, (values, _) in more_arrays(result).items()}
        self._column = {int(site): s for s, site in enumerate(result.sites)}

    def __call__(self, key: str, p: int, site: int) -> Any:
        """Value at position p of a pair, which the result need not have."""
        return _at_site(self._over, key, p, self._column.get(site))


def at_position(result: Result, key: str, p: int) -> Any:
    """Value of an array over the positions; NaN where the result has none."""
    values = getattr(result, key)
    return float("nan") if values is None else values[p]


def _at_site(over: Mapping[str, Any], key: str, p: int, s: int | None) -> Any:
    """Value of a pair, also of one that is unloaded at all positions of a torque."""
    if s is None:
        return _unloaded(key)
    return over[key][p, s] if key in over else float("nan")


def _unloaded(key: str) -> Any:
    """Value of a pair that is unloaded at all positions of a torque."""
    carried = key in OVER_SITES or key in OVER_SLICES or key in COAST
    return 0 if carried and key not in ONLY_LOADED else float("nan")


def to_xarray(results: Result | Sequence[Result]) -> Any:
    """A result, or results of single torques, as a labelled dataset.

    Parameters
    ----------
    results : Result or sequence of Result

    Returns
    -------
    xarray.Dataset
        Dimensions `position` (coordinate: angle of body 1, rad), `site` (pair number) and `slice`
        (axial position, mm; one in a plane scene); units in the attributes of each variable. A list
        of torques, or a sequence, has the dimension `torque` in front (coordinate: N m); a pair
        that a torque never loads has the values of an open pair there.

    Raises
    ------
    ImportError
        If xarray is not installed.
    """
    xarray = optional("xarray", "to_xarray")
    if not isinstance(results, Sequence) and not results.has_torque_list:
        return _dataset(results)
    several = results if isinstance(results, Sequence) else results.by_torque
    torque = [one.torque_Nm for one in several]
    sets = [_dataset(one) for one in several]
    joined = xarray.concat(
        sets,
        xarray.IndexVariable("torque", torque, {"units": "N m"}),
        data_vars="all",
        coords="minimal",
        compat="equals",
        join="outer",
        fill_value={key: _unloaded(key) for data in sets for key in data},
        combine_attrs="override",
    )
    del joined.attrs["torque_Nm"]
    return joined.assign_attrs(warnings=warning_lines(several))


def _dataset(result: Result) -> Any:
    """Dataset of one torque."""
    import xarray

    def variable(dimensions: tuple[str, ...], key: str, unit: str) -> tuple[Any, ...]:
        return dimensions, getattr(result, key), {"units": unit}

    along = {
        key: variable(("position",), key, unit)
        for key, unit in along_positions(result).items()
        if key != "position_rad" and getattr(result, key) is not None
    }
    if result.friction is not None:
        for key, unit in FRICTION.items():
            values = getattr(result.friction, key)
            along[f"friction_{key}"] = (("position",), values, {"units": unit})
    if result.drive is not None:
        for key, unit in result.drive.along.items():
            along[key] = (("position",), getattr(result.drive, key), {"units": unit})
    dimensions = ("position", "site", "slice")
    over = {
        key: variable(dimensions[: getattr(result, key).ndim], key, unit)
        for key, unit in OVER_SITES.items()
    }
    for key, (values, unit) in slice_arrays(result).items():
        over[key] = dimensions, values, {"units": unit}
    for key, (values, unit) in more_arrays(result).items():
        over[key] = ("position", "site"), values, {"units": unit}
    return xarray.Dataset(
        {**along, **over},
        coords={
            "position": variable(("position",), "position_rad", "rad"),
            "site": ("site", result.sites, {"long_name": "pair number"}),
            "slice": variable(("slice",), "slice_z_mm", "mm"),
        },
        attrs={
            "name": result.name,
            **{key: getattr(result, key) for key in SINGLE_NUMBERS},
            "warnings": list(result.warnings),
        },
    )
