"""The deck for another program: whole bodies, conforming triangles, the file; its answer."""

import importlib
import json
import os
import re
import shutil
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import flankload as fl
from flankload.bodies import Material
from flankload.cli import main
from flankload.errors import OtherProgramError, SceneError
from flankload.mechanisms.flank_pair.assembly import build_bodies
from flankload.meshes.plane_mesh import jacobians, scaled_jacobians
from flankload.pairing.body_pair import BodyPair
from flankload.pairing.friction import friction_of
from flankload.studies.verification import deck_model
from flankload.studies.verification.bore_equations import GROUP, further_nodes
from flankload.studies.verification.calculix import read_answer, run_deck, version_of
from flankload.studies.verification.contact_places import Place, contact_places
from flankload.studies.verification.deck import Deck, DeckFriction, Part, deck_text
from flankload.studies.verification.deck_model import check_bodies, friction_of_deck, model_of
from flankload.studies.verification.triangles import (
    Triangles,
    quadratic,
    refined,
    sides,
    whole_body,
)
from tests.support.paths import CALCULIX_OUTPUT, SCENES
from tests.support.tolerances import ROUND_OFF, SOLVER

#: Elements of 2.25 mm against those of 0.3 mm, and coarse ones at the contact.
COARSE_DECK = 0.01
#: The border goes from the parabolas of long elements to those of short ones.
SAME_AREA = 1e-5
#: Halving across longest sides halves the smallest angle of the coarse mesh at the most.
WORST_PART = 0.5
#: Samples of a flank are 0.01 mm apart.
SAMPLED = 0.011


def scene_of(name: str = "external_gear", **more: object) -> fl.Scene:
    tree = {**_tables(name), **more}
    accuracy = (
        {"flank_element_mm": 2.25, "estimate": False, "tangents": False} if "gear" in name else {}
    )
    tree["accuracy"] = {**accuracy, **tree.get("accuracy", {})}
    return fl.Scene.from_dict(tree)


def _tables(name: str) -> dict:
    import tomllib

    tree = tomllib.loads((SCENES / f"{name}.toml").read_text(encoding="utf-8"))
    tree["positions"] = {"count": 8}
    return tree


@pytest.fixture(scope="module", autouse=True)
def _coarse_bodies() -> Iterator[None]:
    """Coarse elements away from the contacts: the tests ask for no more."""
    model = importlib.import_module("flankload.studies.verification.deck_model")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(model, "COARSE_PART", 1.0)
        patch.setattr(model, "GROWTH", 1.0)
        yield


@pytest.fixture(scope="module")
def pair() -> BodyPair:
    return build_bodies(scene_of())


@pytest.fixture(scope="module")
def fine(pair: BodyPair) -> Triangles:
    """Body 1, fine about the working flank of tooth 0."""
    body = pair.body_1
    mesh = whole_body(body, ((0, 0.0), (15, -2 * np.pi / 16)))
    middle = body.curve.point([0.5 * body.curve.length_mm])[0]
    return refined(mesh, lambda points: size_at(points, middle))


def size_at(points: np.ndarray, middle: np.ndarray) -> np.ndarray:
    return 0.05 + 0.3 * np.linalg.norm(points - middle, axis=1)


# --- triangles ------------------------------------------------------------------------------------
def test_every_side_belongs_to_two_triangles_or_to_the_border(fine: Triangles) -> None:
    numbers, ends = sides(fine.corners)
    count = np.bincount(numbers.ravel())
    assert set(count) == {1, 2}
    alone = {tuple(pair) for pair in ends[count == 1].tolist()}
    assert alone == {tuple(sorted(pair)) for pair in fine.border.ends.tolist()}
    # a body with one hole
    assert len(fine.vertices) - len(ends) + len(fine.corners) == 0


def test_border_has_its_material_on_the_left(fine: Triangles) -> None:
    corners = fine.corners
    directed = {
        pair for k in range(3) for pair in map(tuple, corners[:, [k, (k + 1) % 3]].tolist())
    }
    assert {tuple(pair) for pair in fine.border.ends.tolist()} <= directed


