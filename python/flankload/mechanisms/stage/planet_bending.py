"""Root stress of the planets under the loads of both their flanks."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flankload.elasticity.near_field import mode_values, to_coefficients
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
    loads = _mode_loads(assembly, planet, found)
    of_sun, of_ring = _responses(root)
    # stress (n, P, z, q)
    stress = np.einsum("ikqa,npka->npiq", of_sun, loads[0])
    stress += np.einsum("ikqa,npka->npiq", of_ring, loads[1])
    return PlanetBending(root.points, stress.max(axis=(1, 2)), stress.min(axis=(1, 2)))


def _responses(root: RootResponse) -> tuple[Floats, Floats]:
    """(z, z, q, a) Stress in the root of tooth i by loads on tooth k: its working or coast flank.

    A load on the coast flank of a tooth is the mirror image, about the tooth's centre line, of one
    on its working flank.
    """
    teeth = np.arange(len(root.response))
    apart = (teeth[:, None] - teeth) % teeth.size
    working = root.points.working
    mirrored = np.concatenate([np.flatnonzero(~working), np.flatnonzero(working)])
    return root.response[apart], root.response[-apart % teeth.size][:, :, mirrored]


def _mode_loads(assembly: StageAssembly, planet: BodyCompliance, found: MeshesSweep) -> Floats:
    """(2, n, P, z, a) Coefficients of the modes on both flanks of the teeth of all planets, MPa."""
    pairing, modes = assembly.pairing, planet.modes
    n_modes, (low, high) = planet.smooth.shape[1], modes.range_mm
    end = high if modes.tip is None else modes.tip.end_mm
    shape = (2, pairing.count, len(found.motions), pairing.teeth[1], n_modes)
    loads = np.zeros(shape)
    for mesh, sweep in zip(pairing.meshes, found.meshes, strict=True):
        pairs, own = sweep.pairs, 0 if mesh.with_ring else 1
        within = np.clip(pairs.column(f"s_{own + 1}"), low, end)
        values = mode_values(within, modes.range_mm, n_modes, tip=modes.tip)
        values = to_coefficients(values.T, modes.range_mm, tip=modes.tip).T
        # contact pushes into the material
        force = -pairs.column("force")[:, None] / assembly.face_width_mm
        tooth = mesh.pairing.site_teeth[own][pairs.sites]
        at = loads[int(mesh.with_ring), mesh.planet]
        np.add.at(at, (pairs.position, tooth), force * values)
    return loads
