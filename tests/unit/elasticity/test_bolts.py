"""A free rim: closed form of a thin ring, and bolts that hold it."""

from dataclasses import replace
from math import pi, sin, tan

import numpy as np
import pytest

from flankload.elasticity.bolts import Bolts, on_bolts
from flankload.elasticity.compliance import JobOptions, flank_compliance
from tests.support.plane_sectors import STEEL, ring_sector
from tests.support.ring_bodies import gear_body
from tests.support.tolerances import ROUND_OFF

TEETH, RADIUS, HEIGHT = 120, 100.0, 5.0
#: Thin rings have no shear, and forces at points (measured 7e-3).
THIN = 1e-2


@pytest.fixture(scope="module")
def ring():
    """Compliance of a plain thin ring that is free inside, in plane stress."""
    mesh, _ = ring_sector(TEETH, rows=2, columns=3, lobe=0.0)
    radius = np.hypot(*mesh.nodes.T)
    nodes = mesh.nodes * ((RADIUS + HEIGHT * (radius - 20.0) / 20.0) / radius)[:, None]
    arc_length = mesh.flank_arc_length * (RADIUS + 0.5 * HEIGHT) / 30.0
    inner = mesh.fixed_nodes
    cuts = {"left_nodes": inner[0], "right_nodes": inner[-1]}
    free = replace(
        mesh,
        nodes=nodes,
        flank_arc_length=arc_length,
        fixed_nodes=np.empty(0, dtype=np.int64),
        bore_edges=np.stack([inner[:-2:2], inner[2::2], inner[1::2]], axis=1),
        **{name: np.append(getattr(mesh, name), node) for name, node in cuts.items()},
    )
    span = (0.0, float(np.nanmax(arc_length)))
    body = replace(gear_body(TEETH, 2.0), mesh=free, mode_range_mm=span, material=STEEL)
    return flank_compliance(body, JobOptions(n_modes=3, plane="stress", rim=True))


@pytest.mark.parametrize("n", [2, 3, 4])
def test_thin_free_ring_under_equal_radial_forces(ring, n):
    """w of n radial forces: bending about the angle pi/n between them, and the hoop force."""
    a, modulus = pi / n, STEEL.young_modulus_MPa
    bending = RADIUS**3 / (4 * modulus * HEIGHT**3 / 12 * a) * ((a / sin(a)) ** 2 + a / tan(a) - 2)
    hoop = n * RADIUS / (2 * pi * modulus * HEIGHT)
    moved = ring.rim.by_forces[:: TEETH // n, 0, 0].sum()
    assert moved == pytest.approx(bending + hoop, rel=THIN)


def test_bolts_carry_all_and_equal_ones_by_the_mean_of_the_rim(ring):
    """Equal bolts behind all teeth: their mean displacement is the force over all stiffnesses."""
    stiffness = 5.0
    held = on_bolts(ring, Bolts(TEETH, (stiffness, stiffness)))
    orbit = held.rim_motion.body.reshape(2, TEETH, -1)
    turns = 2 * pi / TEETH * np.arange(TEETH)
    x, y, _ = ring.rim.modes
    along = np.cos(turns)[:, None] * x - np.sin(turns)[:, None] * y
    expected = along / (TEETH * stiffness)
    np.testing.assert_allclose(orbit[0], expected, atol=1e-9 * np.abs(expected).max())


def test_few_bolts_turn_with_their_spacing(ring):
    """Six bolts on 120 teeth repeat every 20 teeth, with reciprocity; stiff ones hold more."""
    soft, stiff = (on_bolts(ring, Bolts(6, (k, k))) for k in (1.0, 1e6))
    blocks = soft.smooth.reshape(TEETH, TEETH, *soft.smooth.shape[1:])
    scale = np.abs(blocks).max()
    turned = np.roll(blocks, (20, 20), axis=(0, 1))
    np.testing.assert_allclose(turned, blocks, atol=1e4 * ROUND_OFF * scale)
    np.testing.assert_allclose(blocks.transpose(1, 0, 3, 2), blocks, atol=1e4 * ROUND_OFF * scale)
    own = [held.smooth[held.own_blocks][:, 0, 0] for held in (stiff, soft)]
    assert (own[0] < own[1]).all()
    assert np.ptp(own[0]) > 0.1 * own[0].min()