def test_sides_are_as_short_as_wanted_and_no_element_is_bent_over(
    pair: BodyPair, fine: Triangles
) -> None:
    middle = pair.body_1.curve.point([0.5 * pair.body_1.curve.length_mm])[0]
    corners = fine.vertices[fine.corners]
    longest = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)
    assert (longest <= size_at(corners.mean(axis=1), middle)).all()
    nodes, cells, _ = quadratic(fine)
    assert (jacobians(nodes, "triangle6", cells) > 0).all()
    start, first, _ = quadratic(whole_body(pair.body_1, ()))
    worst = scaled_jacobians(start, "triangle6", first).min()
    assert scaled_jacobians(nodes, "triangle6", cells).min() > WORST_PART * worst


def test_refinement_keeps_the_area_and_the_flanks_on_their_curve(
    pair: BodyPair, fine: Triangles
) -> None:
    body = pair.body_1
    start = whole_body(body, ((0, 0.0), (15, -2 * np.pi / 16)))
    assert len(fine.corners) > len(start.corners)
    np.testing.assert_allclose(area(fine), area(start), rtol=SAME_AREA, atol=0)
    border = fine.border
    for k, turn in enumerate((0.0, -2 * np.pi / 16)):
        ours = border.flank == k
        s, distance = body.curve.rotated(turn).arc_length_of(fine.vertices[border.ends[ours, 0]])
        assert distance.max() < ROUND_OFF * body.curve.length_mm * 100
        np.testing.assert_allclose(s, border.s[ours, 0], rtol=0, atol=SOLVER)
        # the sides of a flank follow each other from one end of the curve to the other
        np.testing.assert_allclose(
            np.abs(np.diff(border.s[ours], axis=1)).sum(), body.curve.length_mm, rtol=SOLVER, atol=0
        )


def area(mesh: Triangles) -> float:
    """Area with curved border, by the parabolas' own formula."""
    place, border = mesh.vertices, mesh.border
    a, b, m = place[border.ends[:, 0]], place[border.ends[:, 1]], border.middles

    def cross(u: np.ndarray, v: np.ndarray) -> np.ndarray:
        return u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]

    return float((0.5 * cross(a, b) + 2 / 3 * cross(b - a, 0.5 * (a + b) - m)).sum())


def test_flank_beside_its_share_takes_the_border_with_it(pair: BodyPair) -> None:
    body, beside = pair.body_1, 2e-4
    mesh = whole_body(body, ((3, 3 * 2 * np.pi / 16 + beside),))
    ours = mesh.border.flank == 0
    s = mesh.border.s[ours, 0]
    wanted = body.curve.rotated(3 * 2 * np.pi / 16 + beside).point(s)
    np.testing.assert_allclose(
        mesh.vertices[mesh.border.ends[ours, 0]], wanted, rtol=0, atol=SOLVER
    )


@pytest.mark.parametrize(
    "name", ["internal_gear", "spline", "toothed_sector", "external_gear_mesh"]
)
def test_every_kind_of_mesh_becomes_a_whole_body(name: str) -> None:
    found = build_bodies(fl.read_scene(SCENES / f"{name}.toml"))
    pairing = found.pairing
    for z, body in enumerate((found.body_1, found.body_2)):
        teeth, angles = pairing.site_teeth[z].tolist(), pairing.site_angles_rad[z].tolist()
        flanks = tuple(zip(teeth, angles, strict=True))[:2]
        mesh = whole_body(body, flanks)
        numbers, _ = sides(mesh.corners)
        assert (np.bincount(numbers.ravel()) <= 2).all()
        assert mesh.border.held.any()
        for k in range(len(flanks)):
            lengths = np.abs(np.diff(mesh.border.s[mesh.border.flank == k], axis=1)).sum()
            assert lengths > 0.5 * body.curve.length_mm
        nodes, cells, _ = quadratic(mesh)
        assert (jacobians(nodes, "triangle6", cells)[:, :3].mean(axis=1) > 0).all()


