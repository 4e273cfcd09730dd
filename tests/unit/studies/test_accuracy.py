"""The study of accuracy: limits of ladders, errors, runs that are kept, files, the front."""

import csv
import io
import json
import tomllib
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from msgspec import structs

import flankload as fl
from flankload.cli import main
from flankload.errors import SceneError
from flankload.plot.work_precision import plot_work_precision
from flankload.scene.discretization import choose_discretization
from flankload.scene.named_discretization import NamedDiscretization, scene_at
from flankload.scene.plane_section import plane_section
from flankload.scene.steps import STEPS
from flankload.studies.accuracy import (
    AccuracyStudy,
    accuracy,
    reference,
    refinements,
    runs,
)
from flankload.studies.accuracy.ladder import limit_of
from flankload.studies.accuracy.quantities import (
    common,
    errors_of,
    from_tree,
    quantities_of,
    to_tree,
)
from flankload.studies.accuracy.reference import Reference
from flankload.studies.accuracy.refinements import (
    affordable,
    can_be_nodal,
    can_lump,
    refinements_of,
)
from flankload.studies.accuracy.runs import Run, Runs, fingerprint
from flankload.studies.accuracy.study import Row
from flankload.studies.accuracy.study_text import corner_notes, failure_notes, file_notes
from tests.support.made_up_result import made_up_result
from tests.support.paths import SCENES
from tests.support.small_job import SCENE
from tests.support.tolerances import ROUND_OFF, SOLVER

#: A budget that is never spent, CPU seconds.
ENOUGH = 1e6
#: A step of a ladder is Richardson's to this part of its first change, where the change is that of
#: one power of the step.
POWER = 1e-7
#: The near field of three-dimensional bodies is integrated at other places for other modes.
QUADRATURE = 1e-6
#: Knobs that chains and belts have not.
NOT_OF_DRIVES = {"flank_element_mm", "modes", "strips_per_half_width", "zone_half_widths"}
QUANTITIES = ("transmission_error", "load_share", "peak_pressure", "stiffness")


def example(name: str) -> fl.Scene:
    return fl.read_scene(SCENES / f"{name}.toml")


def small_tree() -> dict:
    """A gear on a rigid wheel, pressed so hard that nodes by the contact's width are few."""
    tree = tomllib.loads(SCENE)
    tree["body_2"]["rigid"] = True
    tree["load"]["torque_Nm"] = 600
    return tree


def small() -> fl.Scene:
    """The same at eight positions."""
    tree = small_tree()
    tree["positions"]["count"] = 8
    del tree["accuracy"]
    return fl.Scene.from_dict(tree)


def spatial(**tables: dict) -> fl.Scene:
    """The same gears in three dimensions, one of them crowned."""
    tree = tomllib.loads(SCENE) | {"effects": {"dimension": 3}}
    tree["body_1"] |= {"lead_crowning_um": 10.0, "bore_diameter_mm": 48}  # few elements
    tree["body_2"]["rigid"] = True
    tree["positions"]["count"] = 2
    del tree["accuracy"]
    for name, keys in tables.items():
        tree[name] = tree.get(name, {}) | keys
    return fl.Scene.from_dict(tree)


@pytest.fixture(scope="module")
def short_ladders() -> Iterator[None]:
    """Short ladders, and nothing measured twice."""
    with pytest.MonkeyPatch.context() as patch:
        short: dict[str, tuple[float, ...]] = {
            "flank_element_mm": (2.0, 1.0, 0.5),
            "modes": (3, 5, 8),
            "strips_per_half_width": (5.0, 10.0, 20.0),
            "zone_half_widths": (2.0, 2.5, 3.0),
            "axial_degree": (5, 6),
            "load_degree_z": (1, 2),
            "slices": (7, 14, 28),
        }
        for name, study in short.items():
            patch.setitem(STEPS, name, replace(STEPS[name], study=study))
        finest = {"flank_element_mm": 0.5, "strips_per_half_width": 20.0, "count": 2.0}
        patch.setattr(refinements, "FINEST", replace(refinements.FINEST, limits=(finest,)))
        patch.setattr(refinements, "SPATIAL_STEPS", 2)
        finest = {"flank_element_mm": 1.5, "axial_degree": 6, "load_degree_z": 2, "count": 2.0}
        few = replace(refinements.SPATIAL_FINEST, limits=(finest,))
        patch.setattr(refinements, "SPATIAL_FINEST", few)
        for room in (refinements, reference):
            patch.setattr(room, "ADAPTIVE", (0.03,), raising=False)
        patch.setattr(runs, "REPEATED_BELOW_S", 0.0)
        yield


