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
from matplotlib.cm import ScalarMappable
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.colors import Normalize, to_rgb

from flankload.base.rotation import turned
from flankload.plot.figures import note
from flankload.plot.style import GREY, STEEL

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes

    from flankload.base.arrays import Floats
    from flankload.bodies.axial_shape import AxialShape
    from flankload.result import Result


LOAD_MAP = "YlOrRd"
#: Facets of a tooth along its contour at most, and along z.
CONTOUR_FACETS, AXIAL_FACETS = 40, 10
#: Points per inch; points for the title of a body, and for the text at an end of its face width.
POINTS, TITLE, TEXT = 72.0, 22.0, np.array([60.0, 13.0])
#: Iterations for the scale of a drawing with texts.
SCALE_STEPS = 4
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


def draw_loaded_bodies(axes: Axes, result: Result, p: int, bodies: tuple[int, ...]) -> None:
    """Draw the teeth of bodies at position p, and the line load on their flanks.

    Each body is drawn from the side of its loaded flanks, its mate as contours of both end faces;
    both have the same scale and are beside or above each other, whichever is larger.
    """
    axes.set_axis_off()
    axes.figure.colorbar(
        ScalarMappable(Normalize(0.0, _most(result, p)), LOAD_MAP),
        ax=axes,
        orientation="horizontal",
        label="line load in N per mm face width" + _largest(result, p),
        fraction=0.04,
        aspect=40.0,
        pad=0.02,
    )
    place = np.array(axes.bbox.size) * POINTS / axes.figure.dpi
    pairs = [[teeth_in_mesh(result, p, z) for z in (body, 3 - body)] for body in bodies]
    outlines = [_outline(result, *pair) for pair in pairs]
    panels, scale = _arrangement(outlines, place)
    for body, panel, outline in zip(bodies, panels, outlines, strict=True):
        inset = axes.inset_axes((panel[0], panel[1], panel[2], panel[3]))
        draw_loaded_body(inset, result, p, body)
        inset.set_title(_words(result, body), color=EDGE, fontsize=10, loc="center")
        low, high = _with_texts(outline, scale)
        half = 0.5 * scale * place * panel[2:]
        (left, bottom), (right, top) = 0.5 * (low + high) - half, 0.5 * (low + high) + half
        inset.set(xlim=(left, right), ylim=(bottom, top))


def _outline(result: Result, own: Teeth, mate: Teeth) -> tuple[Floats, Floats]:
    """Points (n, 2) of a body with its mate, the places (2, 2) of its axial positions among them.

    The latter are the end faces of smaller and of larger z.
    """
    sections = own.sections(own.face(), 2), _other_axis(result, mate.sections(mate.face(), 2))
    points = np.concatenate([part.reshape(-1, 3) for part in sections])
    return points @ VIEW[:2].T, _ends(own) @ VIEW[:2].T


def _with_texts(outline: tuple[Floats, Floats], scale: float) -> tuple[Floats, Floats]:
    """Lower left and upper right corner of a body and the texts at its ends.

    The scale is that of the drawing, mm per point.
    """
    points, (at_small_z, at_large_z) = outline
    texts = [at_small_z - scale * TEXT, at_large_z - scale * TEXT * [0.5, 1.0]]
    texts.append(at_large_z + scale * TEXT * [0.5, 0.0])
    points = np.vstack([points, texts])
    return points.min(axis=0), points.max(axis=0)


def _arrangement(
    outlines: Sequence[tuple[Floats, Floats]], place: Floats
) -> tuple[list[Floats], float]:
    """Left, bottom, width and height of the panels as parts of a place, and mm per point.

    Parameters
    ----------
    outlines : sequence of tuple
        As of `_outline`, per body.
    place : (2,) array
        Width and height, points.
    """
    found = []
    count = len(outlines)
    for step in (np.array([1.0, 0.0]), np.array([0.0, -1.0])):  # beside, above each other
        panel = np.where(step, 1.0 / count, 1.0)
        panel[1] -= TITLE / place[1]
        scale = 0.0
        for _ in range(SCALE_STEPS):  # texts have a size of their own
            corners = [_with_texts(outline, scale) for outline in outlines]
            scale = float(np.max([(high - low) / (place * panel) for low, high in corners]))
        first = np.array([0.0, 1.0 - 1.0 / count]) if step[1] else np.zeros(2)
        starts = [first + k * step / count for k in range(count)]
        found.append((scale, [np.concatenate([start, panel]) for start in starts]))
    scale, panels = min(found, key=lambda each: each[0])
    return panels, scale


def draw_loaded_body(axes: Axes, result: Result, p: int, body: int) -> None:
    """Draw the teeth of a body over its width, contours of its mate, and the line load."""
    pair = teeth_in_mesh(result, p, 1), teeth_in_mesh(result, p, 2)
    _draw_teeth(axes, pair[body - 1], STEEL[body - 1])
    _draw_mate(axes, result, pair[2 - body], STEEL[2 - body])
    _draw_load(axes, result, p, body)
    _mark_ends(axes, pair[body - 1])
    axes.set_aspect("equal")
    axes.set_axis_off()
    axes.autoscale_view()


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


def _draw_load(axes: Axes, result: Result, p: int, body: int) -> None:
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
    shown.set_clim(0.0, _most(result, p))
    axes.add_collection(shown)
    if load.size:
        ring = bands[load.argmax()].mean(axis=0)
        axes.plot(*ring, marker="o", markersize=9, mfc="none", mec=EDGE, zorder=7)


def _ends(teeth: Teeth) -> Floats:
    """(2, 3) Lower front corners of the end faces of smaller and of larger z."""
    return teeth.sections(teeth.rim()[:1], 2)[:, 0]


def _mark_ends(axes: Axes, teeth: Teeth) -> None:
    """Axial positions of both end faces, below the front edge."""
    ends = _ends(teeth)
    for (x, y), z, side in zip(ends @ VIEW[:2].T, ends[:, 2], ("right", "center"), strict=True):
        text = f"z = {z:g} mm".replace("-", "−")
        note(axes, text, (x, y), offset=(0, -3), ha=side, va="top", fontsize=8)


def _most(result: Result, p: int) -> float:
    """Largest line load of a position, N/mm; 1 without load."""
    assert result.slices is not None
    return float(result.slices.line_load_N_per_mm[p].max(initial=0.0)) or 1.0


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