# --- places ---------------------------------------------------------------------------------------
def places_of(pair: BodyPair, reach: float) -> tuple:
    turns = pair.pairing.turns(np.zeros(1))
    return contact_places(
        pair, (float(turns[0][0]), float(turns[1][0])), force_N_per_mm={0: 637.66},
        rotation_rad=1.36e-3, reach=reach, elements_per_half_width=6.0, plane="strain",
    )  # fmt: skip


def test_place_of_pair_0_is_the_pitch_point(pair: BodyPair) -> None:
    (place,) = places_of(pair, 1.0)
    assert place.site == 0
    assert abs(place.gap_rad) < 1e-6
    np.testing.assert_allclose(place.points[-1], [91.5 * 16 / 40, 0.0], rtol=0, atol=SAMPLED)


def test_elements_are_as_many_as_wanted_on_the_half_width(pair: BodyPair) -> None:
    # Hertz at the pitch point: 1/rho = (1/16 + 1/24) / (m/2 * sin of the working angle)
    (place,) = places_of(pair, 1.0)
    curvature = (1 / 16 + 1 / 24) / (0.5 * 91.5 / 20 * np.sin(np.arccos(33.82893 / 36.6)))
    c = 4 * (1 - 0.3**2) / (np.pi * 206000)
    width = np.sqrt(2 * 637.66 * c / curvature)
    np.testing.assert_allclose(place.element_mm, width / 6.0, rtol=1e-3, atol=0)


def test_farther_flanks_are_watched_with_a_longer_reach(pair: BodyPair) -> None:
    assert [place.site for place in places_of(pair, 30.0)] == [-1, 0, 1]


# --- the file -------------------------------------------------------------------------------------
@pytest.fixture(scope="module")
def deck() -> Deck:
    scene = scene_of()
    result = fl.solve(scene)
    model = model_of(scene, result, 3, elements_per_half_width=2.0, large_displacement=False)
    return model.deck


def blocks_of(text: str) -> list[tuple[str, list[str]]]:
    """Keyword lines and the lines of data under each."""
    found: list[tuple[str, list[str]]] = []
    for line in text.splitlines():
        if line.startswith("**"):
            continue
        if line.startswith("*"):
            found.append((line, []))
        else:
            found[-1][1].append(line)
    return found


def test_deck_agrees_with_the_arrays(deck: Deck) -> None:
    blocks = blocks_of(deck_text(deck))
    node_lines = [line for key, data in blocks if key.startswith("*NODE") and "PRINT" not in key
                  for line in data]  # fmt: skip
    nodes = {int(line.split(",")[0]): np.array(line.split(",")[1:3], float) for line in node_lines}
    assert sorted(nodes) == list(range(1, deck.node_count + 2))
    elements = {}
    for key, data in blocks:
        if key.startswith("*ELEMENT"):
            assert "TYPE=CPE6" in key
            elements |= {int(k[0]): k[1:] for k in (list(map(int, row.split(","))) for row in data)}
    assert len(elements) == sum(len(part.cells) for part in deck.parts)
    # a surface is one run of sides on its flank: each end but two belongs to two sides
    surfaces = {key.split("NAME=")[1].split(",")[0]: data for key, data in blocks
                if key.startswith("*SURFACE, NAME")}  # fmt: skip
    assert sorted(surfaces) == [
        *("PAIR_0_LAYER_0_BODY_1", "PAIR_0_LAYER_0_BODY_2"),
        *("PAIR_M1_LAYER_0_BODY_1", "PAIR_M1_LAYER_0_BODY_2"),
    ]  # fmt: skip
    for data in surfaces.values():
        ends = []
        for row in data:
            element, side = row.split(", S")
            corners = elements[int(element)][:3]
            ends += [corners[int(side) - 1], corners[int(side) % 3]]
        counts = np.unique(ends, return_counts=True)[1]
        assert sorted(counts)[:3] == [1, 1, 2]
        assert max(counts) == 2
    sets = {key.split("NSET=")[1]: data for key, data in blocks if key.startswith("*NSET")}
    for name, radius, centre in (("HELD_1", 15.0, [0, 0]), ("HELD_2", 20.0, [91.5, 0])):
        held = np.array([nodes[int(row.strip(","))] for row in sets[name]]) - centre
        np.testing.assert_allclose(np.hypot(*held.T), radius, rtol=SOLVER, atol=0)


