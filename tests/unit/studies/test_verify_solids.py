"""The solid deck for another program: layers of wedges on the true flanks, its answer by layers."""

import json
import math
import re
import shutil
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import flankload as fl
from flankload.cli import main
from flankload.errors import OtherProgramError, SceneError
from flankload.mechanisms.flank_pair.assembly import build_bodies
from flankload.pairing.body_pair import BodyPair
from flankload.studies.verification import comparison, solid_model
from flankload.studies.verification.calculix import read_answer
from flankload.studies.verification.deck import Deck, deck_text, probe_of
from flankload.studies.verification.deck_model import flanks_of
from flankload.studies.verification.size import ITERATIONS, PROBE, least_seconds, require_size
from flankload.studies.verification.solid import (
    Layers,
    Stand,
    beyond,
    layers_of,
    solid_part,
)
from flankload.studies.verification.solid_model import solid_model_of
from flankload.studies.verification.triangles import whole_body
from tests.support.paths import CALCULIX_SOLIDS, SCENES
from tests.support.solving import solve
from tests.support.tolerances import ROUND_OFF, SOLVER

#: Elements of 0.6 mm at contacts 0.2 mm wide, in three layers.
COARSE: dict[str, Any] = {"elements_per_half_width": 0.2}
#: Size of a deck by a coarse run against the exact one.
COARSE_SIZE = 0.02
#: Nodes of flanks are on them, mm.
ON_FLANK = 1e-9
#: Rotation, and loads of pairs as parts of the torque's, on so coarse elements.
COARSE_ROTATION, COARSE_LOAD = 0.05, 0.005
#: Volume of wedges with straight generators against area times width.
SAME_VOLUME = 1e-4


def scene_of(helix_deg: float = 0.0, **changes: dict[str, Any]) -> fl.Scene:
    """A pair of small gears with few elements; changes of tables."""
    gear = {"kind": "gear", "teeth": 12, "module_mm": 4, "profile_shift": 0.3,
            "tip_diameter_mm": 59 if helix_deg else 57.5, "bore_diameter_mm": 30}  # fmt: skip
    tree: dict[str, dict[str, Any]] = {
        "body_1": dict(gear),
        "body_2": dict(gear),
        "pair": {"center_distance_mm": 52.0 if helix_deg else 50.3, "face_width_mm": 10},
        "load": {"torque_Nm": 150},
        "positions": {"count": 4},
        "effects": {"dimension": 3},
        "accuracy": {"flank_element_mm": 2.0, "estimate": False, "tangents": False, "modes": 3,
                     "axial_degree": 5, "load_degree_z": 1, "slices": 10},
    }  # fmt: skip
    if helix_deg:
        tree["body_1"] |= {"helix_angle_deg": helix_deg, "hand": "right"}
        tree["body_2"] |= {"helix_angle_deg": helix_deg, "hand": "left"}
    for table, keys in changes.items():
        tree[table] |= keys
    return fl.Scene.from_dict(tree)


def deck_of(scene: fl.Scene, position: int) -> Deck:
    return solid_model_of(scene, solve(scene), position, large_displacement=False, **COARSE).deck


SKEWED = scene_of(
    12.0,
    body_1={"helix_slope_um": 9.0, "tooth_helix_slope_um": [0, *range(11)], "face_width_mm": 12,
            "pitch_errors_um": [0, 3, *[0] * 10]},
    body_2={"lead_crowning_um": 5.0, "profile_twist_um": 8.0, "end_relief_um": [3.0, 0.0],
            "end_relief_length_mm": [2.0, 2.0]},
    pair={"inclination_um_per_mm": 0.2, "deviation_um_per_mm": -0.3},
)  # fmt: skip


@pytest.fixture(scope="module")
def skewed() -> Deck:
    """Helical, modified in every way, of unequal widths."""
    return deck_of(SKEWED, 2)


# --- layers ---------------------------------------------------------------------------------------
def test_layers_are_thin_at_the_ends_and_fill_the_width() -> None:
    edges = layers_of(-3.0, 4.0, 12)
    thickness = np.diff(edges)
    np.testing.assert_allclose(edges[[0, -1]], [-3.0, 4.0], rtol=ROUND_OFF)
    np.testing.assert_allclose(thickness, thickness[::-1], rtol=SOLVER)
    np.testing.assert_allclose(thickness[[1, 5]] / thickness[0], [1.7, 3.0], rtol=SOLVER)


