"""Ring closure against fully meshed rings, symmetry, convergence of the smooth compliance."""

from __future__ import annotations

import numpy as np
import pytest

from flankload.bodies.body import Body, MeshedFlank, WholeMesh
from flankload.bodies.involute.involute_body import build_involute_body
from flankload.bodies.root_fillet import root_fillets
from flankload.elasticity.compliance import (
    BodyCompliance,
    JobOptions,
    flank_compliance,
)
from flankload.elasticity.compliance.loads import ModeLoads
from flankload.elasticity.compliance.plane_extent import PlaneExtent
from flankload.elasticity.compliance.response import Job, of_whole
from flankload.elasticity.finite_elements import stiffness
from flankload.elasticity.job_log import JobLog
from flankload.elasticity.near_field import mode_loads
from flankload.elasticity.sector_closure import close_ring
from flankload.pairing.expansion import BodyLoad
from flankload.scene import Gear, Ring
from tests.support.condensed import condense
from tests.support.plane_sectors import STEEL, ring_sector
from tests.support.ring_bodies import full_ring, gear_body
from tests.support.tolerances import CLOSURE, ROUND_OFF


@pytest.mark.parametrize("teeth", [5, 6])
def test_ring_closure_equals_the_meshed_ring(teeth: int) -> None:
    mesh, span = ring_sector(teeth)
    matrix = stiffness(mesh.nodes, mesh.cells, STEEL, "strain")
    sector, _ = condense(matrix, mode_loads(mesh, span, 3), mesh)
    found, expected = close_ring(sector, teeth), full_ring(mesh, span, 3)
    assert np.abs(found - expected).max() <= CLOSURE * np.abs(expected).max()


def test_compliance_of_a_ring_is_symmetric() -> None:
    teeth = 6
    mesh, span = ring_sector(teeth)
    matrix = stiffness(mesh.nodes, mesh.cells, STEEL, "strain")
    sector, _ = condense(matrix, mode_loads(mesh, span, 4), mesh)
    response = close_ring(sector, teeth)
    mirrored = response[-np.arange(teeth) % teeth].transpose(0, 2, 1)
    np.testing.assert_allclose(
        response, mirrored, rtol=0, atol=100 * ROUND_OFF * np.abs(response).max()
    )
    # a unit of pressure on its own tooth gives way, and most where it presses
    assert (np.diag(response[0]) > 0).all()
    assert response[0, 0, 0] > np.abs(response[1:, 0, 0]).max()


@pytest.mark.parametrize("teeth", [7, 8])
def test_ring_closure_of_real_teeth_equals_the_meshed_gear(teeth: int) -> None:
    body = gear_body(teeth, 2.5, profile_shift=0.5)
    mesh, n_modes = body.mesh, 3
    matrix = stiffness(mesh.nodes, mesh.cells, STEEL, "strain")
    sector, _ = condense(matrix, mode_loads(mesh, body.mode_range_mm, n_modes), mesh)
    found = close_ring(sector, teeth)
    expected = full_ring(mesh, body.mode_range_mm, n_modes)
    assert np.abs(found - expected).max() <= CLOSURE * np.abs(expected).max()


def test_ring_closure_of_internal_teeth_equals_the_meshed_ring() -> None:
    spec = Ring(
        teeth=12,
        module_mm=3.0,
        tip_diameter_mm=35.0,
        root_diameter_mm=43.0,
        outer_diameter_mm=55.0,
    )
    body = build_involute_body(spec, "body_2", flank_element_mm=2.0)
    matrix = stiffness(body.mesh.nodes, body.mesh.cells, STEEL, "strain")
    loads = mode_loads(body.mesh, body.mode_range_mm, 3)
    found = close_ring(condense(matrix, loads, body.mesh)[0], 12)
    expected = full_ring(body.mesh, body.mode_range_mm, 3)
    assert np.abs(found - expected).max() <= CLOSURE * np.abs(expected).max()


def test_compliance_of_a_gear_is_symmetric_and_counted() -> None:
    """Before both halves are averaged: displacement at a under load b = at b under load a."""
    found = flank_compliance(gear_body(16, 1.0), JobOptions(n_modes=5, plane="strain"))
    assert found.job.asymmetry < 1e-12
    assert (found.job.counters["fe_factorisations"], found.job.counters["unit_loads_normal"]) == (
        1,
        5,
    )
    assert found.smooth.shape == (16, 5, 5)
    assert 1500 < found.job.degrees_of_freedom < 6000


