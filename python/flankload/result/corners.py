"""Sharp corners in contact: pressures off and on them, warnings with the key that removes each."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flankload.contact.status import SiteCorner

if TYPE_CHECKING:
    from collections.abc import Iterator

    from flankload.base.arrays import Floats
    from flankload.bodies import Body
    from flankload.contact.sweep import Sweep
    from flankload.pairing.body_pair import BodyPair
    from flankload.result.optional_results import CoastContact
    from flankload.result.result import Result

#: Labels of the curve before and behind a corner: its name, and the key that removes it. Other
#: corners are the end of the curve.
CORNERS = {
    ("flank", "relief"): (
        "the kink where its tip relief begins",
        '{body}.tip_relief_shape = "parabolic" avoids it',
    ),
    ("root_relief", "flank"): (
        "the kink where its root relief begins",
        '{body}.root_relief_shape = "parabolic" avoids it',
    ),
    ("relief", "relief"): (
        "the knee of its tip relief",
        '{body}.tip_relief_shape = "parabolic" avoids it',
    ),
    ("fillet", "flank"): (
        "the end of its undercut",
        "a larger {body}.profile_shift avoids undercut",
    ),
    ("*", "tip_chamfer"): (
        "the edge between flank and chamfer",
        "{body}.tip_radius_mm instead of {body}.tip_chamfer_mm avoids it",
    ),
}
TIP = ("its sharp tip corner", "{body}.tip_radius_mm rounds it")
#: Ends of flanks on flanks that extend further along the axis.
END = ("the sharp end of its flanks", "{body}.end_relief_um relieves it")
END_OF_SPLINE = (END[0], "{body}.lead_crowning_um relieves it")
#: If tips and fillets are left out.
CUT = ("the end of its active flank", "the tip or fillet beyond it is excluded from contact")
#: For bodies with an imported profile.
OF_FILE = ("a sharp corner of its flank", "a rounding there avoids it")


def off_corners(contact: Result | CoastContact) -> Floats:
    """Pressures (P, S) that are finite on finer cells: 0 on sharp corners.

    NaN everywhere if all loaded contacts are on sharp corners.
    """
    corner = contact.corner_contact & (contact.peak_pressure_MPa > 0)
    smooth = np.where(corner, 0.0, contact.peak_pressure_MPa)
    alone = corner.any() and not smooth.any()
    return np.full_like(smooth, np.nan) if alone else smooth


def on_corners(contact: Result | CoastContact) -> Floats:
    """Pressures (P, S) on sharp corners, where they grow without limit on finer cells; 0 else."""
    return np.where(contact.corner_contact, contact.peak_pressure_MPa, 0.0)


def corner_notes(pair: BodyPair, found: Sweep) -> Iterator[str]:
    """Warnings about contact on sharp corners, one for each kind of corner of each body."""
    at: dict[tuple[str, str], set[int]] = {}
    end = END if pair.slices.conforming is None else END_OF_SPLINE
    for z, body in enumerate(pair.bodies):
        for p, s in _places(found, z):
            what, cure = end if s is None else _corner(body, s)
            cure = cure.format(body=f"body_{z + 1}")
            at.setdefault((f"body_{z + 1} touches with {what}", cure), set()).add(p)
    for (touches, cure), positions in at.items():
        yield (
            f"at {len(positions)} of {found.status.size} positions {touches}, where no finite peak "
            f"pressure exists; {cure}"
        )


def _places(found: Sweep, z: int) -> Iterator[tuple[int, float | None]]:
    """Position, and place of the largest pressure, for contact on a corner of body z.

    In three dimensions, for each slice with such a contact; None at a sharp end of the flanks.
    """
    names = found.pairs.names
    place, force, cell = (names.index(name) for name in (f"s_{z + 1}", "force", "cell"))
    corner = found.slices.corner
    last = corner.shape[2] - 1
    ends = [j for j, of in zip((0, last), found.slices.sharp_ends, strict=True) if of == z + 1]
    for p, site, j in np.argwhere(corner == SiteCorner.of_body(z)).tolist():
        if j in ends:
            yield p, None
            continue
        sites, table = found.pairs.at(p)
        rows = (sites == site) & (found.pairs.slices_at(p) == j)
        if rows.any():
            loaded = table[rows]
            yield p, float(loaded[np.argmax(loaded[:, force] / loaded[:, cell]), place])


def _corner(body: Body, s: float) -> tuple[str, str]:
    """The corner next to a place, and the key that removes it."""
    if not body.is_parametric:
        return OF_FILE
    curve, ends = body.curve, body.active_range_mm or ()
    corners = np.flatnonzero(curve.corners)
    apart = np.abs(curve.breaks[corners] - s)
    if min((abs(end - s) for end in ends), default=np.inf) <= apart.min(initial=np.inf):
        return CUT
    k = int(corners[np.argmin(apart)])
    if not 0 < k < len(curve.labels):
        return TIP
    before, behind = curve.labels[k - 1], curve.labels[k]
    return CORNERS.get((before, behind)) or CORNERS.get(("*", behind)) or TIP
