"""Load over the face width of helical pairs: load factors, contact ratios and their premise."""

from __future__ import annotations

from dataclasses import replace
from math import cos, pi, radians, sin
from typing import Any

import numpy as np
import pytest

import flankload as fl
from flankload.report.key_figures import key_rows
from tests.support.solving import solve
from tests.support.tolerances import ROUND_OFF, SOLVER

#: The bodies are coarse; degrees and slices are those of a user.
COARSE = {"flank_element_mm": 2.5, "modes": 3, "estimate": False, "tangents": False}
TIPS = (66.70, 191.37)
#: Tip diameters with a transverse contact ratio of 0.86.
SHORT_TIPS = (64.5, 189.0)


def drawing_pair(tips: tuple[float, float] = TIPS, **tables: dict[str, Any]) -> fl.Scene:
    """An aligned pair without crowning: 23/71 teeth, module 2.5, 18 degrees, width 30 mm."""
    each = {"kind": "gear", "module_mm": 2.5, "helix_angle_deg": 18.0}
    if tips == TIPS:
        each["tip_radius_mm"] = 0.3
    one = {"teeth": 23, "profile_shift": 0.25, "hand": "right", "bore_diameter_mm": 30}
    two = {"teeth": 71, "profile_shift": -0.05, "hand": "left", "bore_diameter_mm": 60}
    tree: dict[str, Any] = {
        "body_1": {**each, **one, "tip_diameter_mm": tips[0]},
        "body_2": {**each, **two, "tip_diameter_mm": tips[1]},
        "pair": {"center_distance_mm": 124.04, "face_width_mm": 30},
        "load": {"torque_Nm": 320},
        "positions": {"count": 16},
        "accuracy": COARSE,
    }
    for name, keys in tables.items():
        tree[name] = {**tree[name], **keys}
    return fl.Scene.from_dict(tree)


def solved(*args: Any, **tables: dict[str, Any]) -> fl.Result:
    found = solve(drawing_pair(*args, **tables))
    assert isinstance(found, fl.Result)
    return found


# --- load factors ---------------------------------------------------------------------------------
def test_the_face_load_factor_of_an_aligned_pair_is_near_one() -> None:
    """Regression: that of single positions, 1.5, was K_Hbeta; two contact lines overlap there."""
    found = solved()
    # all slices have the same width
    load = found.slice_line_load_N_per_mm.sum(axis=1)
    over_mesh = load.mean(axis=0)
    assert found.face_load_factor == pytest.approx(over_mesh.max() / over_mesh.mean(), rel=SOLVER)
    assert found.face_load_factor == pytest.approx(1.05, abs=0.01)
    largest = (load.max(axis=1) / load.mean(axis=1)).max()
    assert found.line_load_factor == pytest.approx(largest, rel=SOLVER)
    assert 1.48 < found.line_load_factor < 1.52
    for name in ("face_load_factor", "line_load_factor"):
        assert found.summary[name] == getattr(found, name)


def test_positions_count_with_their_part_of_the_period() -> None:
    """Twice as many positions in the first half of the period do not count twice."""
    parts = [*np.arange(0.0, 0.5, 1 / 32), *np.arange(0.5, 1.0, 1 / 16)]
    angles = [360.0 / 23 * part for part in parts]
    found = solve(drawing_pair().replace({"positions": {"angles_deg": angles}}))
    assert isinstance(found, fl.Result)
    weights = np.full(24, 1 / 32)
    weights[16:] *= 2
    weights[[0, 16]] = 1.5 / 32
    load = np.average(found.slice_line_load_N_per_mm.sum(axis=1), axis=0, weights=weights)
    assert found.face_load_factor == pytest.approx(load.max() / load.mean(), rel=1e-9)


def test_estimated_errors_are_beside_the_factors_of_a_report() -> None:
    estimate = {"face_load_factor": 0.02, "line_load_factor": 0.05, "peak_line_load": 0.1}
    found = replace(solved(), estimate=estimate)
    rows = {row.name: row for row in key_rows([found])}
    for name, error in (
        ("face load factor", 0.02),
        ("line load factor", 0.05),
        ("largest line load", 0.1),
    ):
        assert [cell.error for cell in rows[name].cells if cell] == [error]
    assert rows["face load factor"].symbol == "K_Hβ"
    assert rows["contact ratio by geometry"].symbol == "ε_γ"
    assert rows["contact ratio by geometry"].cells[0].value == found.summary["contact_ratio_total"]


# --- contact ratios -------------------------------------------------------------------------------
def test_all_contact_ratios_are_in_the_summary_and_the_table() -> None:
    found = solved()
    summary, overlap = found.summary, 30.0 * sin(radians(18.0)) / (pi * 2.5)
    assert summary["overlap_ratio"] == pytest.approx(overlap, rel=1e-9)
    total = summary["contact_ratio_geometric"] + overlap
    assert summary["contact_ratio_total"] == pytest.approx(total, rel=ROUND_OFF)
    # deflected teeth touch beyond both ends of the path of contact
    assert total < summary["contact_ratio_under_load"] < 1.1 * total
    text = found.table()
    assert f"eps_gamma {total:.3f} by geometry: eps_beta {overlap:.3f}, eps_alpha 1.521," in text
    assert f"K_Hbeta {found.face_load_factor:.3f}, up to" in text


def test_overlap_makes_up_for_a_transverse_contact_ratio_below_1() -> None:
    """Regression: refused, though another section of the width has contact at each position."""
    found = solved(SHORT_TIPS, load={"torque_Nm": 100.0}, positions={"count": 4})
    assert found.summary["contact_ratio_geometric"] == pytest.approx(0.856, abs=1e-3)
    assert found.summary["contact_ratio_total"] == pytest.approx(2.036, abs=1e-3)
    assert found.loaded_pairs.min() >= 2
    assert not found.outside_limits
    assert not any("contact ratio" in line for line in found.warnings)
    # forces of slices hold the torque: beside the tips all act at the base radius
    base_mm = 0.5 * 23 * 2.5 / cos(radians(18.0))
    assert found.reference_radius_mm < base_mm
    for p in range(found.position_rad.size):
        table = found.pairs(p)
        lever = table.x_mm * table.normal_y - table.y_mm * table.normal_x
        slope = np.tan(radians(18.0)) / base_mm * lever
        torque = table.force_N / np.hypot(1.0, slope) @ np.abs(lever)
        assert torque == pytest.approx(100e3, rel=1e-3)


def test_a_total_contact_ratio_below_1_is_refused_with_its_parts() -> None:
    scene = drawing_pair(SHORT_TIPS, pair={"face_width_mm": 3.0})
    with pytest.raises(fl.PremiseError) as caught:
        fl.solve(scene)
    assert str(caught.value) == (
        "pair.center_distance_mm: expected a contact ratio of at least 1 (or effects.beyond_limits "
        "= true), found 0.9738 (0.8557 transverse + 0.118 overlap) on 124.04 mm with these tip "
        "diameters and this face width"
    )
