"""The states without torque, from which deflections count."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from flankload.contact.status import is_marked
from flankload.contact.sweep import UnloadedStates
from flankload.errors import ContactError

if TYPE_CHECKING:
    from collections.abc import Callable

    from flankload.contact.sweep import Sweep


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
