"""Elastic part of a body: a segment with held ends, a single tooth, teeth without coupling."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.sparse.linalg import splu

import flankload as fl
from flankload.bodies.body import SectorMesh
from flankload.elasticity.compliance import JobOptions, flank_compliance
from flankload.elasticity.finite_elements import degrees_of, stiffness
from flankload.elasticity.near_field import mode_loads
from flankload.elasticity.sector_closure import close_ring
from flankload.elasticity.sector_row import open_row, segment_response
from flankload.mechanisms.elements import compliance_of
from flankload.mechanisms.flank_pair.assembly import build_bodies
from tests.support.condensed import condense
from tests.support.gear_pair import GEARS
from tests.support.gear_scenes import SCENE, changed, example
from tests.support.paths import SCENES
from tests.support.plane_sectors import STEEL, ring_sector
from tests.support.plane_stiffness import plane_stiffness
from tests.support.ring_bodies import gear_body
from tests.support.tolerances import CLOSURE, ROUND_OFF, SOLVER

#: Sizes measured before with another program: held ends change the rotation by so many percent.
SEGMENTS = {3: -25.0, 5: -18.0, 7: -12.0}
#: Sizes are reproduced to a third.
SIZE_MODEL = 1.0 / 3.0


def meshed_segment(
    mesh: SectorMesh, span: tuple[float, float], n_modes: int, cells: int
) -> np.ndarray:
    """Response (n, n, p, p) of a segment that is meshed as a whole, its two end faces held."""
    count, own = len(mesh.nodes), mode_loads(mesh, span, n_modes)
    turns = []
    for k in range(cells):
        angle = 2 * np.pi * k / mesh.teeth
        turns.append(np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]]))
    every = np.vstack([mesh.nodes @ turn for turn in turns])
    _, number = np.unique(np.round(every, 7), axis=0, return_inverse=True)
    number = number.ravel()
    nodes = np.zeros((number.max() + 1, 2))
    nodes[number] = every
    ((kind, data),) = mesh.cells
    elements = number[np.vstack([data + k * count for k in range(cells)])]
    matrix = plane_stiffness(nodes, ((kind, elements),), STEEL, "strain")
    loads = []
    for k, turn in enumerate(turns):
        column = np.zeros((2 * len(nodes), n_modes))
        turned = np.einsum("ncq,cd->ndq", own.reshape(count, 2, -1), turn)
        rows = degrees_of(number[k * count : (k + 1) * count])
        np.add.at(column, rows, turned.reshape(2 * count, -1))
        loads.append(column)
    held = [number[mesh.fixed_nodes + k * count] for k in range(cells)]
    ends = [number[mesh.left_nodes], number[mesh.right_nodes + (cells - 1) * count]]
    fixed = degrees_of(np.unique(np.concatenate([*held, *ends])))
    free = np.setdiff1d(np.arange(2 * len(nodes)), fixed)
    moved = np.zeros((cells, 2 * len(nodes), n_modes))
    factor = splu(matrix[free][:, free].tocsc())
    for k in range(cells):
        moved[k, free] = factor.solve(loads[k][free])
    return np.array([[column.T @ part for part in moved] for column in loads])


@pytest.mark.parametrize("cells", [1, 2, 3, 5])
def test_open_row_equals_the_meshed_segment(cells: int) -> None:
    mesh, span = ring_sector(7)
    matrix = stiffness(mesh.nodes, mesh.cells, STEEL, "strain")
    sector, _ = condense(matrix, mode_loads(mesh, span, 3), mesh)
    found = open_row(sector, cells, 2 * np.pi / 7)
    expected = meshed_segment(mesh, span, 3, cells)
    assert np.abs(found - expected).max() <= CLOSURE * np.abs(expected).max()


def test_open_row_of_real_teeth_equals_the_meshed_segment() -> None:
    body = gear_body(9, 2.5, profile_shift=0.5)
    matrix = stiffness(body.mesh.nodes, body.mesh.cells, STEEL, "strain")
    sector, _ = condense(matrix, mode_loads(body.mesh, body.mode_range_mm, 3), body.mesh)
    found = open_row(sector, 3, 2 * np.pi / 9)
    expected = meshed_segment(body.mesh, body.mode_range_mm, 3, 3)
    assert np.abs(found - expected).max() <= CLOSURE * np.abs(expected).max()


@pytest.mark.parametrize(("teeth", "cells"), [(11, 3), (11, 5), (6, 5), (5, 5), (4, 3)])
def test_segment_takes_the_places_nearest_to_its_middle(teeth: int, cells: int) -> None:
    mesh, span = ring_sector(teeth)
    matrix = stiffness(mesh.nodes, mesh.cells, STEEL, "strain")
    sector, _ = condense(matrix, mode_loads(mesh, span, 3), mesh)
    row = open_row(sector, cells, 2 * np.pi / teeth)
    found = segment_response(sector, teeth, cells)
    scale = ROUND_OFF * np.abs(found).max()
    m = cells // 2
    np.testing.assert_allclose(found[0], row[m, m], rtol=0, atol=scale)
    neighbour = 0.5 * (row[m + 1, m] + row[m, m - 1])
    np.testing.assert_allclose(found[1], neighbour, rtol=0, atol=scale)
    if teeth > 4:
        np.testing.assert_allclose(found[2], row[m + 1, m - 1], rtol=0, atol=scale)
    for apart in range(cells, teeth - cells + 1):
        assert not found[apart].any()
    mirrored = found[-np.arange(teeth) % teeth].transpose(0, 2, 1)
    np.testing.assert_allclose(found, mirrored, rtol=0, atol=scale)


def test_single_tooth_is_a_row_of_one() -> None:
    mesh, span = ring_sector(7)
    matrix = stiffness(mesh.nodes, mesh.cells, STEEL, "strain")
    loads = mode_loads(mesh, span, 3)
    tooth, _ = condense(matrix, loads, mesh, held=True)
    expected = open_row(condense(matrix, loads, mesh)[0], 1, 2 * np.pi / 7)[0, 0]
    np.testing.assert_allclose(
        tooth.local[0], expected, rtol=0, atol=SOLVER * np.abs(expected).max()
    )
    assert not tooth.stiffness.size


def test_bodies_stay_elastic_however_small_their_elastic_part() -> None:
    """Fixed nodes only stiffen a tooth; a moving segment remains positive definite."""
    body = gear_body(17, 2.0)
    matrix = stiffness(body.mesh.nodes, body.mesh.cells, STEEL, "strain")
    loads = mode_loads(body.mesh, body.mode_range_mm, 4)
    sector, _ = condense(matrix, loads, body.mesh)
    softer = np.linalg.eigvalsh(close_ring(sector, 17)[0])
    for cells in (15, 9, 5, 3, 1):
        response = segment_response(sector, 17, cells)
        own = np.linalg.eigvalsh(response[0])
        assert (own < softer).all()
        softer = own
        waves = np.fft.fft(response, axis=0)
        least = np.linalg.eigvalsh(0.5 * (waves + waves.conj().transpose(0, 2, 1))).min()
        assert least > 0.0


@cache
def solved(*effects: tuple[str, Any], body: str = "") -> fl.Result:
    tables: dict[str, Any] = {
        "effects": dict(effects),
        "accuracy": {"estimate": False, "tangents": False},
    }
    scene = example(body) if body else {**GEARS, "positions": {"count": 16}}
    return fl.solve(fl.Scene.from_dict({**scene, **tables}))


@pytest.mark.parametrize("teeth", sorted(SEGMENTS))
def test_segments_are_stiffer_by_as_much_as_was_measured(teeth: int) -> None:
    whole = solved()
    found = solved(("body", "segment"), ("segment_teeth", teeth))
    change = 100 * (found.rotation_rad.mean() / whole.rotation_rad.mean() - 1)
    assert change == pytest.approx(SEGMENTS[teeth], rel=SIZE_MODEL)
    # the parts of the teeth hardly depend on how much of the body is elastic
    assert 100 * np.abs(found.load_share - whole.load_share).mean() < 0.06
    assert np.ptp(found.rotation_rad) == pytest.approx(np.ptp(whole.rotation_rad), rel=0.05)


def test_teeth_without_coupling_wind_up_less_and_wave_more() -> None:
    whole, found = solved(), solved(("tooth_coupling", False))
    change = found.rotation_rad.mean() / whole.rotation_rad.mean() - 1
    assert 100 * change == pytest.approx(-8.0, rel=SIZE_MODEL)
    wave = np.ptp(found.rotation_rad) / np.ptp(whole.rotation_rad) - 1
    assert 100 * wave == pytest.approx(39.0, rel=SIZE_MODEL)
    # where one pair carries alone there is nothing to couple with
    alone = (whole.site_force_N > 0).sum(axis=1) == 1
    assert alone.any()
    np.testing.assert_allclose(found.rotation_rad[alone], whole.rotation_rad[alone], rtol=SOLVER)


def test_single_teeth_are_the_stiffest() -> None:
    three = solved(("body", "segment"), ("segment_teeth", 3))
    found = solved(("body", "tooth"))
    assert (found.rotation_rad < three.rotation_rad).all()
    assert found.cost["fe_factorisations"] == 2
    assert found.cost["unit_loads_normal"] == 10


def test_curves_close_whichever_part_is_elastic() -> None:
    """The segment moves with the mesh: after one pitch the state is the same."""
    pitch = 360.0 / 16
    for effects in ({"body": "segment", "segment_teeth": 3}, {"tooth_coupling": False}):
        scene = fl.Scene.from_dict(
            {
                **GEARS,
                "positions": {"angles_deg": [0.0, pitch, 0.4 * pitch, 1.4 * pitch]},
                "accuracy": {"estimate": False, "tangents": False},
                "effects": effects,
            }
        )
        turned = fl.solve(scene).rotation_rad
        np.testing.assert_allclose(turned[::2], turned[1::2], rtol=SOLVER)


def test_splines_carry_on_their_segments() -> None:
    whole, found = solved(body="spline"), solved(("body", "tooth"), body="spline")
    assert found.site_force_N.min() >= 0.0
    assert found.rotation_rad[0] < whole.rotation_rad[0]


def test_stress_and_friction_go_with_a_segment() -> None:
    body = gear_body(16, 2.0)
    whole = flank_compliance(body, JobOptions(n_modes=4, plane="strain", friction=True))
    three = flank_compliance(body, JobOptions(n_modes=4, plane="strain", friction=True), sectors=3)
    assert three.tangential.shape == whole.tangential.shape
    assert not three.tangential[3:14].any()
    assert three.job.asymmetry < SOLVER
    alone = whole.without_coupling()
    np.testing.assert_array_equal(alone.smooth[0], whole.smooth[0])
    np.testing.assert_array_equal(alone.tangential[0], whole.tangential[0])
    assert not alone.smooth[1:].any()
    assert not alone.tangential[1:].any()
    found = solved(("body", "segment"), ("segment_teeth", 3), ("root_stress", True))
    whole_stress = solved(("root_stress", True))
    for one, other in zip(found.root_stress, whole_stress.root_stress, strict=True):
        assert one is not None
        assert other is not None
    assert found.cost["stress_recoveries"] == whole_stress.cost["stress_recoveries"]


@pytest.mark.parametrize("part", [{"body": "segment", "segment_teeth": 3}, {"body": "tooth"}])
def test_segments_in_three_dimensions_are_as_stiff_as_those_of_the_section(
    part: dict[str, Any],
) -> None:
    """Rotation of a spur pair beside that of whole bodies; the held ends carry at all z."""
    accuracy = {"flank_element_mm": 3.0, "modes": 3, "estimate": False, "tangents": False}
    changes = []
    for dimension in (2, 3):
        tables = changed(accuracy=accuracy, positions={"angles_deg": [0.0]})
        whole, held = (
            fl.solve(fl.Scene.from_dict(tables | {"effects": {"dimension": dimension} | extent}))
            for extent in ({}, part)
        )
        changes.append(held.rotation_rad[0] / whole.rotation_rad[0] - 1.0)
    assert changes[1] < -0.1
    assert changes[1] == pytest.approx(changes[0], rel=0.05)


def test_a_file_is_uncoupled_as_elements_are(tmp_path: Path) -> None:
    """A compliance file without coupling, compared with the elements from which it was written."""
    from flankload.cli import main

    scene = SCENES / "external_gear.toml"
    assert main(["compliance", str(scene), "-o", str(tmp_path)]) == 0
    asked = example("external_gear")
    asked["effects"] = {"tooth_coupling": False}
    expected = fl.Scene.from_dict(asked)
    for key in ("body_1", "body_2"):
        asked[key] = {"kind": "compliance", "file": str(next(tmp_path.glob(f"{key}*.npz")))}
    from_file = fl.Scene.from_dict(asked)
    pair, other = build_bodies(from_file), build_bodies(expected)
    one, two = compliance_of(pair.body_1, from_file), compliance_of(other.body_1, expected)
    np.testing.assert_array_equal(one.smooth, two.smooth)
    assert not one.smooth[1:].any()


@pytest.mark.parametrize(
    ("changes", "line"),
    [
        (
            {"effects__body": "segment"},
            (
                r"effects\.segment_teeth: expected an odd number from 3, since effects\.body is "
                r"'segment': .*, found nothing"
            ),
        ),
        (
            {"effects__body": "segment", "effects__segment_teeth": 4},
            r"effects\.segment_teeth: expected an odd number .*, found 4",
        ),
        (
            {"effects__segment_teeth": 3},
            r"effects\.segment_teeth: expected nothing, unless effects\.body is 'segment', found 3",
        ),
        (
            {"effects__body": "segment", "effects__segment_teeth": 17},
            (
                r"effects\.segment_teeth: expected at most 16, .* body_1 has \(body_1\.teeth\), "
                "found 17"
            ),
        ),
        (
            {"effects__body": "tooth", "effects__tooth_coupling": True},
            r"effects\.tooth_coupling: expected false or nothing, since effects\.body is 'tooth'",
        ),
        (
            {"effects__body": "tooth", "body_2": {"kind": "compliance", "file": "b.npz"}},
            (
                r"effects\.body: expected 'whole', since body_2\.kind is 'compliance': .*, found "
                "'tooth'"
            ),
        ),
        (
            {
                "effects__body": "tooth",
                "body_2": {
                    "kind": "mesh",
                    "file": "b.msh",
                    "flank_sets": ["A", "B", "C"],
                    "reference_radius_mm": 40,
                },
            },
            (
                r"effects\.body: expected 'whole', since body_2\.flank_sets names the flanks of a "
                r"whole body, .*, found 'tooth'"
            ),
        ),
    ],
)
def test_refusals(changes: dict[str, Any], line: str) -> None:
    with pytest.raises(fl.errors.SceneError, match=line):
        fl.Scene.from_dict(changed(**changes))


@pytest.mark.parametrize(
    ("effects", "line"),
    [
        ({"body": "tooth"}, r"effects\.body: .* body_1\.kind is 'follower', which has one flank"),
        ({"tooth_coupling": False}, r"effects\.tooth_coupling: .*body_2\.kind is 'cam'"),
    ],
)
def test_cams_have_one_flank(effects: dict[str, Any], line: str) -> None:
    with pytest.raises(fl.errors.SceneError, match=line):
        fl.Scene.from_dict({**example("cam"), "effects": effects})


def test_rigid_bodies_do_not_ask() -> None:
    rigid = {"kind": "compliance", "file": "b.npz", "rigid": True}
    scene = fl.Scene.from_dict(changed(effects__body="tooth", body_2=rigid))
    assert scene.sectors == 1
    assert fl.Scene.from_dict(SCENE).sectors is None
