"""Timing belts: T10 and HTD 8M as plane strips, their response and load shares."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np

from flankload.bodies.body import Material
from flankload.contact import ContactState, solve_contact_general
from flankload.mechanisms.belt.belt import Round, Strip, Trapezoid
from flankload.mechanisms.belt.contact import BeltState, SpringRow
from flankload.mechanisms.belt.row import BeltRow, StripResponse

CORD, FORCE = 25e3, 40.0
#: Difference of load shares between a spring row and its elements, percentage points.
ROW = 0.2
#: The same if the last tooth touches with a part of its flank and nothing holds the cord straight:
#: its sharp corner at the land recedes, which a spring cannot represent. Finer elements, elements
#: refined at the corners, lands held at nodes or by linear shape functions, and free corners all
#: give about 0.28.
ROW_AT_THE_EDGE = 0.3
T10 = Strip(
    pulley_teeth=24,
    pitch_mm=10.0,
    wrapped_teeth=12,
    width_mm=1.0,
    tooth=Trapezoid(5.3, 2.5, np.radians(25.0)),
    groove=None,
    land_distance_mm=1.0,
    back_mm=2.0,
    cord_N_per_mm=CORD,
    material=Material(100.0, 0.45),
)


def longer(strip: Strip, difference_um: float) -> Strip:
    return replace(strip, pitch_difference_mm=difference_um / 1000.0)


@cache
def response(strip: Strip = T10, elements: int = 6, *, lands: bool = True) -> StripResponse:
    return BeltRow(strip, elements, sliding=lands, lifting=lands).at(0.0)


def solved_springs(row: SpringRow, slack_N_per_mm: float, difference_mm: float) -> ContactState:
    """Forces of the teeth under `FORCE`; the rotation is the displacement on the pitch circle, mm.

    K = L of the tooth that is nearer to the tight end, plus 1/k_t on the diagonal and the coupling
    by an elastic pulley.
    """
    slack = row.slack_mm2_per_N
    order = np.arange(slack.size)
    matrix = slack[np.minimum.outer(order, order)] + np.eye(slack.size) / row.tooth_N_per_mm2
    if row.coupling_mm2_per_N.size:
        apart = np.abs(np.subtract.outer(order, order))
        matrix = matrix + np.append(0.0, row.coupling_mm2_per_N)[apart]
    gaps = slack_N_per_mm * slack + difference_mm * order
    return solve_contact_general(matrix, gaps, np.ones(slack.size), FORCE, positive_definite=True)


def shares(state: BeltState) -> np.ndarray:
    return 100.0 * state.tooth_N_per_mm / FORCE


TAUT = replace(T10, prestress_N_per_mm=20.0)
HTD = replace(T10, pitch_mm=8.0, tooth=Round(2.575, 3.38), land_distance_mm=0.686, back_mm=2.2)
