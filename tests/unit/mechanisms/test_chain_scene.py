"""A chain on its sprocket as a scene: refused scenes, results, files."""

from __future__ import annotations

import csv
import io
import json
import re
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import flankload as fl
from flankload.cli import main
from flankload.errors import ContactError
from flankload.mechanisms.chain.sprocket import build_sprocket
from tests.support.gear_scenes import example
from tests.support.paths import SCENES

EXAMPLE = SCENES / "chain.toml"


def tables(**changes: dict[str, Any]) -> dict[str, Any]:
    scene = example("chain")
    for table, keys in changes.items():
        scene[table] = {**scene.get(table, {}), **keys}
    return scene


def solved(**changes: dict[str, Any]) -> fl.Result:
    found = fl.solve(fl.Scene.from_dict(tables(**changes)))
    assert isinstance(found, fl.Result)
    return found


REFUSED = [
    ({"body_2": {"pitch_mm": 12.8}}, "body_2.pitch_mm: expected 12.7 as in body_1.pitch_mm"),
    ({"body_2": {"roller_diameter_mm": 8}}, "body_2.roller_diameter_mm: expected 8.51"),
    ({"body_2": {"wrap_angle_deg": 350}}, "body_2.wrap_angle_deg: expected at most 342"),
    ({"body_2": {"elongation": 0.2}}, "body_2.elongation: expected a number from 0 to 0.05"),
    ({"load": {"slack_tension_N": 0}}, "load.slack_tension_N: expected a number > 0"),
    ({"pair": {"face_width_mm": 5}}, "pair: expected nothing"),
    ({"effects": {"friction_coefficient": 0.1}}, "effects.friction_coefficient: expected nothing"),
    ({"positions": {"adaptive": True}}, "positions.adaptive: expected nothing"),
    ({"accuracy": {"modes": 5}}, "accuracy.modes: expected nothing"),
]


@pytest.mark.parametrize(("changes", "line"), REFUSED, ids=[line for _, line in REFUSED])
def test_scene_is_refused(changes: dict[str, Any], line: str) -> None:
    with pytest.raises(fl.SceneError) as found:
        fl.Scene.from_dict(tables(**changes))
    assert str(found.value).startswith(line)


def test_sprocket_and_chain_go_together() -> None:
    scene = tables()
    scene["body_2"] = {"kind": "compliance", "file": "x.npz"}
    with pytest.raises(fl.SceneError, match=r"body_2.kind: expected 'chain' with body_1.kind"):
        fl.Scene.from_dict(scene)


def test_slack_tension_is_needed() -> None:
    scene = tables()
    del scene["load"]["slack_tension_N"]
    with pytest.raises(fl.SceneError, match=r"load.slack_tension_N: expected a number > 0: the"):
        fl.Scene.from_dict(scene)


BUILT = [
    ({"roller_seat_radius_mm": 4.2}, "body_1.roller_seat_radius_mm: expected more than half of"),
    ({"seating_angle_deg": 165}, "body_1.seating_angle_deg: expected less than 180 - 360/teeth"),
    ({"tip_diameter_mm": 80}, "body_1.tip_diameter_mm: expected more than the pitch diameter"),
    ({"tip_diameter_mm": 90}, "body_1.tip_diameter_mm: expected at most 86.0"),
    ({"flank_radius_mm": 3}, "body_1: expected roller, seat and flank radius, seating angle that"),
    ({"flank_radius_mm": 1}, "body_1: expected roller, seat and flank radius, seating angle that"),
    ({"roller_seat_radius_mm": 8}, "body_1: expected roller, seat and flank radius, seating angle"),
    ({"roller_seat_radius_mm": 12, "flank_radius_mm": 3}, "body_1: expected roller, seat and"),
    ({"seating_angle_deg": 60}, "body_1: expected roller, seat and flank radius, seating angle"),
]


@pytest.mark.parametrize(("keys", "line"), BUILT, ids=[line for _, line in BUILT])
def test_roller_has_to_fit_its_pocket(keys: dict[str, Any], line: str) -> None:
    with pytest.raises(fl.SceneError) as found:
        solved(body_1=keys)
    assert str(found.value).startswith(line)


def test_rollers_too_thick_for_their_pitch_leave_no_teeth() -> None:
    with pytest.raises(fl.SceneError, match=r"body_1: expected roller, .* found flanks that"):
        solved(body_1={"roller_diameter_mm": 12}, body_2={"roller_diameter_mm": 12})


