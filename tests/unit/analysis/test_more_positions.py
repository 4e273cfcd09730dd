"""Sampling errors from four times as many positions."""

from __future__ import annotations

import numpy as np

from flankload.analysis.more_positions import more_positions, with_known
from flankload.contact.flank_contact import FlankContact
from flankload.contact.sweep import sweep
from tests.support.sweep_calls import TORQUES, assert_same, job
from tests.support.tolerances import ROUND_OFF


def test_known_states_are_placed_between_the_others() -> None:
    pair, compliances = job("gears", 3)
    more = more_positions(pair.position_rad, pair.period_rad)
    np.testing.assert_array_equal(more[:, 0], pair.position_rad)
    steps = np.diff([*more.ravel(), pair.position_rad[0] + pair.period_rad])
    np.testing.assert_allclose(steps, pair.period_rad / 12, rtol=ROUND_OFF, atol=0)
    contact = FlankContact(pair, compliances, pair.discretization.grid, "lumped")
    known, others, whole = (
        sweep(contact, places.ravel(), TORQUES[:1], keep_pairs=False)[0]
        for places in (more[:, 0], more[:, 1:], more)
    )
    assert_same(with_known(known, others), whole)
