"""A bore that follows a shaft: the meshed ring on a beam, closed forms, limits, mirrors."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from flankload.bodies.shaft import FlexibleShaft
from flankload.elasticity.axial_basis import AxialBasis
from flankload.elasticity.condensed_sector import CondensedSector
from flankload.elasticity.finite_elements import SectionStiffness, section_stiffness
from flankload.elasticity.fronts.condensation import condense_nodes
from flankload.elasticity.near_field import mode_loads
from flankload.elasticity.prism.flexible_bore import FlexibleBore, beam_stiffness
from flankload.elasticity.sector_closure import close_ring
from tests.support.plain_prism import product_loads, whole_stiffness
from tests.support.plane_sectors import STEEL, ring_sector
from tests.support.tolerances import CLOSURE, SOLVER

E, G = 206000.0, 206000.0 / 2.6
#: Springs of different stiffness in all ways, at both ends.
SPRINGS = ((3e4, 2e5, -4e6, 2e8), (0.0, 3e5, 5e6, 1e8))


def shaft(range_mm: tuple[float, float], radius: float, **changes) -> FlexibleShaft:
    """A solid steel shaft on springs, as thick as the bore."""
    area, moment = np.pi * radius**2, 0.25 * np.pi * radius**4
    return FlexibleShaft(
        **{
            "range_mm": range_mm,
            "radius_mm": radius,
            "inner_radius_mm": 0.0,
            "stiffness": (E * area, E * moment, 0.9 * G * area, 2.0 * G * moment),
            "beyond": SPRINGS,
            "end_radii_mm": (radius, radius),
            "bearings": (),
            "axially_held": True,
            "torque_end": "I",
            **changes,
        }
    )


MESH, SPAN = ring_sector(5, rows=1, columns=4)
AXIAL = AxialBasis((-9.0, 6.0), 3)


def _loads(twist: float) -> np.ndarray:
    in_plane = mode_loads(MESH, SPAN, 2, twist=twist).reshape(-1, 3, 2)
    # aslant, so that there is a torque
    in_plane[:, :2] = np.einsum("cd,ndm->ncm", [[0.8, -0.6], [0.6, 0.8]], in_plane[:, :2])
    in_plane = in_plane.reshape(-1, 2)
    return product_loads(in_plane, AXIAL.load_vectors(1)).reshape(len(MESH.nodes), -1, 4)


def _section(twist: float) -> SectionStiffness:
    section = section_stiffness(MESH.nodes, MESH.cells, STEEL, twist)
    return replace(section, functions=AXIAL, cut_degree=3)


def _bore(twist: float, carrying: FlexibleShaft) -> tuple[FlexibleBore, np.ndarray]:
    return FlexibleBore.of(carrying, _section(twist), MESH), _loads(twist)


def _sector(twist: float, loads: np.ndarray) -> CondensedSector:
    return condense_nodes(_section(twist), MESH, loads)


@cache
def _response(twist: float, carrying: FlexibleShaft | None) -> np.ndarray:
    """(z, p, p) of modes on the ring, its bore held or on a shaft."""
    loads = _loads(twist)
    if carrying is None:
        found = close_ring(_sector(twist, loads), MESH.teeth)
    else:
        bore, _ = _bore(twist, carrying)
        found = bore.close_ring(_sector(twist, np.concatenate([loads, bore.columns], axis=2)))
    mirrored = found[-np.arange(MESH.teeth)].transpose(0, 2, 1)
    np.testing.assert_allclose(found, mirrored, rtol=0, atol=CLOSURE * np.abs(found).max())
    return found


# the ring closure


def _meshed_ring(mesh, axial: AxialBasis, twist: float, bore: FlexibleBore, loads: np.ndarray):
    """Readings (z, p, p) of the loads on tooth 0 by the stiffness of the whole ring, dense."""
    teeth, count = mesh.teeth, len(mesh.nodes)
    turns = []
    for angle in 2 * np.pi * np.arange(teeth) / teeth:
        turn = np.eye(3)
        turn[:2, :2] = [[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]
        turns.append(turn)
    every = np.vstack([mesh.nodes @ turn[:2, :2].T for turn in turns])
    _, number = np.unique(np.round(every, 7), axis=0, return_inverse=True)
    number = number.ravel()
    nodes = np.zeros((number.max() + 1, 2))
    nodes[number] = every
    ((kind, data),) = mesh.cells
    cells = number[np.vstack([data + tooth * count for tooth in range(teeth)])]
    section = section_stiffness(nodes, ((kind, cells),), STEEL, twist)
    stiffness = whole_stiffness(section, axial).toarray()

    def placed(columns: np.ndarray, tooth: int) -> np.ndarray:
        """Columns of a sector on the unknowns of the ring."""
        parts = columns.reshape(count, axial.count, 3, -1)
        whole = np.zeros((len(nodes), axial.count, 3, parts.shape[-1]))
        np.add.at(
            whole,
            number[tooth * count : (tooth + 1) * count],
            np.einsum("xc,nkcm->nkxm", turns[tooth], parts),
        )
        return whole.reshape(-1, parts.shape[-1])

    size = len(bore.stiffness)
    degree = size // 6
    held = np.unique(number[(mesh.fixed_nodes + count * np.arange(teeth)[:, None]).ravel()])
    x, y = (nodes[held] / bore.shaft.radius_mm).T
    motions = np.zeros((held.size, 3, 6))
    motions[:, [0, 1, 2], [0, 1, 2]] = 1.0
    motions[:, 2, 3], motions[:, 2, 4], motions[:, 0, 5], motions[:, 1, 5] = y, -x, -y, x
    at = (held[:, None] * 3 * axial.count + np.arange(3 * axial.count)).ravel()
    free = np.setdiff1d(np.arange(len(stiffness)), at)
    spread = np.zeros((len(stiffness), free.size + size))
    spread[free, np.arange(free.size)] = 1.0
    follows = np.einsum("ncm,kd->nkcdm", motions, np.eye(axial.count, degree))
    spread[at, free.size :] = follows.reshape(at.size, size)
    reduced = spread.T @ stiffness @ spread
    reduced[free.size :, free.size :] += bore.beam
    # the motions of both ends: the beam's, and the mean of the faces
    ends = np.zeros((12, free.size + size))
    for tooth, turn in enumerate(turns):
        both = np.kron(np.eye(4), turn)
        faces = placed(bore.columns[:, :, size:], tooth)
        ends += both @ faces.T @ spread
    values = axial.values(np.array(axial.range_mm))[:, :degree]
    shares = [_shares(bore.shaft, end) for end in (0, 1)]
    ends[:, free.size :] += np.vstack(
        [np.kron(values[end], np.diag(shares[end])) for end in (0, 1)]
    )
    scale = np.repeat([1.0, 1.0 / bore.shaft.radius_mm], 3)
    for end, (axially, force, mixed, moment) in enumerate(bore.shaft.beyond):
        spring = np.diag([force, force, axially, moment, moment, 0.0])
        spring[0, 4] = spring[4, 0] = mixed
        spring[1, 3] = spring[3, 1] = -mixed
        own = ends[6 * end : 6 * end + 6]
        reduced += own.T @ (scale[:, None] * spring * scale) @ own
    side = "I", "II"
    entry = ends[6 * side.index(bore.shaft.torque_end) + 5]
    bordered = np.block([[reduced, entry[:, None]], [entry[None], np.zeros((1, 1))]])
    columns = [spread.T @ placed(loads, tooth) for tooth in range(teeth)]
    moved = np.linalg.solve(bordered, np.vstack([columns[0], np.zeros((1, loads.shape[-1]))]))
    return np.array([column.T @ moved[:-1] for column in columns])


def _shares(shaft: FlexibleShaft, end: int) -> np.ndarray:
    """Part of a solid shaft's forces and moments within the bore."""
    ratio = min(1.0, shaft.radius_mm / shaft.end_radii_mm[end])
    return np.repeat([ratio**2, ratio**4], 3)


