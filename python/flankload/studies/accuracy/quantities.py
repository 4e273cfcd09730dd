"""Quantities of a run in a study, and their differences from a reference."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from flankload.base.plain import plain
from flankload.studies.accuracy.ladder import Limit, largest_of, limit_of

if TYPE_CHECKING:
    from flankload.base.arrays import Floats
    from flankload.result import Result


#: Quantities that can be requested, and their errors.
MEASURES = {
    "transmission_error": (
        "transmission_error",
        "transmission_error_mean",
        "transmission_error_peak_to_peak",
    ),
    "load_share": ("load_share",),
    "peak_pressure": ("peak_pressure",),
    "stiffness": ("stiffness",),
    "face_load_factor": ("face_load_factor",),
}
#: Column heading of each error in a table.
HEADS = {
    "transmission_error": "TE",
    "transmission_error_mean": "mean",
    "transmission_error_peak_to_peak": "p-to-p",
    "load_share": "share",
    "peak_pressure": "pressure",
    "stiffness": "stiffness",
    "face_load_factor": "K_Hbeta",
}
#: Meaning of the columns.
MEANINGS = {
    "transmission_error": "largest error at a position, relative to the largest transmission error",
    "transmission_error_mean": "error of its mean",
    "transmission_error_peak_to_peak": "error of its peak to peak",
    "load_share": "largest error, as part of the load",
    "peak_pressure": "largest error off sharp corners, relative to the largest pressure there",
    "stiffness": "error of the mean secant or tangent stiffness, the larger one",
    "face_load_factor": "error of the face load factor, which is 1 in the plane",
}
#: Arrays over positions, and over positions and sites.
OVER_POSITIONS = ("transmission_error",)
OVER_SITES = ("load_share", "peak_pressure")
#: Scalars of a torque.
NUMBERS = (
    "transmission_error_mean",
    "transmission_error_peak_to_peak",
    "largest_pressure",
    "stiffness_secant",
    "stiffness_tangent",
    "face_load_factor",
)
#: All quantities that converge.
CONVERGING = (*OVER_POSITIONS, *OVER_SITES, *NUMBERS)
#: Scalars of a torque that do not converge.
CORNER = "corner_pressure"
#: A transmission error that varies less has no peak to peak.
LEAST_VARIATION_UM = 1e-3
#: Positions closer than this are equal, rad.
SAME_RAD = 1e-9

#: Arrays by name: `position_rad` (P,), `sites` (S,); for T torques those over positions (T, P),
#: over sites (T, P, S) and the scalars (T,); NaN if missing.
Quantities = dict[str, "Floats"]


def quantities_of(results: Result | Sequence[Result]) -> Quantities:
    """All quantities of the results of one scene, one per torque."""
    parts = results if isinstance(results, Sequence) else results.by_torque
    sites = np.unique(np.concatenate([r.sites for r in parts]))  # each torque has its own sites

    def over_sites(r: Result, values: Floats) -> Floats:
        whole = np.zeros((len(values), sites.size))
        whole[:, np.searchsorted(sites, r.sites)] = values
        return whole

    smooth = [over_sites(r, np.where(r.corner_contact, np.nan, r.peak_pressure_MPa)) for r in parts]

    def summary(key: str) -> Floats:
        return np.array([r.summary[key] for r in parts], dtype=float)

    return {
        "position_rad": parts[0].position_rad,
        "sites": sites.astype(float),
        "transmission_error": np.array([r.transmission_error_um for r in parts]),
        "load_share": np.array([over_sites(r, r.load_share) for r in parts]),
        "peak_pressure": np.array(smooth),
        "transmission_error_mean": summary("transmission_error_mean_um"),
        "transmission_error_peak_to_peak": summary("transmission_error_peak_to_peak_um"),
        "largest_pressure": summary("peak_pressure_MPa"),
        "stiffness_secant": summary("stiffness_secant_mean_Nm_per_rad"),
        "stiffness_tangent": summary("stiffness_tangent_mean_Nm_per_rad"),
        "face_load_factor": np.array([r.face_load_factor for r in parts]),
        CORNER: np.array([r.summary["corner_pressure_MPa"] or 0.0 for r in parts]),
    }


def common(runs: Sequence[Quantities]) -> list[Quantities]:
    """Restrict runs to common positions, on the union of sites; missing sites carry no load."""
    keys = [np.round(run["position_rad"] / SAME_RAD).astype(np.int64) for run in runs]
    shared = keys[0]
    for key in keys[1:]:
        shared = np.intersect1d(shared, key)
    sites = np.unique(np.concatenate([run["sites"] for run in runs]))
    found = []
    for run, key in zip(runs, keys, strict=True):
        order = np.argsort(key, kind="stable")
        rows = order[np.searchsorted(key, shared, sorter=order)]
        there = np.searchsorted(sites, run["sites"])
        part = dict(run)
        part["position_rad"], part["sites"] = run["position_rad"][rows], sites
        for name in OVER_POSITIONS:
            part[name] = run[name][:, rows]
        for name in OVER_SITES:
            whole = np.zeros((*run[name].shape[:1], rows.size, sites.size))
            whole[:, :, there] = run[name][:, rows]
            part[name] = whole
        found.append(part)
    return found


def limits_of(sizes: Sequence[float], runs: Sequence[Quantities]) -> dict[str, Limit]:
    """Limits of arrays and scalars, from runs at ascending step sizes: the finest first."""
    parts = common(runs[:3])
    return {name: limit_of(sizes, [part[name] for part in parts]) for name in CONVERGING}


def with_numbers(
    limits: Mapping[str, Limit], reference: Quantities, before: Quantities
) -> dict[str, Limit]:
    """Limits with scalars from a more accurate run, and their last change."""
    known = {
        name: replace(limits[name], value=reference[name], left=reference[name] - before[name])
        for name in NUMBERS
    }
    return {**limits, **known}


def shifted(run: Quantities, *shifts: Mapping[str, Floats]) -> Quantities:
    """A run shifted by what is added to its quantities, where that has their shape."""
    parts = dict(run)
    for shift in shifts:
        for name, values in shift.items():
            if values.shape == run[name].shape:
                parts[name] = parts[name] + values
    return parts


def largest(
    errors: Mapping[str, float], names: Iterable[str], doubts: Mapping[str, float] | None = None
) -> float | None:
    """The largest of some errors, each with its uncertainty; None if none is known."""
    doubts = doubts or {}
    known = (errors[name] + doubts.get(name, 0.0) for name in names if name in errors)
    return max(known, default=None)


def errors_of(run: Quantities, reference: Quantities) -> dict[str, float]:
    """Errors of a run by the names of `HEADS`, the largest over the torques."""
    one, two = common([run, reference])
    found: dict[str, list[float]] = {}
    for t in range(reference["transmission_error"].shape[0]):
        for name, error in _errors(one, two, t).items():
            found.setdefault(name, []).append(error)
    return {name: max(errors) for name, errors in found.items()}


def _errors(one: Quantities, two: Quantities, t: int) -> dict[str, float]:
    """Errors of one torque."""

    def change(name: str) -> float:
        return abs(float(one[name][t] - two[name][t]))

    curve = two["transmission_error"][t]
    found = {
        "transmission_error": _part(
            float(np.abs(one["transmission_error"][t] - curve).max()), float(np.abs(curve).max())
        ),
        "transmission_error_mean": _part(
            change("transmission_error_mean"), abs(float(two["transmission_error_mean"][t]))
        ),
        "load_share": largest_of(one["load_share"][t] - two["load_share"][t]),
    }
    span = float(two["transmission_error_peak_to_peak"][t])
    if span > LEAST_VARIATION_UM:
        found["transmission_error_peak_to_peak"] = change("transmission_error_peak_to_peak") / span
    highest = float(two["largest_pressure"][t])
    if highest > 0:
        local = largest_of(one["peak_pressure"][t] - two["peak_pressure"][t])
        found["peak_pressure"] = max(local, change("largest_pressure")) / highest
    if two["face_load_factor"][t] != 1.0:
        found["face_load_factor"] = change("face_load_factor") / two["face_load_factor"][t]
    stiffness = [
        change(name) / abs(float(two[name][t]))
        for name in ("stiffness_secant", "stiffness_tangent")
        if np.isfinite(two[name][t]) and np.isfinite(one[name][t])
    ]
    if stiffness:
        found["stiffness"] = max(stiffness)
    return found


def _part(change: float, whole: float) -> float:
    return change / whole if whole > 0 else 0.0


def to_tree(run: Quantities) -> dict[str, Any]:
    """Data in the form of JSON: null for NaN."""
    return {name: plain(values) for name, values in run.items()}


def from_tree(tree: Mapping[str, Any]) -> Quantities:
    """Inverse of `to_tree`."""
    return {name: np.array(values, dtype=float) for name, values in tree.items()}