def test_held_nodes_of_body_1_turn_as_one(deck: Deck) -> None:
    part = deck.parts[0]
    equations = [data for key, data in blocks_of(deck_text(deck)) if key == "*EQUATION"]
    assert len(equations) == 2 * part.held.size
    turn = 1e-3
    for count, terms in equations:
        node, component, one, axis, first, arm = terms.split(",")
        assert (count, int(axis), int(first), float(one)) == ("2", deck.axis_node(1), 1, 1.0)
        x, y = part.nodes[int(node) - 1]
        moved = (-y * turn, x * turn)[int(component) - 1]
        np.testing.assert_allclose(moved + float(arm) * turn, 0.0, rtol=0, atol=SOLVER)


def test_no_number_is_longer_than_calculix_reads(deck: Deck) -> None:
    for _, data in blocks_of(deck_text(deck))[1:]:
        for line in data:
            numbers = [field.strip() for field in line.split(",") if "PAIR" not in field]
            assert max(map(len, numbers), default=0) <= 20


def test_torque_is_that_of_a_millimetre_of_width(deck: Deck) -> None:
    (load,) = (data for key, data in blocks_of(deck_text(deck)) if key == "*CLOAD")
    np.testing.assert_allclose(float(load[0].split(",")[2]), 302e3 / 14, rtol=SOLVER, atol=0)


def test_options_are_in_the_deck(deck: Deck) -> None:
    other = deck_text(
        replace(deck, plane="stress", large_displacement=True, title="*STEP\n*END STEP")
    )
    assert other.splitlines()[1].startswith("scene: *STEP *END STEP")
    assert "TYPE=CPS6" in other
    assert "NLGEOM" in other
    assert "NLGEOM" not in deck_text(deck)


# --- friction -------------------------------------------------------------------------------------
def rubbing_of(
    pair_: BodyPair, coefficients: object, driver: str = "body_1"
) -> DeckFriction | None:
    scene = scene_of(
        effects={"friction_coefficient": coefficients}, positions={"count": 8, "driver": driver}
    )
    friction = friction_of(scene, pair_.body_1, pair_.pairing)
    places = tuple(Place(site, 0.0, 0.1, np.zeros((1, 2))) for site in (-1, 0))
    return friction_of_deck(scene, replace(pair_, friction=friction), places)


@pytest.mark.parametrize(("driver", "sense"), [("body_1", 1), ("body_2", -1)])
def test_body_2_comes_from_where_it_stood_a_little_before(
    pair: BodyPair, driver: str, sense: int
) -> None:
    friction = rubbing_of(pair, 0.1, driver)
    turned = pair.pairing.turns(np.array([0.0, sense * 2e-3]))[1]
    assert friction.back_rad == pytest.approx(turned[0] - turned[1], rel=SOLVER)
    assert friction.coefficients == (0.1, 0.1)


def test_pairs_have_the_coefficients_of_their_teeth(pair: BodyPair) -> None:
    by_tooth = [0.0] * 16
    by_tooth[1] = 0.2  # the tooth that comes into contact after that of pair 0: pair -1
    assert rubbing_of(pair, by_tooth).coefficients == (0.2, 0.0)


def test_coefficients_along_a_flank_are_refused(pair: BodyPair) -> None:
    with pytest.raises(SceneError, match=r"friction_coefficient: expected a number, or one per"):
        rubbing_of(pair, [[-5.0, 0.05], [5.0, 0.1]])


