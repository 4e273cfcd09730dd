"""Sector meshes of gears: valid elements, exact boundaries, matching cuts."""

from __future__ import annotations

from math import pi

import numpy as np
import pytest
from skfem import Basis, ElementQuad2, MeshQuad2

from flankload.bodies import build_body
from flankload.bodies.body import Body, SectorMesh
from flankload.bodies.involute.involute_body import build_involute_body
from flankload.bodies.profile.gear_profile import gear_profile
from flankload.elasticity.compliance import JobOptions, flank_compliance, loads
from flankload.errors import SceneError
from flankload.meshes.blocks import growing_breaks, symmetric_breaks
from flankload.meshes.plane_mesh import scaled_jacobians
from flankload.meshes.report import quality_rows, verdict
from flankload.scene import Ring
from tests.support.ring_bodies import gear
from tests.support.tolerances import ROUND_OFF, SOLVER


def built(element_mm: float = 1.0, **keys) -> Body:
    return build_involute_body(gear(**keys), "body_1", flank_element_mm=element_mm)


def mesh_of(body: Body) -> SectorMesh:
    assert body.mesh is not None
    return body.mesh


def gauss_weights(mesh: SectorMesh) -> np.ndarray:
    """Jacobian times weight at 3 x 3 Gauss points, by scikit-fem."""
    cells = mesh.cells[0][1]
    basis = Basis(MeshQuad2(mesh.nodes.T, cells.T), ElementQuad2(), intorder=5)
    return basis.dx


FZG_1 = {}
FZG_2 = {
    "teeth": 24,
    "profile_shift": 0.171,
    "tip_diameter_mm": 118.36,
    "bore_diameter_mm": 40.0,
}
#: Odd ones: few and many teeth, thin and thick rims, roundings, chamfers, modifications.
ODD = [
    FZG_1,
    FZG_2,
    {"teeth": 8, "profile_shift": 0.0, "tip_diameter_mm": 45.0, "bore_diameter_mm": 10.0},
    {"teeth": 8, "profile_shift": -0.3, "tip_diameter_mm": 40.0, "bore_diameter_mm": 1.0},
    {"teeth": 8, "profile_shift": 0.8, "tip_diameter_mm": 49.0, "bore_diameter_mm": 31.0},
    {"teeth": 100, "profile_shift": 0.0, "tip_diameter_mm": 459.0, "bore_diameter_mm": 20.0},
    {"teeth": 200, "profile_shift": 0.8, "tip_diameter_mm": 915.0, "bore_diameter_mm": 890.0},
    {"bore_diameter_mm": 61.5},
    {"tip_radius_mm": 0.1},
    {"tip_radius_mm": 1.0},
    {"tip_chamfer_mm": 0.5},
    {"tip_relief_um": 30.0, "tip_relief_start_diameter_mm": 79.0, "profile_crowning_um": 5.0},
    {"tip_diameter_mm": 86.2},
    {"fillet_radius_factor": 0.4719},
    {"fillet_radius_factor": 0.0},
]


#: Rings: few and many teeth, thin and thick rims, small and full fillets, roundings, chamfers.
ODD_RINGS = [
    {},
    {"outer_diameter_mm": 189.0},
    {"outer_diameter_mm": 500.0},
    {"root_fillet_radius_mm": 0.1, "tip_radius_mm": 0.1},
    {"tip_radius_mm": 1.0},
    {"tip_chamfer_mm": 0.5, "profile_crowning_um": 5.0},
    {"tip_relief_um": 30.0, "tip_relief_start_diameter_mm": 178.0},
    {"teeth": 24, "tip_diameter_mm": 70.0, "root_diameter_mm": 79.5, "outer_diameter_mm": 100.0},
    {"teeth": 200, "tip_diameter_mm": 595.0, "root_diameter_mm": 608.0, "outer_diameter_mm": 640.0},
]


def ring_built(element_mm: float = 1.0, **keys) -> Body:
    """A ring of 60 teeth, with other keys."""
    given = {
        "teeth": 60,
        "module_mm": 3.0,
        "tip_diameter_mm": 175.2,
        "root_diameter_mm": 187.5,
        "outer_diameter_mm": 220.0,
    }
    return build_involute_body(Ring(**(given | keys)), "body_2", flank_element_mm=element_mm)


