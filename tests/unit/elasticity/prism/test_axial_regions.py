"""Prisms with regions of other width: axial matrices, condensation, limits, symmetries."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from itertools import pairwise

import numpy as np
import pytest
from numpy.polynomial.legendre import leggauss
from scipy.sparse import csc_array

from flankload.bodies.body import SectorMesh
from flankload.bodies.involute.involute_body import build_involute_body
from flankload.elasticity.axial_basis import (
    AxialBasis,
    AxialRegions,
    cross_terms,
    functions_of,
)
from flankload.elasticity.compliance import BodyCompliance, JobOptions, flank_compliance
from flankload.elasticity.finite_elements import SectionStiffness, section_stiffness
from flankload.elasticity.fronts.condensation import condense_nodes
from flankload.elasticity.near_field import mode_loads
from flankload.elasticity.prism import Prism
from flankload.elasticity.sector_closure import close_ring
from tests.support.plain_prism import product_loads, unknowns, whole_stiffness
from tests.support.plane_sectors import STEEL, ring_sector
from tests.support.ring_bodies import gear
from tests.support.tolerances import CLOSURE, ROUND_OFF

TEETH = 5
WIDE, THIN, HUB = (-3.0, 4.0), (-0.5, 1.5), (-2.0, 6.0)
WEBBED = build_involute_body(
    gear(web_width_mm=4.0, rim_thickness_mm=6.0, hub_diameter_mm=38.0, hub_width_mm=20.0),
    "body_1",
    flank_element_mm=3.5,
    regions=("web", "hub"),
)
COARSE = Prism((-7.0, 7.0), degree=6, load_degree=2, cut_degree=3)
TWIST = float(np.tan(np.radians(15.0)) / 36.0)


def _sector() -> tuple[SectorMesh, tuple[float, float]]:
    """The ring sector with a thin web between a wide rim and a hub of another width."""
    mesh, span = ring_sector(TEETH, rows=4, columns=4)
    ((kind, data),) = mesh.cells
    radius = np.hypot(*mesh.nodes[data[:, 8]].T)
    parts = (radius > 20.0, (radius < 20.0) & (radius > 15.0), radius < 15.0)
    cells = tuple((kind, data[part]) for part in parts)
    return replace(mesh, cells=cells, regions=("", "web", "hub")), span


def _regions(degree: int) -> tuple[SectorMesh, tuple[float, float], tuple[int, ...], AxialRegions]:
    mesh, span = _sector()
    numbers, axial = functions_of(mesh, AxialBasis(WIDE, degree), {"web": THIN, "hub": HUB})
    assert isinstance(axial, AxialRegions)
    return mesh, span, numbers, axial


def test_integrals_over_a_width_mix_functions_of_two() -> None:
    one, two, over = (AxialBasis(extent, 5) for extent in (WIDE, HUB, THIN))
    found = cross_terms(one, two, over)
    points, weights = leggauss(40)
    z, weights = 0.5 + points, weights
    (a, b), step = (np.array([basis.values(z) for basis in (one, two)])), 1e-6
    slope_a, slope_b = (
        (basis.values(z + step) - basis.values(z - step)) / (2 * step) for basis in (one, two)
    )
    for term, (row, column) in enumerate(((a, b), (a, slope_b), (slope_a, b), (slope_a, slope_b))):
        np.testing.assert_allclose(
            found[term], row.T @ (weights[:, None] * column), rtol=0, atol=1e-8
        )
    np.testing.assert_allclose(
        cross_terms(two, one, over)[[0, 2, 1, 3]], found.transpose(0, 2, 1), rtol=0, atol=1e-15
    )
    # the general integral over the own width is the closed form
    nearly = AxialBasis((WIDE[0], WIDE[1] * (1 + 1e-15)), 5)
    _close(cross_terms(one, nearly, one), one.terms, 10 * ROUND_OFF)


def test_nodes_have_the_functions_of_the_widest_region() -> None:
    mesh, _, numbers, axial = _regions(3)
    assert [basis.range_mm for basis in axial.bases[:3]] == [HUB, WIDE, THIN]
    assert not any(basis.inside_mm for basis in axial.bases[:3])
    assert numbers == (1, 2, 0)
    radius = np.hypot(*mesh.nodes[:, :2].T)
    layers = [np.unique(data) for _, data in mesh.cells]
    for layer, extent in ((layers[0], WIDE), (layers[2], HUB)):
        own = [axial.bases[number] for number in set(axial.of_node[layer])]
        assert {(basis.range_mm, basis.inside_mm) for basis in own} == {
            (extent, ()),
            (extent, (THIN,)),
        }
    alone = np.setdiff1d(layers[1], np.concatenate([layers[0], layers[2]]))
    assert set(axial.of_node[alone]) == {2}
    assert alone.size
    assert radius[alone].max() < radius[layers[0]].max()


def _whole(
    mesh: SectorMesh, numbers: tuple[int, ...], axial: AxialRegions, twist: float
) -> csc_array:
    """The stiffness of all unknowns, part by part, from functions restricted to the part.

    A part is that of a region between the ends of the others. Every node first has the functions of
    the part as if it were alone; its own functions are polynomials of the same degree there, so
    they are sums of these.
    """
    size = 3 * axial.count * len(mesh.nodes)
    total = csc_array((size, size))
    parts = []
    for number, cells in zip(numbers, mesh.cells, strict=True):
        low, high = axial.bases[number].range_mm
        ends = sorted({low, high, *(end for end in THIN if low < end < high)})
        parts += [(AxialBasis(part, axial.count - 1), cells) for part in pairwise(ends)]
    for own, cells in parts:
        section = section_stiffness(mesh.nodes, (cells,), STEEL, twist)
        points, weights = leggauss(axial.count)
        low, high = own.range_mm
        z = 0.5 * (low + high + (high - low) * points)
        project = own.values(z) * (0.5 * (high - low) * weights)[:, None]
        onto = [np.kron(project.T @ basis.values(z), np.eye(3)) for basis in axial.bases]
        blocks = [onto[basis] for basis in axial.of_node]
        rows = np.arange(size).reshape(len(mesh.nodes), -1)
        restricted = csc_array(
            (
                np.array(blocks).ravel(),
                (
                    np.repeat(rows, rows.shape[1], axis=1).ravel(),
                    np.tile(rows, rows.shape[1]).ravel(),
                ),
            ),
            shape=(size, size),
        )
        total = total + restricted.T @ whole_stiffness(section, own) @ restricted
    return total.tocsc()


def _section(mesh, numbers, functions, twist: float, *, cut_degree: int) -> SectionStiffness:
    section = section_stiffness(mesh.nodes, mesh.cells, STEEL, twist, numbers)
    return replace(section, functions=functions, cut_degree=cut_degree)


@pytest.mark.parametrize("twist", [0.0, 0.04])
def test_it_is_the_schur_complement_of_the_whole_matrix(twist: float) -> None:
    mesh, span, numbers, axial = _regions(4)
    section = _section(mesh, numbers, axial, twist, cut_degree=2)
    matrix = _whole(mesh, numbers, axial, twist)
    teeth = AxialBasis(WIDE, 4)
    loads = product_loads(mode_loads(mesh, span, 3, twist=twist), teeth.load_vectors(2))
    cuts = np.concatenate([mesh.left_nodes, mesh.right_nodes])
    kept = unknowns(cuts, axial.count, 3)
    held = np.union1d(unknowns(mesh.fixed_nodes, axial.count), unknowns(cuts, axial.count))
    inner = np.setdiff1d(np.arange(matrix.shape[0]), held)
    coupling = matrix[inner][:, kept].toarray()
    moved = np.linalg.solve(matrix[inner][:, inner].toarray(), np.hstack([loads[inner], coupling]))
    by_loads, by_cuts = np.split(moved, [loads.shape[1]], axis=1)
    found = condense_nodes(section, mesh, loads.reshape(len(mesh.nodes), 3 * axial.count, -1))
    for one, two in (
        (found.local[0], loads[inner].T @ by_loads),
        (found.carried[0], loads[kept] - coupling.T @ by_loads),
        (found.stiffness, matrix[kept][:, kept].toarray() - coupling.T @ by_cuts),
    ):
        np.testing.assert_allclose(one, two, rtol=0, atol=CLOSURE * np.abs(two).max())


def test_widths_about_one_middle_leave_two_problems_of_half_the_size() -> None:
    mesh, span = _sector()
    axial = AxialBasis(WIDE, 4)
    loads = product_loads(mode_loads(mesh, span, 2, twist=0.0), axial.load_vectors(2))
    loads = loads.reshape(len(mesh.nodes), 3 * axial.count, -1)
    for web, symmetric in (((0.0, 1.0), True), ((0.0, 1.5), False)):
        numbers, functions = functions_of(mesh, axial, {"web": web, "hub": (-4.0, 5.0)})
        assert functions.symmetric is symmetric
        section = _section(mesh, numbers, functions, 0.0, cut_degree=2)
        # a twist after its blocks are made joins both problems
        one, two = (
            condense_nodes(replace(section, twist=twist), mesh, loads) for twist in (0.0, 1.0)
        )
        largest = np.abs(two.local[0]).max()
        np.testing.assert_allclose(one.local[0], two.local[0], rtol=0, atol=CLOSURE * largest)


def test_the_response_is_positive_definite() -> None:
    mesh, span, numbers, axial = _regions(6)
    loads = product_loads(
        mode_loads(mesh, span, 3, twist=0.03), AxialBasis(WIDE, 6).load_vectors(2)
    )
    section = _section(mesh, numbers, axial, 0.03, cut_degree=4)
    sector = condense_nodes(section, mesh, loads.reshape(len(mesh.nodes), 3 * axial.count, -1))
    ring = close_ring(sector, TEETH)
    apart = np.arange(TEETH)
    whole = ring[(apart[:, None] - apart) % TEETH].transpose(0, 2, 1, 3)
    whole = whole.reshape(TEETH * ring.shape[1], -1)
    assert np.abs(whole - whole.T).max() < 1e-13 * np.abs(whole).max()
    assert np.linalg.eigvalsh(whole).min() > 0


@cache
def _found(prism: Prism = COARSE, **keys) -> BodyCompliance:
    return flank_compliance(WEBBED, JobOptions(n_modes=3, prism=replace(prism, **keys)))


def _close(one: np.ndarray, two: np.ndarray, part: float) -> None:
    np.testing.assert_allclose(one, two, rtol=0, atol=part * np.abs(two).max())


def test_regions_as_wide_as_the_teeth_are_none() -> None:
    plain = _found()
    same = _found(regions=(("web", (-7.0, 7.0)), ("hub", (-7.0, 7.0))))
    assert np.array_equal(same.smooth, plain.smooth)
    # up to rounding, by the integrals of functions of three bases
    nearly = _found(regions=(("web", (-7.0, 7.0 - 1e-13)), ("hub", (-7.0 - 1e-13, 7.0))))
    _close(nearly.smooth, plain.smooth, 1e-11)


def test_thin_webs_obey_betti() -> None:
    found = _found(twist=TWIST, degree=12, regions=(("web", (-0.2, 0.2)), ("hub", (-3.0, 17.0))))
    assert found.job.asymmetry < 10 * ROUND_OFF
    assert found.smooth[0, 0, 0] > 3 * _found(twist=TWIST).smooth[0, 0, 0]
    assert found.job.counters["fe_factorisations"] == 1


def test_a_web_off_the_middle_couples_even_and_odd_modes() -> None:
    found = _found(regions=(("web", (2.0, 5.0)),))
    assert found.job.asymmetry < 10 * ROUND_OFF
    assert found.smooth[0, 0, 1] < -0.1 * found.smooth[0, 0, 0]
    middle = _found(regions=(("web", (-1.5, 1.5)),))
    assert np.abs(middle.smooth[0, 0, 1]) < ROUND_OFF * middle.smooth[0, 0, 0]


def test_narrower_webs_are_softer_and_wider_hubs_stiffer() -> None:
    def mean(web: float, hub: float) -> float:
        regions = (("web", (-web, web)), ("hub", (-hub, hub)))
        return float(_found(regions=regions).smooth[0, 0, 0])

    assert mean(7.0, 7.0) < mean(4.0, 7.0) < mean(2.0, 7.0) < mean(1.0, 7.0)
    assert mean(2.0, 12.0) < mean(2.0, 7.0) < mean(2.0, 3.0)


def test_the_mirror_image_has_the_other_hand_and_offset() -> None:
    right = _found(twist=TWIST, regions=(("web", (-5.0, 1.0)), ("hub", (-9.0, 2.0))))
    left = _found(twist=-TWIST, regions=(("web", (-1.0, 5.0)), ("hub", (-2.0, 9.0))))
    parity = np.tile((-1.0) ** np.arange(3), 3)
    _close(left.smooth, right.smooth * np.outer(parity, parity), 1e-11)


def test_the_matrices_of_a_thin_web_stay_well_conditioned() -> None:
    mesh, _, numbers, axial = _regions(12)
    section = section_stiffness(mesh.nodes, mesh.cells, STEEL, 0.0, numbers)
    number, terms = axial.products(section)
    web = np.flatnonzero((section.rows == section.columns) & (section.regions == 2))
    alone = web[axial.of_node[section.rows[web]] == 2]
    mass = terms[number[alone[0]], 0]
    assert np.linalg.cond(mass) < 1.0 + 1e-12
    # the polynomials of the rim over the web alone are nearly dependent
    rim, narrow = AxialBasis(WIDE, 12), AxialBasis(THIN, 12)
    assert np.linalg.cond(cross_terms(rim, rim, narrow)[0]) > 1e8


@pytest.mark.parametrize(
    ("extent", "inside"),
    [((-7.0, 7.0), (-2.0, 2.0)), (WIDE, THIN), ((0.0, 5.0), (0.0, 2.0)), ((0.0, 5.0), (2.0, 5.0))],
)
def test_functions_of_a_seam_are_orthonormal_with_kinks_at_its_ends(
    extent: tuple[float, float], inside: tuple[float, float]
) -> None:
    basis = AxialBasis(extent, 8, (inside,))
    _close(basis.terms[0], np.eye(9), 1000 * ROUND_OFF)
    z, step = np.linspace(*extent, 40)[1:-1], 1e-6
    change = (basis.values(z + step) - basis.values(z - step)) / (2 * step)
    np.testing.assert_allclose(basis.derivatives(z), change, rtol=0, atol=1e-6)
    # polynomials of low degree come first, and functions are even or odd in turn
    _close(basis.values(z)[:, :5], AxialBasis(extent, 4).values(z), 1000 * ROUND_OFF)
    if sum(extent) == sum(inside):
        parity = (-1.0) ** np.arange(9)
        _close(basis.values(sum(extent) - z), parity * basis.values(z), 1000 * ROUND_OFF)
    ends = [end for end in inside if extent[0] < end < extent[1]]
    for end in ends:
        jump = np.diff(basis.derivatives(np.array([end - step, end + step])), axis=0)
        assert np.abs(jump).max() > 0.1
    # ends that are almost those of the width are these
    nearly = AxialBasis(extent, 8, ((extent[0] + 1e-13, extent[1]),))
    _close(nearly.values(z), AxialBasis(extent, 8).values(z), 1000 * ROUND_OFF)