def test_flanks_slide_to_the_position_in_a_second_step(deck: Deck) -> None:
    friction = DeckFriction((0.2, 0.0), 1e-3)
    blocks = blocks_of(deck_text(replace(deck, friction=friction)))
    rows = [row for key, data in blocks if key == "*BOUNDARY" for row in data]
    assert [row for row in rows if "AXIS_2, 1" in row] == [
        "AXIS_2, 1, 1, 0.001",
        "AXIS_2, 1, 1, 0.",
    ]
    assert not any("HELD_2" in row for row in rows)
    assert [key for key, _ in blocks].count("*STATIC") == 2
    (friction,) = (k for k, (key, _) in enumerate(blocks) if key == "*FRICTION")
    assert blocks[friction][1] == ["0.2, 5e+06"]
    assert blocks[friction - 2][0] == "*SURFACE INTERACTION, NAME=PAIR_M1"
    part, first = deck.parts[1], 1 + len(deck.parts[0].nodes)
    equations = [data[1].split(",") for key, data in blocks if key == "*EQUATION"]
    about_2 = [row for row in equations if int(row[3]) == deck.axis_node(2)]
    assert len(about_2) == 2 * part.held.size
    for node, component, _, _, _, arm in about_2:
        x, y = part.nodes[int(node) - first] - [91.5, 0.0]
        moved = (-y, x)[int(component) - 1]
        np.testing.assert_allclose(moved + float(arm), 0.0, rtol=0, atol=SOLVER)


def test_a_free_bore_follows_its_axis_in_the_mean(deck: Deck) -> None:
    """A rotation about the axis and an oval bore satisfy the equations, a displacement does not."""
    held = deck.parts[1]
    assert held.weights is None
    free = replace(held, weights=np.ones(held.held.size))
    changed = replace(deck, parts=(deck.parts[0], free))
    assert changed.unknowns == deck.unknowns + 2 * held.held.size - 3
    blocks = blocks_of(deck_text(changed))
    assert "AXIS_2, 1, 1" in [row for key, data in blocks if key == "*BOUNDARY" for row in data]
    axis, first, further = deck.axis_node(2), 1 + len(deck.parts[0].nodes), changed.first_sum(2)
    equations = [
        np.array([float(word) for row in data[1:] for word in row.split(",")]).reshape(-1, 3)
        for key, data in blocks
        if key == "*EQUATION"
    ]
    equations = [rows for rows in equations if rows[0, 0] >= first]
    assert max(map(len, equations)) <= 2 * 2 * GROUP + 7  # few terms keep the stiffness sparse
    dependent = {tuple(rows[0, :2]) for rows in equations}
    assert len(dependent) == len(equations)
    assert not any(tuple(term[:2]) in dependent for rows in equations for term in rows[1:])
    sums = np.zeros((len(equations), 3 * further_nodes(held.held.size)))
    for rows, row in zip(equations, sums, strict=True):
        for node, c, f in rows[rows[:, 0] >= further]:
            row[3 * int(node - further) + int(c) - 1] = f
    x, y = (held.nodes - [91.5, 0.0]).T

    def left(u: np.ndarray, turn: float) -> float:
        """Residual of the equations."""
        moved = dict(enumerate(u, start=first)) | {axis: np.array([turn])}
        known = [sum(f * moved[n][int(c) - 1] for n, c, f in e if n < further) for e in equations]
        return float(np.abs(known - sums @ np.linalg.lstsq(sums, known, rcond=None)[0]).max())

    scale = float(np.abs(held.nodes).max())
    assert left(1e-3 * np.column_stack([-y, x]), 1e-3) < SOLVER * scale
    assert left(np.column_stack([x, -y]), 0.0) < 1e-4 * scale
    for u in ([np.ones_like(x), 0.0 * y], [0.0 * x, np.ones_like(y)], [-y, x]):
        assert left(np.column_stack(u), 0.0) > 0.01


