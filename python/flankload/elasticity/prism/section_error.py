"""Estimate of the discretization error of a prism, from the elements of its plane section.

The elements of the section miss the same part of the deformation under a flank in every slice: the
error varies within a few elements, over which the load hardly changes along the axis. Stress
recovery in plane strain (`fe_error`) gives the missed displacement under a line load; a load over
P_b(z) is one line load per length.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flankload.elasticity.compliance.job import JobOptions, flank_compliance
from flankload.elasticity.prism.axial_basis import mode_norms_z

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from flankload.bodies.body import Body
    from flankload.cost import Account

    Floats = NDArray[np.float64]


def missed_over_width(
    body: Body,
    n_modes: int,
    *,
    width_mm: float,
    load_degree: int,
    friction: bool,
    cosine: float,
    account: Account,
) -> Floats:
    """Estimated error of the compliance of a flank under loads on itself.

    Parameters
    ----------
    body : Body
        With the mesh of a sector.
    n_modes : int
        Pressure modes along the flank, without those of a tip.
    load_degree : int
        Of the pressure modes along the axis.
    friction : bool
        Loads along the profile follow.
    cosine : float
        Of the helix angle of the contact line: part of a normal force in the section, and of its
        displacement.
    account : Account
        One plane factorisation and its solutions are counted.

    Returns
    -------
    (1, p, p) array, (1, p, 2 p) with friction
        As `BodyCompliance.missed`, mm/N.
    """
    options = JobOptions(n_modes=n_modes, plane="strain", friction=friction, estimate=True)
    section = flank_compliance(body, options, sectors=1)
    assert section.missed is not None
    counted = ("fe_factorisations", "fe_solutions")
    account.count(**{name: section.job.counters[name] for name in counted})
    along = np.diag(1.0 / mode_norms_z(width_mm, load_degree))
    missed = cosine**2 * np.kron(section.missed[0], along)
    missed[:, len(missed) :] /= cosine  # loads along the profile lie in the section
    return np.asarray(missed[None])
