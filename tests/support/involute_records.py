"""Records of involutes at the pitch point, as sun, planet and ring of a stage."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from tests.support.packed_meshes import body_record

MODULE, ALPHA, DISTANCE = 3.0, np.radians(20.0), 63.0
TEETH = {"sun": 25, "planet": 17, "ring": 59}
BASE = {name: 0.5 * MODULE * z * np.cos(ALPHA) for name, z in TEETH.items()}
#: Levels of cells and of lumped contact in the core.
LEVELS = (0.0, 1.0)


def involute(name: str, n_sites: int, *, ring: bool = False, **changes: Any) -> NDArray[np.float64]:
    """Record of a body whose left flank has its pitch point at angle 0, with a site per mesh."""
    radius, t_pitch = BASE[name], np.tan(ALPHA)
    ends = 0.5 * radius * (t_pitch + np.array([-0.08, 0.08])) ** 2
    breaks = np.linspace(*ends, 9)
    nodes = 0.5 * (1 - np.cos(np.pi * (np.arange(8) + 0.5) / 8))
    coefficients = np.empty((8, 2, 8), order="F")
    for k in range(8):
        local = nodes * (breaks[k + 1] - breaks[k])
        s = breaks[k] + local if not ring else breaks[0] + breaks[-1] - breaks[k] - local
        t = np.sqrt(2 * s / radius)
        point = radius * np.exp(1j * (t_pitch - ALPHA - t)) * (1 + 1j * t)
        fit = np.polynomial.Polynomial.fit(local, point, 7, domain=[0, local.max()])
        powers = fit.convert().coef
        coefficients[:, 0, k], coefficients[:, 1, k] = powers.real, powers.imag
    smooth = np.zeros((1, 1, 2), order="F")
    smooth[0, 0, 0] = 2e-6
    return body_record(
        n_sites,
        changes.pop("smooth", smooth),
        breaks=breaks - breaks[0],
        coefficients=coefficients,
        corners=np.zeros(9, dtype=np.intc),
        mode_range=np.array([0.0, breaks[-1] - breaks[0]]),
        **changes,
    )