def test_a_deck_of_solids_holds_all_of_the_bore() -> None:
    scene = scene_of(effects={"dimension": 3})
    free = scene.replace({"body_2.bore": "torque"})
    with pytest.raises(SceneError, match=r"body_2\.bore: expected 'held', since the deck turns"):
        check_bodies(free)


# --- the answer -----------------------------------------------------------------------------------
def small_deck() -> Deck:
    """The deck whose output is kept, as far as the reader looks at it."""
    nothing = np.zeros((0, 2))
    ours = (np.array([[20, 3], [31, 1]]), np.array([[40, 2]]))
    part = Part(nothing, np.zeros((0, 6), int), np.zeros(0, int), ours, Material(206e3, 0.3))
    return Deck("kept", (part, part), (-1, 0), 21571.4, 1e-4, False, "strain")


def test_reader_takes_the_last_increment(tmp_path: Path) -> None:
    answer = read_answer(CALCULIX_OUTPUT, small_deck())
    assert answer.rotation_rad == pytest.approx(1e-4 + 9.507927e-04, rel=ROUND_OFF)
    assert answer.force_N_per_mm.tolist() == [282.3087, 355.2771]
    assert answer.moment_N == pytest.approx(9.552614e03 + 1.201701e04, rel=ROUND_OFF)
    assert answer.pressure_MPa.tolist() == [1455.9, 1214.4]
    assert answer.iterations == 4 + 10


def test_with_friction_single_points_do_not_count() -> None:
    deck = replace(small_deck(), friction=DeckFriction((0.1, 0.1), 1e-3))
    pressure = read_answer(CALCULIX_OUTPUT, deck).pressure_MPa
    np.testing.assert_allclose(pressure, [1450.9, 1212.4], rtol=ROUND_OFF, atol=0)


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("AXIS_1", "AXIS_2", "for set AXIS_1' in deck.dat"),
        ("9.507927E-04", "what", "could not convert"),
        ("9.507927E-04", "NaN", "the rotation is not a number"),
        ("contact stress", "contact energy", "no lines 'contact stress"),
    ],
)
def test_output_that_cannot_be_read_is_one_line(
    tmp_path: Path, old: str, new: str, said: str
) -> None:
    shutil.copytree(CALCULIX_OUTPUT, tmp_path / "out")
    path = tmp_path / "out" / "deck.dat"
    path.write_text(path.read_text(encoding="utf-8").replace(old, new), encoding="utf-8")
    with pytest.raises(OtherProgramError, match=re.escape(said)) as caught:
        read_answer(tmp_path / "out", small_deck())
    assert caught.value.folder == tmp_path / "out"


def fake_program(path: Path, body: str) -> str:
    path.write_text(f"#!/bin/sh\n{body}\n", encoding="utf-8")
    path.chmod(0o755)
    return str(path)


@pytest.mark.parametrize(
    ("body", "said"),
    [
        ("echo ' *ERROR: increment size smaller than minimum'; exit 201", "did not converge"),
        ("echo ' *ERROR in e_c3d: bad'; exit 201", "(exit code 201): *ERROR in e_c3d: bad"),
        ("exit 139", "(exit code 139): no message"),
        ("exec sleep 60", "did not end within 0.2 s and was stopped"),
        ("echo Job finished", "cannot be read"),
    ],
)
def test_program_without_an_answer_says_why_and_its_files_stay(
    body: str, said: str, tmp_path: Path
) -> None:
    program = fake_program(tmp_path / "ccx", body)
    limit = 0.2 if "sleep" in body else 30.0
    with pytest.raises(OtherProgramError, match=re.escape(said)) as caught:
        run_deck(program, tmp_path, small_deck(), time_limit_s=limit)
    assert caught.value.folder == tmp_path
    assert str(tmp_path) in str(caught.value)
    assert (tmp_path / "deck.log").exists()