@pytest.mark.parametrize("seat", ["tight", "wide"])
@pytest.mark.parametrize("teeth", [6, 9, 20, 60])
def test_teeth_end_where_their_flanks_meet(teeth: int, seat: str) -> None:
    """The contour, traced point by point, leaves no room to the next pocket at the top."""
    scene = tables(body_1={"teeth": teeth, "seat": seat}, body_2={"wrap_angle_deg": 150})
    sprocket = build_sprocket(fl.Scene.from_dict(scene).body_1, "body_1")  # type: ignore[arg-type]
    radius = sprocket.flank_radius_mm - 0.5 * sprocket.roller_diameter_mm
    turn = np.linspace(sprocket.seat_half_angle_rad, -0.5 * np.pi, 200001)
    flank = sprocket.flank_centers[1] + radius * np.column_stack([-np.sin(turn), np.cos(turn)])
    flank[:, 1] += sprocket.pitch_radius_mm
    within = np.arctan2(flank[:, 0], flank[:, 1]) < sprocket.half_pitch_rad
    highest = np.hypot(*flank[: int(np.argmin(within))].T).max()
    np.testing.assert_allclose(sprocket.tooth_top_mm, highest, rtol=1e-5, atol=0.0)
    assert sprocket.tip_radius_mm <= highest * (1 + 1e-5)


@pytest.mark.parametrize(("slack_N", "said"), [(100.0, "N above T1 q^n"), (4.0, "N below T1 q^n")])
def test_report_says_on_which_side_of_jumping_it_is(slack_N: float, said: str) -> None:
    result = solved(load={"slack_tension_N": slack_N}, positions={"count": 1})
    assert result.drive is not None
    assert f"slack strand {abs(result.drive.least_margin_N):.4g} {said}" in result.drive.words()


def test_other_pairs_know_no_slack_strand() -> None:
    gear = tomllib.loads((EXAMPLE.parent / "external_gear.toml").read_text())
    gear["load"]["slack_tension_N"] = 10
    with pytest.raises(fl.SceneError, match="slack_tension_N: expected nothing: a gear has no"):
        fl.Scene.from_dict(gear)
    del gear["load"]["slack_tension_N"]
    for large in (True, False):
        gear["effects"] = {"large_displacement": large}
        with pytest.raises(fl.SceneError, match="large_displacement: expected nothing, unless"):
            fl.Scene.from_dict(gear)
    del gear["effects"], gear["pair"]
    with pytest.raises(fl.SceneError, match=r"pair\.face_width_mm: expected a number"):
        fl.Scene.from_dict(gear)


def test_result_of_the_example() -> None:
    result = solved()
    drive = result.drive
    assert drive is not None
    assert drive.mode == "linear"
    assert result.sites.tolist() == list(range(12))
    assert result.status.max() == 0
    assert result.warnings == ()
    np.testing.assert_allclose(result.load_share.sum(axis=1), 1.0, rtol=1e-12, atol=0.0)
    # statics: the strands turn the sprocket; its lever changes with the polygon by 1.2 %
    lever = 1000 * result.torque_Nm / (drive.tight_tension_N - drive.slack_tension_N)
    np.testing.assert_allclose(lever, result.reference_radius_mm, rtol=0.02, atol=0.0)
    falls = np.diff(drive.tension_behind_N, axis=1)
    assert (falls < 0).all()
    assert result.cost["fe_factorisations"] == 0
    # two torques a position: for the stiffness
    assert result.cost["stages"]["sweep"]["counters"]["contact_passes"] == 64


def test_estimate_is_the_change_by_following_the_rollers() -> None:
    result = solved()
    followed = solved(effects={"large_displacement": True})
    off = np.abs(followed.rotation_rad - result.rotation_rad).max() / result.rotation_rad.max()
    assert result.estimate is not None
    assert 0.3 * off < result.estimate["transmission_error"] < 3 * off
    cost = result.cost["stages"]
    assert cost["estimate"]["counters"]["states"] == 2
    assert "estimate" not in solved(accuracy={"estimate": False}).cost["stages"]


def test_several_torques_and_a_loose_sprocket() -> None:
    found = fl.solve(
        fl.Scene.from_dict(
            tables(load={"torque_Nm": [0, 40]}, positions={"count": 2}),
        )
    )
    free, loaded = found.by_torque
    assert free.drive is not None
    assert loaded.drive is not None
    np.testing.assert_allclose(free.drive.tight_tension_N, 100.0, rtol=0.03, atol=0.0)
    assert (loaded.drive.tight_tension_N > 1000.0).all()


