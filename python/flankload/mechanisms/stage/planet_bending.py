"""Root stress of the planets under the loads of both their flanks."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from flankload.elasticity.axial_basis import AxialBasis
from flankload.elasticity.near_field import mode_values, to_coefficients
from flankload.result.planet_bending import PlanetBending
from flankload.result.root_stress import OverWidth, RootReading, modes_on_slices

if TYPE_CHECKING:
    from flankload.base.arrays import Floats
    from flankload.contact.meshes_contact import MeshesSweep
    from flankload.elasticity.compliance import BodyCompliance
    from flankload.elasticity.compliance.contributions import RootResponse
    from flankload.mechanisms.stage.assembly import StageAssembly
    from flankload.pairing.slices import Slices


def bending_of_planets(
    assembly: StageAssembly, planet: BodyCompliance, found: MeshesSweep
) -> PlanetBending | None:
    """Extremes of the root stress of all planets; None if their compliance contains no stress."""
    root = planet.root
    if root is None:
        return None
    loads, (of_sun, of_ring) = _mode_loads(assembly, planet, found), _responses(root)
    # stress (n, P, z, q), with a width by function of z
    stress = _product(of_sun, loads[0]) + _product(of_ring, loads[1])
    if root.range_mm is None:
        return PlanetBending(root.points, stress.max(axis=(1, 2)), stress.min(axis=(1, 2)))
    z_mm = assembly.slices[0].z_mm
    values = AxialBasis(root.range_mm, stress.shape[-1] - 1).values(z_mm)
    over_width = stress @ values.T
    largest, least = over_width.max(axis=(1, 2)), over_width.min(axis=(1, 2))
    at = (largest - least).argmax(axis=2)[..., np.newaxis]
    extremes = [np.take_along_axis(part, at, axis=2)[..., 0] for part in (largest, least)]
    return PlanetBending(root.points, extremes[0], extremes[1], z_mm[at[..., 0]])


def _responses(root: RootResponse) -> tuple[Floats, Floats]:
    """(z, z, q, …, a) Stress in the root of tooth i by loads on tooth k: on its working flank, or
    on its coast flank.
    """
    assert root.coast is not None
    teeth = np.arange(len(root.response))
    apart = (teeth[:, None] - teeth) % teeth.size
    return root.response[apart], root.coast[apart]


def _product(response: Floats, loads: Floats) -> Floats:
    """(n, P, z, q, …) Stress by loads (n, P, z, a) on the teeth."""
    moved = np.moveaxis(response, 1, -2)  # tooth k beside the modes
    shape, kept = moved.shape[:-2], moved.shape[-2] * moved.shape[-1]
    found = loads.reshape(-1, kept) @ moved.reshape(-1, kept).T
    return np.asarray(found.reshape(*loads.shape[:2], *shape))


def _mode_loads(assembly: StageAssembly, planet: BodyCompliance, found: MeshesSweep) -> Floats:
    """(2, n, P, z, a) Coefficients of the modes on both flanks of the teeth of all planets, MPa.

    With a width the forces times the values of the modes, N.
    """
    pairing, modes = assembly.pairing, planet.modes
    n_modes, (low, high) = planet.smooth.shape[1], modes.range_mm
    end = high if modes.tip is None else modes.tip.end_mm
    shape = (2, pairing.count, len(found.motions), pairing.teeth[1], n_modes)
    loads = np.zeros(shape)
    reading = None if planet.root is None or assembly.is_plane else partial(_reading, planet)
    meshes = zip(pairing.meshes, found.meshes, assembly.slices, strict=True)
    for mesh, sweep, slices in meshes:
        pairs, own = sweep.pairs, 0 if mesh.with_ring else 1
        places, width_mm = pairs.column(f"s_{own + 1}"), assembly.slices[0].compliance_width_mm
        if reading is None:
            within = np.clip(places, low, end)
            values = mode_values(within, modes.range_mm, n_modes, tip=modes.tip)
            values = to_coefficients(values.T, modes.range_mm, tip=modes.tip).T
        else:
            z_mm = slices.z_mm[pairs.slices]
            values = modes_on_slices(reading(slices), places, pairs.column("cell"), z_mm)
        # contact pushes into the material
        force = -pairs.column("force")[:, None] / width_mm
        tooth = mesh.pairing.site_teeth[own][pairs.sites]
        at = loads[int(mesh.with_ring), mesh.planet]
        np.add.at(at, (pairs.position, tooth), force * values)
    return loads


def _reading(planet: BodyCompliance, slices: Slices) -> RootReading:
    """Modes of a planet in the slices of a mesh."""
    root, modes = planet.root, planet.modes
    assert root is not None
    assert root.range_mm is not None
    return RootReading(
        points=root.points,
        n_modes=planet.smooth.shape[1] // planet.modes_per_place,
        response=root.response,
        mode_range_mm=modes.range_mm,
        tip=modes.tip,
        face_width_mm=1.0,
        over_width=OverWidth(root.range_mm, modes.axial.degree, slices.edges_mm),
    )
