"""Records for the core: of a body (`flankload_pack_body`) and of a mesh (`flankload_pack_mesh`)."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from flankload import _core
from flankload.bodies.flank_surface import section_curves
from flankload.contact.conforming import conforming_height, expansion_at_slices
from flankload.contact.status import checked
from flankload.elasticity.compliance.contributions import Expansion

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

    Compliances = tuple[BodyCompliance, BodyCompliance]
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
    mesh = packed_mesh(
        contact.mesh, contact.grid, contact.level, contact.finite_steps, contact.compliances
    )
    return mesh, _record_of_pair(contact, 0), _record_of_pair(contact, 1)


def packed_mesh(
    mesh: GearMesh,
    grid: Grid,
    level: Level,
    finite_steps: int = 0,
    compliances: Compliances | None = None,
) -> NDArray[np.float64]:
    """Record of a mesh; `compliances` of its bodies if their flanks conform."""
    pairing, friction, slices = mesh.pairing, mesh.friction, mesh.slices
    count, twist = slices.count, 0.0
    parts: list[Part] = []
    if not slices.plane:
        twist = mesh.body_1.axial.twist_rad_per_mm
        parts.append(("slices", slices.edges_mm))
    if slices.conforming is not None and compliances is not None:
        parts.append(("height", conforming_height(mesh, compliances)))
    if pairing.coast is not None:
        parts.append(("sides", np.repeat([1.0, -1.0], pairing.sites.size * count)))
    if friction is not None:
        coefficients = friction.coefficients
        if pairing.coast is not None:  # as on the working flanks
            coefficients = np.hstack([coefficients, coefficients])
        # equal in all slices of a flank
        table = np.column_stack([friction.places_mm, np.repeat(coefficients, count, axis=1)])
        parts.append(("friction", table.ravel(order="F")))
    axes = np.array([[0.0, pairing.center_distance_mm], [0.0, 0.0]], order="F")
    settings = np.array(
        [
            *(grid.strips_per_half_width, grid.corner_strips_per_half_width),
            *(grid.zone_half_widths, LEVELS[level], finite_steps),
        ],
        float,
    )
    return _packed(_core.flankload_pack_mesh, (core_sites(mesh), axes, twist, settings), parts)


def packed_body(
    body: Body,
    compliance: BodyCompliance,
    *,
    angles_rad: NDArray[np.float64],
    deviations_mm: NDArray[np.float64],
    block: NDArray[np.int64],
    teeth: NDArray[np.int64],
    n_working: int,
    slices: Slices,
    which: int,
    coast: bool,
    tangential: bool = False,
) -> NDArray[np.float64]:
    """Record of a body in one or more meshes, with its sites mesh after mesh.

    Parameters
    ----------
    angles_rad, deviations_mm : (S,) arrays
        Angle of the flank at each site in the frame of the body, and excess of its material.
    block : (S, S) array
        Blocks of the compliance, from 0.
    teeth : (n,) array
        Tooth of each flank, `n_working` working ones first.
    slices : Slices
        Slices of a mesh; the surface of the flanks in them is that in all meshes.
    which : int
        Number of the body in that mesh, from 0.
    coast, tangential : bool
        Whether coast flanks touch, and whether tangential forces act.
    """
    compliance = _of_width(compliance, slices.compliance_width_mm)
    # equal in all slices of a flank
    shifts = compliance.shift_of(teeth, n_working).repeat(slices.count, axis=0)
    parts = _compliance_parts(compliance, shifts)
    if tangential:
        parts += _tangential_parts(compliance, coast=coast)
    if not slices.plane:
        parts += _axial_parts(body, compliance.modes.axial, coast=coast)
    removed = slices.surfaces_mm[which]
    curves = [body.curve] if removed is None else section_curves(body, removed)
    if body.active_range_mm is not None:
        curves = [curve.cut(*body.active_range_mm) for curve in curves]
    if removed is not None:
        flanks = [_powers_first(curve).ravel(order="F") for curve in curves]
        parts.append(("sections", np.concatenate(flanks)))
    curve = curves[0]
    corners = curve.corners.astype(np.intc)
    if body.active_range_mm is not None:
        corners[[0, -1]] = CUT_CORNER
    arguments = (
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
    return _packed(_core.flankload_pack_body, arguments, parts)


def core_sites(mesh: GearMesh) -> int:
    """Number of sites of the core: pairs of flanks, coast flanks, slices."""
    sites = mesh.pairing.sites.size * (1 if mesh.pairing.coast is None else 2)
    return sites * mesh.slices.count


def _record_of_pair(contact: FlankContact, z: int) -> NDArray[np.float64]:
    """Record of body z of a pair."""
    mesh, body, compliance = contact.mesh, contact.mesh.bodies[z], contact.compliances[z]
    pairing, slices = mesh.pairing, mesh.slices
    angles, deviations = at_sites(pairing, slices, z)
    if slices.conforming is not None and compliance.expansion.shifts:
        deviations = deviations + expansion_at_slices(mesh, contact.compliances, z)
        compliance = replace(compliance, expansion=Expansion())
    teeth = pairing.teeth_of(z)
    block = compliance.blocks_of_sites(teeth, pairing.sites.size, body.teeth)
    return packed_body(
        body,
        compliance,
        angles_rad=angles,
        deviations_mm=deviations,
        block=block.repeat(slices.count, axis=0).repeat(slices.count, axis=1),
        teeth=teeth,
        n_working=pairing.sites.size,
        slices=slices,
        which=z,
        coast=pairing.coast is not None,
        tangential=mesh.friction is not None or contact.finite_steps > 0,
    )


def _of_width(compliance: BodyCompliance, face_width_mm: float) -> BodyCompliance:
    """Compliance in mm/N instead of mm²/N: the only division by the width."""
    near = replace(
        compliance.near,
        kernel=compliance.near.kernel / face_width_mm,
        jump=compliance.near.jump / face_width_mm,
    )
    return replace(compliance.with_blocks(lambda part: part / face_width_mm), near=near)


def at_sites(
    pairing: Pairing, slices: Slices, z: int, excess_mm: float = 0.0
) -> tuple[Floats, Floats]:
    """Angles (n,) and deviations (n,) of body z at the sites of the core, working flanks first.

    Deviations of single teeth, and the excess of all of them, apply to working flanks only.
    """
    angles = slices.site_angles(pairing.site_angles_rad[z], z)
    of_teeth = slices.tooth_deviations(pairing.sites, z)
    of_teeth = pairing.site_deviations_mm[z][:, np.newaxis] + excess_mm + of_teeth
    deviations = slices.site_deviations(of_teeth, z)
    if pairing.coast is None:
        return angles, deviations
    of_coast = pairing.coast.site_angles_rad[z]
    none = slices.site_deviations(np.zeros_like(of_coast), z, coast=True)
    of_coast = slices.site_angles(of_coast, z, coast=True)
    return np.concatenate([angles, of_coast]), np.concatenate([deviations, none])


def _powers_first(curve: FlankCurve) -> NDArray[np.float64]:
    """Coefficients in the order of the core: (power, x or y, interval)."""
    return np.asfortranarray(curve.coefficients.transpose(2, 1, 0))


def _compliance_parts(compliance: BodyCompliance, shifts: Floats) -> list[Part]:
    """Parts of a compliance under normal loads, if present; shifts (S, p) by body loads."""
    modes, near = compliance.modes, compliance.near
    values_of = {
        "tip": modes.tip,
        "wedge": near.wedge if any(near.wedge) else None,
        "wedge_along": near.wedge_along if any(near.wedge_along) else None,
        "turned": _by_blocks(compliance.all_blocks()[1]) if compliance.turns else None,
        "nodes": modes.nodes,
        "shift": shifts if len(shifts) else None,
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
            parts.append((name, _by_blocks(values)))
    if compliance.near.jump:
        parts.append(("jump", np.array([compliance.near.jump])))
    return parts


def _by_blocks(values: Floats | None) -> Floats:
    """Responses (z, p, q) in the order of the core: (p, q, z)."""
    assert values is not None
    return values.transpose(1, 2, 0).ravel(order="F")


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