def test_wider_body_continues_the_layers() -> None:
    edges = layers_of(-3.0, 4.0, 4)
    every = beyond(edges, (-3.0, 9.0))
    assert every[:5].tolist() == edges.tolist()
    assert every[-1] == 9.0
    assert (np.diff(every) > 0).all()


# --- the bodies -----------------------------------------------------------------------------------
def wedge_jacobians(nodes: np.ndarray, cells: np.ndarray) -> np.ndarray:
    """Determinants (m, 6) of 15-node wedges at points beside their corners."""
    found = []
    for r, s in ((0.1, 0.1), (0.8, 0.1), (0.1, 0.8)):
        for t in (-0.8, 0.8):
            columns = []
            for d in np.eye(3) * 1e-5:
                up, down = (shapes(*(np.array([r, s, t]) + side * d)) for side in (1, -1))
                columns.append((up - down) / 2e-5)
            gradient = np.einsum("dk,mkx->mdx", np.array(columns), nodes[cells])
            found.append(np.linalg.det(gradient))
    return np.array(found).T


def shapes(r: float, s: float, t: float) -> np.ndarray:
    """Functions of the wedge with corners 1-3 at t = -1, 4-6 at t = 1."""
    areas = np.array([1 - r - s, r, s])
    low, high = 0.5 * (1 - t), 0.5 * (1 + t)
    middle = areas * (1 - t * t)
    between = 4 * areas * np.roll(areas, -1)
    corners = [areas * (2 * areas - 1) * side - 0.5 * middle for side in (low, high)]
    return np.concatenate([*corners, between * low, between * high, middle])


def test_wedges_have_positive_jacobians(skewed: Deck) -> None:
    for part in skewed.parts:
        determinants = wedge_jacobians(part.nodes, part.cells)
        assert (determinants.min(axis=1) > 0.1 * determinants.mean(axis=1)).all()


FACES = {
    3: (0, 1, 4, 3, 6, 13, 9, 12),
    4: (1, 2, 5, 4, 7, 14, 10, 13),
    5: (2, 0, 3, 5, 8, 12, 11, 14),
}


def flank_nodes(deck: Deck, z: int, k: int) -> np.ndarray:
    """Nodes of all faces of flank k of body z (0 or 1)."""
    part = deck.parts[z]
    faces = np.vstack(part.flanks[k * deck.layers : (k + 1) * deck.layers])
    return np.unique([part.cells[e, list(FACES[f])] for e, f in faces.tolist()])


def test_nodes_of_flanks_are_on_the_modified_helicoids(skewed: Deck) -> None:
    """The flank of tooth and z, turned by the metal removed over the base radius."""
    pair = build_bodies(SKEWED)
    turns = [float(turn) for turn in pair.pairing.turns(solve(SKEWED).position_rad[2])]
    turns[0] += skewed.start_rad
    assert -1 in skewed.sites  # other teeth than those of pair 0
    twist = math.tan(math.radians(12.0)) / (12 * 4 / math.cos(math.radians(12.0)) / 2)
    for z, body in enumerate((pair.body_1, pair.body_2)):
        flanks = flanks_of(pair, z, skewed.sites)
        for k, (site, (_, angle)) in enumerate(zip(skewed.sites, flanks, strict=True)):
            x, y, height = skewed.parts[z].nodes[flank_nodes(skewed, z, k)].T
            if z == 1:
                x, y = x - 52.0 - 0.2e-3 * height, y + 0.3e-3 * height
            places = (x + 1j * y) * np.exp(-1j * (turns[z] + (-1) ** z * twist * height + angle))
            assert (height <= 5.0 + ON_FLANK).all()
            s = arc_lengths(body, np.abs(places))
            low, high = body.mode_range_mm
            on = (s > low) & (s < high) if z == 1 else s >= 0  # beside it the twist fades
            assert on.sum() > 30
            xi = (s - low) / (high - low)
            removed = removed_1(-site % 12, height) if z == 0 else removed_2(xi, height)
            places *= np.exp(1j * removed / body.base_radius_mm)
            points = np.stack([places.real, places.imag], axis=1)
            assert body.curve.arc_length_of(points[on])[1].max() < ON_FLANK


