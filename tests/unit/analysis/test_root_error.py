"""Errors of the largest root tension from those of its load and of omitted modes."""

from __future__ import annotations

from types import SimpleNamespace
from typing import TYPE_CHECKING, cast

import numpy as np
import pytest

from flankload.analysis.error_rules import ELEMENTS, ROOT_STRESS, RemainingError
from flankload.analysis.root_error import RootTension, add_root_errors

if TYPE_CHECKING:
    from flankload.contact.sweep import Sweep

#: Two flanks at one position, of which the second carries almost nothing; its root is bent by its
#: neighbour.
SHARES = np.array([[0.999, 0.001]])
TENSION = np.array([[[1.0, 0.4]], [[1.0, 0.3]]])


def _error(source: str, of_share: float, omitted: float, difference: float = 0.0) -> float:
    part = cast("Sweep", SimpleNamespace(site_force_N=SHARES))
    changes = {"modes": np.full((2, 1, 2), omitted)}
    roots = RootTension(TENSION, changes, np.full((2, 1, 1), difference))
    errors = {source: {"load_share": RemainingError(0.0, np.full(SHARES.shape, of_share))}}
    add_root_errors(errors, part, roots, following=0.6)
    return errors[source][ROOT_STRESS].size


def test_a_root_bent_by_its_neighbour_hardly_feels_its_own_force() -> None:
    assert _error("slices", 0.01, 0.0) == pytest.approx(0.01 / 0.999)


def test_omitted_modes_act_on_the_roots() -> None:
    assert _error("modes", 0.0, 0.02) == pytest.approx(0.6 * 0.02)


def test_elements_err_by_the_square_of_what_recovery_shows() -> None:
    both = abs(ELEMENTS.part) + ELEMENTS.doubt
    assert _error("elements", 0.0, 0.02, 0.05) == pytest.approx(both * 0.05**2)
