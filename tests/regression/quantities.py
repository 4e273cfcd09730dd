"""Quantities of a reference: units, and the distance that counts as a change."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from flankload.result import Result


@dataclass(frozen=True)
class Quantity:
    """One quantity of a reference.

    Attributes
    ----------
    unit : str
    rtol, atol : float
        A number may differ by atol + rtol times the largest number of its quantity.
    reason : str
        Why just that much.
    """

    unit: str
    rtol: float
    atol: float
    reason: str


_SOLVED = "equations solved to rounding; condition below 1e6"
_ROUNDED = "sums of a few thousand terms in another order, zones bracketed to 1e-9 of their width"
_PLACED = _ROUNDED + "; flanks known to 1e-9 mm"
_EXACT = "a count"
_WORD = "a word"

#: Of contact problems.
CONTACT = {
    "outcome": Quantity("", 0.0, 0.0, _WORD),
    "status": Quantity("1", 0.0, 0.0, _EXACT),
    "active_pairs": Quantity("1", 0.0, 0.0, _EXACT),
    "motions": Quantity("rad or mm", 1e-9, 0.0, _SOLVED),
    "forces": Quantity("N", 1e-9, 0.0, _SOLVED),
    "gaps": Quantity("rad or mm", 1e-9, 0.0, _SOLVED),
    "tangent": Quantity("motion/load", 1e-9, 0.0, _SOLVED),
    "sums_of_groups": Quantity("N", 1e-9, 0.0, "sums of forces not determined pair by pair"),
    "condition": Quantity("1", 1e-2, 0.0, "an estimate of a norm"),
    "held": Quantity("N mm", 1e-6, 1e-12, "where a path ends, found by the last of its steps"),
}

#: Of a position or a sweep of points.
NODAL = {
    "status": Quantity("1", 0.0, 0.0, _EXACT),
    "pairs": Quantity("1", 0.0, 0.0, _EXACT),
    "rotation": Quantity("rad", 1e-9, 0.0, _SOLVED),
    "tangent": Quantity("rad/(N mm)", 1e-9, 0.0, _SOLVED),
    "torque_2": Quantity("N mm", 1e-9, 0.0, _SOLVED),
    "flank_force": Quantity("N", 1e-9, 0.0, _SOLVED),
    "largest_force": Quantity("N", 1e-9, 0.0, _SOLVED),
    "gap_angle": Quantity("rad", 1e-9, 1e-14, "a difference of two angles"),
    "influence": Quantity("mm/N", 1e-9, 0.0, "two tables read by straight lines"),
    "levers": Quantity("mm", 1e-9, 0.0, "a product with a normal of a spline"),
}

#: Of scenes.
SCENE = {
    "sites": Quantity("1", 0.0, 0.0, _EXACT),
    "status": Quantity("1", 0.0, 0.0, _EXACT),
    "loaded_pairs": Quantity("1", 0.0, 0.0, _EXACT),
    "pairs": Quantity("1", 0.0, 0.0, _EXACT),
    "position_rad": Quantity("rad", 1e-12, 1e-14, "no more than a product"),
    "rotation_rad": Quantity("rad", 1e-6, 1e-11, _PLACED),
    "transmission_error_um": Quantity("um", 1e-6, 1e-6, _PLACED),
    "load_share": Quantity("1", 1e-6, 0.0, _ROUNDED),
    "site_force_N": Quantity("N", 1e-6, 0.0, _ROUNDED),
    "coast_force_N": Quantity("N", 1e-6, 0.0, _ROUNDED),
    "peak_pressure_MPa": Quantity(
        "MPa", 1e-5, 0.0, "a force over its cell: the least smooth number"
    ),
    "stiffness_secant_Nm_per_rad": Quantity("N m/rad", 1e-6, 0.0, _ROUNDED),
    "stiffness_tangent_Nm_per_rad": Quantity(
        "N m/rad", 1e-5, 0.0, "a difference over 2e-3 of the torque of rotations known to 1e-9"
    ),
    "fe_factorisations": Quantity("1", 0.0, 0.0, _EXACT),
}

#: Of those scenes that are about them.
MORE = {
    "root_tension_MPa": Quantity("MPa", 1e-6, 0.0, _ROUNDED),
    "root_compression_MPa": Quantity("MPa", 1e-6, 0.0, _ROUNDED),
    "transmission_error_harmonics_um": Quantity("um", 1e-6, 1e-6, _PLACED),
    "contact_ratio_under_load": Quantity("1", 1e-6, 0.0, "a count of loaded pairs over positions"),
    "error_estimates": Quantity("1", 1e-4, 1e-9, "differences of two solutions known to 1e-9"),
    "estimates_by_source": Quantity("1", 1e-4, 1e-9, "differences of two solutions known to 1e-9"),
    "sliding_mm_per_rad": Quantity("mm/rad", 1e-6, 0.0, _PLACED),
    "specific_sliding": Quantity("1", 1e-6, 0.0, _PLACED),
    "friction_loss_J_per_rad": Quantity("J/rad", 1e-6, 0.0, _ROUNDED),
    "tension_behind_N": Quantity("N", 1e-6, 0.0, _ROUNDED),
    "roller_height_um": Quantity("um", 1e-6, 1e-6, "rollers followed to 1e-10 of a pitch"),
    "jump_margin_N": Quantity("N", 1e-6, 0.0, _ROUNDED),
    "lands_N": Quantity("N", 1e-6, 0.0, _ROUNDED),
}


def quantity_beside(key: str, result: Result) -> Any:
    """One of `MORE` of a result; sites without load have 0."""
    if key in ("root_tension_MPa", "root_compression_MPa"):
        assert result.root_stress is not None
        side = key.split("_")[1]
        return [getattr(body, side).stress_MPa for body in result.root_stress if body is not None]
    if key in ("transmission_error_harmonics_um", "contact_ratio_under_load"):
        return result.summary[key]
    if key == "friction_loss_J_per_rad":
        assert result.friction is not None
        return result.friction.loss_J_per_rad
    if key in ("error_estimates", "estimates_by_source"):
        assert result.estimate is not None
        whole = {k: v for k, v in result.estimate.items() if isinstance(v, float)}
        parts = [whole] if key == "error_estimates" else result.estimate["by_source"].values()
        return [part[name] for part in parts for name in sorted(part)]
    if key == "specific_sliding":
        return np.nan_to_num([result.specific_sliding_1, result.specific_sliding_2])
    if key == "sliding_mm_per_rad":
        return np.nan_to_num(result.sliding_mm_per_rad)
    return np.nan_to_num(getattr(result.drive, key))