def removed_1(tooth: int, z: np.ndarray) -> np.ndarray:
    """Metal removed from body 1 of the scene SKEWED: both helix slopes."""
    return np.asarray(1e-3 * (z + 6.0) / 12.0 * (9.0 + max(0, tooth - 1)))


def removed_2(xi: np.ndarray, z: np.ndarray) -> np.ndarray:
    """Metal removed from body 2: crowning, end relief and twist."""
    zeta = (z + 5.0) / 10.0
    crowning, relief = 5e-3 * (2 * zeta - 1) ** 2, 3e-3 * np.maximum(0.0, 1 - 10 * zeta / 2.0)
    return np.asarray(crowning + relief + 4e-3 * (2 * zeta - 1) * (2 * xi - 1))


def arc_lengths(body: Any, radii: np.ndarray) -> np.ndarray:
    """Arc lengths of points of a flank from their distance to the axis."""
    s = np.linspace(0.0, body.curve.length_mm, 4000)
    first = np.interp(radii, np.hypot(*body.curve.point(s).T), s)
    for _ in range(6):  # Newton's method
        p, t = body.curve.point(first), body.curve.tangent(first)
        r = np.hypot(*p.T)
        first = np.clip(first - (r - radii) * r / (p * t).sum(axis=1), 0, body.curve.length_mm)
    return first


def test_misalignment_opens_the_gap_as_in_flankload(skewed: Deck) -> None:
    pair = build_bodies(SKEWED)
    assert pair.pairing.gear_geometry is not None
    angle = pair.pairing.gear_geometry.pressure_angle_rad
    held = skewed.parts[1].nodes[skewed.parts[1].held]
    ends = [held[held[:, 2] == z, :2].mean(axis=0) for z in (held[:, 2].min(), held[:, 2].max())]
    shift = (ends[1] - ends[0]) / np.ptp(held[:, 2])
    opened = shift @ [math.sin(angle), math.cos(angle)]
    plain = build_bodies(
        SKEWED.replace({"pair.inclination_um_per_mm": 0, "pair.deviation_um_per_mm": 0})
    )
    slices, without = pair.slices, plain.slices
    more = np.diff((slices.removed_mm[1] - without.removed_mm[1])[[0, -1]])
    np.testing.assert_allclose(opened, more / np.ptp(slices.z_mm), rtol=1e-6)


@pytest.fixture(scope="module")
def straight() -> BodyPair:
    return build_bodies(scene_of())


def half_thick(pair: BodyPair) -> tuple[Any, Any]:
    """Body 1 with four thin layers on one side of a line and two thick ones on the other."""
    mesh = whole_body(pair.body_1, ((0, 0.0),))
    edges = np.array([-5.0, -3.0, 0.0, 3.5, 5.0])
    near = mesh.vertices[mesh.corners].mean(axis=1)[:, 0] > -3.0
    layers = Layers(edges, np.array([0, 2, 4]), (0, 4), near)
    return solid_part(pair.body_1, mesh, (0,), layers, Stand(0.0, 0.0, (0.0, 0.0))), mesh


def test_thin_and_thick_layers_fill_the_body_without_gaps(straight: BodyPair) -> None:
    part, mesh = half_thick(straight)
    corners = part.nodes[part.cells[:, :6]]
    base = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    volume = 0.5 * np.cross(*base)[:, 2] * (corners[:, 3, 2] - corners[:, 0, 2])
    a, b, c = (mesh.vertices[mesh.corners[:, k]] for k in range(3))
    u, v = b - a, c - a
    area = 0.5 * (u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]).sum()
    np.testing.assert_allclose(volume.sum(), 10.0 * area, rtol=SAME_VOLUME)


def test_tied_nodes_follow_quadratic_displacements_of_thick_layers(straight: BodyPair) -> None:
    part, _ = half_thick(straight)
    ties = part.ties
    assert ties.nodes.size > 0
    np.testing.assert_allclose(ties.weights.sum(axis=1), 1.0, rtol=SOLVER)
    x, y, z = part.nodes.T
    for field in (x, y, z, z**2, x * z, y * z, x * y):
        values = np.einsum("kj,kj->k", ties.weights, field[ties.masters])
        np.testing.assert_allclose(values, field[ties.nodes], rtol=0, atol=0.02)
    for field in (x, y, z, z**2):  # along the axis the generators are straight: exact
        values = np.einsum("kj,kj->k", ties.weights, field[ties.masters])
        np.testing.assert_allclose(values, field[ties.nodes], rtol=0, atol=1e-9)
    # no node hangs: those that thin wedges alone use on the border of the thick ones are tied
    assert not np.intersect1d(ties.nodes, ties.masters).size
    assert not np.intersect1d(ties.nodes, part.held).size


