"""The loaded pair in three dimensions: teeth over the face width, line load on their flanks.

Each body is drawn in a frame on its own axis, in which its teeth point to positive x and its loaded
flanks have positive normals y: that of body 1 is the world, that of body 2 the world turned by 180°
about z. An internal pair meets at negative x: its body 1 is turned, its body 2 is not.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import cos, pi, sin
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.colors import to_rgb

from flankload.base.rotation import turned
from flankload.plot.figures import note
from flankload.plot.style import GREY, STEEL

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from flankload.base.arrays import Floats
    from flankload.bodies.axial_shape import AxialShape
    from flankload.result import Result


LOAD_MAP = "YlOrRd"
#: Facets of a tooth along its contour at most, and along z.
CONTOUR_FACETS, AXIAL_FACETS = 40, 10
#: Width of the coloured bands and depth of the rim below the root, in heights of the teeth.
BAND, RIM = 0.12, 0.7
EDGE = "#404040"


def _view(elevation: float, azimuth: float) -> Floats:
    """(3, 3) Directions of the picture: to the right, upwards, to the viewer.

    Without these angles z is to the right and the tips of the teeth are above.
    """
    right = np.array([0.0, -sin(azimuth), cos(azimuth)])
    level = np.array([0.0, cos(azimuth), sin(azimuth)])
    up = np.array([cos(elevation), 0.0, 0.0]) - sin(elevation) * level
    return np.array([right, up, np.cross(right, up)])


#: Loaded flanks are seen down to the root, and from the end of larger z.
VIEW = _view(np.radians(48.0), np.radians(25.0))
#: Direction to the light.
LIGHT = np.array([-0.3, 0.5, 0.8]) @ VIEW


@dataclass(frozen=True)
class Teeth:
    """Teeth of a body around its loaded flanks.

    Attributes
    ----------
    contours : tuple of (k, 2) arrays
        At z = 0, from cut to cut with the body on the left, in the direction of y.
    rim_mm : float
        Radius at which the drawing ends, below the roots.
    shape : AxialShape
    """

    contours: tuple[Floats, ...]
    rim_mm: float
    shape: AxialShape

    def sections(self, points: Floats, count: int) -> Floats:
        """(count, k, 3) Points of z = 0 in sections from end to end."""
        z = np.linspace(*self.shape.range_mm, count)
        planes = [turned(points, self.shape.twist_rad_per_mm * height) for height in z]
        return np.dstack([np.array(planes), np.broadcast_to(z[:, None], (count, len(points)))])

    def contour(self) -> Floats:
        """(n, 2) Toothed contour."""
        return np.vstack(self.contours)

    def rim(self) -> Floats:
        """(n, 2) End of the drawing, from the last tooth to the first."""
        first, last = (np.arctan2(*self.contours[k][k, ::-1]) for k in (0, -1))
        outward = 1.0 if self.rim_mm < np.hypot(*self.contours[0][0]) else -1.0
        turn = outward * (outward * (last - first) % (2 * pi))
        around = np.linspace(last, last - turn, 10 * len(self.contours))
        return self.rim_mm * np.column_stack([np.cos(around), np.sin(around)])

    def face(self) -> Floats:
        """(n, 2) Closed contour of the end face."""
        return np.vstack([self.contour(), self.rim()])


def fill_with_loaded_bodies(figure: Figure, result: Result, p: int) -> None:
    """Draw the teeth of both bodies at position p, and the line load on their flanks.

    Each body is drawn from the side of its loaded flanks, its mate as contours of both end faces.
    """
    figure.set_size_inches(7.2, 4.4)
    grid = figure.add_gridspec(2, 2, height_ratios=(1.0, 0.035))
    panels = [figure.add_subplot(grid[0, column]) for column in (0, 1)]
    for body, axes in zip((1, 2), panels, strict=True):
        shown = draw_loaded_body(axes, result, p, body)
        axes.set_title(_words(result, body), color=EDGE, fontsize=10)
    # the same scale for both
    size = np.max([axes.dataLim.size for axes in panels], axis=0)
    for axes in panels:
        low, high = axes.dataLim.get_points().mean(axis=0) + np.outer([-0.52, 0.52], size)
        axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]))
    figure.colorbar(
        shown,
        cax=figure.add_subplot(grid[1, :]),
        orientation="horizontal",
        label="line load in N per mm face width" + _largest(result, p),
    )


def draw_loaded_body(axes: Axes, result: Result, p: int, body: int) -> PolyCollection:
    """Draw the teeth of a body over its width, contours of its mate, and the line load.

    Returns
    -------
    matplotlib.collections.PolyCollection
        The line load, for a scale of colours.
    """
    pair = teeth_in_mesh(result, p, 1), teeth_in_mesh(result, p, 2)
    _draw_teeth(axes, pair[body - 1], STEEL[body - 1])
    _draw_mate(axes, result, pair[2 - body], STEEL[2 - body])
    shown = _draw_load(axes, result, p, body)
    _mark_ends(axes, pair[body - 1])
    axes.set_aspect("equal")
    axes.set_axis_off()
    axes.autoscale_view()
    return shown


def teeth_in_mesh(result: Result, p: int, body: int) -> Teeth:
    """The teeth of body 1 or 2 that carry load at position p, and their neighbours."""
    drawing = result.drawing
    shape = drawing.axial[body - 1]
    assert shape is not None
    outline, teeth, angle, bore = (
        (drawing.outline_1, drawing.teeth_1, drawing.angle_1[p], drawing.bore_radius_1_mm),
        (drawing.outline_2, drawing.teeth_2, drawing.angle_2[p], drawing.bore_radius_2_mm),
    )[body - 1]
    inwards = drawing.is_around and body == 2
    outward, meet = (-1.0, pi) if inwards else (1.0, 0.0)
    if drawing.is_around != (body == 2):
        angle += pi
    pitch = 2 * pi / teeth
    x, y, z = _loaded_places(result, p, body).T
    middle = angle + float(np.arctan2(*outline.mean(axis=0)[::-1])) - meet
    around = np.arctan2(outward * y, outward * x) - shape.twist_rad_per_mm * z - middle
    turns = np.rint((around if around.size else np.array([-middle])) / pitch)
    low, high = (float(end(np.hypot(*outline.T))) for end in (np.min, np.max))
    contours = [
        turned(_fewer(outline), angle + pitch * k)
        for k in np.arange(turns.min() - 1, turns.max() + 2)
    ]
    depth = RIM * (high - low)
    if inwards:
        contours = [contour[::-1] for contour in reversed(contours)]
        return Teeth(tuple(contours), min(high + depth, bore or np.inf), shape)
    return Teeth(tuple(contours), max(low - depth, bore or 0.0), shape)


def _loaded_places(result: Result, p: int, body: int) -> Floats:
    """(n, 3) Contacts with load at position p, in the frame of a body."""
    table = result.pairs(p)
    assert table.z_mm is not None
    places = np.column_stack([table.x_mm, table.y_mm, table.z_mm])[table.force_N > 0]
    places *= [_side(result), _side(result), 1.0]
    return places if body == 1 else _other_axis(result, places)


def _side(result: Result) -> float:
    """Side of the axis of body 1 on which the bodies meet: the sign of x."""
    return -1.0 if result.drawing.is_around else 1.0


def _contacts(result: Result, p: int) -> tuple[Floats, Floats, Floats]:
    """Places (n, 3), normals (n, 2) and forces (n,) of the contacts at position p.

    The cells of a flank in a slice are one contact.
    """
    table = result.pairs(p)
    carries = table.force_N > 0
    force = table.force_N[carries]
    normal = _side(result) * table.normal[carries]
    rows = np.column_stack([_loaded_places(result, p, 1), normal])
    if table.half_width_mm is None:
        keys = np.column_stack([table.site[carries], rows[:, 2]])
        of_slice, of = np.unique(keys, axis=0, return_inverse=True)
        total = np.zeros(len(of_slice))
        means = np.zeros((len(of_slice), rows.shape[1]))
        np.add.at(total, of.ravel(), force)
        np.add.at(means, of.ravel(), force[:, None] * rows)
        rows, force = means / total[:, None], total
        rows[:, 2] = of_slice[:, 1]  # slices are found again by their exact places
    return rows[:, :3], rows[:, 3:], force


def _other_axis(result: Result, points: Floats) -> Floats:
    """Points (..., 3) of one body's frame in that of its mate: turned by 180° about z."""
    apart = np.array([_side(result) * result.drawing.center_distance_mm, 0.0, 0.0])
    return np.asarray(apart + points * [-1.0, -1.0, 1.0])