@pytest.fixture(
    scope="module",
    params=[*range(len(ODD)), *(f"ring{k}" for k in range(len(ODD_RINGS)))],
    ids=str,
)
def body(request: pytest.FixtureRequest) -> Body:
    if isinstance(request.param, int):
        return built(**ODD[request.param])
    return ring_built(**ODD_RINGS[int(request.param[4:])])


def test_elements_are_valid(body: Body) -> None:
    assert (gauss_weights(mesh_of(body)) > 0).all()


def test_elements_fit_together(body: Body) -> None:
    """Every edge is shared by two elements or lies on the boundary; no place has two nodes."""
    mesh = mesh_of(body)
    cells = mesh.cells[0][1]
    edges = np.concatenate([cells[:, [a, b, m]] for a, b, m in ((0, 1, 4), (1, 2, 5), (2, 3, 6))])
    edges = np.concatenate([edges, cells[:, [3, 0, 7]]])
    edges[:, :2].sort(axis=1)
    unique, count = np.unique(edges, axis=0, return_counts=True)
    assert count.max() == 2
    # Euler: vertices - edges + elements of a disc
    vertices = np.unique(cells[:, :4]).size
    assert vertices - len(unique) + len(cells) == 1
    assert np.unique(cells).tolist() == list(range(len(mesh.nodes)))
    step = np.linalg.norm(mesh.nodes[edges[:, 0]] - mesh.nodes[edges[:, 1]], axis=1).min()
    assert len(np.unique(np.round(mesh.nodes / (0.01 * step)), axis=0)) == len(mesh.nodes)


def test_cuts_match_and_the_rim_is_held(body: Body) -> None:
    mesh = mesh_of(body)
    pitch = 2 * pi / mesh.teeth
    turn = np.array([[np.cos(pitch), -np.sin(pitch)], [np.sin(pitch), np.cos(pitch)]])
    left, right = mesh.nodes[mesh.left_nodes], mesh.nodes[mesh.right_nodes]
    size = np.abs(mesh.nodes).max()
    np.testing.assert_allclose(right, left @ turn.T, rtol=0, atol=size * ROUND_OFF)
    start = body.involute.tooth_center_rad - pitch / 2
    np.testing.assert_allclose(
        np.arctan2(left[:, 1], left[:, 0]), start, rtol=1e-12, atol=10 * ROUND_OFF
    )
    bore = np.hypot(*mesh.nodes[mesh.fixed_nodes].T)
    np.testing.assert_allclose(bore, body.bore_radius_mm, rtol=1e-12)
    assert not set(mesh.fixed_nodes) & (set(mesh.left_nodes) | set(mesh.right_nodes))
    polar = np.arctan2(mesh.nodes[:, 1], mesh.nodes[:, 0])
    on_cut = np.isclose(polar, start, rtol=0, atol=1e-9)
    assert set(np.flatnonzero(on_cut)) - set(mesh.fixed_nodes) == set(mesh.left_nodes)


def test_flank_edges_lie_on_the_profile_from_end_to_end_of_the_modes(body: Body) -> None:
    mesh = mesh_of(body)
    first, last, middle = mesh.flank_edges.T
    s = mesh.flank_arc_length
    low, high = body.mode_range_mm
    assert (first[1:] == last[:-1]).all()
    assert s[first[0]] == pytest.approx(low, abs=SOLVER)
    assert s[last[-1]] == pytest.approx(high, abs=SOLVER)
    assert (s[last] > s[first]).all()
    np.testing.assert_allclose(s[middle], 0.5 * (s[first] + s[last]), rtol=0, atol=SOLVER)
    assert (s[last] - s[first]).max() <= 1.0 + SOLVER
    carrying = np.unique(mesh.flank_edges)
    assert np.flatnonzero(np.isfinite(s)).tolist() == carrying.tolist()
    np.testing.assert_allclose(
        mesh.nodes[carrying], body.curve.point(s[carrying]), rtol=0, atol=SOLVER
    )


