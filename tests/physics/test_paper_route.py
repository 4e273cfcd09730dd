"""The example that walks the way of the paper against the default way."""

from __future__ import annotations

import importlib.util
from types import ModuleType

import numpy as np
import pytest

from tests.support.paths import ROOT

FILE = ROOT / "examples" / "paper_route.py"
#: Spacings of the nodes, mm, and largest errors of the rotation (measured 3.6, 1.8 %).
SPACINGS = (0.2, 0.1)
ROTATION = (0.045, 0.022)
#: Of the load, on a flank (measured 0.05 points).
SHARE = 0.001


@pytest.fixture(scope="module")
def example() -> ModuleType:
    spec = importlib.util.spec_from_file_location("paper_route", FILE)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_error_falls_with_the_spacing(example: ModuleType) -> None:
    rotation, share = example.default_route()
    found = [example.paper_route(spacing) for spacing in SPACINGS]
    errors = [part[0] / rotation - 1 for part in found]
    assert np.all(np.array(errors) < ROTATION), errors
    # single nodes are too compliant, in proportion to their distance
    assert 1.8 < errors[0] / errors[1] < 2.2
    np.testing.assert_allclose(found[1][1], share, rtol=0, atol=SHARE)
    assert all(2 <= passes <= 5 for _, _, passes in found)
