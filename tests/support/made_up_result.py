"""A result with plausible numbers for plots and reports, created without a solution.

An involute pair of FZG type C size; the load is shared by springs whose stiffness grows from the
ends of the path, pressures are Hertzian. A lightly loaded pair at an end of the path counts as
contact on a sharp corner.
"""

from math import acos, atan2, cos, pi, sin, sqrt, tan

import numpy as np

from flankload.result import PairDrawing, PairTable, Result

TEETH = (16, 24)
DISTANCE = 91.5
WIDTH = 14.0
BASE_RADII = (4.5 * 8 * cos(pi / 9), 4.5 * 12 * cos(pi / 9))
TIP_RADII = (41.23, 59.18)
ROOT_RADII = (31.194, 49.1445)
WORKING_ANGLE = acos(sum(BASE_RADII) / DISTANCE)
BASE_PITCH = 2 * pi * BASE_RADII[0] / TEETH[0]
SITES = np.array([-1, 0, 1])


def made_up_result(
    *, count: int = 32, torque_Nm: float = 302.0, closed: bool = True, **changes: object
) -> Result:
    """Result of `count` positions over a period; `changes` replace individual arguments."""
    period = 2 * pi / TEETH[0]
    position = period * np.arange(count) / count
    forces = np.array([_site_forces(x / period, torque_Nm) for x in position])
    radii = _equivalent_radii(position[:, None] / period + SITES)
    compliance = 2 * (1 - 0.3**2) / (pi * 206000)
    half = np.sqrt(8 * radii * forces / WIDTH * compliance)
    pressure = np.divide(2 * forces / WIDTH, pi * half, out=np.zeros_like(half), where=half > 0)
    angles = _angles(position)
    tables = tuple(
        _pair_table(position[p] / period, forces[p], half[p], pressure[p]) for p in range(count)
    )
    corner = np.zeros(forces.shape, dtype=bool)
    corner[:, [0, 2]] = (forces[:, [0, 2]] > 0) & (forces[:, [0, 2]] < 0.3 * forces.max())
    stiffness = 2.0e5 + 9.0e4 * (forces > 0).sum(axis=1)
    arguments: dict[str, object] = {
        "name": "made-up pair",
        "torque_Nm": torque_Nm,
        "sites": SITES,
        "position_rad": position,
        "rotation_rad": torque_Nm / (0.95 * stiffness),
        "reference_radius_mm": BASE_RADII[0],
        "site_force_N": forces,
        "peak_pressure_MPa": np.where(corner, 1.6, 1.0) * pressure,
        "stiffness_tangent_Nm_per_rad": stiffness,
        "status": np.zeros(count, dtype=int),
        "pair_tables": tables,
        "corner_contact": corner,
        "period_rad": period,
        "closed": closed,
        "face_width_mm": WIDTH,
        "estimate": {
            "transmission_error": 1e-3,
            "load_share": 2e-3,
            "peak_pressure": 8e-3,
            "largest_pressure": 8e-3,
            "by_source": {"strips": {"transmission_error": 1e-3}},
        },
        "cost": {
            "fe_factorisations": 2,
            "unit_loads_normal": 10,
            "pivots": 640,
            "stages": {
                "bodies": {
                    "wall_s": 0.1,
                    "cpu_s": 0.1,
                    "bytes": 20000,
                    "workspace_bytes": 0,
                    "counters": {"states": 1},
                    "predicted": {"cpu_s": 0.12, "counters": {"states": 1}},
                }
            },
        },
        "warnings": ("the backlash on the working pitch circle is -0.30 um",),
        "drawing": PairDrawing(
            outline_1=_outline(0),
            outline_2=_outline(1),
            teeth_1=TEETH[0],
            teeth_2=TEETH[1],
            center_distance_mm=DISTANCE,
            angle_1=angles[0],
            angle_2=angles[1],
            bore_radius_1_mm=15.0,
            bore_radius_2_mm=20.0,
        ),
    }
    arguments |= changes
    return Result(**{"pitch_rad": arguments["period_rad"], **arguments})  # type: ignore[arg-type]


def _site_forces(fraction: float, torque_Nm: float) -> np.ndarray:
    """Parallel springs that fade out over the ends of a path of 1.55 base pitches."""
    places = SITES + fraction
    springs = np.clip(0.775 - np.abs(places), 0.0, 0.25)
    total = 1000 * torque_Nm / BASE_RADII[0]
    return np.asarray(total * springs / springs.sum())


def _equivalent_radii(places: np.ndarray) -> np.ndarray:
    along = places * BASE_PITCH
    one = BASE_RADII[0] * tan(WORKING_ANGLE) + along
    two = BASE_RADII[1] * tan(WORKING_ANGLE) - along
    return np.asarray(np.maximum(one * two, 1.0) / (one + two))


def _involute_angle(radius: float, base: float) -> float:
    roll = sqrt(max(0.0, (radius / base) ** 2 - 1))
    return roll - atan2(roll, 1.0)


def _half_angle(radius: float, z: int) -> float:
    """Half of the tooth's angle on a circle; both flanks touch at the working pitch circle."""
    pitch = DISTANCE * TEETH[z] / sum(TEETH)
    return (
        pi / 2 / TEETH[z]
        + _involute_angle(pitch, BASE_RADII[z])
        - _involute_angle(radius, BASE_RADII[z])
    )


def _outline(z: int) -> np.ndarray:
    start = max(BASE_RADII[z], ROOT_RADII[z] + 1.0)
    radii = np.linspace(start, TIP_RADII[z], 30)
    angles = np.array([_half_angle(r, z) for r in radii])
    flank = np.column_stack([radii * np.cos(angles), radii * np.sin(angles)])
    root = ROOT_RADII[z] * np.array([[cos(a), sin(a)] for a in (pi / TEETH[z], angles[0] + 0.02)])
    left = np.vstack([root, flank])
    return np.vstack([left * [1, -1], left[::-1]])


def _angles(position: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    pitch = DISTANCE * TEETH[0] / sum(TEETH)
    one = -_half_angle(pitch, 0) + position
    two = pi - _half_angle(DISTANCE - pitch, 1) - position * TEETH[0] / TEETH[1]
    return one, two


def _pair_table(
    fraction: float, forces: np.ndarray, half: np.ndarray, pressure: np.ndarray
) -> PairTable:
    normal = np.array([sin(WORKING_ANGLE), cos(WORKING_ANGLE)])
    tangent = np.array([cos(WORKING_ANGLE), -sin(WORKING_ANGLE)])
    pitch_point = np.array([DISTANCE * TEETH[0] / sum(TEETH), 0.0])
    rows = []
    for s in np.flatnonzero(forces > 0):
        centre = pitch_point + (SITES[s] + fraction) * BASE_PITCH * normal
        x = np.linspace(-1.5, 1.5, 31) * half[s]
        cell = x[1] - x[0]
        p = pressure[s] * np.sqrt(np.maximum(0.0, 1 - (x / half[s]) ** 2))
        place = centre + x[:, None] * tangent
        gap = np.where(p > 0, 0.0, 5.0 * (np.abs(x) - half[s]))
        ones = np.ones_like(x)
        rows.append(
            np.column_stack(
                [
                    SITES[s] * ones,
                    np.hypot(*place.T),
                    x,
                    -x,
                    place,
                    ones[:, None] * normal,
                    p * cell * WIDTH,
                    p,
                    gap,
                    cell * ones,
                ]
            )
        )
    columns = np.concatenate(rows or [np.empty((0, 12))]).T
    return PairTable(columns[0].astype(int), *columns[1:])