# --- the file -------------------------------------------------------------------------------------
def blocks_of(text: str) -> list[tuple[str, list[str]]]:
    """Keyword lines and the lines of data under each."""
    found: list[tuple[str, list[str]]] = []
    for line in text.splitlines():
        if line.startswith("*") and not line.startswith("**"):
            found.append((line, []))
        elif not line.startswith("**"):
            found[-1][1].append(line)
    return found


def test_deck_agrees_with_the_arrays(skewed: Deck) -> None:
    blocks = blocks_of(deck_text(skewed))
    rows = [row for key, data in blocks if key == "*NODE" for row in data]
    nodes = np.array([[float(x) for x in row.split(",")[1:]] for row in rows])
    np.testing.assert_allclose(nodes, np.vstack([p.nodes for p in skewed.parts]), atol=1e-9)
    elements = {}
    for key, data in blocks:
        if key.startswith("*ELEMENT"):
            assert "TYPE=C3D15" in key
            elements |= {int(k[0]): k[1:] for k in (list(map(int, row.split(","))) for row in data)}
    offset = len(skewed.parts[0].nodes)
    cells = np.vstack([skewed.parts[0].cells, skewed.parts[1].cells + offset]) + 1
    assert np.array_equal(np.array([elements[k + 1] for k in range(len(elements))]), cells)
    surfaces = {key.split("NAME=")[1].split(",")[0]: data for key, data in blocks
                if key.startswith("*SURFACE, NAME")}  # fmt: skip
    pairs = [data[0] for key, data in blocks if key.startswith("*CONTACT PAIR")]
    assert len(pairs) == len(skewed.sites) * skewed.layers
    for pair in pairs:
        slave, master = (surfaces[name] for name in pair.split(", "))
        assert len({nodes_of(row, elements, nodes) for row in slave}) == 1  # all in one layer
        assert len(master) > len(slave) / 3
    (load,) = (data for key, data in blocks if key == "*CLOAD")
    assert load == ["AXIS_1, 1, 150000"]
    for key, data in blocks[1:]:
        if key == "*EQUATION":
            terms = ", ".join(data[1:]).split(", ")
            assert len(terms) == 3 * int(data[0])
        if "SURFACE" not in key and "CONTACT" not in key:
            for line in data:
                assert max(len(field.strip()) for field in line.split(",")) <= 20


def nodes_of(row: str, elements: dict[int, list[int]], nodes: np.ndarray) -> float:
    """Lower end of the element of a face."""
    return float(nodes[elements[int(row.split(",")[0])][0] - 1, 2])


def test_held_nodes_of_body_1_turn_as_one(skewed: Deck) -> None:
    part, axis = skewed.parts[0], skewed.axis_node(1)
    equations = [
        "".join(data[1:]).split(", ")
        for key, data in blocks_of(deck_text(skewed))
        if key == "*EQUATION"
    ]
    turning = [row for row in equations if row[3] == f"{axis}"]
    assert len(turning) == 2 * part.held.size
    np.testing.assert_allclose(np.hypot(*part.nodes[part.held, :2].T), 15.0, rtol=SOLVER)
    for node, component, one, _, first, arm in turning:
        x, y, _ = part.nodes[int(node) - 1]
        assert (first, float(one)) == ("1", 1.0)
        np.testing.assert_allclose((-y, x)[int(component) - 1] + float(arm), 0.0, atol=SOLVER)


# --- the answer -----------------------------------------------------------------------------------
def small_deck() -> Deck:
    """The deck whose output is kept, as far as the reader looks at it."""
    edges = layers_of(-5.0, 5.0, 2)
    return Deck("kept", (), (-1, 0), 150e3, 1e-4, False, edges_mm=edges, width_mm=10.0)  # type: ignore[arg-type]


