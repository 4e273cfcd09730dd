"""Compliance of a body from a compliance file, converted to pressure modes or tables."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flankload.bodies.flank_elements import gauss_places
from flankload.bodies.free_corner import along_strengths, image_strengths
from flankload.bodies.imported.compliance import ModalCompliance, NodalCompliance
from flankload.elasticity.axial_basis import mode_norms_z
from flankload.elasticity.compliance import BodyCompliance, FlankModes, NearField
from flankload.elasticity.compliance.plane_extent import PlaneExtent
from flankload.elasticity.job_log import JobCost
from flankload.elasticity.near_field import (
    logarithm_strength,
    mode_norms,
    mode_values,
    projected_near_field,
)
from flankload.elasticity.nodal_loads import linear_shapes, shape_widths
from flankload.elasticity.sector_closure import made_symmetric
from flankload.errors import ComplianceFileError

if TYPE_CHECKING:
    from collections.abc import Callable

    from flankload.base.arrays import Floats
    from flankload.bodies.body import Body
    from flankload.elasticity.prism import Prism

#: Largest difference between a response and its transpose, relative to the largest response.
LARGEST_ASYMMETRY = 1e-6


def imported_compliance(
    body: Body,
    *,
    modes: int | None,
    default_modes: int,
    plane: str,
    tangential: str | None = None,
    turns: bool = False,
    nodal: bool = False,
) -> BodyCompliance:
    """Compliance of a body from its compliance file, `body.imported`.

    Parameters
    ----------
    modes : int or None
        Number of pressure modes of the scene; at most that of a file with modes.
    default_modes : int
        Default number for a matrix between nodes, limited by the number of nodes; the default for a
        file with modes is their number.
    plane : {"strain", "stress"}
        Plane state of the scene, which must be that of the file.
    tangential : str, optional
        Key of the scene that requires the response to tangential loads.
    turns : bool
        Whether forces turn over sharp tips, if the file has a response along the flank.
    nodal : bool
        Tables between the nodes of the file instead of pressure modes.

    Raises
    ------
    ComplianceFileError
        If the plane state differs, the compliance is not symmetric and positive definite, or the
        response to tangential loads is required but missing.
    """
    imported = body.imported
    assert imported is not None
    if imported.plane != plane:
        raise ComplianceFileError(
            file=imported.file,
            key="plane",
            expected=f"'{plane}', as in accuracy.plane",
            found=f"'{imported.plane}'",
        )
    if tangential and imported.tangential is None:
        modal = isinstance(imported, ModalCompliance)
        raise ComplianceFileError(
            file=imported.file,
            key="smooth_nt" if modal else "format",
            expected=f"the response to loads along the flank, since the scene has {tangential}: "
            "as flankload compliance writes it for a scene with friction",
            found="nothing" if modal else "a matrix of normal displacements and forces alone",
        )
    if isinstance(imported, ModalCompliance):
        return _of_modes(
            body,
            imported,
            modes or imported.smooth.shape[1],
            friction=bool(tangential),
            turns=turns,
        )
    if nodal:
        return _tables(body, imported, plane)
    enough = max(2, min(default_modes, imported.flank_elements // 2 + 1))
    return _of_nodes(body, imported, modes or enough, plane)


def _of_modes(
    body: Body, imported: ModalCompliance, n_modes: int, *, friction: bool, turns: bool
) -> BodyCompliance:
    """Compliance from modes, checked for symmetry and positive definiteness."""
    smooth, f = imported.smooth, len(imported.flanks)
    own = np.arange(f) * (f + 1) if f else np.zeros(1, dtype=np.int64)
    across = np.arange(f * f).reshape(f, f).T.ravel() if f else -np.arange(len(smooth))
    symmetric, asymmetry = made_symmetric(smooth, across)
    if asymmetry > LARGEST_ASYMMETRY:
        raise ComplianceFileError(
            file=imported.file,
            key="smooth",
            expected=f"smooth[{'j f + i' if f else '-t'}] to be smooth[{'i f + j' if f else 't'}] "
            f"transposed (reciprocity), to {LARGEST_ASYMMETRY:g} of the largest entry",
            found=f"{asymmetry:.3g}",
        )
    near = NearField(
        imported.kernel,
        jump=imported.jump if friction or turns else 0.0,
        wedge=image_strengths(body),
        wedge_along=along_strengths(body),
    )
    n, extent = smooth.shape[1] // imported.modes_per_place, _extent(body, imported)
    parts = extent.near_products(body, near, n, friction=False)
    over_width = mode_norms_z(extent.axial.width_mm, extent.load_degree)
    products = np.kron(parts.modes, np.diag(over_width))
    whole = products @ smooth @ products
    whole[own] += parts.normal
    least = _least_eigenvalue(whole, f)
    if not least > 0.0:
        raise ComplianceFileError(
            file=imported.file,
            key="smooth",
            expected="a compliance that is positive definite together with its kernel, since any "
            "load does positive work",
            found=f"an eigenvalue of {least:.3g}",
        )
    found = BodyCompliance(
        smooth=symmetric,
        near=near,
        modes=FlankModes(body.mode_range_mm, tip=imported.tip, axial=parts.axial),
        flanks=imported.flanks,
        tangential=imported.tangential if friction or turns else None,
        job=JobCost(max(imported.asymmetry, asymmetry)),
    )
    spare = found.flank_modes - n_modes
    return found.fewer_modes(spare) if spare > 0 else found


def _extent(body: Body, imported: ModalCompliance) -> PlaneExtent | Prism:
    """Extent along the axis of the body of a file."""
    if imported.axial_degree is None:
        return PlaneExtent(imported.plane)
    from flankload.elasticity.prism import Prism

    shape, degree = body.axial, imported.axial_degree
    return Prism(shape.range_mm, shape.twist_rad_per_mm, degree, degree)


def _least_eigenvalue(whole: Floats, flanks: int) -> float:
    """Least eigenvalue of the matrix of all flanks, from blocks by tooth or by pair of flanks."""
    if flanks:
        p = whole.shape[1]
        matrix = whole.reshape(flanks, flanks, p, p).transpose(0, 2, 1, 3)
        return float(np.linalg.eigvalsh(matrix.reshape(flanks * p, -1)).min())
    # a Fourier transform over the equal teeth decouples the block-circulant matrix
    waves = np.fft.fft(whole, axis=0)
    return float(np.linalg.eigvalsh(0.5 * (waves + waves.conj().transpose(0, 2, 1))).min())


def _of_nodes(body: Body, imported: NodalCompliance, n_modes: int, plane: str) -> BodyCompliance:
    """Compliance from a matrix between nodes, projected on pressure modes without the near field.

    With the consistent nodal forces B_qa = integral of N_q P_a ds of the modes, the response is
    B' C B, with their nodal pressures P' M C P; without the logarithm and as coefficients,
    D^-1 (B' C B - <P, K P>) D^-1.
    """
    if imported.of_pressures:
        loads = mode_values(imported.arc_length_mm, body.mode_range_mm, n_modes)
    else:
        loads = nodal_mode_forces(imported, body.mode_range_mm, n_modes)
    response = _responses(body, imported, loads)
    low, high = body.mode_range_mm
    strength = logarithm_strength(body.material, plane)
    wedge = image_strengths(body)
    response[0] += strength * projected_near_field(n_modes, high - low, wedge=wedge)
    norms = mode_norms(body.mode_range_mm, n_modes)
    return BodyCompliance(
        smooth=response / (norms[:, None] * norms[None, :]),
        near=NearField(strength, wedge=wedge),
        modes=FlankModes(body.mode_range_mm),
        job=JobCost(imported.asymmetry),
    )


def _responses(body: Body, imported: NodalCompliance, loads: Floats) -> Floats:
    """Response (z, p, p) of all teeth to p loads on tooth 0, with readings by the same loads."""
    response = np.zeros((body.teeth, loads.shape[1], loads.shape[1]))
    for offset, block in zip(imported.offsets.tolist(), imported.matrix, strict=True):
        response[offset] = loads.T @ block @ loads
        if -offset % body.teeth not in imported.offsets:
            response[-offset % body.teeth] = response[offset].T
    return response


def _tables(body: Body, imported: NodalCompliance, plane: str) -> BodyCompliance:
    """Compliance as tables between nodes; for quadratic elements, ends of edges (`nodal_loads`)."""
    nodes = imported.arc_length_mm[:: 2 if imported.quadratic else 1]

    def pressures(s: Floats) -> Floats:
        return linear_shapes(s, nodes) / shape_widths(nodes)

    if imported.of_pressures:
        loads = pressures(imported.arc_length_mm)
    else:
        loads = consistent_forces(imported, pressures)
    return BodyCompliance(
        smooth=_responses(body, imported, loads),
        near=NearField(logarithm_strength(body.material, plane)),
        modes=FlankModes(body.mode_range_mm, nodes=nodes),
        job=JobCost(imported.asymmetry),
    )


def nodal_mode_forces(
    imported: NodalCompliance, mode_range_mm: tuple[float, float], n_modes: int
) -> Floats:
    """Consistent normal nodal forces (n, n_modes) of the pressure modes, mm."""
    return consistent_forces(imported, lambda s: mode_values(s, mode_range_mm, n_modes))


def consistent_forces(imported: NodalCompliance, pressures: Callable[[Floats], Floats]) -> Floats:
    """Consistent normal nodal forces (n, p) of p pressures over the arc length."""
    places, weights, shapes = gauss_places(imported.arc_length_mm, quadratic=imported.quadratic)
    return np.asarray(shapes.T @ (weights[:, None] * pressures(places)))
