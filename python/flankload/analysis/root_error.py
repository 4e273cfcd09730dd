"""Error of the largest root tension: of the load of the tooth, of modes, and of elements.

The stress in a root is proportional to the force on its tooth, so that it has the relative error of
this share from each source. Modes that are left out act on the roots as well: the two highest ones
have an effect of which the following ones add a part. In three dimensions the largest tension is
that of a place along the axis, often near an end of the contact; modes, degrees of the load and
degrees of the stress itself converge there as line loads do. Stress is read at the points of an
edge where that of quadratic elements is most accurate, so that recovered stresses are no better;
but like the displacement of a flank it is a product of two fields, that of the load and that of a
dipole in the fillet. Both have the relative error that recovery shows there, their product its
square, and recovery shows as much of it as of that of a displacement.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from flankload.analysis.error_rules import (
    ELEMENTS,
    ROOT_STRESS,
    RemainingError,
    load_shares,
    of_largest,
)
from flankload.result.root_stress import (
    largest_tension,
    loads_of_modes,
    root_reading,
    stress_by_slice,
)

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from flankload.base.arrays import Floats
    from flankload.contact.sweep import Sweep
    from flankload.elasticity.compliance import BodyCompliance
    from flankload.pairing.body_pair import BodyPair
    from flankload.result.pairs import PairTable
    from flankload.result.root_stress import RootReading

    Bodies = tuple[BodyCompliance, BodyCompliance]


class RootTension(NamedTuple):
    """Largest tension in the roots (2, P, S) of both bodies at some positions.

    Attributes
    ----------
    tension : (2, P, S) array
        Relative to the largest one of each body; 0 without fillets.
    omitted : mapping of str to (2, P, S) array
        Largest change without the highest modes, by the source of errors that this shows.
    difference : (2, 1, 1) array
        `RootResponse.difference`.
    """

    tension: Floats
    omitted: Mapping[str, Floats]
    difference: Floats


def root_tension(
    pair: BodyPair, compliances: Bodies, tables: Sequence[PairTable]
) -> RootTension | None:
    """The tension under the forces of a table per position; None if the scene asks for none."""
    if all(each.root is None for each in compliances):
        return None
    tables, sites = tuple(tables), pair.pairing.sites
    tension = np.zeros((2, len(tables), sites.size))
    omitted: dict[str, Floats] = {}
    difference = np.zeros((2, 1, 1))
    for z, own in enumerate(compliances):
        reading = root_reading(pair, compliances, z, np.arange(sites.size))
        if own.root is None or reading is None:
            continue
        loads = loads_of_modes(reading, tables, sites, z)
        fewer = [_projected(loads, own.onto_lower_modes(less), reading) for less in (1, 2)]
        whole, *others = _tension(reading, [loads, *fewer])
        changes = {"modes": np.abs(others - whole).max(axis=0)}
        if reading.over_width is not None:
            lower = _projected(loads, own.onto_lower_degrees(), reading)
            less = replace(reading, response=reading.response[..., :-2, :])
            changes["axial"] = np.abs(_tension(less, [lower])[0] - whole)
        largest = whole.max() or 1.0
        tension[z], difference[z] = whole / largest, own.root.difference
        for source, change in changes.items():
            omitted.setdefault(source, np.zeros_like(tension))[z] = change / largest
    return RootTension(tension, omitted, difference)


def _projected(loads: Floats, onto: Floats, reading: RootReading) -> Floats:
    """Loads (P, S, p) of fewer modes, by a projection of coefficients; all kinds of loads."""
    kinds = loads.reshape(*loads.shape[:2], -1, len(onto))
    # with a width, loads are integrals with the modes in place of coefficients
    fewer = kinds @ (onto.T if reading.over_width is None else onto)
    return np.asarray(fewer.reshape(loads.shape))


def _tension(reading: RootReading, loads: Sequence[Floats]) -> Floats:
    """Largest tension (n, P, S) in each root under n loads of the modes (P, S, p)."""
    stress = stress_by_slice(reading, np.concatenate(loads))
    found = np.maximum(largest_tension(reading.points, stress).max(axis=2), 0.0)
    return np.asarray(found.reshape(len(loads), -1, found.shape[1]))


def add_root_errors(
    errors: Mapping[str, dict[str, RemainingError]],
    part: Sweep,
    roots: RootTension,
    following: float,
) -> None:
    """Add the error of the largest tension to those of each source, by source and quantity.

    `following`: part of the effect of the highest modes that the omitted ones add at most.
    """
    share = load_shares(part)
    # a root whose own flank carries little has the stress of its neighbours: that of its own force
    # is at most as large per force as where the tension is largest
    loaded = np.where(share > 0, roots.tension, 0.0)
    per_share = loaded / np.where(share > 0, share, 1.0)
    at = loaded.reshape(2, -1).argmax(axis=1)
    per_share = np.minimum(per_share, per_share.reshape(2, -1)[[0, 1], at][:, None, None])
    for source, quantities in errors.items():
        of_share = quantities.get("load_share", RemainingError(0.0, 0.0))
        error: Floats | float = 0.0
        own = following * roots.omitted.get(source, 0.0)
        if source == "elements":
            change = roots.difference**2 * roots.tension
            error, own = ELEMENTS.part * change, ELEMENTS.doubt * change
        doubts = per_share * (np.abs(of_share.error) + of_share.doubt), own
        each = RemainingError(error, np.hypot(*doubts))
        if np.any(each.doubt):
            quantities[ROOT_STRESS] = of_largest(each, roots.tension)