def test_reader_has_the_force_of_each_layer() -> None:
    answer = read_answer(CALCULIX_SOLIDS, small_deck())
    text = (CALCULIX_SOLIDS / "deck.dat").read_text(encoding="utf-8")
    turned = re.search(r"AXIS_1 and time .*\n\n +\d+ +(\S+)", text)
    assert turned is not None
    assert answer.rotation_rad == pytest.approx(1e-4 + float(turned[1]), rel=ROUND_OFF)
    load = answer.line_load_N_per_mm
    assert load is not None
    assert load.shape == (2, 2)
    total = re.search(r"PAIR_M1_LAYER_1_BODY_2.*\n\n.*\n\n +(\S+) +(\S+) +(\S+)", text)
    assert total is not None
    force = math.hypot(*(float(x) for x in total.groups()))
    assert load[0, 1] == pytest.approx(force / 5.0, rel=ROUND_OFF)
    np.testing.assert_allclose(answer.force_N_per_mm, load.mean(axis=1), rtol=SOLVER)
    np.testing.assert_allclose(answer.moment_N, 15000.0, rtol=2e-3)


def test_output_without_rotation_is_one_line(tmp_path: Path) -> None:
    (tmp_path / "deck.dat").write_text("nothing", encoding="utf-8")
    with pytest.raises(OtherProgramError, match=r"for set AXIS_1' in deck\.dat"):
        read_answer(tmp_path, small_deck())


