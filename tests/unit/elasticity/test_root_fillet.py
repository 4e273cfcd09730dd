"""Places of the root stress, the ring closure of the readings, and results of a scene with it."""

from __future__ import annotations

import csv
import io
import json
from pathlib import Path

import numpy as np
import pytest

import flankload as fl
from flankload.bodies import Body
from flankload.bodies.involute.involute_body import build_involute_body
from flankload.bodies.root_fillet import root_fillets
from flankload.elasticity.compliance import JobOptions, flank_compliance
from flankload.elasticity.finite_elements import stiffness
from flankload.elasticity.near_field import mode_loads
from flankload.elasticity.sector_closure import close_ring
from flankload.errors import SceneError
from flankload.mechanisms.flank_pair.assembly import build_bodies
from flankload.meshes.io import read_mesh, write_mesh
from flankload.result import Result
from flankload.result.root_stress import _peak, root_stress
from flankload.scene import Gear, Ring
from tests.support.condensed import condense
from tests.support.mesh_files import COARSE_PINION, whole_of
from tests.support.pair_scenes import RING_PAIR, SPLINE
from tests.support.paths import EXAMPLES
from tests.support.ring_bodies import full_ring
from tests.support.solving import solve
from tests.support.tolerances import CLOSURE, ROUND_OFF, SOLVER

PROFILE = {"module_mm": 4.5, "profile_shift": 0.182, "tip_diameter_mm": 82.46}
GEAR = {"kind": "gear", "teeth": 16, "bore_diameter_mm": 30.0, **PROFILE}
WHEEL = {
    "kind": "gear", "teeth": 24, "module_mm": 4.5, "profile_shift": 0.171,
    "tip_diameter_mm": 118.36, "bore_diameter_mm": 40.0,
}  # fmt: skip
#: The largest slant at the root circle: a fillet leaves it at a right angle to the centre line, but
#: for what the tooth's half of the pitch turns it.
RIGHT_ANGLE = 0.5 * np.pi


def scene_of(
    body_1: dict | None = None, body_2: dict | None = None, *, asked: bool = True, **more: object
) -> fl.Scene:
    return fl.Scene.from_dict(
        {
            "body_1": body_1 or GEAR,
            "body_2": body_2 or WHEEL,
            "pair": {"center_distance_mm": 91.5, "face_width_mm": 14.0},
            "load": {"torque_Nm": 302.0},
            "positions": {"count": 4},
            "accuracy": {"estimate": False, "tangents": False},
            **({"effects": {"root_stress": True}} if asked else {}),
            **more,
        }
    )


def solved(*args: object, **keys: object) -> Result:
    result = solve(scene_of(*args, **keys))  # type: ignore[arg-type]
    assert isinstance(result, Result)
    return result


@pytest.fixture(scope="module")
def with_stress() -> Result:
    return fl.solve(scene_of())  # alone: its cost is that of all of its elements


def gear_body(flank_element_mm: float = 1.5) -> Body:
    keys = {key: value for key, value in GEAR.items() if key != "kind"}
    return build_involute_body(Gear(**keys), "body_1", flank_element_mm=flank_element_mm)


def ring_body() -> Body:
    keys = {key: value for key, value in RING_PAIR["body_2"].items() if key != "kind"}
    return build_involute_body(Ring(**{**keys, "teeth": 60}), "body_2", flank_element_mm=1.5)


