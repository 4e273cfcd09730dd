"""The pictures of a result as columns: curves, bars and maps.

None depends on the kind of drive: a picture has no columns where a result has no data for it.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from flankload.plot.load_maps import contact_pattern
from flankload.plot.picture import of_largest_force
from flankload.plot.positions import curve, lifted, places_on_way, through_uneven, way_curve

if TYPE_CHECKING:
    from flankload.base.arrays import Floats
    from flankload.result import Result

    Columns = dict[str, Any]

#: Columns and rows of a map.
MAP = (160, 80)


def curves_of(result: Result) -> dict[str, Columns]:
    """Columns of the curves and bars of a result, by name of the picture.

    `x`, `y` and `corner`: the pressure on sharp corners, which means nothing.
    """
    engagement, several = result.engagement, result.position_rad.size > 1
    known = engagement.pictures(result)
    found: dict[str, Columns] = {}
    if "transmission_error" in known and several:
        error = result.transmission_error_um
        found["error"] = _columns(*(through_uneven(result, error) or curve(result, error)))
    if "load_sharing" in known:
        place, share = way_curve(result, 100.0 * result.load_share)
        found["share"] = _columns(place, lifted(share))
    stay = several and engagement.has_pressures and not engagement.pairs_advance
    if "peak_pressure" in known or stay:
        place, pressure = way_curve(result, result.peak_pressure_MPa)
        on_corner = way_curve(result, result.corner_contact.astype(float))[1] > 0
        pressure = lifted(pressure)
        on_corner |= not (pressure[~on_corner] > 0).any()
        found["pressure"] = _columns(place, pressure, on_corner)
    if "transmission_error_spectrum" in known:
        orders = result.key_figures["transmission_error_mesh_harmonics_um"] or []
        found["spectrum"] = _columns(np.arange(1.0, 1 + len(orders)), np.array(orders, dtype=float))
    if "load_sharing" not in known and result.sites.size > 1:
        force = result.site_force_N[of_largest_force(result)]
        found["sites"] = _columns(1.0 * result.sites, force)
    return found


def maps_of(result: Result) -> dict[str, Columns]:
    """Columns of the maps of a three-dimensional result: `image`, its place and its size."""
    slices = result.slices
    if slices is None or not result.site_force_N.any():
        return {}
    ends = slices.z_mm[0] - 0.5 * slices.width_mm[0], slices.z_mm[-1] + 0.5 * slices.width_mm[-1]
    found = {}
    if "contact_pattern" in result.engagement.pictures(result):
        diameter, pressure = contact_pattern(result, 1)
        found["pattern"] = _map(slices.z_mm, diameter, pressure.T, ends)
    place = places_on_way(result)
    order = np.argsort(place, axis=None, kind="stable")
    load = slices.line_load_N_per_mm.reshape(-1, slices.z_mm.size)[order]
    carries = load.any(axis=1)
    found["line_load"] = _map(place.ravel()[order][carries], slices.z_mm, load[carries], None, ends)
    return found


def _map(
    x: Floats,
    y: Floats,
    values: Floats,
    x_ends: tuple[float, float] | None = None,
    y_ends: tuple[float, float] | None = None,
) -> Columns:
    """Image of values (x, y) on an even grid: each point has the value of the nearest place."""
    (left, right), (low, high) = x_ends or (x.min(), x.max()), y_ends or (y.min(), y.max())
    nearest = []
    for places, ends, count in ((x, (left, right), MAP[0]), (y, (low, high), MAP[1])):
        order = np.argsort(places, kind="stable")
        middle = 0.5 * (places[order][1:] + places[order][:-1])
        step = (ends[1] - ends[0]) / count
        at = ends[0] + step * (np.arange(count) + 0.5)
        nearest.append(order[np.searchsorted(middle, at)])
    image = values[np.ix_(*nearest)].T
    return {
        "image": [np.where(image > 0, image, np.nan).astype(np.float32)],
        "x": [left], "y": [low], "dw": [right - left], "dh": [high - low],
    }  # fmt: skip


def _columns(x: Any, y: Any, on_corner: Any = False) -> Columns:
    """Columns of a curve from its first to its last value."""
    (drawn,) = np.isfinite(y).nonzero()
    points = np.array(np.broadcast_arrays(x, y, on_corner), dtype=float)
    x, y, on_corner = points[:, drawn[0] : drawn[-1] + 1] if drawn.size else points[:, :0]
    values = np.where(on_corner, np.nan, y), np.where(on_corner, y, np.nan)
    return {"x": x, "y": values[0], "corner": values[1]}