@pytest.mark.parametrize(("twist", "torque_end"), [(0.0, "I"), (0.02, "II")])
def test_sectors_close_to_the_meshed_ring_on_its_shaft(twist: float, torque_end: str) -> None:
    """Exact, with a shaft that is thicker than the bore on one side."""
    carrying = shaft((-9.0, 6.0), 10.0, end_radii_mm=(18.0, 10.0), torque_end=torque_end)
    bore, loads = _bore(twist, carrying)
    found = _response(twist, carrying)
    wanted = _meshed_ring(MESH, AXIAL, twist, bore, loads)
    np.testing.assert_allclose(found, wanted, rtol=0, atol=CLOSURE * np.abs(wanted).max())


def test_other_readings_see_the_shaft() -> None:
    """The displacements under two of the loads, read once more as a kind of their own."""
    carrying = shaft((-9.0, 6.0), 10.0)
    bore, loads = _bore(0.02, carrying)
    sector = _sector(0.02, np.concatenate([loads, bore.columns], axis=2))
    (local,), (carried,) = sector.local, sector.carried
    sector = replace(sector, local=(local, local[1:3]), carried=(carried, carried[:, 1:3]))
    found, wanted = bore.close_ring(sector), _response(0.02, carrying)
    accuracy = {"rtol": 0.0, "atol": CLOSURE * np.abs(wanted).max()}
    np.testing.assert_allclose(found[:, :4], wanted, **accuracy)
    np.testing.assert_allclose(found[:, 4:], wanted[:, 1:3], **accuracy)


