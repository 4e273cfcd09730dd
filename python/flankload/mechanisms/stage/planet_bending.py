"""Root stress of the planets under the loads of both their flanks."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flankload.elasticity.axial_basis import AxialBasis
from flankload.elasticity.near_field import to_coefficients
from flankload.mechanisms.stage.mode_loads import mode_values_at
from flankload.result.planet_bending import PlanetBending

if TYPE_CHECKING:
    from flankload.base.arrays import Floats
    from flankload.contact.meshes_contact import MeshesSweep
    from flankload.elasticity.compliance import BodyCompliance
    from flankload.elasticity.compliance.contributions import RootResponse
    from flankload.mechanisms.stage.assembly import StageAssembly


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
    shape = (2, pairing.count, len(found.motions), pairing.teeth[1], planet.smooth.shape[1])
    loads = np.zeros(shape)
    for mesh, sweep, slices in zip(pairing.meshes, found.meshes, assembly.slices, strict=True):
        pairs, own = sweep.pairs, 0 if mesh.with_ring else 1
        values = mode_values_at(planet, slices, sweep, own)
        if assembly.is_plane:
            values = to_coefficients(values.T, modes.range_mm, tip=modes.tip).T
        # contact pushes into the material
        force = -pairs.column("force")[:, None]
        tooth = mesh.pairing.site_teeth[own][pairs.sites]
        at = loads[int(mesh.with_ring), mesh.planet]
        np.add.at(at, (pairs.position, tooth), force * values)
    return loads
