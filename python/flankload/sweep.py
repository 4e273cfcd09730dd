"""All positions of a sweep: bodies and compliances go into one call of the core."""

from __future__ import annotations

from dataclasses import dataclass
from time import perf_counter
from typing import TYPE_CHECKING, Any

import numpy as np

from flankload.errors import (
    ContactError,
    InputError,
    NoContactState,
    PivotLimit,
    SingularContact,
)

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from flankload.bodies.body import Body
    from flankload.compliance import BodyCompliance
    from flankload.pairing import Pairing
    from flankload.resolution import Grid

#: Status of a position without an answer: the contact loop's codes, then those of the stages before
#: it.
FAILURES: dict[int, tuple[type[ContactError], str]] = {
    -1: (NoContactState, "no state of contact was found for this torque"),
    -2: (PivotLimit, "the contact loop used up its pivots"),
    -3: (SingularContact, "the equations of the pairs in contact are singular"),
    -4: (InputError, "numbers that do not make a contact problem"),
    -5: (InputError, "no pair could carry the torque"),
    -11: (NoContactState, "no circle about O1 cuts two facing flanks: no flank can touch here"),
    -12: (PivotLimit, "more places of least gap than can be kept: the profiles are too wavy"),
    -13: (PivotLimit, "the contact keeps reaching the end of its cells"),
    -14: (PivotLimit, "a circle about O1 misses the flank of body 2 inside the contact"),
}

#: Room for pairs at a position in the first call; a position that has more asks for a second one.
FIRST_ROOM = 512


@dataclass(frozen=True)
class Sweep:
    """What the core found at all positions (P) for one torque; S sites.

    Attributes
    ----------
    torque_Nmm : float
    status, rotation_rad, tangent_rad_per_Nmm : (P,) arrays
    certificate : (P, 3) array
        Backward error, condition, margin.
    counters : (P, 4) array
        Pivots, influence columns, passes over the cells, refactorisations.
    site_force_N, site_peak_N_per_mm, site_corner : (P, S) arrays
        Force; peak of force over cell width; body whose sharp corner works (0: none).
    n_pairs : (P,) array
    pair_site : (P, room) array
        Site of each pair, from 0.
    pair_table : (P, room, 11) array
        s_1, s_2, radius, x, y, n_x, n_y, force, cell, final gap [mm, N], lever of the torque row.
    seconds : float
    """

    torque_Nmm: float
    status: NDArray[np.int64]
    rotation_rad: NDArray[np.float64]
    tangent_rad_per_Nmm: NDArray[np.float64]
    certificate: NDArray[np.float64]
    counters: NDArray[np.int64]
    site_force_N: NDArray[np.float64]
    site_peak_N_per_mm: NDArray[np.float64]
    site_corner: NDArray[np.int64]
    n_pairs: NDArray[np.int64]
    pair_site: NDArray[np.int64]
    pair_table: NDArray[np.float64]
    seconds: float


def sweep(
    bodies: tuple[Body, Body],
    *,
    compliances: tuple[BodyCompliance, BodyCompliance],
    pairing: Pairing,
    position_rad: NDArray[np.float64],
    torque_Nmm: float,
    face_width_mm: float,
    grid: Grid,
) -> Sweep:
    """Solve all positions in one call of the core.

    Parameters
    ----------
    bodies, compliances, pairing
        From the stages before.
    position_rad : (P,) array
        Angle of body 1 from position zero.
    torque_Nmm : float
        Torque on body 1, >= 0.
    face_width_mm : float
        Width over which both bodies touch.
    grid : Grid
        How fine the cells are.

    Returns
    -------
    Sweep

    Raises
    ------
    FlankloadError
        If a position has no answer; the message names the first one.
    """
    start = perf_counter()
    arguments = _core_arguments(bodies, compliances, pairing, face_width_mm)
    turn_1, turn_2 = pairing.turns(position_rad)
    room = FIRST_ROOM
    while True:
        found = _call_core(turn_1, turn_2, pairing, torque_Nmm, arguments, grid, room)
        n_pairs = np.asarray(found[8])
        if n_pairs.max(initial=0) <= room:
            break
        room = int(n_pairs.max())
    status = np.asarray(found[0])
    _raise_first_failure(status, position_rad)
    return Sweep(
        torque_Nmm=torque_Nmm,
        status=status,
        rotation_rad=found[1],
        tangent_rad_per_Nmm=found[2],
        certificate=found[3].T,
        counters=found[4].T,
        site_force_N=found[5].T,
        site_peak_N_per_mm=found[6].T,
        site_corner=found[7].T,
        n_pairs=n_pairs,
        pair_site=found[9].T - 1,
        pair_table=found[10].transpose(2, 1, 0),
        seconds=perf_counter() - start,
    )