def test_a_rigid_motion_of_the_face_is_that_of_the_shaft() -> None:
    """The beam's part and the face's part of each motion make 1."""
    mesh, _ = ring_sector(5, rows=4, columns=8, lobe=0.0)
    axial = AxialBasis((0.0, 8.0), 2)
    carrying = shaft((0.0, 8.0), 10.0, end_radii_mm=(19.0, 24.0))
    section = section_stiffness(mesh.nodes, mesh.cells, STEEL, 0.0)
    bore = FlexibleBore.of(carrying, replace(section, functions=axial), mesh)
    size = len(bore.stiffness)
    motions = np.zeros((len(mesh.nodes), 3, 6))
    motions[:, [0, 1, 2], [0, 1, 2]] = 1.0
    x, y = (mesh.nodes / 10.0).T
    motions[:, 2, 3], motions[:, 2, 4], motions[:, 0, 5], motions[:, 1, 5] = y, -x, -y, x
    motions[mesh.fixed_nodes] = 0.0  # these belong to `ends`
    faces = bore.columns[:, :, size:].reshape(len(mesh.nodes), 3, 3, 12)
    for end in (0, 1):
        seen = np.einsum("ncm,nco->mo", faces[:, 0, :, 6 * end :][..., :6], motions)
        seen *= np.sqrt(8.0)
        seen += bore.ends[6 * end :][:6].reshape(6, 3, 6)[:, 0] * np.sqrt(8.0)
        # ring: mean over the directions of the sectors
        whole = 5.0 * np.array([0.5 * (seen[0, 0] + seen[1, 1]), seen[2, 2], seen[5, 5]])
        np.testing.assert_allclose(whole, 1.0, rtol=SOLVER)


# beams in closed form


def _held(stiffness: np.ndarray, rows: np.ndarray, load: np.ndarray) -> np.ndarray:
    """Displacements of a beam under a load, some combinations of its modes held."""
    zero = np.zeros((len(rows), len(rows)))
    bordered = np.block([[stiffness, rows.T], [rows, zero]])
    scale = 1.0 / np.sqrt(np.abs(np.diag(stiffness)).max())
    scales = np.append(np.full(len(stiffness), scale), np.full(len(rows), 1.0 / scale))
    bordered = bordered * np.outer(scales, scales)
    found = scales * np.linalg.solve(bordered, scales * np.append(load, np.zeros(len(rows))))
    return found[: len(stiffness)]


@pytest.mark.parametrize("twist", [0.0, 0.03])
def test_a_cantilever_with_a_force_at_its_end(twist: float) -> None:
    """Bending, shear and extension, in a frame that turns with the helix, too."""
    radius, length, degree = 5.0, 40.0, 9 if twist else 3
    carrying = shaft((0.0, length), radius, beyond=((0.0,) * 4,) * 2)
    basis = AxialBasis((0.0, length), degree)
    stiffness = beam_stiffness(carrying, basis, degree, twist)
    start, end = basis.values(np.array([0.0, length]))
    angle = twist * length
    out, aside = np.array([np.cos(angle), -np.sin(angle)]), np.array([np.sin(angle), np.cos(angle)])
    force = np.array([*out, 2.0, 0.0, 0.0, 3.0 / radius])  # along x in space, N; N mm
    moved = _held(stiffness, np.kron(start, np.eye(6)), np.kron(end, force))
    at_end = moved.reshape(degree + 1, 6).T @ end
    push, bend, shear, turn = carrying.stiffness
    accuracy = {"rtol": 1e-8 if twist else CLOSURE}
    wanted = length**3 / (3.0 * bend) + length / shear
    np.testing.assert_allclose(at_end[:2] @ out, wanted, **accuracy)
    np.testing.assert_allclose(at_end[:2] @ aside, 0.0, atol=1e-8 * wanted)
    slope = length**2 / (2.0 * bend)
    np.testing.assert_allclose(at_end[3:5] @ aside / radius, slope, **accuracy)
    np.testing.assert_allclose(at_end[2], 2.0 * length / push, **accuracy)
    np.testing.assert_allclose(at_end[5] / radius, 3.0 * length / turn, **accuracy)


