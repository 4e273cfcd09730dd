"""Records for the core: of a body (`flankload_pack_body`) and of a mesh (`flankload_pack_mesh`)."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from flankload import _core
from flankload.bodies.flank_surface import section_curves
from flankload.contact.conforming import conforming_height
from flankload.contact.status import checked

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from flankload.base.arrays import Floats
    from flankload.bodies.body import Body
    from flankload.contact.flank_contact import FlankContact, Level
    from flankload.elasticity.compliance import BodyCompliance
    from flankload.elasticity.compliance.contributions import AxialModes
    from flankload.flank import FlankCurve
    from flankload.pairing.gear_mesh import GearMesh
    from flankload.pairing.pairing import Pairing
    from flankload.pairing.slices import Slices
    from flankload.scene.discretization import Grid

    Part = tuple[str, NDArray[np.float64]]

#: Parts of `flankload_pack_part` in the order of their numbers, from 1.
PARTS = (
    "tip",
    "wedge",
    "nodes",
    "tangential",
    "jump",
    "along",
    "shift",
    "sides",
    "friction",
    "axial",
    "slices",
    "turned",
    "wedge_along",
    "shaft",
    "sections",
    "height",
    "members",
    "support",
    "carrier",
    "tilt",
)
#: Value of the core for a curve end that is a cut, where contact cannot begin.
CUT_CORNER = 2


#: Contact models and their numbers in the core.
LEVELS: dict[Level, int] = {"pairs": 0, "lumped": 1}


def records_of(contact: FlankContact) -> tuple[NDArray[np.float64], ...]:
    """Records (n,) of the mesh and of both bodies for the sweep of the core.

    Raises
    ------
    InputError
        If the core refuses an argument.
    """
    return _mesh_record(contact), _body_record(contact, 0), _body_record(contact, 1)


def _mesh_record(contact: FlankContact) -> NDArray[np.float64]:
    """Record of the mesh."""
    axial = _axial_modes(contact, 0)
    arguments = (
        core_sites(contact.mesh),
        _axes(contact.mesh.pairing.center_distance_mm),
        0.0 if axial is None else axial.twist,
        _settings(contact.grid, contact.level, contact.finite_steps),
    )
    return _packed(_core.flankload_pack_mesh, arguments, _mesh_parts(contact))


def _axial_modes(contact: FlankContact, z: int) -> AxialModes | None:
    """Modes of body z along the axis; None in the plane, also for a section of a wide body."""
    return None if contact.mesh.slices.plane else contact.compliances[z].modes.axial


def packed_mesh(
    mesh: GearMesh, grid: Grid, level: Level, twist_rad_per_mm: float = 0.0
) -> NDArray[np.float64]:
    """Record of a mesh without friction and coast flanks; the twist is that of its body 1."""
    axes = _axes(mesh.pairing.center_distance_mm)
    arguments = (core_sites(mesh), axes, twist_rad_per_mm, _settings(grid, level))
    parts = [] if mesh.slices.plane else [("slices", mesh.slices.edges_mm)]
    return _packed(_core.flankload_pack_mesh, arguments, parts)


def packed_body(
    body: Body,
    compliance: BodyCompliance,
    *,
    angles_rad: NDArray[np.float64],
    deviations_mm: NDArray[np.float64],
    block: NDArray[np.int64],
    slices: Slices,
    which: int,
) -> NDArray[np.float64]:
    """Record of a body in several meshes, with its sites mesh after mesh.

    Parameters
    ----------
    angles_rad, deviations_mm : (S,) arrays
        Angle of the flank at each site in the frame of the body, and excess of its material.
    block : (S, S) array
        Blocks of the compliance, from 0.
    slices : Slices
        Slices of a mesh; the surface of the flanks in them is that in all meshes.
    which : int
        Number of the body in that mesh, from 0.
    """
    compliance = _of_width(compliance, slices.compliance_width_mm)
    parts = _compliance_parts(compliance, np.zeros(0, dtype=np.int64))
    axial = None if slices.plane else compliance.modes.axial
    if axial is not None:
        parts += _axial_parts(body, axial, coast=compliance.coast is not None)
    sections = _sections(body, slices, which)
    parts += _section_parts(sections)
    curve = sections[0] if sections else _active(body, body.curve)
    arguments = _arguments(body, compliance, curve, angles_rad, deviations_mm, block)
    return _packed(_core.flankload_pack_body, arguments, parts)


def _axes(center_distance_mm: float) -> NDArray[np.float64]:
    """(2, 2) Axes of both bodies in the frame of the mesh."""
    return np.array([[0.0, center_distance_mm], [0.0, 0.0]], order="F")


def _settings(grid: Grid, level: Level, finite_steps: int = 0) -> NDArray[np.float64]:
    """Settings of the record of a mesh."""
    return np.array(
        [
            *(grid.strips_per_half_width, grid.corner_strips_per_half_width),
            *(grid.zone_half_widths, LEVELS[level], finite_steps),
        ],
        float,
    )


def core_sites(mesh: GearMesh) -> int:
    """Number of sites of the core: pairs of flanks, coast flanks, slices."""
    sites = mesh.pairing.sites.size * (1 if mesh.pairing.coast is None else 2)
    return sites * mesh.slices.count


def _body_record(contact: FlankContact, z: int) -> NDArray[np.float64]:
    """Record of body z."""
    mesh, body = contact.mesh, contact.mesh.bodies[z]
    coast = mesh.pairing.coast is not None
    compliance = _of_width(contact.compliances[z], mesh.slices.compliance_width_mm)
    sections = _sections(body, mesh.slices, z)
    parts = _compliance_parts(compliance, mesh.pairing.teeth_of(z))
    if mesh.friction is not None or contact.finite_steps > 0:
        parts += _tangential_parts(compliance, coast=coast)
    axial = _axial_modes(contact, z)
    if axial is not None:
        parts += _axial_parts(body, axial, coast=coast)
    parts += _section_parts(sections)
    curve = sections[0] if sections else _active(body, body.curve)
    arguments = _main_arguments(mesh, compliance, z, curve)
    return _packed(_core.flankload_pack_body, arguments, parts)


def _of_width(compliance: BodyCompliance, face_width_mm: float) -> BodyCompliance:
    """Compliance in mm/N instead of mm²/N: the only division by the width."""
    near = replace(
        compliance.near,
        kernel=compliance.near.kernel / face_width_mm,
        jump=compliance.near.jump / face_width_mm,
    )
    return replace(compliance.with_blocks(lambda part: part / face_width_mm), near=near)


def _main_arguments(
    mesh: GearMesh, compliance: BodyCompliance, z: int, curve: FlankCurve
) -> tuple[NDArray[np.float64] | NDArray[np.intc] | float, ...]:
    """Arguments of `flankload_pack_body` up to the record."""
    body, pairing, slices = mesh.bodies[z], mesh.pairing, mesh.slices
    angles, deviations = _at_sites(pairing, slices, z)
    block = slices.site_blocks(
        compliance.blocks_of_sites(pairing.teeth_of(z), pairing.sites.size, body.teeth)
    )
    return _arguments(body, compliance, curve, angles, deviations, block)


def _arguments(
    body: Body,
    compliance: BodyCompliance,
    curve: FlankCurve,
    angles_rad: NDArray[np.float64],
    deviations_mm: NDArray[np.float64],
    block: NDArray[np.int64],
) -> tuple[NDArray[np.float64] | NDArray[np.intc] | float, ...]:
    """Arguments of `flankload_pack_body` for sites with blocks of the compliance, from 0."""
    corners = curve.corners.astype(np.intc)
    if body.active_range_mm is not None:
        corners[[0, -1]] = CUT_CORNER
    return (
        curve.breaks,
        _powers_first(curve),
        corners,
        angles_rad,
        deviations_mm,
        np.array(compliance.modes.range_mm, dtype=float),
        compliance.near.kernel,
        np.asfortranarray(compliance.all_blocks()[0].transpose(1, 2, 0)),
        np.asfortranarray(block + 1, dtype=np.intc),
    )


def _at_sites(pairing: Pairing, slices: Slices, z: int) -> tuple[Floats, Floats]:
    """Angles (n,) and deviations (n,) of body z at the sites of the core, working flanks first.

    Deviations of single teeth apply to working flanks only.
    """
    angles = slices.site_angles(pairing.site_angles_rad[z], z)
    of_teeth = slices.tooth_deviations(pairing.sites, z)
    of_teeth = pairing.site_deviations_mm[z][:, np.newaxis] + of_teeth
    deviations = slices.site_deviations(of_teeth, z)
    if pairing.coast is None:
        return angles, deviations
    of_coast = pairing.coast.site_angles_rad[z]
    none = slices.site_deviations(np.zeros_like(of_coast), z, coast=True)
    of_coast = slices.site_angles(of_coast, z, coast=True)
    return np.concatenate([angles, of_coast]), np.concatenate([deviations, none])


def _sections(body: Body, slices: Slices, z: int) -> list[FlankCurve]:
    """Flanks of body z in all slices, if they differ; otherwise empty."""
    removed = slices.surfaces_mm[z]
    if removed is None:
        return []
    return [_active(body, curve) for curve in section_curves(body, removed)]


def _section_parts(sections: list[FlankCurve]) -> list[Part]:
    """Part of a body whose flanks differ between slices."""
    if not sections:
        return []
    flanks = [_powers_first(curve).ravel(order="F") for curve in sections]
    return [("sections", np.concatenate(flanks))]


def _active(body: Body, curve: FlankCurve) -> FlankCurve:
    """The part of a flank on which contact is possible."""
    return curve if body.active_range_mm is None else curve.cut(*body.active_range_mm)


def _powers_first(curve: FlankCurve) -> NDArray[np.float64]:
    """Coefficients in the order of the core: (power, x or y, interval)."""
    return np.asfortranarray(curve.coefficients.transpose(2, 1, 0))


def _compliance_parts(compliance: BodyCompliance, teeth: NDArray[np.int64]) -> list[Part]:
    """Parts of a compliance under normal loads, if present."""
    modes, near = compliance.modes, compliance.near
    values_of = {
        "tip": modes.tip,
        "wedge": near.wedge if any(near.wedge) else None,
        "wedge_along": near.wedge_along if any(near.wedge_along) else None,
        "turned": compliance.turned_blocks(),
        "nodes": modes.nodes,
        "shift": compliance.shift_of(teeth) if compliance.expansion.shifts else None,
    }
    return [
        (name, np.asarray(values, dtype=float).ravel())
        for name, values in values_of.items()
        if values is not None
    ]


def _axial_parts(body: Body, axial: AxialModes, *, coast: bool) -> list[Part]:
    """Parts of a three-dimensional body: axial modes, shaft."""
    # where a working flank leans out of an end face, the coast flank leans inwards
    of_coast = axial.end[::-1] if coast else ()
    numbers = [axial.count, *axial.range_mm, axial.twist, *axial.end, *of_coast]
    parts = [("axial", np.array(numbers, dtype=float))]
    shaft = body.axial.shaft
    # a flexible shaft is part of the elements, except in a rigid body
    if shaft is not None and (shaft.flexible is None or body.rigid):
        parts.append(("shaft", np.append(shaft.compliance.ravel(), shaft.z_mm)))
    return parts


def _tangential_parts(compliance: BodyCompliance, *, coast: bool) -> list[Part]:
    """Parts of a compliance under tangential loads; empty for a rigid body."""
    parts: list[Part] = []
    blocks = {"tangential": compliance.all_blocks()[1]}
    if not coast:  # for finite forces, which exclude coast flanks
        blocks["along"] = compliance.along
    for name, values in blocks.items():
        if values is not None:
            parts.append((name, values.transpose(1, 2, 0).ravel(order="F")))
    if compliance.near.jump:
        parts.append(("jump", np.array([compliance.near.jump])))
    return parts


def _mesh_parts(contact: FlankContact) -> list[Part]:
    """Parts of a mesh: sides of the sites, friction, slices."""
    pairing, friction, slices = contact.mesh.pairing, contact.mesh.friction, contact.mesh.slices
    count = slices.count
    parts: list[Part] = [] if slices.plane else [("slices", slices.edges_mm)]
    if slices.conforming is not None:
        parts.append(("height", conforming_height(contact.mesh, contact.compliances)))
    if pairing.coast is not None:
        parts.append(("sides", np.repeat([1.0, -1.0], pairing.sites.size * count)))
    if friction is not None:
        coefficients = friction.coefficients
        if pairing.coast is not None:  # as on the working flanks
            coefficients = np.hstack([coefficients, coefficients])
        # equal in all slices of a flank
        table = np.column_stack([friction.places_mm, np.repeat(coefficients, count, axis=1)])
        parts.append(("friction", table.ravel(order="F")))
    return parts


def _packed(
    pack: Callable[..., int],
    arguments: tuple[NDArray[np.float64] | NDArray[np.intc] | float, ...],
    parts: list[Part],
) -> NDArray[np.float64]:
    """Record begun by a procedure of the core, and its parts."""
    record = np.empty(checked(pack(*arguments, np.empty(0))))
    checked(pack(*arguments, record))
    return packed_parts(record, parts)


def packed_parts(record: NDArray[np.float64], parts: list[Part]) -> NDArray[np.float64]:
    """Record of a body or mesh with more parts, by their names in `PARTS`.

    Raises
    ------
    InputError
        If the core refuses a part.
    """
    longer = np.empty(record.size + sum(values.size for _, values in parts))
    longer[: record.size] = record
    for name, values in parts:
        checked(_core.flankload_pack_part(PARTS.index(name) + 1, values, longer))
    return longer
