"""Examples for multibody programs; those whose program is missing are skipped."""

from __future__ import annotations

import importlib
import re

import numpy as np
import pytest

from tests.support.paths import ROOT

FOLDER = ROOT / "examples" / "multibody"


def test_the_table_for_mbdyn_is_that_of_the_secant_stiffness(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.syspath_prepend(FOLDER)
    example = importlib.import_module("mbdyn_table")
    text = example.include_text()
    head, rows = text.split("drive caller: 1, piecewise linear, ")
    count, *lines = rows.rstrip(";\n").split(",\n")
    values = np.array([line.split(",") for line in lines], dtype=float)
    table = example.solved_table()
    np.testing.assert_array_equal(values[:, 0], table.angle_rad)
    secant = table.values["stiffness_secant_Nm_per_rad"][:, 1]
    np.testing.assert_array_equal(values[:, 1], secant)
    assert int(count) == len(values)
    # the input file uses the names that the table sets, and its blocks end
    deck = (FOLDER / "mbdyn_gear_pair.mbd").read_text(encoding="utf-8")
    for name in re.findall(r"const real (\w+)", head):
        assert name in deck
    assert re.findall(r"begin: ([\w ]+);", deck) == re.findall(r"end: ([\w ]+);", deck)


def test_gears_in_exudyn_run_through_the_static_transmission_error(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    pytest.importorskip("exudyn", reason="Exudyn is not installed: pip install exudyn")
    monkeypatch.syspath_prepend(FOLDER)
    module = importlib.import_module("exudyn_gear_pair")
    angle, found = module.simulate()
    table = module.solved_table()
    static = table.values["transmission_error_um"][:, 1]
    wanted = np.interp(angle % table.period_rad, table.angle_rad, static)
    late = angle > table.period_rad
    # inertia moves gear 1 by less than 3 % of the transmission error at 1 rad/s
    assert np.sqrt(np.mean((found - wanted)[late] ** 2)) < 0.03 * np.ptp(static)


def test_stiffer_teeth_raise_the_frequencies_of_rotors_in_ross(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    pytest.importorskip("ross", reason="ROSS is not installed: pip install ross-rotordynamics")
    monkeypatch.syspath_prepend(FOLDER)
    module = importlib.import_module("ross_gear_pair")
    soft, stiff = module.frequencies_Hz(1.97e8), module.frequencies_Hz(2.81e8)
    # the bearings have damping, so that an undamped bound holds to its square only
    assert (stiff >= soft * (1 - 1e-6)).all()
    assert (stiff / soft).max() > 1.01