@pytest.fixture(scope="module")
def kept(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("study") / "runs.jsonl"


@pytest.fixture(scope="module")
def study(short_ladders: None, kept: Path) -> AccuracyStudy:
    return accuracy(small(), QUANTITIES, ENOUGH, resume=kept)


def test_torques_under_which_other_pairs_carry_are_observed_together() -> None:
    """Regression: results of one scene with different sites ended in a traceback."""
    whole = made_up_result(count=4)
    arrays = ("site_force_N", "peak_pressure_MPa", "corner_contact")
    first_two = {name: getattr(whole, name)[:, :2] for name in arrays}
    few = made_up_result(count=4, sites=whole.sites[:2], **first_two)
    found = quantities_of((few, whole))
    np.testing.assert_array_equal(found["sites"], whole.sites)
    assert found["load_share"].shape == (2, 4, 3)
    np.testing.assert_array_equal(found["load_share"][0, :, :2], few.load_share)
    assert (found["load_share"][0, :, 2] == 0.0).all()
    np.testing.assert_array_equal(found["load_share"][1], whole.load_share)


# --- limits ---------------------------------------------------------------------------------------
@pytest.mark.parametrize("order", [1.3, 2.0, 4.0])
@pytest.mark.parametrize("sizes", [(0.125, 0.25, 0.5), (0.1, 0.25, 0.4)], ids=["even", "uneven"])
def test_limit_of_a_power_is_found(order: float, sizes: tuple[float, ...]) -> None:
    limit = np.array([3.0, -2.0])
    found = limit_of(sizes, [limit + np.array([1.0, 0.5]) * h**order for h in sizes])
    assert found.order == pytest.approx(order, rel=SOLVER, abs=0)
    np.testing.assert_allclose(found.value, limit, rtol=POWER, atol=0)
    assert found.doubt == pytest.approx(sizes[0] ** order, rel=POWER, abs=0)
    assert found.monotone


def test_ladder_that_turns_has_no_limit_but_its_finest_step() -> None:
    found = limit_of((0.25, 0.5, 1.0), [np.array([v]) for v in (2.0, 3.0, 2.5)])
    assert (found.value[0], found.order, found.monotone, found.doubt) == (2.0, None, False, 1.0)


def test_slow_ladder_is_not_extrapolated() -> None:
    """At order 0.7 the limit is 1.6 times the last change away; a larger distance is detected."""
    found = limit_of((0.25, 0.5, 1.0), [np.array([h**0.7]) for h in (0.25, 0.5, 1.0)])
    assert found.slow
    assert found.order is None
    assert found.value[0] == 0.25**0.7


def test_rounding_is_no_change_and_two_steps_no_ladder() -> None:
    found = limit_of((0.25, 0.5, 1.0), [np.array([v]) for v in (1.0, 1.0 + 1e-12, 1.0 - 1e-12)])
    assert found.monotone
    assert found.value[0] == 1.0
    assert not limit_of((0.25, 0.5), [np.ones(1), np.zeros(1)]).monotone


# --- errors ---------------------------------------------------------------------------------------
def curves(position: list[float], sites: list[int], te: list[float], force: list[float]) -> dict:
    """A run of one torque: every site carries its share, pressure is its force."""
    share = np.tile(force, (len(position), 1))[None]
    return {
        "position_rad": np.array(position),
        "sites": np.array(sites, dtype=float),
        "transmission_error": np.array([te]),
        "load_share": share,
        "peak_pressure": 1000.0 * share,
        "transmission_error_mean": np.array([np.mean(te)]),
        "transmission_error_peak_to_peak": np.array([np.ptp(te)]),
        "largest_pressure": np.array([1000.0 * max(force)]),
        "stiffness_secant": np.array([10.0]),
        "stiffness_tangent": np.array([np.nan]),
        "face_load_factor": np.array([1.0]),
        "corner_pressure": np.array([0.0]),
    }


def test_errors_by_hand() -> None:
    fine = curves([0.0, 0.1, 0.2], [-1, 0], [10.0, 12.0, 14.0], [0.5, 0.5])
    coarse = curves([0.2, 0.0], [0, 1], [14.7, 10.2], [0.6, 0.4])
    one, two = common([coarse, fine])
    np.testing.assert_array_equal(one["position_rad"], two["position_rad"])
    np.testing.assert_array_equal(one["sites"], [-1, 0, 1])
    np.testing.assert_array_equal(one["load_share"][0, 0], [0.0, 0.6, 0.4])
    found = errors_of(coarse, fine)
    expected = {
        "transmission_error": 0.7 / 14.0,
        "transmission_error_mean": 0.45 / 12.0,
        "transmission_error_peak_to_peak": 0.5 / 4.0,
        "load_share": 0.5,
        "peak_pressure": 1.0,
        "stiffness": 0.0,
    }
    assert found == pytest.approx(expected, rel=ROUND_OFF, abs=ROUND_OFF)


def test_corners_count_for_no_pressure() -> None:
    fine = curves([0.0], [0], [10.0], [1.0])
    coarse = dict(fine, peak_pressure=np.array([[[np.nan]]]))
    assert errors_of(coarse, fine)["peak_pressure"] == 0.0


def test_runs_read_as_they_are_written() -> None:
    run = curves([0.0, 0.1], [0], [1.0 / 3.0, 2.0], [1.0])
    again = from_tree(json.loads(json.dumps(to_tree(run))))
    assert set(again) == set(run)
    for name in run:
        np.testing.assert_array_equal(again[name], run[name])


def test_finest_elements_are_those_that_the_budget_pays() -> None:
    """Elements of a quarter length have about 15 times the unknowns of the default."""
    base, spent = refinements_of(small()), {"compliance body 1": 1.0, "sweep": 0.0}
    lengths = {
        budget_s: affordable(small(), base, spent, budget_s).finest.flank_element_mm
        for budget_s in (1.0, 50.0, 1e6)
    }
    parts = np.array(list(lengths.values())) / base.base.flank_element_mm
    np.testing.assert_allclose(parts, (0.5, 0.25, 0.125), rtol=0.01, atol=0)


# --- settings -------------------------------------------------------------------------------------
@pytest.mark.parametrize(
    "discretization",
    [
        NamedDiscretization("pairs", 0.5, 6, 12.0, 2.5, 64),
        NamedDiscretization("pairs", 0.25, 8, 100.0, 3.0, 8, 0.001),
        NamedDiscretization("lumped", 1.0, 5, count=32),
        NamedDiscretization("nodes", 0.5, count=32),
        NamedDiscretization("nodes", count=32),
    ],
)
def test_lines_of_a_setting_make_the_scene_of_its_run(discretization: NamedDiscretization) -> None:
    tree = tomllib.loads(SCENE)
    del tree["accuracy"]
    del tree["positions"]
    plain = fl.Scene.from_dict(tree)
    written = fl.Scene.from_dict(tree | tomllib.loads(discretization.lines()))
    assert scene_at(written, NamedDiscretization()) == scene_at(plain, discretization)
    assert (
        NamedDiscretization.from_dict(json.loads(json.dumps(discretization.as_dict())))
        == discretization
    )


@pytest.mark.parametrize(
    ("name", "absent"),
    [
        ("external_gear", set()),
        ("spline", {"count"}),
        ("cam", set()),
        ("external_gear_compliance", {"flank_element_mm"}),
        ("external_gear_mesh", {"flank_element_mm"}),
        ("chain", NOT_OF_DRIVES),
        ("belt", NOT_OF_DRIVES - {"flank_element_mm"}),
        ("helical_gear", {"strips_per_half_width", "zone_half_widths"}),
    ],
)
def test_knobs_are_those_that_a_scene_has(name: str, absent: set[str]) -> None:
    found = refinements_of(example(name))
    everything = {
        "flank_element_mm",
        "modes",
        "strips_per_half_width",
        "zone_half_widths",
        "count",
    }
    if found.spatial:
        everything |= {"axial_degree", "load_degree_z", "slices"}
    assert found.spatial == (name == "helical_gear")
    assert set(found.ladders) == everything - absent
    for parameter, steps in found.ladders.items():
        assert getattr(found.finest, parameter) in steps
        assert getattr(found.base, parameter) in steps


def test_cells_in_slices_are_refined_where_there_are_any() -> None:
    scene = spatial(effects={"dimension": 3, "contact": "pairs"})
    found = refinements_of(scene)
    assert "strips_per_half_width" not in refinements_of(spatial()).ladders
    assert found.base.strips_per_half_width in found.ladders["strips_per_half_width"]
    assert choose_discretization(scene_at(scene, found.base)) == choose_discretization(scene)
    assert can_lump(scene)
    assert not can_lump(spatial())
    coarse = {"flank_element_mm": 3.0, "modes": 3, "axial_degree": 5, "load_degree_z": 1}
    base = replace(found.base, **coarse, slices=7, count=2)
    solved = Runs(scene)
    steps = [solved.at(replace(base, strips_per_half_width=n)) for n in (3.0, 6.0, 24.0)]
    values = [step.values for step in steps if step.values is not None]
    few, more = (errors_of(one, values[2])["transmission_error"] for one in values[:2])
    assert 0 < more < few


def test_lines_of_a_spatial_setting_make_the_scene_of_its_run() -> None:
    steps = {"axial_degree": 10, "load_degree_z": 6, "slices": 20}
    discretization = NamedDiscretization("slices", 1.0, 5, count=32, **steps)
    assert 'contact = "lumped"' not in discretization.lines()
    tree = tomllib.loads(SCENE) | {"effects": {"dimension": 3}}
    del tree["accuracy"]
    del tree["positions"]
    plain = fl.Scene.from_dict(tree)
    written = fl.Scene.from_dict(tree | tomllib.loads(discretization.lines()))
    assert scene_at(written, NamedDiscretization()) == scene_at(plain, discretization)


def test_loads_have_no_degree_that_displacements_do_not_resolve() -> None:
    assert NamedDiscretization(axial_degree=6, load_degree_z=8).load_degree_z == 2
    spatial = refinements_of(example("helical_gear"))
    deep = replace(spatial.base, axial_degree=12, load_degree_z=8)
    twin = reference.twin(spatial, "load_degree_z", deep)
    assert (twin.axial_degree, twin.load_degree_z, twin.slices) == (12, 8, 28)


def test_modes_go_as_far_as_a_file_holds() -> None:
    """The example's compliance files hold five."""
    assert max(refinements_of(example("external_gear_compliance")).ladders["modes"]) == 5


# --- runs -----------------------------------------------------------------------------------------
def test_shared_elements_change_nothing_and_cost_as_if_alone() -> None:
    scene, base = small(), NamedDiscretization("pairs", 2.0, 5, 5.0, 2.5, 8)
    together, alone = Runs(scene), Runs(scene)
    first = together.at(base)
    second = together.at(replace(base, strips_per_half_width=10.0))
    expected = alone.at(replace(base, strips_per_half_width=10.0))
    assert second.values is not None
    assert expected.values is not None
    for name, values in expected.values.items():
        np.testing.assert_array_equal(second.values[name], values)
    assert set(second.stages) == set(first.stages) == set(expected.stages)
    assert second.stages["compliance body 1"] > 0


def test_fewer_modes_from_more_are_those_solved_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    scene, many = small(), NamedDiscretization("pairs", 2.0, 8, 5.0, 2.5, 8)
    monkeypatch.setattr(runs, "SHARED_ABOVE_S", 0.0)
    shared = Runs(scene)
    shared.at(many)
    few = shared.at(replace(many, modes=4)).values
    alone = Runs(scene).at(replace(many, modes=4)).values
    assert few is not None
    assert alone is not None
    error = errors_of(few, alone)
    assert max(error.values()) <= SOLVER


@pytest.mark.parametrize(
    ("keys", "many", "few"),
    [
        (
            {},
            {"modes": 6, "axial_degree": 8, "load_degree_z": 4, "slices": 6},
            {"modes": 4, "load_degree_z": 2},
        ),
        (
            {"body_1": {"tip_radius_mm": 0.3}},
            {"modes": 5, "axial_degree": 4, "load_degree_z": 0, "slices": 2},
            {"modes": 3},
        ),
    ],
    ids=["degrees", "modes beside a rounding"],
)
def test_fewer_modes_in_three_dimensions_are_those_solved_alone(
    keys: dict, many: dict, few: dict, monkeypatch: pytest.MonkeyPatch
) -> None:
    scene = spatial(**keys)
    steps = {"flank_element_mm": 2.0, "count": 4} | many
    monkeypatch.setattr(runs, "SHARED_ABOVE_S", 0.0)
    monkeypatch.setattr(runs, "REPEATED_BELOW_S", 0.0)
    wanted = NamedDiscretization("slices", **steps | few)
    shared = Runs(scene)
    shared.at(NamedDiscretization("slices", **steps))
    one, alone = shared.at(wanted).values, Runs(scene).at(wanted).values
    assert one is not None
    assert alone is not None
    assert max(errors_of(one, alone).values()) <= QUADRATURE


def test_run_without_answer_says_why(study: AccuracyStudy) -> None:
    found = Runs(example("spline")).at(NamedDiscretization("lumped"))
    assert found.values is None
    assert "conform" in (found.failure or "")
    assert "no answer" not in str(study)
    assert found.failure in failure_notes([Row("lumped", found)])[0]


# --- the study ------------------------------------------------------------------------------------
def test_study_holds_all_ladders_levels(study: AccuracyStudy) -> None:
    groups = {row.group for row in study.rows}
    assert {
        "as it stands",
        "default",
        "finest",
        "lumped",
        "nodes",
        *study.knobs.ladders,
    } <= groups
    assert study.stopped is None
    text = str(study)
    assert "mm (others finest)" in text
    assert "lumped Hertz contact" in text
    assert "plain nodal loads" in text
    assert "nodes by the contact's width" in text
    assert "1 %: " in text


def test_nodes_of_the_study_are_named_without_modes_and_strips(study: AccuracyStudy) -> None:
    nodal = [row for row in study.rows if row.run.discretization.level == "nodes"]
    assert [row.run.discretization.tables().get("accuracy") for row in nodal] == [
        {"flank_element_mm": study.knobs.finest.flank_element_mm},
        None,
    ]
    assert all(row.run.failure is None for row in nodal)
    assert nodal[1].errors["transmission_error"] < nodal[0].errors["transmission_error"]


@pytest.mark.parametrize(
    ("name", "can"),
    [
        ("external_gear", True),
        ("spline", True),
        ("cam", False),
        ("belt", False),
        ("spline_press_fit", False),
        ("external_gear_warm", False),
        ("external_gear_mesh", False),
    ],
)
def test_nodes_need_open_meshed_flanks(name: str, can: bool) -> None:
    assert can_be_nodal(example(name)) is can


def test_finer_elements_and_strips_are_better(study: AccuracyStudy) -> None:
    for parameter in ("flank_element_mm", "strips_per_half_width"):
        errors = [row.alone["transmission_error"] for row in study.steps[parameter]]
        assert len(errors) == len(study.knobs.ladders[parameter])
        assert errors == sorted(errors)


def test_errors_are_those_of_a_user_who_writes_the_lines(study: AccuracyStudy) -> None:
    """The scene is written, read and solved independently of the study."""
    row = study.cheapest(0.02)
    assert row is not None
    written = fl.Scene.from_dict(small_tree() | tomllib.loads(row.run.discretization.lines()))
    found = fl.solve(scene_at(written, NamedDiscretization()))
    assert row.run.values is not None
    for name, values in quantities_of(found).items():
        np.testing.assert_array_equal(row.run.values[name], values)
    finest = next(row for row in study.rows if row.group == "finest").run.values
    assert finest is not None
    against_finest = errors_of(row.run.values, finest)
    for name, error in row.errors.items():
        beyond = sum(steps[0].alone[name] for steps in study.steps.values())
        assert (
            abs(error - against_finest[name]) <= beyond * (1.0 + against_finest[name]) + ROUND_OFF
        )


def test_front_descends_and_holds_the_cheapest(study: AccuracyStudy) -> None:
    front = study.front()
    seconds = [row.run.cpu_s for row in front]
    errors = [study.within(row) for row in front]
    assert seconds == sorted(seconds)
    assert errors == sorted(set(errors), reverse=True)
    for row in study.candidates():
        assert any(
            other.run.cpu_s <= row.run.cpu_s and study.within(other) <= study.within(row)
            for other in front
        )
    for tolerance in (0.1, 0.03, 0.02):
        row = study.cheapest(tolerance)
        assert row is not None
        assert row in front
        assert study.within(row) <= tolerance


# --- three dimensions -----------------------------------------------------------------------------
@pytest.fixture(scope="module")
def spatial_study(short_ladders: None) -> AccuracyStudy:
    with pytest.MonkeyPatch.context() as patch:
        for name, steps in {"modes": (3, 5), "flank_element_mm": (3.0, 1.5)}.items():
            patch.setitem(STEPS, name, replace(STEPS[name], study=steps))
        return accuracy(spatial(), (*QUANTITIES, "face_load_factor"), ENOUGH)


def test_study_in_three_dimensions_goes_from_the_plane_to_fine_bodies(
    spatial_study: AccuracyStudy,
) -> None:
    study = spatial_study
    assert study.stopped is None
    rungs = {row.group: row for row in study.rows}
    wanted = {"plane", "coarse", "default", "finest", "as it stands", *study.knobs.ladders}
    assert wanted <= set(rungs)
    assert not {"lumped", "nodes"} & set(rungs)
    assert {"axial_degree", "load_degree_z", "slices", "flank_element_mm"} <= set(study.steps)
    errors = [
        rungs[group].errors["transmission_error_mean"] for group in ("plane", "coarse", "default")
    ]
    assert errors == sorted(errors, reverse=True)
    plane = rungs["plane"]
    (finest,) = (row.run.values for row in study.rows if row.group == "finest")
    assert finest is not None
    assert plane.run.values is not None
    # a plane section carries as much everywhere
    assert plane.run.values["face_load_factor"] == 1.0
    assert rungs["default"].errors["face_load_factor"] < 0.02
    text = str(study)
    for words in ("degree along the axis", "slices of the width", "plane section", "coarse bodies"):
        assert words in text
    assert "K_Hbeta" in text


def test_rungs_of_a_study_are_runs_that_a_user_can_make(spatial_study: AccuracyStudy) -> None:
    (coarse,) = (row for row in spatial_study.rows if row.group == "coarse")
    tree = tomllib.loads(coarse.run.discretization.lines())
    found = fl.solve(spatial(**tree))
    assert isinstance(found, fl.Result)
    assert coarse.run.values is not None
    np.testing.assert_array_equal(
        found.transmission_error_um, coarse.run.values["transmission_error"][0]
    )
    section = plane_section(spatial())
    (plane,) = (row for row in spatial_study.rows if row.group == "plane")
    keys = plane.run.discretization.accuracy_keys
    accuracy_keys = structs.replace(section.accuracy, **keys)
    found = fl.solve(replace(section, accuracy=accuracy_keys))
    assert isinstance(found, fl.Result)
    assert plane.run.values is not None
    np.testing.assert_array_equal(
        found.transmission_error_um, plane.run.values["transmission_error"][0]
    )


def test_study_in_three_dimensions_has_its_files_and_its_picture(
    spatial_study: AccuracyStudy,
) -> None:
    head, *lines = spatial_study.to_csv().splitlines()
    assert {"axial_degree", "load_degree_z", "slices"} <= set(head.split(","))
    assert len(lines) == len(spatial_study.rows)
    figure = plot_work_precision(spatial_study)
    panels = [axes for axes in figure.axes if axes.get_visible()]
    assert len(panels) == len(spatial_study.measures)
    for axes in panels:  # no formulas: names of scenes are words
        assert "$" not in "".join(label.get_text() for label in axes.get_yticklabels())


# --- uncertainty of the limit ---------------------------------------------------------------------
def steps_of(values: list[float]) -> tuple[Reference, refinements.Refinements]:
    """A ladder of elements, the finest first: a transmission error at two positions."""
    sizes = (0.5, 1.0, 2.0)
    ladder = tuple(sizes[::-1][-len(values) :])
    base, finest = (
        NamedDiscretization(flank_element_mm=ladder[0], modes=5),
        NamedDiscretization(flank_element_mm=sizes[0], modes=5),
    )
    done = {}
    for size, value in zip(sizes, values, strict=False):
        discretization = NamedDiscretization(flank_element_mm=size, modes=5)
        found = curves([0.0, 1.0], [0], [value, 0.5 * value], [1.0])
        done[discretization] = Run(discretization, 1.0 / size, 0, found)
    found = refinements.Refinements({"flank_element_mm": ladder}, base, finest, can_adapt=False)
    return Reference(done, found), found


@pytest.mark.parametrize(
    ("values", "doubt"),
    [
        ([100.0, 101.0, 105.0], 0.5 / 3 / (100 - 1 / 3)),  # order 2: half of what it adds
        ([100.0, 101.0, 100.0], 1.0 / 100),  # it turns: the last change
        ([100.0, 101.0, 102.6], 1 / 0.6 / 100),  # it converges slowly: what its order would add
        ([100.0, 101.0, 102.45], 2.0 / 100),  # the same, but never more than two changes
        ([100.0, 101.0], 1.0 / 100),  # two steps: their change
    ],
    ids=["extrapolated", "turns", "slow", "slower", "two steps"],
)
def test_uncertainty_of_the_limit_is_the_rest_of_its_ladder(
    values: list[float], doubt: float
) -> None:
    found, _ = steps_of(values)
    for name in ("transmission_error", "transmission_error_mean"):
        assert found.doubts[name] == pytest.approx(doubt, rel=1e-6)
    assert found.doubts["load_share"] == 0.0


def test_a_ladder_without_runs_leaves_the_error_of_the_default() -> None:
    found, ladders = steps_of([100.0, 101.0, 105.0])
    more = replace(ladders, ladders={**ladders.ladders, "modes": (3, 5)})
    (base,) = (run for discretization, run in found._done.items() if discretization == ladders.base)
    both = Reference(found._done, more).doubts["transmission_error_mean"]
    error = found.errors(base)["transmission_error_mean"]
    assert both == pytest.approx(np.hypot(error, found.doubts["transmission_error_mean"]), rel=1e-9)
    fixed = replace(ladders, ladders={**ladders.ladders, "modes": (5,)})
    assert Reference(found._done, fixed).doubts == found.doubts


def test_the_reference_run_is_not_named_cheapest() -> None:
    """Regression: the finest run was the cheapest for 0.01 % on a slowly converging belt."""
    found, ladders = steps_of([100.0, 101.0, 102.5])
    rows = tuple(Row("flank_element_mm", run, found.errors(run)) for run in found._done.values())
    study = AccuracyStudy(
        name="a belt",
        tolerance=0.01,
        measures=("transmission_error", "transmission_error_mean"),
        rows=rows,
        steps={},
        limits=found.limits,
        knobs=ladders,
        doubts=found.doubts,
    )
    finest = next(row for row in rows if row.run.discretization == ladders.finest)
    assert finest.largest(study.measures) == 0.0
    assert study.cheapest(1e-2) is None
    assert study.cheapest(0.03) is not finest
    text = str(study)
    assert "0.01 %: not reached (?): the uncertainty of the limit is 2 % (TE)" in text
    (line,) = (line for line in text.splitlines() if line.startswith("  1 %  "))
    assert line.split()[2:] == ["?", "?", "?", "0.500", "0.500", "0.500", "?"]
    assert json.loads(study.to_json())["doubts_of_the_limit"]["transmission_error"] == 0.02


def test_doubts_of_a_study_are_those_of_its_ladders(study: AccuracyStudy) -> None:
    """Every run is nearer to the limit of a study than the default, with the doubt added."""
    assert set(study.doubts) == set(study.rows[0].errors)
    (base,) = (row for row in study.rows if row.group == "default")
    for name, doubt in study.doubts.items():
        assert 0 <= doubt < base.errors[name] + ROUND_OFF
    assert "uncertainty of the limit" in str(study)


def test_csv_and_json_hold_every_run(study: AccuracyStudy, tmp_path: Path) -> None:
    study.to_csv(tmp_path / "a.csv")
    lines = list(csv.DictReader(io.StringIO((tmp_path / "a.csv").read_text(encoding="utf-8"))))
    assert len(lines) == len(study.rows)
    for line, row in zip(lines, study.rows, strict=True):
        assert line["group"] == row.group
        for name, error in row.errors.items():
            assert float(line[f"error_{name}"]) == pytest.approx(error, rel=1e-3, abs=0)
    tree = json.loads(study.to_json())
    assert len(tree["runs"]) == len(study.rows)
    row = study.cheapest(0.01)
    wanted = row and {"cpu_s": row.run.cpu_s, "keys": row.run.discretization.tables()}
    assert tree["cheapest"]["0.01"] == wanted


def test_picture_shows_the_front(study: AccuracyStudy) -> None:
    figure = plot_work_precision(study)
    panels = [axes for axes in figure.axes if axes.get_visible()]
    assert len(panels) == len(study.measures)
    for axes, name in zip(panels, study.measures, strict=True):
        front = [(row.run.cpu_s, row.errors[name]) for row in study.front(name)]
        shown = [(x, y) for x, y in front if y > 1e-7]
        drawn = [line.get_xydata().tolist() for line in axes.lines]
        assert [list(point) for point in shown] in drawn
        (shade,) = axes.patches
        # a rectangle or, before matplotlib 3.9, a polygon
        top = shade.get_transform().transform(shade.get_path().vertices)[:, 1].max()
        drawn_limit = axes.transData.inverted().transform((0.0, top))[1]
        assert drawn_limit == pytest.approx(study.doubts[name], abs=1e-6)


def test_sharp_corner_is_named_with_its_pressure() -> None:
    few, many = (curves([0.0], [0], [10.0], [1.0]) for _ in range(2))
    few["corner_pressure"], many["corner_pressure"] = np.array([5e3]), np.array([2e4])
    rows = [
        Row(
            "strips_per_half_width",
            Run(NamedDiscretization(strips_per_half_width=n), 1.0, 0, values),
        )
        for n, values in ((5.0, few), (20.0, many))
    ]
    (note,) = corner_notes(rows)
    assert "5000 MPa with 5 strips and 20000 MPa with 20" in note
    assert "tip_radius_mm" in note
    assert corner_notes([]) == ()


def test_data_from_files_are_named() -> None:
    (first, second) = file_notes(example("external_gear_mesh"))
    assert first == "body_1: its elements come from a file, whose own error is not included"
    assert second.startswith("body_2: its elements")
    assert file_notes(small()) == ()


# --- resuming, stopping ---------------------------------------------------------------------------
def test_resumed_study_solves_nothing_again(
    study: AccuracyStudy, kept: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(runs, "run_once", _never)
    again = accuracy(small(), QUANTITIES, ENOUGH, resume=kept)
    assert str(again) == str(study)
    assert again.to_csv() == study.to_csv()


def _never(*_: object) -> None:
    raise AssertionError("solved again")


def test_file_of_another_scene_is_refused(kept: Path, study: AccuracyStudy) -> None:
    other = fl.Scene.from_dict(tomllib.loads(SCENE))
    assert fingerprint(other) != fingerprint(small())
    with pytest.raises(SceneError, match=r"--resume: expected .* this very scene"):
        accuracy(other, budget_s=ENOUGH, resume=kept)


@pytest.mark.parametrize("text", ["no JSON\n", '{"scene": 1}\n', "[]\n{}\n"])
def test_other_file_is_refused(text: str, tmp_path: Path) -> None:
    path = tmp_path / "runs.jsonl"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(SceneError, match="--resume"):
        accuracy(small(), budget_s=ENOUGH, resume=path)
    assert path.read_text(encoding="utf-8") == text


def test_a_run_that_has_changed_in_its_file_is_refused(kept: Path, tmp_path: Path) -> None:
    """Regression: a changed digit became a result of the study."""
    path, text = tmp_path / "runs.jsonl", kept.read_text(encoding="utf-8")
    at = text.rindex('"cpu_s":') + len('"cpu_s":')
    path.write_text(f"{text[:at]}9{text[at:]}", encoding="utf-8")
    with pytest.raises(SceneError, match=r"--resume: expected .*, which is another one or damaged"):
        accuracy(small(), budget_s=ENOUGH, resume=path)


def stop_at(number: int) -> Callable[[str, int, int], None]:
    """Ctrl-C when this number of groups has been reported."""
    told: list[str] = []

    def tell(group: str, done: int, total: int) -> None:
        assert 0 <= done <= total
        if group not in told:
            told.append(group)
        if len(told) > number:
            raise KeyboardInterrupt

    return tell


def test_interrupted_study_keeps_finished_runs(short_ladders: None, tmp_path: Path) -> None:
    path = tmp_path / "runs.jsonl"
    stopped = accuracy(small(), budget_s=ENOUGH, progress=stop_at(4), resume=path)
    assert stopped.interrupted
    assert {"default", "as it stands", "finest"} <= {row.group for row in stopped.rows}
    assert "interrupted" in str(stopped)
    assert len(path.read_text(encoding="utf-8").splitlines()) == 1 + len(stopped.rows)
    with pytest.raises(KeyboardInterrupt):
        accuracy(small(), budget_s=ENOUGH, progress=stop_at(0))


def test_spent_budget_leaves_runs_out(
    short_ladders: None, kept: Path, study: AccuracyStudy
) -> None:
    """Runs in the file cost nothing; without it the first run is the last."""
    found = accuracy(small(), budget_s=1e-9)
    assert [row.group for row in found.rows] == []
    assert "budget" in str(found)
    assert not found.has_errors
    assert found.cheapest(0.01) is None


@pytest.mark.parametrize(
    ("quantities", "budget", "line"),
    [
        ((), 1.0, "quantities: expected some of transmission_error, .*, found none"),
        (("noise",), 1.0, "quantities: expected some of .*, found 'noise'"),
        (("stiffness",), 0.0, "budget: expected CPU seconds > 0, found 0"),
        (("stiffness",), float("nan"), "budget: expected CPU seconds > 0, found nan"),
    ],
)
def test_wrong_arguments_get_one_line(
    quantities: tuple[str, ...], budget: float, line: str
) -> None:
    with pytest.raises(SceneError, match=line):
        accuracy(small(), quantities, budget)


def test_scene_without_torque_is_refused() -> None:
    tree = tomllib.loads(SCENE)
    tree["load"]["torque_Nm"] = [0, 100]
    with pytest.raises(SceneError, match=r"load\.torque_Nm: expected torques > 0"):
        accuracy(fl.Scene.from_dict(tree))


# --- the command ----------------------------------------------------------------------------------
def test_command_writes_files_and_says_what_is_wrong(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], short_ladders: None
) -> None:
    path = tmp_path / "pair.toml"
    path.write_text(SCENE, encoding="utf-8")
    command = ["accuracy", str(path)]
    files = ["--csv", str(tmp_path / "a.csv"), "--json", str(tmp_path / "a.json")]
    assert main([*command, "--budget", "1e-9", *files, "--plot", str(tmp_path / "out")]) == 0
    assert "small job: cost of accuracy" in capsys.readouterr().out
    assert (tmp_path / "out" / "work_precision.png").read_bytes()[:4] == b"\x89PNG"
    assert (tmp_path / "a.csv").read_text(encoding="utf-8").startswith("group,level,")
    for arguments, said in (
        (["--budget", "-1"], "--budget: expected CPU seconds > 0, found -1"),
        (["--quantities", "noise"], "quantities: expected some of"),
        (["--csv", "-", "--json", "-"], "--json: expected a file"),
        (["--csv", str(tmp_path / "none" / "a.csv")], "--csv: expected a file in a folder"),
        (["--resume", str(tmp_path)], "--resume: expected a file"),
    ):
        assert main([*command, *arguments]) == 2
        assert said in capsys.readouterr().err


def test_interrupted_command_prints_its_table(
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
    short_ladders: None,
) -> None:
    path = tmp_path / "pair.toml"
    path.write_text(SCENE, encoding="utf-8")
    tell = stop_at(2)
    monkeypatch.setattr("flankload.cli.judging.Progress.tell", lambda _, *told: tell(*told))
    assert main(["accuracy", str(path)]) == 130
    out, err = capsys.readouterr()
    assert "note: interrupted" in out
    assert err == "flankload: interrupted\n"