def _fewer(contour: Floats) -> Floats:
    """Some points of a contour, closer where it bends."""
    steps = np.diff(contour, axis=0)
    length = np.hypot(*steps.T)
    bend = np.append(np.abs(np.diff(np.unwrap(np.arctan2(*steps.T[::-1])))), 0.0)
    along = np.append(0.0, np.cumsum(length / length.sum() + bend / bend.sum()))
    places = np.interp(np.linspace(0.0, 2.0, CONTOUR_FACETS + 1), along, np.arange(along.size))
    return np.asarray(contour[np.unique(np.rint(places).astype(int))])


def _draw_teeth(axes: Axes, teeth: Teeth, colour: str) -> None:
    """Sides of the teeth and the cut behind the last one, from back to front; the end face."""
    count = 1 + (AXIAL_FACETS if teeth.shape.twist_rad_per_mm else 1)
    cut = np.vstack([teeth.contour()[-1], teeth.rim()[0]])
    for order, contour in enumerate((*teeth.contours, cut)):
        grid = teeth.sections(contour, count)
        corners = [grid[:-1, :-1], grid[:-1, 1:], grid[1:, 1:], grid[1:, :-1]]
        facets = np.stack(corners, axis=2).reshape(-1, 4, 3)
        normal = np.cross(facets[:, 1] - facets[:, 0], facets[:, 3] - facets[:, 0])
        normal /= np.linalg.norm(normal, axis=1, keepdims=True)
        seen = normal @ VIEW[2] > 0
        facets, normal = facets[seen], normal[seen]
        back_to_front = np.argsort(facets.mean(axis=1) @ VIEW[2], kind="stable")
        shade = 0.55 + 0.45 * np.clip(normal @ LIGHT, 0.0, 1.0)
        colours = (shade[:, None] * to_rgb(colour))[back_to_front]
        axes.add_collection(
            PolyCollection(
                list((facets @ VIEW[:2].T)[back_to_front]),
                facecolors=colours,
                edgecolors=colours,
                linewidths=0.4,
                zorder=2.0 + order / (1 + len(teeth.contours)),
            )
        )
    axes.add_collection(
        PolyCollection(
            [teeth.sections(teeth.face(), 2)[-1] @ VIEW[:2].T],
            facecolors=[colour],
            edgecolors=EDGE,
            linewidths=0.8,
            zorder=5,
        )
    )


