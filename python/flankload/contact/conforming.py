"""Contact of splines in three dimensions: slices whose flanks conform over a common height.

A slice has one unknown, its force F. It is distributed over strips of the height, q_i F on strip i,
like that of a coupling with equal forces on all slices and teeth:

    sum_k (sum over teeth and slices of C)_ik q_k = const,  sum q = 1                          (U1)
    K = q' C q,  g0 = sum_i q_i g_i,  K F + g0 - r_b phi >= 0,  r_b sum F = T                  (U2)

C is the compliance of both bodies between strips of slices. All normals of an involute have the
lever arm r_b. For a uniform load the rotation is exact; for gaps that vary over the height, the
error of K is of second order in the change of q.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from flankload.base.rotation import turned
from flankload.contact import solve_contact_general
from flankload.contact.core_call import CORE_COUNTERS
from flankload.contact.pair_table import COLUMNS, PackedPairs
from flankload.contact.status import SiteCorner
from flankload.contact.sweep import SliceStates, Sweep
from flankload.elasticity.prism.strip_field import StripField

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from numpy.typing import NDArray

    from flankload.base.arrays import Floats
    from flankload.contact.flank_contact import FlankContact
    from flankload.cost import Account
    from flankload.pairing.common_height import CommonHeight
    from flankload.pairing.pairing import Pairing
    from flankload.pairing.slices import Slices


@dataclass(frozen=True, eq=False)
class ConformingSlices:
    """Compliance and gaps of S sites and J slices.

    `spread` (N,): q, the part of the force on each strip of the height; `compliance` (S J, S J): K,
    mm/N; `gap_mm` (S, J): gaps by deviations of the teeth and along the width.
    """

    spread: Floats
    compliance: Floats
    gap_mm: Floats


def sweep_splines(
    contact: FlankContact,
    position_rad: Floats,
    torques_Nmm: Sequence[float],
    *,
    account: Account | None = None,
    progress: Callable[[int, int], None] | None = None,
    **_: object,
) -> tuple[Sweep, ...]:
    """`sweep` of splines with conforming slices; options of the core have no effect."""
    slices, positions = contact.slices, np.asarray(position_rad, dtype=float)
    if account is not None and slices is not None:
        states = positions.size * len(torques_Nmm)
        account.count(states=states, slices=slices.count * states)
    reduced = conforming_slices(contact)
    return conforming_sweep(reduced, contact, positions, torques_Nmm, progress=progress)


def conforming_slices(contact: FlankContact) -> ConformingSlices:
    """Reduce the compliance of two bodies with conforming slices to one unknown per slice."""
    pairing, slices, height, _ = _of_splines(contact)
    fields = [
        StripField.of(compliance, body.teeth, s, height.strip_mm, slices.edges_mm)
        for body, compliance, s in zip(
            contact.bodies, contact.compliances, height.s_mm, strict=True
        )
    ]
    even = fields[0].of_even_load() + fields[1].of_even_load()
    # without elements, as for a run without torque, the strips are equal
    equal = np.ones(len(even))
    together = np.linalg.solve(even, equal) if even.any() else equal
    spread: Floats = np.asarray(together / together.sum(), dtype=float)
    one, two = (
        field.between_sites(spread, teeth)
        for field, teeth in zip(fields, pairing.site_teeth, strict=True)
    )
    compliance = (one + two).reshape(pairing.sites.size * slices.count, -1)
    return ConformingSlices(
        spread=spread,
        compliance=0.5 * (compliance + compliance.T),
        gap_mm=_gaps(contact),
    )


def _of_splines(contact: FlankContact) -> tuple[Pairing, Slices, CommonHeight, float]:
    """Pairing, slices, their common height and the lever arm of all normals."""
    slices = contact.slices
    assert slices is not None
    assert slices.conforming is not None
    return contact.pairing, slices, slices.conforming, slices.conforming.lever_mm


def _gaps(contact: FlankContact) -> Floats:
    """Gaps (S, J) of teeth on a common axis by pitch errors and lead modifications."""
    pairing, slices, _, base_mm = _of_splines(contact)
    one, two = pairing.site_angles_rad
    gaps = base_mm * (two - one)[:, None] + slices.removed_mm[0] + slices.removed_mm[1]
    for of_teeth, teeth in zip(slices.of_teeth_mm, pairing.site_teeth, strict=True):
        if of_teeth is not None:
            gaps = gaps + of_teeth[teeth]
    return np.asarray(gaps)


def conforming_sweep(
    reduced: ConformingSlices,
    contact: FlankContact,
    position_rad: Floats,
    torques_Nmm: Sequence[float],
    *,
    progress: Callable[[int, int], None] | None = None,
) -> tuple[Sweep, ...]:
    """Solve all positions (P,) for all torques >= 0, with progress(done, P) after each position.

    Raises a ContactError if there is no state.
    """
    pairing, slices, height, base_mm = _of_splines(contact)
    turns = pairing.turns(position_rad)[0][:, None] + pairing.site_angles_rad[0]
    states: list[list[_State]] = [[] for _ in torques_Nmm]
    for p, angles in enumerate(turns):
        gaps = reduced.gap_mm + height.gap_mm(angles, slices.z_mm, reduced.spread)
        for t, torque in enumerate(torques_Nmm):
            warm = states[t][-1].active if p else None
            states[t].append(_solved(reduced.compliance, gaps, base_mm, torque, warm))
        if progress is not None:
            progress(p + 1, len(position_rad))
    return tuple(
        _as_sweep(torque, own, turns, slices, base_mm)
        for torque, own in zip(torques_Nmm, states, strict=True)
    )


class _State(NamedTuple):
    """State of a position under a torque; forces and gaps (S, J)."""

    rotation_rad: float
    tangent_rad_per_Nmm: float
    force_N: Floats
    gap_mm: Floats
    active: NDArray[np.intp] | None
    status: int
    certificate: tuple[float, float, float]
    work: tuple[int, int]


def _solved(
    compliance: Floats, gaps: Floats, base_mm: float, torque: float, warm: NDArray[np.intp] | None
) -> _State:
    """State under a torque; without torque, the smallest gap is closed."""
    if not torque:
        rotation = float(gaps.min()) / base_mm
        left = gaps - rotation * base_mm
        return _State(rotation, 0.0, np.zeros_like(gaps), left, None, 0, (0.0, 1.0, 0.0), (0, 0))
    levers = np.full(gaps.size, base_mm)
    state = solve_contact_general(compliance, gaps.ravel(), levers, torque, warm_pairs=warm)
    return _State(
        state.rotation,
        float(state.tangent[0, 0]),
        state.normal_forces.reshape(gaps.shape),
        state.final_gap_angles.reshape(gaps.shape),
        state.active_pairs,
        state.status,
        (state.info.backward_error, state.info.condition, state.info.margin),
        (state.info.pivots, state.info.refactorisations),
    )


def _as_sweep(
    torque: float, states: Sequence[_State], turns_rad: Floats, slices: Slices, base_mm: float
) -> Sweep:
    """States of all positions under a torque; pressures are means over the height."""
    height = slices.conforming
    assert height is not None
    forces = np.array([state.force_N for state in states])
    pressures = forces / (slices.width_mm * height.height_mm)
    counters = np.zeros((len(states), len(CORE_COUNTERS)), dtype=np.int64)
    for column, name in enumerate(("pivots", "refactorisations")):
        counters[:, CORE_COUNTERS.index(name)] = [state.work[column] for state in states]
    site_forces = forces.sum(axis=2)
    corner = np.full(forces.shape, SiteCorner.OFF_CORNERS, dtype=np.int64)
    return Sweep(
        torque_Nmm=torque,
        status=np.array([state.status for state in states], dtype=np.int64),
        rotation_rad=np.array([state.rotation_rad for state in states]),
        tangent_rad_per_Nmm=np.array([state.tangent_rad_per_Nmm for state in states]),
        certificate=np.array([state.certificate for state in states]),
        counters=counters,
        site_force_N=site_forces,
        site_peak_N_per_mm=pressures.max(axis=2),
        site_corner=corner[..., 0],
        site_force_per_torque=site_forces / (torque or 1.0),
        n_pairs=np.full(len(states), forces[0].size, dtype=np.int64),
        pairs=_pairs(
            forces, np.array([state.gap_mm for state in states]), turns_rad, height, base_mm
        ),
        slices=SliceStates(forces, pressures, corner, slices.edges_mm, conforming=True),
    )


def _pairs(
    forces: Floats, gaps: Floats, turns_rad: Floats, height: CommonHeight, base_mm: float
) -> PackedPairs:
    """One pair for each slice (P, S, J), in the middle of the height."""
    (x, y), (normal_x, normal_y) = (
        np.moveaxis(turned(vector, turns_rad), -1, 0)[..., None]
        for vector in (height.middle_mm, height.middle_normal)
    )
    column = {
        "s_1": height.middle_s_mm[0],
        "s_2": height.middle_s_mm[1],
        "radius": float(np.hypot(*height.middle_mm)),
        "x": x,
        "y": y,
        "normal_x": normal_x,
        "normal_y": normal_y,
        "force": forces,
        "cell": height.height_mm,
        "gap": gaps,
        "lever": base_mm,
    }
    table = [np.broadcast_to(column[name], forces.shape).ravel() for name in COLUMNS]
    count, n_slices = forces[0].size, forces.shape[2]
    number = np.tile(np.arange(count, dtype=np.intc), len(forces))
    return PackedPairs(
        site=number // n_slices,
        table=np.column_stack(table),
        first=count * np.arange(len(forces)),
        count=np.full(len(forces), count),
        slice_number=number % n_slices,
    )