def test_iterations_of_the_other_program_are_counted(tmp_path: Path) -> None:
    """Regression: no progress was printed until the end."""
    rows = "".join(f"     1     1     1  {k:4}  177  0.0E+00  0.1E+03\n" for k in (1, 2, 3))
    heads = "SUMMARY\n  STEP   INC  ATT   ITER     CONT.\n           (#)     (%)\n"
    body = f"cat > {tmp_path}/deck.cvg <<'END'\n{heads}{rows}END\nsleep 0.5; echo Job finished"
    program, counted = fake_program(tmp_path / "ccx", body), []
    calls = {"time_limit_s": 30.0, "on_iteration": counted.append}
    with pytest.raises(OtherProgramError, match="cannot be read"):
        run_deck(program, tmp_path, small_deck(), **calls)
    assert counted == [3]


def test_interrupt_ends_the_other_program(tmp_path: Path) -> None:
    program = fake_program(
        tmp_path / "ccx", f"echo $$ > {tmp_path}/pid; sleep 0.5; kill -INT $PPID; exec sleep 60"
    )
    with pytest.raises(KeyboardInterrupt):
        run_deck(program, tmp_path, small_deck(), time_limit_s=None)
    with pytest.raises(ProcessLookupError):
        os.kill(int((tmp_path / "pid").read_text(encoding="utf-8")), 0)


def test_answer_of_an_earlier_run_is_not_taken_for_this_one(tmp_path: Path) -> None:
    for file in CALCULIX_OUTPUT.iterdir():
        shutil.copy(file, tmp_path)
    program = fake_program(tmp_path / "ccx", "echo Job finished")
    with pytest.raises(OtherProgramError, match="cannot be read"):
        run_deck(program, tmp_path, small_deck(), time_limit_s=30.0)


def test_run_removes_no_file_of_the_user_that_is_called_like_the_deck(tmp_path: Path) -> None:
    mine = tmp_path / "deck.toml"
    mine.write_text("a scene", encoding="utf-8")
    program = fake_program(tmp_path / "ccx", "exit 1")
    with pytest.raises(OtherProgramError):
        run_deck(program, tmp_path, small_deck(), time_limit_s=30.0)
    assert mine.read_text(encoding="utf-8") == "a scene"


@pytest.fixture
def coarse_scene(tmp_path: Path) -> Path:
    text = (SCENES / "external_gear.toml").read_text(encoding="utf-8")
    path = tmp_path / "pair.toml"
    path.write_text(
        text.replace("count = 32", "count = 8")
        + "[accuracy]\nflank_element_mm = 2.25\nestimate = false\n",
        encoding="utf-8",
    )
    return path


def command(capsys: pytest.CaptureFixture[str], *argv: object) -> tuple[int, str, str]:
    code = main(["verify", *map(str, argv), "--elements", "1"])
    out, err = capsys.readouterr()
    assert err.count("\n") <= 1
    return code, out, err


