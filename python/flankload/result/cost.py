"""What a run has cost, as the result shows it: counted work, seconds and bytes."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from flankload.contact.sweep import CORE_COUNTERS
from flankload.cost import totals

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flankload.contact.sweep import Sweep
    from flankload.cost import Account
    from flankload.elasticity.compliance import BodyCompliance


def cost_of(
    stages: Mapping[str, Account],
    found: Sweep,
    compliances: tuple[BodyCompliance, BodyCompliance],
    *,
    predicted: Mapping[str, Mapping[str, Any]],
    rounds: int,
) -> dict[str, Any]:
    """Cost of a run and of one of its torques.

    Parameters
    ----------
    stages : mapping of str to Account
        Of the whole run, all torques together.
    found : Sweep
        Of this torque.
    compliances : two BodyCompliance
    predicted : mapping of str to mapping
        By stages, what they were to take: "counters", and more where more was predicted.
    rounds : int
        Sweeps in which the positions were found.

    Returns
    -------
    dict
        Counters summed over all stages at its top, zeros included; the stages, each with what was
        predicted of it beside what it spent; and what the states of this torque took, without what
        tangent and estimate took.
    """
    own = dict(zip(CORE_COUNTERS, found.counters.sum(axis=0, dtype=np.int64).tolist(), strict=True))
    return {
        **totals(stages),
        "positions": found.status.size,
        "position_rounds": rounds,
        "of_this_torque": own,
        "fe_degrees_of_freedom": [c.degrees_of_freedom for c in compliances],
        "bytes": sum(account.bytes for account in stages.values()),
        "largest_backward_error": float(np.max(found.certificate[:, 0], initial=0.0)),
        "largest_condition": float(np.max(found.certificate[:, 1], initial=0.0)),
        "stages": {
            name: account.as_dict() | {"predicted": dict(predicted.get(name, {}))}
            for name, account in stages.items()
        },
    }