def test_mesh_is_its_own_mirror_image(body: Body) -> None:
    mesh = mesh_of(body)
    tolerance = 1e-9 * np.abs(mesh.nodes).max()
    center = body.involute.tooth_center_rad
    c, s = np.cos(center), np.sin(center)
    nodes = mesh.nodes @ np.array([[c, -s], [s, c]])
    there = {tuple(place) for place in np.round(nodes / tolerance).astype(int).tolist()}
    mirrored = np.round(nodes * [1.0, -1.0] / tolerance).astype(int)
    near = [(a, b) for a in (-1, 0, 1) for b in (-1, 0, 1)]
    assert all(any((x + a, y + b) in there for a, b in near) for x, y in mirrored.tolist())


def test_area_converges_to_that_of_the_profile() -> None:
    """Quadratic edges with nodes on the curve: fourth order in the end.

    At these sizes it is less than third order: the radius of the flank goes down to 1.5 mm.
    """
    body = built(4.0)
    profile = gear_profile(gear(), "body_1")
    points, weights = np.polynomial.legendre.leggauss(8)
    half = 0.5 * np.diff(body.curve.breaks)
    s = 0.5 * (body.curve.breaks[1:] + body.curve.breaks[:-1]) + half * points[:, None]
    place, slope, _ = body.curve.derivatives(s.ravel())
    swept = (place[:, 0] * slope[:, 1] - place[:, 1] * slope[:, 0]).reshape(s.shape)
    flank = -(weights[:, None] * half * swept).sum()
    end = np.arctan2(*body.curve.point([body.curve.length_mm])[0][::-1])
    root = profile.involute.root_radius_mm**2 * (pi / 16 - profile.root_half_angle_rad)
    exact = 41.23**2 * end + flank + root - 15.0**2 * pi / 16
    errors = [abs(gauss_weights(mesh_of(built(h))).sum() / exact - 1) for h in (2.0, 1.0, 0.5)]
    assert errors[-1] < 5e-7
    assert (-np.diff(np.log2(errors)) > 2.2).all()


def test_area_of_a_ring_converges_to_that_of_the_profile() -> None:
    body = ring_built()
    points, weights = np.polynomial.legendre.leggauss(8)
    half = 0.5 * np.diff(body.curve.breaks)
    s = 0.5 * (body.curve.breaks[1:] + body.curve.breaks[:-1]) + half * points[:, None]
    place, slope, _ = body.curve.derivatives(s.ravel())
    swept = (place[:, 0] * slope[:, 1] - place[:, 1] * slope[:, 0]).reshape(s.shape)
    flank = (weights[:, None] * half * swept).sum()
    end = np.arctan2(*body.curve.point([body.curve.length_mm])[0][::-1])
    exact = 110.0**2 * pi / 60 - flank - 87.6**2 * (pi / 60 - end)
    errors = [abs(gauss_weights(mesh_of(ring_built(h))).sum() / exact - 1) for h in (2.0, 1.0, 0.5)]
    assert errors[-1] < 5e-7
    assert (-np.diff(np.log2(errors)) > 2.2).all()


def test_compliance_of_a_ring_converges_under_refinement(monkeypatch: pytest.MonkeyPatch) -> None:
    """At least second order, as in gears; without the logarithm it is small, so relative to it.

    Without the image behind the tip corner, whose angle would change with the elements.
    """
    monkeypatch.setattr(loads, "image_strengths", lambda _: (0.0, 0.0))
    sizes = np.array([2.0, 1.0, 0.5])
    smooth = [
        flank_compliance(ring_built(h), JobOptions(n_modes=4, plane="strain")).smooth for h in sizes
    ]
    finest = flank_compliance(ring_built(0.25), JobOptions(n_modes=4, plane="strain")).smooth
    errors = [np.abs(s - finest).max() / np.abs(finest).max() for s in smooth]
    assert np.polyfit(np.log(sizes), np.log(errors), 1)[0] > 1.8
    even = [abs(s[0, 0, 0] / finest[0, 0, 0] - 1) for s in smooth]
    assert even[1] < 5e-4


def test_flank_element_sets_the_size() -> None:
    counts = {h: len(mesh_of(built(h)).flank_edges) for h in (2.0, 1.0, 0.5)}
    assert counts == {2.0: 5, 1.0: 9, 0.5: 17}
    dof = {h: 2 * len(mesh_of(built(h)).nodes) for h in (2.0, 1.0)}
    assert dof[2.0] < 1600
    assert dof[1.0] < 4500


