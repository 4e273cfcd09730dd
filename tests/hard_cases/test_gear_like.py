"""Two thousand of the random problems that `./dev bench stress` runs in full."""

import numpy as np
import pytest

from tests.support.gear_like import METHODS, gear_like, outcome


@pytest.mark.parametrize("seed", range(4))
def test_no_answer_is_wrong(seed: int) -> None:
    rng = np.random.default_rng(1000 + seed)
    outcomes = [outcome(gear_like(rng), METHODS[k % len(METHODS)]) for k in range(500)]
    assert {name for name in outcomes if name.startswith("wrong")} == set()
    assert outcomes.count("solved") >= 450