@pytest.mark.parametrize("twist", [0.0, 0.03, -0.03])
def test_rigid_motions_do_not_strain_a_beam_in_a_frame_that_turns_with_z(twist: float) -> None:
    """A translation along x in space is (cos, -sin)(twist z) in the frame, as in the sections."""
    radius, length, degree = 5.0, 40.0, 11
    carrying = shaft((0.0, length), radius, beyond=((0.0,) * 4,) * 2)
    basis = AxialBasis((0.0, length), degree)
    stiffness = beam_stiffness(carrying, basis, degree, twist)
    z, weights = np.polynomial.legendre.leggauss(30)
    z, weights = 20.0 * (z + 1.0), 20.0 * weights
    along = np.stack([np.cos(twist * z), -np.sin(twist * z)])
    across = np.stack([np.sin(twist * z), np.cos(twist * z)])
    none = np.zeros_like(z)
    moved = [*along, none, none, none, none]
    tilted = [*(-z * across), none, *(radius * along), none]  # about x in space
    turned = [none, none, none, none, none, none + radius]
    for motion in (moved, tilted, turned):
        modes = (np.stack(motion) * weights @ basis.values(z)).T.ravel()
        size = np.abs(stiffness).max() * np.abs(modes).max()
        assert np.abs(stiffness @ modes).max() < 1e-9 * size


def test_an_even_torque_twists_a_wide_bar_by_a_parabola() -> None:
    radius, length, degree = 5.0, 200.0, 4
    carrying = shaft((-100.0, 100.0), radius, beyond=((0.0,) * 4,) * 2)
    basis = AxialBasis((-100.0, 100.0), degree)
    stiffness = beam_stiffness(carrying, basis, degree, 0.0)
    own = slice(5, None, 6)
    start = basis.values(np.array([-100.0]))
    load = np.zeros(degree + 1)
    load[0] = 7.0 / radius * np.sqrt(length)  # 7 N mm per mm
    moved = _held(stiffness[own, own], start, load)
    places = np.linspace(-100.0, 100.0, 9)
    from_end = places + 100.0
    wanted = 7.0 * (from_end * length - 0.5 * from_end**2) / carrying.stiffness[3]
    np.testing.assert_allclose(basis.values(places) @ moved / radius, wanted, atol=1e-12)


# limits and mirrors


@pytest.mark.parametrize("twist", [0.0, 0.02])
def test_a_rigid_shaft_on_rigid_bearings_is_a_held_bore(twist: float) -> None:
    springs = ((1e18, 1e18, 0.0, 1e20),) * 2
    stiff = shaft((-9.0, 6.0), 10.0, stiffness=(1e20, 1e22, 1e20, 1e22), beyond=springs)
    wanted = _response(twist, None)
    np.testing.assert_allclose(
        _response(twist, stiff), wanted, rtol=0, atol=1e-8 * np.abs(wanted).max()
    )
    # a shaft of steel is not
    steel = shaft((-9.0, 6.0), 10.0)
    assert np.abs(_response(twist, steel) - wanted).max() > 0.1 * np.abs(wanted).max()


def test_a_mirrored_shaft_with_the_other_hand() -> None:
    """z -> -z about the middle of the ring: ends change places, modes of odd degree their sign."""
    one = shaft((-9.0, 6.0), 10.0, end_radii_mm=(18.0, 10.0), bearings=((2.0, 1e5, 2e4, 1e8),))
    (axial, force, mixed, moment), other = one.beyond
    mirrored = replace(
        one,
        beyond=((other[0], other[1], -other[2], other[3]), (axial, force, -mixed, moment)),
        end_radii_mm=one.end_radii_mm[::-1],
        bearings=((-5.0, 1e5, 2e4, 1e8),),
        torque_end="II",
    )
    sign = np.tile([1.0, -1.0], 2)
    found, wanted = _response(-0.02, mirrored), _response(0.02, one) * np.outer(sign, sign)
    np.testing.assert_allclose(found, wanted, rtol=0, atol=CLOSURE * np.abs(wanted).max())


def test_a_torque_that_enters_evenly_moves_the_teeth_less() -> None:
    """The mean rotation is held in place of that of one end."""
    ends = [_response(0.0, shaft((-9.0, 6.0), 10.0, torque_end=end)) for end in ("I", "II", "even")]
    one, two, even = (smooth[0, 0, 0] for smooth in ends)
    assert even < 0.99 * min(one, two)
    # mean and slope: rotation grows away from the end where the torque enters
    slopes = [smooth[0, 0, 1] for smooth in ends]
    assert slopes[1] < slopes[2] < slopes[0]


def test_a_shaft_without_axial_bearings_stays_where_it_is() -> None:
    """A spur gear has no axial force: the answer is that with axial bearings."""
    free = shaft((-9.0, 6.0), 10.0, axially_held=False, beyond=((0.0, *SPRINGS[0][1:]), SPRINGS[1]))
    wanted = _response(0.0, replace(free, axially_held=True, beyond=(SPRINGS[0], SPRINGS[1])))
    found = _response(0.0, free)
    np.testing.assert_allclose(found[:, :, 0], wanted[:, :, 0], rtol=0, atol=1e-6 * wanted.max())