def test_parts_grow_by_no_more_than_they_may() -> None:
    parts = np.diff(growing_breaks(16.0, 0.5, 1.4, None))
    assert (parts[1:] / parts[:-1] <= 1.4 + ROUND_OFF).all()
    assert parts[0] * 16.0 == pytest.approx(0.5, rel=0.25)
    both = np.diff(symmetric_breaks(8.0, 0.35, 1.4, 1.0))
    np.testing.assert_allclose(both, both[::-1], rtol=1e-12)
    assert both.max() * 8.0 < 1.25


def test_compliance_converges_under_refinement() -> None:
    """The finite elements' smooth compliance: at least second order (slope 1.8 over four sizes)."""
    sizes = np.array([2.0, 1.0, 0.5])
    smooth = [
        flank_compliance(built(h), JobOptions(n_modes=4, plane="strain")).smooth for h in sizes
    ]
    finest = flank_compliance(built(0.25), JobOptions(n_modes=4, plane="strain")).smooth
    errors = [np.abs(s - finest).max() / np.abs(finest).max() for s in smooth]
    slope = np.polyfit(np.log(sizes), np.log(errors), 1)[0]
    assert slope > 1.8
    assert errors[1] < 4e-3
    even = [abs(s[0, 0, 0] / finest[0, 0, 0] - 1) for s in smooth]
    assert even[1] < 2e-4


#: Without a rounding 0.8 (gears; rings 0.6 to 0.8), with a chamfer 0.47.
LEAST_SHAPE = 0.6


@pytest.mark.parametrize("rounding", [0.03, 0.08, 0.15, 0.3])
@pytest.mark.parametrize("element", [1.0, 1 / 4.5, 1 / 18])
def test_no_element_collapses_at_a_tip_rounding(rounding: float, element: float) -> None:
    """Regression: a block corner on the rounding had 180 degrees, a scaled Jacobian of 0.007."""
    bodies = [
        built(4.5 * element, tip_radius_mm=4.5 * rounding),
        ring_built(3.0 * element, tip_radius_mm=3.0 * rounding),
    ]
    for body in bodies:
        mesh = mesh_of(body)
        assert scaled_jacobians(mesh.nodes, *mesh.cells[0]).min() > LEAST_SHAPE


def test_a_rounding_as_wide_as_the_tooth_has_elements() -> None:
    mesh = mesh_of(built(tip_radius_mm=2.4))  # the largest is 2.4043
    assert scaled_jacobians(mesh.nodes, *mesh.cells[0]).min() > 0.3


def test_quality_has_a_verdict() -> None:
    mesh = mesh_of(built(tip_radius_mm=0.36))
    assert dict(quality_rows(mesh.nodes, mesh.cells))["shape of the elements"] == "good"
    words = [verdict(value).split(":")[0] for value in (0.5, 0.3, 0.01, 0.0, -0.1)]
    assert words == ["good", "usable", "poor", "invalid", "invalid"]


def test_rigid_gear_has_no_mesh() -> None:
    assert built(rigid=True).mesh is None


def test_body_has_the_data_for_pairing() -> None:
    body = built(pitch_errors_um=tuple(range(16)))
    assert body.reference_radius_mm == body.base_radius_mm == body.involute.base_radius_mm
    assert (body.tip_radius_mm, body.bore_radius_mm) == (41.23, 15.0)
    assert body.root_radius_mm == pytest.approx(31.194, abs=1e-9)
    assert body.flank_angle_known
    assert body.pitch_errors_um == tuple(range(16))
    assert body.kind == "gear"


def test_element_size_follows_the_module_where_none_is_given(tmp_path) -> None:
    body = build_body(
        gear(), "body_1", folder=tmp_path, flank_element_mm=None, flank_element_parts=1 / 4.5
    )
    assert len(mesh_of(body).nodes) == len(mesh_of(built(1.0)).nodes)


def test_elements_that_would_fill_the_memory_are_refused() -> None:
    """Regression: 0.001 mm on a gear of module 7 made a block of 1e9 nodes."""
    line = r"accuracy\.flank_element_mm: expected elements so large that a block"
    for length in (1e-3, 1e-6):
        with pytest.raises(SceneError, match=line):
            built(length)