# --- places and strains ---------------------------------------------------------------------------
@pytest.mark.parametrize("body", [gear_body(), ring_body()], ids=["gear", "ring"])
def test_places_cover_both_fillets_of_a_tooth(body: Body) -> None:
    points = root_fillets(body, "body_1").points
    assert body.involute is not None
    form = body.curve.range_of("fillet")[1]
    half = points.working.sum()
    assert 2 * half == points.working.size
    for side in (points.working, ~points.working):
        s = points.arc_length_mm[side]
        assert (np.diff(s) > 0).all()
        assert 0 < s[0] < 0.1 * form
        assert 0.9 * form < s[-1] < form
        # radii grow from the root circle, or fall in a ring
        radius = points.radius_mm[side]
        assert (body.outward * np.diff(radius) > 0).all()
        np.testing.assert_allclose(radius, np.hypot(*body.curve.point(s).T), rtol=SOLVER, atol=0)
        slant = points.slant_rad[side]
        assert (np.diff(slant)[: half // 2] < 0).all()
        assert slant[0] <= RIGHT_ANGLE
    # both sides are images of each other
    np.testing.assert_allclose(
        points.arc_length_mm[:half], points.arc_length_mm[half:], rtol=0, atol=1e-7
    )
    np.testing.assert_allclose(points.angle_rad[:half], -points.angle_rad[half:], rtol=0, atol=1e-9)


@pytest.mark.parametrize("body", [gear_body(), ring_body()], ids=["gear", "ring"])
def test_strain_of_motions_that_are_known(body: Body) -> None:
    """None of a rigid motion, the stretch itself of an even one, t·e·t of any linear field."""
    fillets, mesh = root_fillets(body, "body_1"), body.mesh
    assert mesh is not None
    x, y = mesh.nodes.T
    strain = fillets.columns(0, 2 * len(x))
    scale = np.abs(strain).sum(axis=0).max() * np.abs(mesh.nodes).max()

    def read(u: np.ndarray, v: np.ndarray) -> np.ndarray:
        return np.asarray(strain.T @ np.stack([u, v], axis=1).ravel())

    for u, v, expected in ((-y, x, 0.0), (np.ones_like(x), 0 * x, 0.0), (x, y, 1.0)):
        np.testing.assert_allclose(read(u, v), expected, rtol=0, atol=ROUND_OFF * scale)
    half = fillets.points.working.sum()
    t = body.curve.tangent(fillets.points.arc_length_mm[:half])
    # an edge's own quadratic arc departs from the fillet's tangent by little
    np.testing.assert_allclose(read(0 * x, x)[:half], t[:, 0] * t[:, 1], rtol=0, atol=5e-3)


def test_readings_of_the_closed_ring_equal_those_of_the_meshed_ring() -> None:
    body = gear_body(3.0)
    mesh = body.mesh
    assert mesh is not None
    more = root_fillets(body, "body_1").columns(0, 2 * len(mesh.nodes))
    matrix = stiffness(mesh.nodes, mesh.cells, body.material, "strain")
    loads = mode_loads(mesh, body.mode_range_mm, 3)
    sector, _ = condense(matrix, loads, mesh, {"stress_recoveries": more})
    found = close_ring(sector, mesh.teeth)
    expected = full_ring(mesh, body.mode_range_mm, 3, more)
    for rows in (slice(None, 3), slice(3, None)):
        scale = np.abs(expected[:, rows]).max()
        assert np.abs(found[:, rows] - expected[:, rows]).max() <= CLOSURE * scale


def test_asking_for_stress_leaves_the_compliance_as_it_is() -> None:
    body = gear_body()
    plain = flank_compliance(body, JobOptions(n_modes=4, plane="strain"))
    asked = flank_compliance(
        body, JobOptions(n_modes=4, plane="strain", fillets=root_fillets(body, "b"))
    )
    np.testing.assert_array_equal(plain.smooth, asked.smooth)
    assert plain.root is None
    assert asked.root is not None
    assert asked.root.response.shape == (16, asked.root.points.working.size, 4)
    assert asked.job.counters["fe_factorisations"] == plain.job.counters["fe_factorisations"]
    assert asked.job.counters["unit_loads_normal"] == plain.job.counters["unit_loads_normal"]


def test_stress_is_nearly_the_same_in_plane_strain_and_plane_stress() -> None:
    """Under given forces, plane stresses are independent of Poisson's ratio (Michell)."""
    body = gear_body()
    strain, stress = (
        flank_compliance(
            body, JobOptions(n_modes=3, plane=plane, fillets=root_fillets(body, "b"))
        ).root
        for plane in ("strain", "stress")
    )
    assert strain is not None
    assert stress is not None
    # but for the bore, where displacements are given
    scale = np.abs(strain.response).max()
    np.testing.assert_allclose(stress.response, strain.response, rtol=0, atol=0.02 * scale)


def test_readings_of_a_whole_body_are_those_of_its_sector(tmp_path: Path) -> None:
    write_mesh(tmp_path / "whole.msh", *whole_of(read_mesh(COARSE_PINION), 16))
    names = [f"FLANK_{k}" for k in range(16)]
    whole = {
        "kind": "mesh", "file": str(tmp_path / "whole.msh"), "flank_sets": names,
        "profile": PROFILE,
    }  # fmt: skip
    sector = {"kind": "mesh", "file": str(COARSE_PINION), "teeth": 16, "profile": PROFILE}
    one, two = (fl.solve(scene_of(body)) for body in (sector, whole))
    for key in ("tension", "compression"):
        found, expected = (getattr(result.root_stress[0], key).stress_MPa for result in (two, one))
        # files hold rounded places, Gauss points of other teeth are met by interpolation
        np.testing.assert_allclose(found, expected, rtol=0, atol=1e-5 * np.abs(expected).max())
    # loads of a whole body are solved in full: reading them costs no solution
    assert two.cost["stress_recoveries"] < one.cost["stress_recoveries"]


# --- largest values -------------------------------------------------------------------------------
def test_peak_of_a_parabola_is_exact_and_ends_are_taken_as_they_are() -> None:
    s = np.array([0.0, 0.3, 0.9, 1.0, 1.7, 2.0])
    values = np.stack([5.0 - (s - 0.8) ** 2, s, -s])
    peak, place = _peak(s, values)
    np.testing.assert_allclose(peak, [5.0, 2.0, 0.0], rtol=0, atol=10 * ROUND_OFF)
    np.testing.assert_allclose(place, [0.8, 2.0, 0.0], rtol=0, atol=10 * ROUND_OFF)


def test_stress_that_rises_towards_a_contact_is_not_the_largest() -> None:
    s = np.arange(6.0)
    bent = 5.0 - (s - 1.5) ** 2
    beside = np.where(s < 4, bent, [0, 0, 0, 0, 1.0, 9.0])
    peak, place = _peak(s, np.stack([bent, beside]))
    np.testing.assert_allclose(peak, 5.0, rtol=0, atol=10 * ROUND_OFF)
    np.testing.assert_allclose(place, 1.5, rtol=0, atol=10 * ROUND_OFF)


def test_a_fillet_compressed_by_other_teeth_has_its_largest_stress_beside_the_flank() -> None:
    """Regression: it fell to the compression of the root, by half of the largest tension."""
    peak, place = _peak(np.arange(5.0), np.array([-230.0, -235.0, -120.0, 0.0, 40.0]))
    assert (peak, place) == (40.0, 4.0)


def test_summary_names_the_largest_of_all_positions(with_stress: Result) -> None:
    for z in (0, 1):
        stress, found = with_stress.root_stress[z], with_stress.summary[f"root_stress_{z + 1}"]
        assert stress is not None
        for name, extremes, sign in (
            ("tension", stress.tension, 1), ("compression", stress.compression, -1),
        ):  # fmt: skip
            place = found[name]
            p = with_stress.position_rad.tolist().index(place["position_rad"])
            s = with_stress.sites.tolist().index(place["pair"])
            assert sign * place["stress_MPa"] == (sign * extremes.stress_MPa).max()
            assert place["stress_MPa"] == extremes.stress_MPa[p, s]
            at_places = (sign * stress.stress_MPa[p, s]).max()
            # between the places there is a little more, never less
            assert at_places <= sign * place["stress_MPa"] <= 1.01 * at_places
        assert found["tension"]["side"] == "working"
        assert found["compression"]["side"] == "coast"
        assert found["range_MPa"] >= found["tension"]["stress_MPa"]


def test_of_pairs_that_name_the_same_tooth_one_that_carries_is_quoted() -> None:
    """Over 16 pitches pairs 0 and -16 are the same tooth of body 1, and see the same stress."""
    result = solved(
        {**GEAR, "pitch_errors_um": [5.0] + [0.0] * 15},
        positions={"count": 4, "pitches": 16},
    )
    assert {-16, 0} <= set(result.sites.tolist())
    stress = result.root_stress[0]
    assert stress is not None
    column = result.sites.tolist().index(-16)
    same = stress.tension.stress_MPa[:, result.sites.tolist().index(0)]
    np.testing.assert_allclose(stress.tension.stress_MPa[:, column], same, rtol=SOLVER, atol=0)
    for key in ("tension", "compression"):
        place = result.summary["root_stress_1"][key]
        p = result.position_rad.tolist().index(place["position_rad"])
        assert result.site_force_N[p, result.sites.tolist().index(place["pair"])] > 0


def test_stress_is_linear_in_the_torque_where_the_contact_stays_one_pair() -> None:
    results = fl.solve(scene_of(load={"torque_Nm": [0.0, 30.0, 60.0]}, positions={"count": 1}))
    zero, one, two = (stress[0].stress_MPa[0] for stress in results.root_stress)
    assert not zero.any()
    assert two.max() == pytest.approx(2 * one.max(), rel=1e-3)


def test_stress_of_a_spline_without_errors_is_the_same_on_every_tooth() -> None:
    scene = {**SPLINE, "load": {"torque_Nm": 50.0}, "effects": {"root_stress": True}}
    result = fl.solve(
        fl.Scene.from_dict({**scene, "accuracy": {"estimate": False, "tangents": False}})
    )
    assert isinstance(result, Result)
    for stress in result.root_stress:
        assert stress is not None
        tension = stress.tension.stress_MPa[0]
        assert tension.min() > 0
        np.testing.assert_allclose(tension, tension[0], rtol=SOLVER, atol=0)


# --- requested and not requested ------------------------------------------------------------------
def test_a_scene_that_does_not_ask_holds_nothing_of_it() -> None:
    result = fl.solve(scene_of(asked=False))
    assert result.root_stress == (None, None)
    assert result.cost["stress_recoveries"] == 0
    assert not any("root" in key for key in result.summary)
    assert "root_" not in result.to_csv().splitlines()[0]
    assert not any("root" in key for key in json.loads(result.to_json()))
    assert "root of body" not in result.table()


def test_stress_changes_nothing_else(with_stress: Result) -> None:
    plain = fl.solve(scene_of(asked=False))
    np.testing.assert_array_equal(with_stress.rotation_rad, plain.rotation_rad)
    np.testing.assert_array_equal(with_stress.site_force_N, plain.site_force_N)
    for key in ("fe_factorisations", "unit_loads_normal", "pivots"):
        assert with_stress.cost[key] == plain.cost[key]
    places = sum(stress.points.working.size for stress in with_stress.root_stress)
    assert with_stress.cost["stress_recoveries"] == places


def test_stress_is_in_all_files_and_in_the_table(with_stress: Result) -> None:
    tree = json.loads(with_stress.to_json())
    row = next(csv.DictReader(io.StringIO(with_stress.to_csv())))
    for z, stress in enumerate(with_stress.root_stress, start=1):
        for name in ("tension", "compression"):
            extremes = getattr(stress, name)
            key = f"root_{name}_{z}_MPa"
            assert tree[key] == extremes.stress_MPa.tolist()
            assert tree[f"root_{name}_{z}_arc_length_mm"] == extremes.arc_length_mm.tolist()
            site = with_stress.sites[0]
            assert float(row[f"{key}_pair_{site}"]) == extremes.stress_MPa[0, 0]
        found = with_stress.summary[f"root_stress_{z}"]["tension"]
        assert tree["summary"][f"root_stress_{z}"]["tension"] == found
        text = f"tension {found['stress_MPa']:.0f} MPa on pair {found['pair']}"
        assert text in with_stress.table()


def test_loaded_flank_pairs_that_are_not_listed_are_refused(with_stress: Result) -> None:
    reading, loaded = with_stress.root_readings[0], with_stress.site_force_N.any(axis=0)
    assert reading is not None
    missing = with_stress.sites[loaded][0]
    others = np.where(with_stress.sites == missing, 1000, with_stress.sites)
    with pytest.raises(ValueError, match=rf"without \[{missing}\] found"):
        root_stress(reading, with_stress.pair_tables, others, 0)


def test_a_rigid_body_has_no_root_stress() -> None:
    result = solved(GEAR, {**WHEEL, "rigid": True})
    assert result.root_stress[0] is not None
    assert result.root_stress[1] is None
    assert "root_stress_2" not in result.summary
    assert "body_2: rigid, so there is no stress in its roots" in result.warnings


def test_without_any_torque_there_is_nothing_to_ask() -> None:
    result = fl.solve(scene_of(load={"torque_Nm": 0.0}))
    assert result.root_stress == (None, None)
    assert result.cost["fe_factorisations"] == 0


@pytest.mark.parametrize(
    ("body", "found"),
    [
        (
            {"kind": "compliance", "file": str(EXAMPLES / "compliance/fzg_c_pinion.npz")},
            "body_1.kind = 'compliance'",
        ),
        (
            {
                "kind": "mesh", "file": str(COARSE_PINION), "teeth": 16,
                "reference_radius_mm": 33.8289,
            },
            "body_1.kind = 'mesh' without a profile",
        ),
    ],
    ids=["compliance", "mesh"],
)  # fmt: skip
def test_bodies_whose_fillets_are_not_known_are_refused(body: dict, found: str) -> None:
    with pytest.raises(SceneError) as caught:
        build_bodies(scene_of(body))
    assert str(caught.value) == (
        "effects.root_stress: expected bodies with finite elements and a known root fillet "
        f"(gear, ring, splines, mesh with profile), found {found}"
    )


def test_a_mesh_without_all_of_the_fillet_is_refused() -> None:
    from dataclasses import replace

    body = gear_body()
    mesh = body.mesh
    assert mesh is not None
    ((kind, cells),) = mesh.cells
    at = mesh.nodes[cells[:, 8]]
    kept = cells[~((np.hypot(*at.T) < 32.5) & (at[:, 1] > 0))]
    part = replace(body, mesh=replace(mesh, cells=((kind, kept),)))
    with pytest.raises(SceneError, match="holds both root fillets of a tooth in one piece"):
        root_fillets(part, "body_1")
