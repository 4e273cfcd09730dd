"""The loaded teeth of a body in three dimensions, projected, for any program that draws polygons.

Each body is drawn in a frame on its own axis, in which its teeth point to positive x and its loaded
flanks have positive normals y: that of body 1 is the world, that of body 2 the world turned by 180°
about z. An internal pair meets at negative x: its body 1 is turned, its body 2 is not.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import cos, pi, sin
from typing import TYPE_CHECKING

import numpy as np

from flankload.base.rotation import turned

if TYPE_CHECKING:
    from flankload.base.arrays import Floats
    from flankload.bodies.axial_shape import AxialShape
    from flankload.result import Result

#: Facets of a tooth along its contour at most, and along z.
CONTOUR_FACETS, AXIAL_FACETS = 40, 10
#: Width of the bands of load and depth of the rim below the root, in heights of the teeth.
BAND, RIM = 0.12, 0.7


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


@dataclass(frozen=True)
class LoadedTeeth:
    """Polygons of a body in the plane of the picture, mm, in the order in which they are drawn.

    Attributes
    ----------
    far : (n, 2) array
        End face of the mate behind.
    facets : (m, 4, 2) array
        Visible sides of the teeth, from back to front.
    shade : (m,) array
        Brightness of the facets, 0 to 1.
    bands : (k, 4, 2) array
        Contacts along their contact lines, never hidden by a tooth.
    load_N_per_mm : (k,) array
        Force per mm of face width of each band.
    face : (n, 2) array
        End face of the body.
    near : (n, 2) array
        Contour of the mate's end face before it.
    ends : (2, 2) array
        Lower front corners of the end faces of smaller and of larger z.
    z_mm : (2,) array
        Axial positions of the end faces.
    """

    far: Floats
    facets: Floats
    shade: Floats
    bands: Floats
    load_N_per_mm: Floats
    face: Floats
    near: Floats
    ends: Floats
    z_mm: Floats

    @property
    def outline(self) -> Floats:
        """(n, 2) Points between which everything lies."""
        return np.vstack([self.far, self.near, self.face, self.facets.reshape(-1, 2)])


def loaded_teeth(
    result: Result,
    p: int,
    body: int,
    contour_facets: int = CONTOUR_FACETS,
    axial_facets: int = AXIAL_FACETS,
) -> LoadedTeeth:
    """The teeth of body 1 or 2 at position p of a result over the face width."""
    own, mate = (teeth_in_mesh(result, p, z, contour_facets) for z in (body, 3 - body))
    facets, shade = _facets(own, 1 + (axial_facets if own.shape.twist_rad_per_mm else 1))
    bands, load = _bands(result, p, body)
    far, _ = _other_axis(result, mate.sections(mate.face(), 2)) @ VIEW[:2].T
    _, near = _other_axis(result, mate.sections(mate.contour(), 2)) @ VIEW[:2].T
    ends = own.sections(own.rim()[:1], 2)[:, 0]
    return LoadedTeeth(
        far=far,
        facets=facets,
        shade=shade,
        bands=bands,
        load_N_per_mm=load,
        face=own.sections(own.face(), 2)[-1] @ VIEW[:2].T,
        near=near,
        ends=ends @ VIEW[:2].T,
        z_mm=ends[:, 2],
    )


def teeth_in_mesh(result: Result, p: int, body: int, contour_facets: int = CONTOUR_FACETS) -> Teeth:
    """The teeth of body 1 or 2 that carry load at position p, and their neighbours."""
    drawing = result.drawing
    shape = drawing.axial[body - 1]
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
        turned(_fewer(outline, contour_facets), angle + pitch * k)
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


def _fewer(contour: Floats, count: int) -> Floats:
    """Some points of a contour, closer where it bends."""
    steps = np.diff(contour, axis=0)
    length = np.hypot(*steps.T)
    bend = np.append(np.abs(np.diff(np.unwrap(np.arctan2(*steps.T[::-1])))), 0.0)
    along = np.append(0.0, np.cumsum(length / length.sum() + bend / bend.sum()))
    places = np.interp(np.linspace(0.0, 2.0, count + 1), along, np.arange(along.size))
    return np.asarray(contour[np.unique(np.rint(places).astype(int))])


def _facets(teeth: Teeth, count: int) -> tuple[Floats, Floats]:
    """Visible facets (m, 4, 2) of the teeth and of the cut behind the last, and their brightness.

    They are in the order of the teeth, each from back to front, with `count` sections.
    """
    cut = np.vstack([teeth.contour()[-1], teeth.rim()[0]])
    found, shades = [], []
    for contour in (*teeth.contours, cut):
        grid = teeth.sections(contour, count)
        corners = [grid[:-1, :-1], grid[:-1, 1:], grid[1:, 1:], grid[1:, :-1]]
        facets = np.stack(corners, axis=2).reshape(-1, 4, 3)
        normal = np.cross(facets[:, 1] - facets[:, 0], facets[:, 3] - facets[:, 0])
        normal /= np.linalg.norm(normal, axis=1, keepdims=True)
        seen = normal @ VIEW[2] > 0
        facets, normal = facets[seen], normal[seen]
        back_to_front = np.argsort(facets.mean(axis=1) @ VIEW[2], kind="stable")
        shades.append((0.55 + 0.45 * np.clip(normal @ LIGHT, 0.0, 1.0))[back_to_front])
        found.append((facets @ VIEW[:2].T)[back_to_front])
    return np.concatenate(found), np.concatenate(shades)


def _bands(result: Result, p: int, body: int) -> tuple[Floats, Floats]:
    """Bands (k, 4, 2) along the contact line of each contact, and their line loads, N/mm."""
    slices, shape = result.width_loads, result.drawing.axial[0]
    place, normal, force = _contacts(result, p)
    width = slices.width_mm[np.searchsorted(slices.z_mm, place[:, 2])]
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
    return bands @ VIEW[:2].T, force / width
