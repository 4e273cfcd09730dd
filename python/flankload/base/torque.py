"""Torques are in N m in scenes and results, and in N mm between them."""

from __future__ import annotations

from typing import TYPE_CHECKING, TypeVar

import numpy as np

if TYPE_CHECKING:
    from flankload.base.arrays import Floats

    Torque = TypeVar("Torque", float, Floats)

N_MM_PER_N_M = 1000.0


def in_newton_metres(torque_Nmm: Torque) -> Torque:
    """Torques or moments in N m, for results and texts; `Scene.torques_Nmm` is the inverse."""
    return torque_Nmm / N_MM_PER_N_M


def stiffness_Nm_per_rad(compliance_rad_per_Nmm: Floats) -> Floats:
    """Stiffness, N m/rad; NaN where a torque causes no rotation."""
    stiffness = np.full_like(compliance_rad_per_Nmm, np.nan)
    factor = in_newton_metres(1.0)
    np.divide(factor, compliance_rad_per_Nmm, out=stiffness, where=compliance_rad_per_Nmm != 0.0)
    return stiffness