def test_fewer_modes_are_the_leading_block() -> None:
    """The result of a separate finite-element job with one mode less."""
    body = gear_body(16, 2.0)
    five, four = (flank_compliance(body, JobOptions(n_modes=n, plane="strain")) for n in (5, 4))
    np.testing.assert_allclose(
        five.fewer_modes().smooth,
        four.smooth,
        rtol=0,
        atol=1000 * ROUND_OFF * np.abs(four.smooth).max(),
    )


def test_even_pressure_converges_with_the_square_of_the_elements() -> None:
    finest = flank_compliance(gear_body(16, 0.25), JobOptions(n_modes=4, plane="strain")).smooth[
        0, 0, 0
    ]
    sizes = np.array([2.0, 1.0, 0.5])
    errors = [
        abs(
            flank_compliance(gear_body(16, h), JobOptions(n_modes=4, plane="strain")).smooth[
                0, 0, 0
            ]
            / finest
            - 1
        )
        for h in sizes
    ]
    slope = np.polyfit(np.log(sizes), np.log(errors), 1)[0]
    assert slope > 1.8
    assert errors[1] < 3e-4


def test_rigid_body_has_no_compliance_and_no_elements() -> None:
    spec = Gear(teeth=16, module_mm=4.5, tip_diameter_mm=81.0, bore_diameter_mm=30.0, rigid=True)
    found = flank_compliance(
        build_involute_body(spec, "body_1", flank_element_mm=1.0),
        JobOptions(n_modes=5, plane="strain"),
    )
    assert found.near.kernel == 0.0
    assert not found.smooth.any()
    assert (found.job.counters, found.job.workspace_bytes) == ({}, 0)


#: Each adds columns that only read: BLAS sums a product of more columns in another order.
READINGS = ("stress", "growth")


def read_with(body: Body, *asked: str, sectors: int | None = None) -> BodyCompliance:
    return flank_compliance(
        body,
        JobOptions(
            n_modes=7,
            plane="strain",
            friction=True,
            fillets=root_fillets(body, "body_1") if "stress" in asked else None,
        ),
        body_load=BodyLoad(speed_rad_per_s=300.0, density_Ns2_per_mm4=7.85e-9)
        if "growth" in asked
        else None,
        sectors=sectors,
    )


@pytest.mark.parametrize("sectors", [None, 3, 1])
def test_further_readings_change_no_bit(sectors: int | None) -> None:
    body = gear_body(16, 1.0)
    readings = READINGS if sectors != 1 else READINGS[:1]  # a tooth alone does not grow by elements
    every = read_with(body, *readings, sectors=sectors)
    for asked in ((), *((name,) for name in readings)):
        some = read_with(body, *asked, sectors=sectors)
        np.testing.assert_array_equal(some.smooth, every.smooth)
        np.testing.assert_array_equal(some.tangential, every.tangential)
        if some.root is not None:
            np.testing.assert_array_equal(some.root.response, every.root.response)
        for name, shift in some.expansion.shifts.items():
            np.testing.assert_array_equal(shift, every.expansion.shifts[name])


def test_readings_of_a_whole_mesh_change_no_bit_of_its_compliance() -> None:
    body = gear_body(16, 1.0)
    mesh = body.mesh
    flank = MeshedFlank(0, mesh.nodes, mesh.flank_edges, mesh.flank_arc_length)
    whole = WholeMesh(mesh.nodes, mesh.cells, mesh.fixed_nodes, (flank,))
    matrix = stiffness(mesh.nodes, mesh.cells, body.material, "strain")
    extent = PlaneExtent()
    loads = ModeLoads(body, extent, 7, friction=True)
    stress = extent.root_columns(root_fillets(body, "body_1"), 0, matrix, body.material)

    def response(readings: dict[str, tuple[np.ndarray, int]]) -> np.ndarray:
        job = Job(body, matrix, loads, lambda _: readings, None, JobLog())
        return of_whole(job, whole).response

    plain, asked = response({}), response({"stress_recoveries": (stress, 1)})
    np.testing.assert_array_equal(asked[:, : plain.shape[1]], plain)
    assert asked.shape[1] == plain.shape[1] + stress.shape[2]
