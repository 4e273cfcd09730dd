"""Error estimates of a timing belt: what elements twice as long change.

At sharp corners errors fall about as elements do, so what they change is about what is left. Bodies
are independent sources, whose squares add up.
"""

from __future__ import annotations

from math import hypot
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from flankload.belt_contact import BeltState
    from flankload.belt_row import StripResponse

    #: Source, and what is compared: an answer with elements twice as long, with another one or, if
    #: None, with the state as found.
    Coarser = tuple[str, StripResponse | None, StripResponse]


def estimate_belt(
    tried: Sequence[tuple[BeltState, Sequence[Coarser]]],
    largest_rad: float,
    solve: Callable[[StripResponse], BeltState],
) -> dict[str, object]:
    """Estimated errors under a torque, as a result shows them.

    Parameters
    ----------
    tried : sequence of (BeltState, sequence of Coarser)
        States at some positions, and what is compared there. Of all with the same source the
        largest change counts.
    largest_rad : float
        Rotation to which changes are related.
    solve : callable
        From an answer to its state.

    Returns
    -------
    dict
        Errors of rotation and shares, and both by source.
    """
    by_source: dict[str, dict[str, float]] = {}
    for state, coarser in tried:
        for source, as_found, other in coarser:
            one, two = solve(as_found) if as_found is not None else state, solve(other)
            off = np.abs(two.tooth_N_per_mm - one.tooth_N_per_mm).max()
            changes = {
                "transmission_error": abs(two.rotation_rad - one.rotation_rad) / largest_rad,
                "load_share": float(off / state.tooth_N_per_mm.sum()),
            }
            before = by_source.get(source, changes)
            by_source[source] = {name: max(before[name], changes[name]) for name in changes}
    sums = {
        quantity: hypot(*(changes[quantity] for changes in by_source.values()))
        for quantity in ("transmission_error", "load_share")
    }
    return {**sums, "by_source": by_source}
