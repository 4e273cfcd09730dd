"""Section matrices: plane strain as their limit, rigid motions, a bar under tension."""

from __future__ import annotations

import numpy as np
import pytest

from flankload.elasticity.axial_basis import AxialBasis
from flankload.elasticity.finite_elements import section_stiffness
from tests.support.plain_prism import whole_stiffness
from tests.support.plane_sectors import STEEL, ring_sector
from tests.support.plane_stiffness import plane_stiffness
from tests.support.tolerances import ROUND_OFF, SOLVER

AXIAL = AxialBasis((-2.0, 5.0), 3)
MESH, _ = ring_sector(6, rows=2, columns=3)


def _motion(*parts: tuple[int, int, np.ndarray | float]) -> np.ndarray:
    """A displacement of all nodes: (component, degree in z, values at the nodes)."""
    moved = np.zeros((len(MESH.nodes), AXIAL.count, 3))
    for component, degree, values in parts:
        # the coefficients of z^degree
        z = np.linspace(*AXIAL.range_mm, 40)
        along = np.linalg.lstsq(AXIAL.values(z), z**degree, rcond=None)[0]
        moved[:, :, component] += np.asarray(values)[..., None] * along
    return moved.ravel()


def _matrix(twist: float):
    return whole_stiffness(section_stiffness(MESH.nodes, MESH.cells, STEEL, twist), AXIAL)


def test_without_axial_motion_it_is_plane_strain() -> None:
    plane = plane_stiffness(MESH.nodes, MESH.cells, STEEL, "strain").toarray()
    straight = section_stiffness(MESH.nodes, MESH.cells, STEEL, 0.0)
    whole = whole_stiffness(straight, AxialBasis((0.0, 1.0), 0)).toarray()
    in_plane = np.flatnonzero(np.arange(3 * len(MESH.nodes)) % 3 < 2)
    np.testing.assert_allclose(
        whole[np.ix_(in_plane, in_plane)], plane, rtol=0, atol=ROUND_OFF * abs(plane).max()
    )


@pytest.mark.parametrize("twist", [0.0, 0.03, -0.03])
def test_matrix_is_symmetric_and_positive(twist: float) -> None:
    matrix = _matrix(twist).toarray()
    np.testing.assert_allclose(matrix, matrix.T, rtol=0, atol=ROUND_OFF * abs(matrix).max())
    assert np.linalg.eigvalsh(matrix).min() > -1e-12 * abs(matrix).max()


def test_rigid_motions_meet_no_resistance() -> None:
    x, y = MESH.nodes.T
    one = np.ones_like(x)
    axial = [_motion((2, 0, one)), _motion((0, 0, -y), (1, 0, x))]
    others = [
        _motion((0, 0, one)),
        _motion((1, 0, one)),
        _motion((1, 1, -one), (2, 0, y)),
        _motion((0, 1, -one), (2, 0, x)),
    ]
    for twist, motions in ((0.0, axial + others), (0.03, axial)):
        matrix = _matrix(twist)
        for motion in motions:
            scale = abs(matrix).max() * np.abs(motion).max()
            assert np.abs(matrix @ motion).max() <= SOLVER * scale


def test_a_translation_across_is_rigid_in_the_turning_frame() -> None:
    """v = (cos kz, -sin kz) has no strain up to polynomial errors; the other sign has."""
    twist = 0.03
    one = np.ones(len(MESH.nodes))

    def energy(sign: float) -> float:
        powers = [
            (1.0, 0.0),
            (0.0, -sign * twist),
            (-0.5 * twist**2, 0.0),
            (0.0, sign * twist**3 / 6),
        ]
        motion = _motion(
            *((c, d, one * part) for d, both in enumerate(powers) for c, part in enumerate(both))
        )
        return float(motion @ (_matrix(twist) @ motion))

    assert energy(1.0) < 1e-4 * energy(-1.0)


@pytest.mark.parametrize("twist", [0.0, 0.03])
def test_a_bar_under_tension_has_its_modulus(twist: float) -> None:
    x, y = MESH.nodes.T
    modulus, ratio = STEEL.young_modulus_MPa, STEEL.poisson_ratio
    stretched = _motion((2, 1, np.ones_like(x)), (0, 0, -ratio * x), (1, 0, -ratio * y))
    # K_QQ of axial shapes is the area times the modulus without lateral strain
    held = modulus * (1 - ratio) / ((1 + ratio) * (1 - 2 * ratio))
    blocks = section_stiffness(MESH.nodes, MESH.cells, STEEL, 0.0).blocks
    area = blocks[:, 3, 2, 2].sum() / held
    energy = stretched @ (_matrix(twist) @ stretched)
    assert energy == pytest.approx(modulus * area * AXIAL.width_mm, rel=SOLVER)
