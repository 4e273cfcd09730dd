"""Contact pairs of slices give back the torque by their places, normals and forces alone.

At kinks, corners and tip roundings the force has another direction than at the least gap, and so
another inclination to the section.
"""

from __future__ import annotations

import numpy as np
import pytest

import flankload as fl
from flankload.bodies import Body
from flankload.mechanisms.flank_pair.assembly import build_bodies
from tests.support.balance import imbalance
from tests.support.helical_pairs import helical_pair, solved_helical
from tests.support.tolerances import ROUND_OFF

#: Mate, helix angle and shapes of both bodies.
PAIRS = (
    ("gear", 5.0, ("kinks", "round")),
    ("gear", 40.0, ("round", "kinks")),
    ("ring", 40.0, ("kinks", "kinks")),
)


@pytest.mark.parametrize("contact", ["lumped", "pairs"])
@pytest.mark.parametrize(("mate", "angle_deg", "shapes"), PAIRS)
def test_pairs_give_back_the_torque(
    mate: str, angle_deg: float, shapes: tuple[str, str], contact: str
) -> None:
    """Regression: off by 4e-6 at 5° and by 2e-4 at 40°, with the status 0."""
    found = solved_helical(mate, angle_deg, shapes=shapes, contact=contact)
    assert not found.status.any()
    assert imbalance(found) < ROUND_OFF


def test_pairs_with_friction_give_back_the_torque() -> None:
    found = solved_helical(
        "gear", 40.0, shapes=("round", "kinks"), contact="lumped", friction_coefficient=0.1
    )
    assert imbalance(found) < ROUND_OFF


# a lumped contact may be longer on one side; cells begin at corners
@pytest.mark.parametrize(("contact", "inside"), [("lumped", 0.8), ("pairs", 1.01)])
def test_flanks_with_a_kink_or_a_corner_in_their_contact_are_marked(
    contact: str, inside: float
) -> None:
    """No other contacts are marked: off corners, the peak pressure is meaningful."""
    shapes = ("kinks", "round")
    found = solved_helical("gear", 5.0, shapes=shapes, contact=contact)
    bodies = build_bodies(helical_pair("gear", 5.0, shapes=shapes, contact=contact)).bodies
    near, far = (_with_corner(bodies, found, half_widths) for half_widths in (inside, 2.0))
    assert near.any()
    assert not near.all()
    assert found.corner_contact[near].all()
    assert far[found.corner_contact].all()


def _with_corner(bodies: tuple[Body, Body], found: fl.Result, half_widths: float) -> np.ndarray:
    """Flank pairs (P, S) with a corner so close to the middle of a loaded contact or cell."""
    near = np.zeros(found.load_share.shape, dtype=bool)
    for body, name in zip(bodies, ("arc_length_1_mm", "arc_length_2_mm"), strict=True):
        corners = body.curve.breaks[np.flatnonzero(body.curve.corners)]
        if not corners.size:
            continue
        for p, table in enumerate(found.pair_tables):
            half = 0.5 * table.cell_mm if table.half_width_mm is None else table.half_width_mm
            away = np.abs(getattr(table, name)[:, None] - corners).min(axis=1)
            touched = table.site[(away <= half_widths * half) & (table.force_N > 0)]
            near[p] |= np.isin(found.sites, touched)
    return near