def test_table_compares_layers_with_the_slices_in_them(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(
        comparison, "_run", lambda *_, **__: read_answer(CALCULIX_SOLIDS, small_deck())
    )
    found = fl.verify(scene_of(), position=2, elements_per_half_width=0.1)
    layers, loads = found.layers, solve(scene_of()).slices
    assert layers is not None
    assert loads is not None
    # two layers of five slices each
    ours = loads.line_load_N_per_mm[2].reshape(-1, 2, 5).mean(axis=2)
    np.testing.assert_allclose(layers.line_load_N_per_mm, ours[ours.any(axis=1)], rtol=SOLVER)
    summed = ours.sum(axis=0)
    assert layers.line_load_factor(ours) == pytest.approx(summed.max() / summed.mean())
    text = found.table()
    assert "z -5.00 to 0.00 mm" in text
    assert "15-node wedges in 2 layers" in text
    assert "pressure" not in text
    tree = json.loads(found.to_json())
    assert tree["deck"]["unknowns"] == layers.unknowns
    assert tree["calculix"]["line_load_N_per_mm"][0][1] > 0


# --- scenes ---------------------------------------------------------------------------------------
@pytest.mark.parametrize(
    ("changes", "line"),
    [
        ({"body_2": {"shaft": {"compliance": np.zeros((6, 6)).tolist()}}},
         "body_2.shaft: expected nothing, since the deck turns the bore of body 1 about a fixed"),
        ({"body_1": {"web_width_mm": 5.0, "rim_thickness_mm": 3.0}},
         "body_1.web_width_mm: expected nothing, since all of a body in the deck is as wide as"),
        ({"effects": {"friction_coefficient": 0.1}},
         "effects.friction_coefficient: expected nothing, since solid decks have no friction"),
    ],
)  # fmt: skip
def test_features_that_the_deck_lacks_are_refused(changes: dict[str, Any], line: str) -> None:
    with pytest.raises(SceneError, match=re.escape(line)):
        fl.verify(scene_of(**changes), run=False)


def test_internal_gears_are_refused() -> None:
    with pytest.raises(SceneError, match=r"body_2\.kind: expected 'gear' or 'mesh', since solid"):
        fl.verify(fl.read_scene(SCENES / "internal_helical.toml"), run=False)


def test_dimension_is_that_of_both_programs(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(comparison, "SOLID_ELEMENTS", 0.2)
    plane = tmp_path / "pair.toml"
    body = "kind = 'gear'\nteeth = 12\nmodule_mm = 4\nprofile_shift = 0.3\ntip_diameter_mm = 57.5\n"
    body += "bore_diameter_mm = 30\n"
    plane.write_text(
        f"[body_1]\n{body}[body_2]\n{body}[pair]\ncenter_distance_mm = 50.3\nface_width_mm = 10\n"
        "[load]\ntorque_Nm = 150\n[positions]\ncount = 1\n"
        "[accuracy]\nflank_element_mm = 3.0\nmodes = 3\nestimate = false\n",
        encoding="utf-8",
    )
    told = ["--no-run", "--json", "--dimension", "3"]
    assert main(["verify", str(plane), *told, "-o", str(tmp_path)]) == 0
    out = capsys.readouterr().out
    assert len(json.loads(out)["deck"]["layer_ends_mm"]) == 4
    assert "C3D15" in (tmp_path / "deck.inp").read_text(encoding="ascii")
    assert main(["verify", str(SCENES / "helical_gear.toml"), "--dimension", "2"]) == 2
    assert "effects.dimension: expected 3 or nothing" in capsys.readouterr().err
    assert main(["verify", str(plane), "--dimension", "3", "--elements", "0.1"]) == 2
    assert "--elements: expected a number from 0.2 to 100" in capsys.readouterr().err


# --- size and time --------------------------------------------------------------------------------
def test_size_is_known_before_the_scene_is_solved(monkeypatch: pytest.MonkeyPatch) -> None:
    """Regression: a wide helical pair was meshed and passed to CalculiX, which did not end."""
    exact = deck_of(SKEWED, 2).unknowns
    reached: list[tuple[str, int, int, float | None]] = []

    def solve_nothing(*_: object) -> None:
        raise AssertionError("the scene was solved")

    monkeypatch.setattr(comparison, "_solved", solve_nothing)
    options: dict[str, Any] = {"position": 2, **COARSE, "run": False}
    with pytest.raises(SceneError, match=r"found 0\.2 elements with about [\d ]+ unknowns$"):
        fl.verify(SKEWED, most_unknowns=exact // 2, **options)
    with pytest.raises(AssertionError, match="solved"):
        fl.verify(SKEWED, progress=lambda *one: reached.append(one), **options)
    (_, (stage, done, _, left_s)) = reached
    assert (done, left_s) == (0, None)
    assert abs(int(re.sub(r"\D", "", stage)) / exact - 1.0) < COARSE_SIZE


def test_a_deck_that_is_too_large_names_one_that_is_not() -> None:
    def solid(elements: float) -> Any:
        return SimpleNamespace(unknowns=round(1_234_567 * elements**2))

    with pytest.raises(SceneError) as refused:
        require_size(solid(1.0).unknowns, 400_000, 1.0, solid)
    assert str(refused.value) == (
        "elements: expected a deck of at most 400000 unknowns (0.5 elements have about 309 000; "
        "most_unknowns or --most-unknowns allows more), found 1 elements with about 1 230 000 "
        "unknowns"
    )
    require_size(400_000, 400_000, 1.0)


def test_a_small_part_of_the_deck_measures_the_other_program(skewed: Deck, tmp_path: Path) -> None:
    text, unknowns = probe_of(skewed, 50)
    blocks = {block.split("\n")[0]: block.split("\n")[1:-1] for block in text.split("*")}
    nodes, held = blocks["NODE"], blocks["NSET, NSET=HELD_1"]
    wedges = [row.split(", ")[1:] for row in blocks["ELEMENT, TYPE=C3D15, ELSET=BODY_1"]]
    assert [len(row) for row in wedges] == [15] * 50
    assert {int(node) for row in wedges for node in row} == set(range(1, len(nodes) + 1))
    assert unknowns == 3 * (len(nodes) - len(held)) > 0
    program = tmp_path / "ccx"
    program.write_text("#!/bin/sh\nsleep 0.1; echo Job finished\n", encoding="utf-8")
    program.chmod(0o755)
    least = ITERATIONS * 0.1 * skewed.unknowns / probe_of(skewed, PROBE)[1]
    found = least_seconds(skewed, str(program))
    assert found is not None
    assert found > least
    program.write_text("#!/bin/sh\nexit 1\n", encoding="utf-8")
    assert least_seconds(skewed, str(program)) is None


# --- the other program itself ---------------------------------------------------------------------
@pytest.mark.skipif(shutil.which("ccx") is None, reason="CalculiX is not installed")
def test_coarse_solids_give_rotation_and_loads(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(solid_model, "LAYERS", 5.0)  # one layer
    found = fl.verify(scene_of(), position=2, **COARSE)
    other = found.calculix
    assert other is not None
    assert abs(found.rotation_difference) < COARSE_ROTATION
    assert np.abs(found.share_difference).max() < COARSE_LOAD
    np.testing.assert_allclose(other.moment_N, 150e3 / 10, rtol=2e-3, atol=0)
