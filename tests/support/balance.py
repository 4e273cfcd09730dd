"""Balance of moments of a result, from the columns of its contact pairs alone."""

from __future__ import annotations

from typing import Any

import numpy as np

import flankload as fl


def imbalance(result: fl.Result) -> float:
    """Largest sum of all moments on body 1 over the sum of their sizes.

    The forces of a chain's rollers have directions of their own, which are not looked at.
    """
    torque = 1000 * result.torque_Nm
    drive: Any = result.drive
    if drive is not None:
        if drive.name == "chain":
            return 0.0
        if hasattr(drive, "meshes"):
            return _imbalance_of_meshes(torque, _meshes_of_body_1(drive))
        forces = np.column_stack([result.site_force_N, drive.land_friction_N])
        parts = np.column_stack(
            [forces * result.reference_radius_mm, -torque * np.ones(len(forces))]
        )
        sizes = np.maximum(np.abs(parts).sum(axis=1), np.finfo(float).tiny)
        return float((np.abs(parts.sum(axis=1)) / sizes).max())
    worst = 0.0
    coast = () if result.coast is None else (result.coast.pair_tables,)
    for tables in zip(result.pair_tables, *coast, strict=True):
        moments = (
            _moments(table, side, _twist(result))
            for table, side in zip(tables, (1, -1), strict=False)
        )
        parts = np.concatenate([[-torque], *moments])
        size = np.abs(parts).sum()
        worst = max(worst, abs(parts.sum()) / size if size > 0 else 0.0)
    return worst


def _meshes_of_body_1(drive: Any) -> list[fl.Result]:
    """Meshes of the sun, of the driver of an idler, of a wheel, or of both halves of a pinion."""
    if drive.name == "stage":
        return list(drive.meshes[: len(drive.meshes) // 2])
    return list(drive.meshes[: 1 if drive.kind == "idler" else 2])


def _imbalance_of_meshes(torque: float, meshes: list[fl.Result]) -> float:
    """Like `imbalance`, for a body in several meshes."""
    worst = 0.0
    for p in range(meshes[0].position_rad.size):
        moments = (_moments(mesh.pair_tables[p], 1, _twist(mesh)) for mesh in meshes)
        parts = np.concatenate([[-torque], *moments])
        size = np.abs(parts).sum()
        worst = max(worst, abs(parts.sum()) / size if size > 0 else 0.0)
    return worst


def _twist(result: fl.Result) -> float:
    """Twist of body 1, rad/mm; 0 in a plane scene."""
    slices = result.slices
    return 0.0 if slices is None else slices.tangent_helix_base / result.reference_radius_mm


def _moments(table: Any, side: int, twist: float) -> np.ndarray:
    """Moments of normal and friction forces about the axis of body 1, N mm; side -1: coast flanks.

    Arc length grows from root to tip on both sides of a tooth, friction is positive that way. On a
    helix the normal of a flank leaves the plane of the section: it is perpendicular to the line
    twist e_z x P + e_z in the flank.
    """
    along = table.x_mm * table.normal_y - table.y_mm * table.normal_x
    parts = [table.force_N * along / np.hypot(1.0, twist * along)]
    if table.friction_force_N is not None:
        across = table.x_mm * table.normal_x + table.y_mm * table.normal_y
        parts.append(side * table.friction_force_N * across)
    return np.concatenate(parts)
