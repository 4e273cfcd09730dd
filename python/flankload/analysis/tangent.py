"""Tangent stiffness by differences of the rotation, and the rotation without torque.

The derivative of the rotation for fixed pairs in contact lacks the contribution of the edges of the
contacts, since cells become longer with the torque: 0.1 to 0.3 % on gears with ten cells on the
half-width. Cells are laid out for each torque, in the same number on each half-width, so the
rotation of given pairs in contact is smooth in the torque: differences over 2e-3 of it agree with
those over 1e-4 to 2e-8.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from flankload.contact.status import is_marked
from flankload.contact.sweep import UnloadedStates, known_contacts
from flankload.errors import ContactError

if TYPE_CHECKING:
    from collections.abc import Callable

    from flankload.contact.sweep import Sweep

#: Relative step of the torque: the error is below 1e-7 by the third derivative, below 1e-8 by
#: rounding.
STEP = 1e-3
#: Signs of the steps.
SIDES = (-1, 1)
#: Where the pairs in contact are not known, one-sided differences that differ by more than this
#: show that a flank comes into contact or leaves it within the step; the derivative for fixed pairs
#: in contact is more accurate then.
LARGEST_KINK = 5e-3


def with_tangents(
    found: tuple[Sweep, ...], run: Callable[..., tuple[Sweep, ...]]
) -> tuple[Sweep, ...]:
    """Replace the derivatives of rotation and forces by differences.

    Parameters
    ----------
    found : tuple of Sweep
        One for each torque.
    run : callable
        run(torques_Nmm=…, known=…) sweeps the same positions under other torques; `known` are pairs
        in contact.

    Returns
    -------
    tuple of Sweep
        Unchanged without torque, or if there is no state under a slightly larger torque.
    """
    loaded = [t for t, part in enumerate(found) if part.torque_Nmm > 0]
    if not loaded:
        return found
    torques = [found[t].torque_Nmm * (1.0 + side * STEP) for t in loaded for side in SIDES]
    known = known_contacts([found[t] for t in loaded for _ in SIDES])
    try:
        beside = run(torques_Nmm=torques, known=known)
    except ContactError:
        return found
    parts = list(found)
    for k, t in enumerate(loaded):
        parts[t] = _differenced(found[t], beside[2 * k], beside[2 * k + 1])
    return tuple(parts)


def with_unloaded(
    found: tuple[Sweep, ...], run: Callable[..., tuple[Sweep, ...]]
) -> tuple[Sweep, ...]:
    """Add the state without torque, from which the deflection under torque is measured.

    Deviations of pitch and profile, an offset of the axes, expansion and preload rotate body 1
    without any torque.

    Parameters
    ----------
    found : tuple of Sweep
        One for each torque.
    run : callable
        run(torques_Nmm=…) sweeps the same positions under other torques.

    Returns
    -------
    tuple of Sweep
        Unchanged if there is no state without torque.
    """
    none = next((part for part in found if part.torque_Nmm == 0.0), None)
    if none is None:
        try:
            (none,) = run(torques_Nmm=[0.0])
        except ContactError:
            return found
    unloaded = UnloadedStates(none.rotation_rad, is_marked(none.site_corner))
    return tuple(replace(part, unloaded=unloaded) for part in found)


def _differenced(part: Sweep, less: Sweep, more: Sweep) -> Sweep:
    """Central differences for one torque."""
    step = STEP * part.torque_Nmm
    before = (part.rotation_rad - less.rotation_rad) / step
    behind = (more.rotation_rad - part.rotation_rad) / step
    smooth = np.abs(behind - before) <= LARGEST_KINK * np.abs(part.tangent_rad_per_Nmm)
    tangent = np.where(smooth, 0.5 * (before + behind), part.tangent_rad_per_Nmm)
    forces = 0.5 * (more.site_force_N - less.site_force_N) / step
    return replace(part, tangent_rad_per_Nmm=tangent, site_force_per_torque=forces)
