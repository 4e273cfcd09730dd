"""Webs and hubs in section meshes: circles with element edges, sets in files, refusals."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from math import pi
from pathlib import Path
from typing import Any

import meshio
import numpy as np
import pytest
from skfem import Basis, ElementQuad2, MeshQuad2

import flankload as fl
from flankload.bodies import build_body
from flankload.bodies.body import Body, SectorMesh
from flankload.bodies.imported.body_file import write_body
from flankload.bodies.involute.involute_body import build_involute_body
from flankload.elasticity.compliance import JobOptions, flank_compliance
from flankload.elasticity.prism import Prism
from flankload.errors import FlankloadError
from flankload.mechanisms.flank_pair.assembly import build_bodies
from flankload.scene import MeshBody
from flankload.scene.mesh import Profile
from tests.support.gear_scenes import ABSENT, changed
from tests.support.ring_bodies import gear, ring
from tests.support.tolerances import ROUND_OFF

WEB = {"web_width_mm": 4.0, "web_outer_diameter_mm": 50.0}
HUB = {"hub_diameter_mm": 38.0, "hub_width_mm": 20.0}
EXTENTS = (("web", (-2.0, 2.0)), ("hub", (-10.0, 10.0)))


def _body(regions: tuple[str, ...] = ("web", "hub"), **keys: Any) -> Body:
    spec = gear(**(WEB | HUB | keys))
    return build_involute_body(spec, "body_1", flank_element_mm=2.25, regions=regions)


def _mesh(body: Body) -> SectorMesh:
    assert isinstance(body.mesh, SectorMesh)
    return body.mesh


@pytest.mark.parametrize(
    "keys",
    [{}, {"tip_radius_mm": 0.3}, {"web_outer_diameter_mm": 60.5}, {"hub_diameter_mm": 30.2}],
)
def test_element_edges_lie_on_the_circles_of_web_and_hub(keys: dict[str, float]) -> None:
    body = _body(**keys)
    mesh, sizes = _mesh(body), WEB | HUB | keys
    assert mesh.regions == ("", "web", "hub")
    circles = [sizes["web_outer_diameter_mm"], sizes["hub_diameter_mm"], 30.0]
    for (_, cells), name in zip(mesh.cells, mesh.regions, strict=True):
        basis = Basis(MeshQuad2(mesh.nodes.T, cells.T), ElementQuad2(), intorder=5)
        assert basis.dx.min() > 0
        if name:
            outer, inner = (0.5 * circles[("web", "hub").index(name) + k] for k in (0, 1))
            # parabolas through three places of an arc of 2 degrees
            assert basis.dx.sum() == pytest.approx(pi * (outer**2 - inner**2) / 16, rel=1e-6)
            radii = np.hypot(*mesh.nodes[cells].reshape(-1, 2).T)
            assert radii.min() > inner * (1 - ROUND_OFF)
            assert radii.max() < outer * (1 + ROUND_OFF)
    assert np.isfinite(mesh.nodes).all()
    assert np.unique(np.concatenate([data.ravel() for _, data in mesh.cells])).size == len(
        mesh.nodes
    )


def test_cuts_of_web_and_hub_match_and_end_at_the_bore() -> None:
    mesh = _mesh(_body())
    pitch = 2 * pi / mesh.teeth
    turn = np.array([[np.cos(pitch), np.sin(pitch)], [-np.sin(pitch), np.cos(pitch)]])
    np.testing.assert_allclose(
        mesh.nodes[mesh.left_nodes] @ turn, mesh.nodes[mesh.right_nodes], rtol=0, atol=1e-12
    )
    cuts = np.concatenate([mesh.left_nodes, mesh.right_nodes])
    assert np.unique(cuts).size == cuts.size
    assert not np.isin(mesh.fixed_nodes, cuts).any()
    angle = np.abs(np.arctan2(*mesh.nodes.T[::-1]))
    on_cut = np.flatnonzero(np.abs(angle - 0.5 * pitch) < 1e-12)
    radii = np.hypot(*mesh.nodes.T)
    bore = np.flatnonzero(np.abs(radii - 15.0) < 1e-12)
    assert np.array_equal(np.sort(mesh.fixed_nodes), bore)
    assert np.array_equal(np.sort(cuts), np.setdiff1d(on_cut, bore))


def test_the_web_of_a_ring_continues_its_rim_outwards() -> None:
    spec = ring(web_width_mm=4.0, rim_thickness_mm=6.0)
    mesh = _mesh(build_involute_body(spec, "body_2", flank_element_mm=2.0, regions=("web",)))
    (_, rim), (_, web) = mesh.cells
    assert mesh.regions == ("", "web")
    for cells in (rim, web):
        basis = Basis(MeshQuad2(mesh.nodes.T, cells.T), ElementQuad2(), intorder=5)
        assert basis.dx.min() > 0
    inner = 0.5 * 187.5 + 6.0
    assert basis.dx.sum() == pytest.approx(pi * (110.0**2 - inner**2) / 60, rel=1e-6)
    radii = np.hypot(*mesh.nodes.T)
    assert np.hypot(*mesh.nodes[rim].reshape(-1, 2).T).max() == pytest.approx(inner, rel=1e-14)
    pitch = 2 * pi / mesh.teeth
    turn = np.array([[np.cos(pitch), np.sin(pitch)], [-np.sin(pitch), np.cos(pitch)]])
    np.testing.assert_allclose(
        mesh.nodes[mesh.left_nodes] @ turn, mesh.nodes[mesh.right_nodes], rtol=0, atol=1e-12
    )
    outside = np.flatnonzero(np.abs(radii - 110.0) < 1e-11)
    assert np.array_equal(np.sort(mesh.fixed_nodes), outside)


@pytest.mark.parametrize(
    ("keys", "line"),
    [
        (
            {"web_inner_diameter_mm": 187.0},
            (
                "web_inner_diameter_mm: expected more than the root diameter (187.5000) and less "
                "than body_2.outer_diameter_mm (220), found 187.0"
            ),
        ),
        (
            {"rim_thickness_mm": 17.0},
            (
                "rim_thickness_mm: expected less than 16.2500, since the rim ends within "
                "body_2.outer_diameter_mm (220), found 17.0"
            ),
        ),
    ],
)
def test_a_web_of_a_ring_outside_of_it_gets_one_line(keys: dict[str, float], line: str) -> None:
    with pytest.raises(FlankloadError) as caught:
        build_involute_body(ring(web_width_mm=4.0, **keys), "body_2", flank_element_mm=2.0)
    assert str(caught.value) == f"body_2.{line}"


def test_a_rim_thickness_is_measured_from_the_root_circle() -> None:
    body = _body(web_outer_diameter_mm=None, rim_thickness_mm=5.0)
    assert body.involute is not None
    rim = np.unique(_mesh(body).cells[0][1])
    radii = np.hypot(*_mesh(body).nodes[rim].T)
    assert radii.min() == pytest.approx(body.involute.root_radius_mm - 5.0, rel=1e-14)


SCENE = {f"body_1__{key}": value for key, value in (WEB | HUB).items()}


@pytest.mark.parametrize(
    ("changes", "line"),
    [
        (
            {"body_1__web_outer_diameter_mm": 62.0},
            (
                "web_outer_diameter_mm: expected more than body_1.bore_diameter_mm (30) and less "
                "than the root diameter (60.7500), found 62.0"
            ),
        ),
        (
            {"body_1__web_outer_diameter_mm": 30},
            (
                "web_outer_diameter_mm: expected more than body_1.bore_diameter_mm (30) and less "
                "than the root diameter (60.7500), found 30.0"
            ),
        ),
        (
            {"body_1__hub_diameter_mm": 50},
            (
                "hub_diameter_mm: expected more than body_1.bore_diameter_mm (30) and less than "
                "the outer diameter of the web (50.0000), found 50.0"
            ),
        ),
        (
            {"body_1__hub_diameter_mm": 29},
            (
                "hub_diameter_mm: expected more than body_1.bore_diameter_mm (30) and less than "
                "the outer diameter of the web (50.0000), found 29.0"
            ),
        ),
        (
            {"body_1__web_outer_diameter_mm": ABSENT, "body_1__rim_thickness_mm": 15.4},
            (
                "rim_thickness_mm: expected less than 15.3750, since the rim ends outside "
                "body_1.bore_diameter_mm (30), found 15.4"
            ),
        ),
    ],
)
def test_circles_out_of_order_get_one_line(changes: dict[str, Any], line: str) -> None:
    keys = {key: value for key, value in (SCENE | changes).items() if value is not ABSENT}
    with pytest.raises(FlankloadError) as caught:
        build_bodies(fl.Scene.from_dict(changed(**keys), file="a.toml"))
    assert str(caught.value).startswith(f"a.toml: body_1.{line}")
    assert "\n" not in str(caught.value)


def test_a_rigid_gear_is_checked_as_well() -> None:
    with pytest.raises(FlankloadError, match=r"body_1\.hub_diameter_mm: expected more than"):
        build_bodies(
            fl.Scene.from_dict(
                changed(**(SCENE | {"body_1__rigid": True, "body_1__hub_diameter_mm": 29}))
            )
        )


PROFILE = Profile(module_mm=4.5, profile_shift=0.182, tip_diameter_mm=82.46)


def _from_file(path: Path, **keys: Any) -> Body:
    spec = MeshBody(
        file=path.name,
        teeth=16,
        profile=PROFILE,
        **({"region_sets": ("web", "HUB"), "region_widths_mm": (4.0, 20.0)} | keys),
    )
    return build_body(
        spec,
        "body_1",
        folder=path.parent,
        flank_element_mm=None,
        flank_element_parts=1.0,
        pair_width_mm=14.0,
    )


PRISM = Prism((-7.0, 7.0), 0.0, 6, 0, 3)


@pytest.mark.parametrize("suffix", [".msh", ".inp", ".vtu"])
def test_a_written_mesh_has_the_regions_as_sets(tmp_path: Path, suffix: str) -> None:
    own = _body()
    write_body(tmp_path / f"a{suffix}", _mesh(own))
    body = _from_file(tmp_path / f"a{suffix}")
    mesh = _mesh(body)
    assert mesh.regions == ("", "web", "HUB")
    assert [len(data) for _, data in mesh.cells] == [len(data) for _, data in _mesh(own).cells]
    assert body.axial.regions == (("web", (-2.0, 2.0)), ("HUB", (-10.0, 10.0)))
    found = flank_compliance(
        body, JobOptions(n_modes=1, prism=replace(PRISM, regions=body.axial.regions))
    )
    # middle nodes of .inp are restored
    np.testing.assert_allclose(found.smooth, _of_the_gear(), rtol=1e-6)


@cache
def _of_the_gear() -> np.ndarray:
    """Compliance of the gear with its web and hub, which is that of a plain gear with more."""
    own = _body()
    expected, plain = (
        flank_compliance(own, JobOptions(n_modes=1, prism=replace(PRISM, regions=regions))).smooth
        for regions in (EXTENTS, PRISM.regions)
    )
    assert expected[1, 0, 0] > 1.5 * plain[1, 0, 0]
    return expected


@pytest.mark.parametrize(
    ("keys", "line"),
    [
        (
            {"region_sets": ("web", "nave")},
            (
                "region_sets[1]: expected a set named 'nave' in the mesh, found the sets BODY, "
                "BORE, CUT_LEFT, CUT_RIGHT, FLANK, hub, web"
            ),
        ),
        (
            {"region_sets": ("web", "FLANK")},
            "region_sets[1]: expected a set of elements, found none in 'FLANK'",
        ),
        (
            {"region_sets": ("web", "BODY")},
            (
                "region_sets[1]: expected a region without nodes of the flank, which is as wide "
                "as the teeth, found "
            ),
        ),
    ],
)
def test_sets_that_are_no_region_get_one_line(
    tmp_path: Path, keys: dict[str, Any], line: str
) -> None:
    path = tmp_path / "a.msh"
    write_body(path, _mesh(_body()))
    with pytest.raises(FlankloadError) as caught:
        _from_file(path, **keys)
    assert str(caught.value).startswith(f"{path}: body_1.{line}")
    assert "\n" not in str(caught.value)


def test_regions_that_share_elements_get_one_line(tmp_path: Path) -> None:
    mesh = _mesh(_body())
    path = tmp_path / "a.vtu"
    write_body(path, mesh)
    file = meshio.read(path)
    both = [
        np.maximum(a, b) for a, b in zip(file.cell_data["web"], file.cell_data["hub"], strict=True)
    ]
    file.cell_data["both"] = both
    meshio.write(path, file)
    with pytest.raises(FlankloadError) as caught:
        _from_file(path, region_sets=("web", "both"))
    assert str(caught.value) == (
        f"{path}: body_1.region_sets[1]: expected elements that are not in 'web', found 'both' has "
        "some"
    )