def test_missing_program_names_the_package_and_keeps_the_deck(
    coarse_scene: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    code, _, err = command(
        capsys, coarse_scene, "--program", tmp_path / "no_ccx", "-o", tmp_path / "out"
    )
    assert code == 1
    assert "apt install calculix-ccx" in err
    assert os.listdir(tmp_path / "out") == ["deck.inp"]


def test_without_a_run_the_deck_is_written_and_shown(
    coarse_scene: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    code, out, _ = command(
        capsys, coarse_scene, "--no-run", "--json", "-o", tmp_path, "--position", "3"
    )
    tree = json.loads(out)
    assert (code, tree["calculix"], tree["sites"]) == (0, None, [-1, 0])
    assert tree["deck"]["file"] == str(tmp_path / "deck.inp")
    assert tree["deck"]["nodes"] > 1000


@pytest.mark.parametrize(
    ("more", "line"),
    [
        (["--position", "8"], "position: expected an index from 0 to 7"),
        (["--position", "-1"], "position: expected an index from 0 to 7"),
        (["--time-limit", "0"], "--time-limit: expected seconds > 0, found 0"),
        (["-o", "/dev/null"], "-o: expected a folder, found the file /dev/null"),
    ],
)
def test_bad_options_are_exit_2(
    more: list[str], line: str, coarse_scene: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    code, out, err = command(capsys, coarse_scene, "--no-run", *more)
    assert (code, out) == (2, "")
    assert line in err


def test_number_of_elements_has_limits(
    coarse_scene: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["verify", str(coarse_scene), "--elements", "nan"]) == 2
    assert "--elements: expected a number from 1 to 100, found nan" in capsys.readouterr().err


def test_bodies_without_elements_are_refused() -> None:
    tree = _tables("external_gear")
    tree["body_2"] = {**tree["body_2"], "rigid": True}
    with pytest.raises(SceneError, match=r"body_2\.rigid: expected an elastic body"):
        fl.verify(fl.Scene.from_dict(tree), run=False)
    with pytest.raises(SceneError, match=r"body_1\.kind: expected a body with elements"):
        fl.verify(fl.read_scene(SCENES / "external_gear_compliance.toml"), run=False)
    with pytest.raises(SceneError, match=r"load\.torque_Nm: expected a torque > 0, found 0"):
        fl.verify(scene_of(load={"torque_Nm": 0}), run=False)
    with pytest.raises(SceneError, match=r"body_2\.kind: expected bodies with teeth"):
        fl.verify(fl.read_scene(SCENES / "cam.toml"), run=False)


# --- the other program itself ---------------------------------------------------------------------
@pytest.mark.skipif(shutil.which("ccx") is None, reason="CalculiX is not installed")
def test_coarse_deck_gives_rotation_and_loads() -> None:
    """Regression: hollow gears had no model. Held, this pinion has half the transmission error."""
    gear = {"kind": "gear", "teeth": 12, "module_mm": 4, "profile_shift": 0.3,
            "tip_diameter_mm": 57.5, "bore_diameter_mm": 30}  # fmt: skip
    scene = fl.Scene.from_dict(
        {
            "body_1": {**gear, "bore_diameter_mm": 34, "bore": "torque"},
            "body_2": gear,
            "pair": {"center_distance_mm": 50.3, "face_width_mm": 10},
            "load": {"torque_Nm": 50},
            "positions": {"count": 4},
            "accuracy": {"flank_element_mm": 1.0, "modes": 8, "estimate": False, "tangents": False},
        }
    )
    found = fl.verify(scene, position=2, elements_per_half_width=1)
    other = found.calculix
    assert other.version == version_of("ccx")
    assert found.deck is None
    assert (other.force_N_per_mm > 0).sum() == 2
    assert abs(found.rotation_difference) < COARSE_DECK
    assert np.abs(found.share_difference).max() < COARSE_DECK
    np.testing.assert_allclose(other.moment_N, 50e3 / 10, rtol=1e-3, atol=0)
    assert other.cpu_s > 0
    assert "kept as" not in found.table()
    assert json.loads(found.to_json())["calculix"]["iterations"] > 1


def test_a_deck_has_the_modified_flanks() -> None:
    relief = {"body_1.tip_relief_um": 30.0, "body_1.tip_relief_start_diameter_mm": 80.0}
    scene = fl.read_scene(SCENES / "external_gear.toml").replace(relief)
    bodies = [pair.bodies[0] for pair in (deck_model.coarse_bodies(scene), build_bodies(scene))]
    places = [body.mesh.nodes[body.mesh.flank_edges.ravel()] for body in bodies]
    in_deck, in_run = (bodies[0].curve.arc_length_of(points)[1].max() for points in places)
    assert in_deck < 1e-6
    assert in_run == pytest.approx(0.03, rel=0.1)


def test_a_mesh_without_the_modifications_of_its_profile_has_no_deck() -> None:
    relief = {"tip_relief_um": 60.0, "tip_relief_start_diameter_mm": 79.0}
    scene = fl.read_scene(SCENES / "external_gear_mesh_profile.toml").replace(
        {f"body_1.profile.{key}": value for key, value in relief.items()}
    )
    with pytest.raises(fl.SceneError, match=r"body_1\.profile: expected a profile on which"):
        deck_model.coarse_bodies(scene)