def _draw_mate(axes: Axes, result: Result, mate: Teeth, colour: str) -> None:
    """End faces of the mate: the far one filled, the near one as a contour."""
    far, _ = _other_axis(result, mate.sections(mate.face(), 2)) @ VIEW[:2].T
    _, near = _other_axis(result, mate.sections(mate.contour(), 2)) @ VIEW[:2].T
    axes.add_collection(
        PolyCollection([far], facecolors=[colour], edgecolors=GREY, linewidths=0.6, zorder=1)
    )
    axes.add_collection(
        LineCollection([near], colors=GREY, linewidths=0.8, linestyles="dotted", zorder=6)
    )


def _draw_load(axes: Axes, result: Result, p: int, body: int) -> PolyCollection:
    """The line load of each contact, as a band along its contact line, never hidden by a tooth."""
    slices, shape = result.slices, result.drawing.axial[0]
    assert slices is not None
    assert shape is not None
    place, normal, force = _contacts(result, p)
    width = slices.width_mm[np.searchsorted(slices.z_mm, place[:, 2])]
    load = force / width
    # the contact line of an involute lies in the plane of action
    lever = place[:, 0] * normal[:, 1] - place[:, 1] * normal[:, 0]
    along = np.column_stack([shape.twist_rad_per_mm * lever[:, None] * normal, np.ones(len(place))])
    along *= 0.5 * width[:, None]
    radii = np.hypot(*result.drawing.outline_1.T)
    across = np.column_stack([-normal[:, 1], normal[:, 0], np.zeros(len(place))])
    across *= 0.5 * BAND * (radii.max() - radii.min())
    corners = (-along - across, along - across, along + across, across - along)
    bands = place[:, None, :] + np.stack(corners, axis=1)
    if body == 2:
        bands = _other_axis(result, bands)
    bands = bands @ VIEW[:2].T
    shown = PolyCollection(
        list(bands), array=load, cmap=LOAD_MAP, edgecolors=EDGE, linewidths=0.25, zorder=4
    )
    shown.set_clim(0.0, float(load.max(initial=0.0)) or 1.0)
    axes.add_collection(shown)
    if load.size:
        ring = bands[load.argmax()].mean(axis=0)
        axes.plot(*ring, marker="o", markersize=9, mfc="none", mec=EDGE, zorder=7)
    return shown


def _mark_ends(axes: Axes, teeth: Teeth) -> None:
    """Axial positions of both end faces, below the front edge."""
    edge = teeth.sections(teeth.rim()[:1], 2)[:, 0]
    for (x, y), z, side in zip(edge @ VIEW[:2].T, edge[:, 2], ("right", "center"), strict=True):
        text = f"z = {z:g} mm".replace("-", "−")
        note(axes, text, (x, y), offset=(0, -3), ha=side, va="top", fontsize=8)


def _largest(result: Result, p: int) -> str:
    """The meaning of the ring; nothing without load."""
    assert result.slices is not None
    load = result.slices.line_load_N_per_mm[p]
    if not load.any():
        return ""
    z = result.slices.z_mm[load.max(axis=0).argmax()]
    return f"; ○ largest: {load.max():.0f} at z = {z:.1f} mm".replace("-", "−")


def _words(result: Result, body: int) -> str:
    """Number, teeth and hand of a body."""
    shape = result.drawing.axial[body - 1]
    assert shape is not None
    teeth = (result.drawing.teeth_1, result.drawing.teeth_2)[body - 1]
    twist = shape.twist_rad_per_mm
    hand = "right hand" if twist > 0 else "left hand" if twist < 0 else "spur"
    return f"Body {body}, {teeth} teeth, {hand}"