def _core_arguments(
    bodies: tuple[Body, Body],
    compliances: tuple[BodyCompliance, BodyCompliance],
    pairing: Pairing,
    face_width_mm: float,
) -> list[tuple[NDArray[Any] | float, ...]]:
    """Per body: curve arrays, then compliance arrays, in the layout of the flat door."""
    arguments: list[tuple[NDArray[Any] | float, ...]] = []
    for z, (body, compliance) in enumerate(zip(bodies, compliances, strict=True)):
        teeth = pairing.site_teeth[z]
        block = compliance.block_of(teeth[:, None], teeth[None, :], body.teeth)
        if compliance.is_rigid:
            smooth = np.zeros((1, 1, 1), order="F")
        else:
            smooth = np.asfortranarray(compliance.smooth.transpose(1, 2, 0) / face_width_mm)
        curve = body.curve
        arguments.append(
            (
                curve.breaks,
                np.asfortranarray(curve.coefficients.transpose(2, 1, 0)),
                curve.corners.astype(np.intc),
                pairing.site_angles_rad[z],
                pairing.site_deviations_mm[z],
                np.asarray(compliance.mode_range_mm, dtype=float),
                compliance.kernel / face_width_mm,
                smooth,
                np.asfortranarray(block + 1, dtype=np.intc),
            )
        )
    return arguments


def _call_core(
    turn_1: NDArray[np.float64],
    turn_2: NDArray[np.float64],
    pairing: Pairing,
    torque_Nmm: float,
    arguments: list[tuple[NDArray[Any] | float, ...]],
    grid: Grid,
    room: int,
) -> tuple[NDArray[Any], ...]:
    from flankload import _core

    (curve_1, curve_2) = (argument[:3] for argument in arguments)
    (site_1, site_2) = (argument[3:5] for argument in arguments)
    (field_1, field_2) = (argument[5:] for argument in arguments)
    *found, info = _core.flankload_sweep(
        turn_1,
        turn_2,
        pairing.center_distance_mm,
        torque_Nmm,
        *curve_1,
        *curve_2,
        site_1[0],
        site_2[0],
        site_1[1],
        site_2[1],
        *field_1,
        *field_2,
        np.array(
            [
                grid.strips_per_half_width,
                grid.corner_strips_per_half_width,
                grid.zone_half_widths,
            ]
        ),
        room,
    )
    if info < 0:
        raise InputError(f"argument {-info} of flankload_sweep is not valid")
    return tuple(found)


def _raise_first_failure(status: NDArray[np.int64], position_rad: NDArray[np.float64]) -> None:
    failed = np.flatnonzero(status < 0)
    if failed.size == 0:
        return
    k = int(failed[0])
    code = int(status[k])
    where = f"position {k} ({np.degrees(position_rad[k]):.4f} deg)"
    more = f" ({failed.size} of {status.size} positions failed)" if failed.size > 1 else ""
    kind, reason = FAILURES[code]
    raise kind(f"{where}: {reason}{more}")
