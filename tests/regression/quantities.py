"""What a reference holds: units, and how far each quantity may move before it is a change."""

from __future__ import annotations

from dataclasses import dataclass


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
    "sums_of_groups": Quantity("N", 1e-9, 0.0, "sums of what is not determined pair by pair"),
    "condition": Quantity("1", 1e-2, 0.0, "an estimate of a norm"),
    "held": Quantity("N mm", 1e-6, 1e-12, "where a path ends, found by the last of its steps"),
    "columns": Quantity("1", 0.0, 0.0, _EXACT),
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