def test_worn_chain_says_which_way_is_right() -> None:
    worn = solved(body_2={"elongation": 0.02}, positions={"count": 2})
    assert "effects.large_displacement = true follows the rollers" in worn.warnings[0]
    followed = solved(
        body_2={"elongation": 0.02}, positions={"count": 2}, effects={"large_displacement": True}
    )
    assert followed.warnings == ()
    assert followed.drive is not None
    assert followed.drive.mode == "large displacement"
    assert (followed.drive.passes > 2).all()
    assert np.nanmax(followed.drive.roller_height_um) > 700.0


@pytest.mark.parametrize(("slack", "holds"), [(8.0, True), (5.0, False)])
def test_chain_jumps_below_the_limit(slack: float, *, holds: bool) -> None:
    changes: dict[str, Any] = {
        "body_2": {"elongation": 0.01},
        "load": {"slack_tension_N": slack},
        "effects": {"large_displacement": True},
        "positions": {"angles_deg": [9]},
    }
    if holds:
        drive = solved(**changes).drive
        assert drive is not None
        assert 0 < drive.least_margin_N < 2.0
        return
    with pytest.raises(fl.NoContactState, match=r"over the tip .* below a slack tension of about"):
        solved(**changes)


def test_jump_limit_takes_the_moment_of_the_slack_strand(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    """T1 a = M + T2 b and T1 q^n: 10.5 pitches, roller 0 half a pitch off its line."""

    def no_state(*_: object, **__: object) -> None:
        raise ContactError("made up")

    torque_Nm, slack_N, radius = 77.0, 5000.0, 0.5 * 12.7 / np.sin(np.pi / 20)
    text = EXAMPLE.read_text().replace("angle_deg = 198", "angle_deg = 189")
    text = text.replace("tension_N = 100", "tension_N = 5000") + "[positions]\ncount = 1\n"
    path = tmp_path / "heavy.toml"
    path.write_text(text)
    scene = fl.Scene.from_dict(tomllib.loads(text))
    assert isinstance(scene.body_1, fl.scene.Sprocket)
    falls = build_sprocket(scene.body_1, "body_1").tension_ratio ** 10.5
    monkeypatch.setattr("flankload.mechanisms.chain.drive.solve_wrap", no_state)
    with pytest.raises(fl.NoContactState, match="made up") as refused:
        fl.solve(scene)
    said = re.search(r"below a slack tension of about (\S+) N", str(refused.value))
    assert said is not None
    tight_N = (1000 * torque_Nm / radius + slack_N) / np.cos(np.pi / 20)
    assert said[1] == f"{tight_N * falls:.3g}"
    assert main(["check", str(path)]) == 0
    on_circle = 1000 * torque_Nm / radius + slack_N
    assert f"{on_circle * falls:.4g} N" in capsys.readouterr().out


def test_exports_have_tensions(tmp_path: Path) -> None:
    result = solved(positions={"count": 2})
    tree = json.loads(result.to_json())
    assert tree["drive"]["mode"] == "linear"
    assert len(tree["drive"]["roller_height_um"][0]) == 12
    rows = list(csv.DictReader(io.StringIO(result.to_csv())))
    assert result.drive is not None
    assert float(rows[1]["tight_tension_N"]) == result.drive.tight_tension_N[1]
    assert float(rows[1]["tension_behind_N_pair_3"]) == result.drive.tension_behind_N[1, 3]
    assert "slack strand" in result.table()


def test_run_draws_and_check_describes(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["run", str(EXAMPLE), "--plot", str(tmp_path), "--quiet"]) == 0
    assert {path.name for path in tmp_path.iterdir()} == {
        "chain_on_sprocket.png",
        "load_map.png",
        "stiffness.png",
        "tensions.png",
        "transmission_error.png",
        "transmission_error_spectrum.png",
    }
    assert main(["check", str(EXAMPLE)]) == 0
    assert "chain jumps below about" in capsys.readouterr().out
    assert main(["mesh", str(EXAMPLE), "-o", str(tmp_path)]) == 2
    assert "body_2.kind: expected bodies with flanks" in capsys.readouterr().err


@pytest.mark.parametrize("kind", ["chain", "belt"])
def test_drawn_forces_have_the_moment_of_the_torque(kind: str) -> None:
    count = 3 if kind == "chain" else 1
    result = fl.solve({**example(kind), "positions": {"count": count}})
    drive = result.drive
    assert drive is not None
    for p, forces in enumerate(result.site_force_N):
        places = [drive.drawn_force(result, p, s) for s in range(result.sites.size)]
        levers = [result.reference_radius_mm * np.sin(there - angle) for angle, _, there in places]
        # MODEL: rollers are drawn on the pitch circle; 0.4 % where they are
        assert forces @ levers == pytest.approx(1e3 * result.torque_Nm, rel=5e-3)
