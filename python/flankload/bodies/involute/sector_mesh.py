"""Structured sector mesh of a gear: quadratic quadrilaterals in four blocks.

The tooth block ends at a line that sags between the two fillets. The middle block is below it, the
two side blocks below the lower fillets and root arcs; all extend to the bore in common rows. Three
blocks meet at the split point of each fillet. A tooth with rounded tips has other blocks
(`rounded_tooth`). The two halves are mirror images.
"""

from __future__ import annotations

from math import atan2, cos, pi, sin
from typing import TYPE_CHECKING

import numpy as np

from flankload.base.rotation import directions
from flankload.base.rounding import TIE
from flankload.bodies.body import SectorMesh
from flankload.bodies.involute.rounded_tooth import rounded_tooth
from flankload.bodies.involute.sector_breaks import sector_breaks, slants
from flankload.errors import SceneError
from flankload.meshes.blocks import BlockMesh, coons, edges_along, even_breaks, with_middles
from flankload.meshes.plane_mesh import jacobians

if TYPE_CHECKING:
    from flankload.base.arrays import Floats, Numbers
    from flankload.bodies.involute.sector_breaks import ToothCurve, ToothForm
    from flankload.bodies.profile.tooth_profile import ToothProfile


#: Largest sag of the tooth's foot over the height of the rim.
SAG_RATIO = 0.35


def sector_mesh(
    profile: ToothProfile,
    bore_radius_mm: float,
    lengths_mm: tuple[float, float | None],
    key: str,
    inner_key: str = "bore_diameter_mm",
    width_mm: float | None = None,
) -> SectorMesh:
    """Mesh one sector of a gear, checked, with its tooth on the +x axis; others: `tooth_mesh`."""
    mesh = tooth_mesh(profile, bore_radius_mm, lengths_mm, width_mm)
    place, found = inverted_element(mesh)
    if found:
        in_rim = place < profile.involute.root_radius_mm
        raise SceneError(
            key=f"{key}.{inner_key if in_rim else 'tip_diameter_mm'}",
            expected="a tooth and rim that can be meshed in blocks",
            found=f"{found} ({inner_key.split('_')[0]} {2 * bore_radius_mm:g} mm)",
        )
    return mesh


def inverted_element(mesh: SectorMesh) -> tuple[float, str]:
    """Radius of the worst element, mm, and its defect; "" if it is valid."""
    cells = mesh.cells[0][1]
    determinants = jacobians(mesh.nodes, "quad9", cells)
    worst = determinants.min(axis=1) / np.abs(determinants).mean(axis=1)
    place = float(np.linalg.norm(mesh.nodes[cells[worst.argmin(), 8]]))
    if worst.min() > 0.0:
        return place, ""
    return place, (
        f"an element at radius {place:.3f} mm with a Jacobian of {worst.min():.3g} "
        "relative to its mean"
    )


def tooth_mesh(
    profile: ToothForm,
    bore_radius: float,
    lengths_mm: tuple[float, float | None],
    width_mm: float | None = None,
) -> SectorMesh:
    """Mesh of an external tooth on the +x axis; its elements are not checked.

    `lengths_mm`: largest length of an element along the flank, and largest distance of the flank's
    nodes, if nodal forces require finer elements there. `width_mm`: as of `sector_breaks`.
    """
    breaks = sector_breaks(profile, bore_radius, *lengths_mm, width_mm=width_mm)
    curve = profile.curve
    mirror = np.array([1.0, -1.0])
    s_flank = with_middles(breaks.flank)
    flank = curve.point(s_flank)
    split = flank[0]
    columns = with_middles(breaks.columns)
    rows = with_middles(breaks.rows)
    angle = atan2(split[1], split[0])
    foot = _sagging_line(curve, s_flank[0], angle, columns, bore_radius)
    s_tip = with_middles(breaks.tip) if breaks.tip.size > 1 else breaks.tip
    n = 2 * breaks.layers
    inside = columns[n : columns.size - n]
    inside = (inside - inside[0]) / (inside[-1] - inside[0])
    top, top_parts = _tip_line(curve, s_tip, profile.tip_radius_mm, inside)
    shaft = split * (1 - rows[:, None]) + rows[:, None] * bore_radius * split / np.hypot(*split)

    # rows run towards the tip, columns from the working flank (y > 0) to its mirror image
    mesh = BlockMesh()
    if n:
        on_flank, on_top, on_foot = rounded_tooth(
            mesh, curve, s_flank, (foot, columns), (top, top_parts), n
        )
    else:
        up = (s_flank - s_flank[0]) / (s_flank[-1] - s_flank[0])
        across = np.stack([columns, top_parts])
        tooth = mesh.add(coons(foot, top, flank, flank * mirror, across, up), {})
        on_flank, on_top, on_foot = tooth[:, 0], tooth[-1], tooth[0]
    bore = bore_radius * directions(angle * (1 - 2 * columns))
    grid = coons(bore, foot, shaft[::-1], shaft[::-1] * mirror, columns, 1 - rows[::-1])
    middle = mesh.add(grid, {"top": on_foot})
    grid = _side_grid(profile, breaks.low, rows, shaft, bore_radius)
    right = mesh.add(grid, {"right": middle[:, 0]})
    left = mesh.add(grid[:, ::-1] * mirror, {"left": middle[:, -1]})
    fixed = np.unique(np.concatenate([right[0], middle[0], left[0]]))
    numbers = np.concatenate([on_flank, on_top[1 : s_tip.size]])
    lengths = np.concatenate([s_flank, s_tip[1:]])
    return _sector(profile, mesh, (numbers, lengths), fixed, (left[1:, -1], right[1:, 0]))


def _side_grid(
    profile: ToothForm, low: Floats, rows: Floats, shaft: Floats, bore_radius: float
) -> Floats:
    """Points of the side block, from the cut to the line from the split point to the bore."""
    half_pitch = pi / profile.teeth
    side_top, side_parts = _root_line(profile, low)
    angle = atan2(shaft[0, 1], shaft[0, 0])
    bore = bore_radius * directions(angle + (half_pitch - angle) * (1 - side_parts))
    ray = np.array([cos(half_pitch), sin(half_pitch)])
    cut = np.linalg.norm(side_top[0]) * (1 - rows) + bore_radius * rows
    sides = cut[::-1, None] * ray, shaft[::-1]
    return coons(bore, side_top, *sides, side_parts, 1 - rows[::-1])


def _sector(
    profile: ToothForm,
    mesh: BlockMesh,
    outline: tuple[Numbers, Floats],
    fixed: Numbers,
    cuts: tuple[Numbers, Numbers],
) -> SectorMesh:
    """The sector mesh; `outline`: nodes from the split point to the tip, and arc lengths."""
    nodes = mesh.nodes
    numbers, lengths = outline
    low, high = profile.mode_range_mm
    rounding = TIE * (high - low)
    carries = (lengths >= low - rounding) & (lengths <= high + rounding)
    path = numbers[carries]
    arc_length = np.full(len(nodes), np.nan)
    arc_length[path] = lengths[carries]
    beyond = numbers[lengths >= high - rounding]
    s_beyond = lengths[lengths >= high - rounding]
    return SectorMesh(
        nodes=nodes,
        cells=mesh.quads,
        flank_edges=edges_along(path),
        flank_arc_length=arc_length,
        fixed_nodes=fixed,
        left_nodes=cuts[0],
        right_nodes=cuts[1],
        teeth=profile.teeth,
        tip_edges=edges_along(beyond),
        tip_arc_length=edges_along(s_beyond),
    )


def _sagging_line(
    curve: ToothCurve, s_split: float, angle: float, columns: Floats, bore_radius: float
) -> Floats:
    """Foot of the tooth from split point to mirror image: a cubic that sags into the rim."""
    start = curve.point([s_split])[0]
    slant = float(slants(curve, np.array([s_split]))[0])
    # the line bisects the angle between the profile and the ray to the bore
    lean = 0.5 * (slant + pi - angle)
    width = 2 * start[1]
    # its middle falls by width * fall / 4, limited for a thin rim
    radius = float(np.hypot(*start))
    deepest = start[0] - radius + SAG_RATIO * (radius - bore_radius)
    fall = max(min(-cos(lean), 4 * deepest / width), -0.9)
    reach = width * np.array([-fall, -np.sqrt(1 - fall**2)])
    x = columns[:, None]
    h00, h01 = (1 + 2 * x) * (1 - x) ** 2, x**2 * (3 - 2 * x)
    h10, h11 = x * (1 - x) ** 2, x**2 * (x - 1)
    mirror = np.array([1.0, -1.0])
    return h00 * start + h01 * start * mirror + h10 * reach + h11 * reach * np.array([-1.0, 1.0])


def _tip_line(
    curve: ToothCurve, s_tip: Floats, tip_radius: float, columns: Floats
) -> tuple[Floats, Floats]:
    """Upper edge of the tooth block from working side to mirror image, and relative positions."""
    end = curve.point([curve.length_mm])[0]
    half_angle = atan2(end[1], end[0])
    length = curve.length_mm - s_tip[0] + tip_radius * half_angle
    n_own = s_tip.size - 1
    own = (s_tip - s_tip[0]) / (2 * length)
    m = (columns.size - 1) // 2
    # the nodes of the tip circle keep the spacing of the columns
    land = columns[n_own : m + 1]
    if n_own:
        land = own[-1] + (land - land[0]) / (0.5 - land[0]) * (0.5 - own[-1])
    half = np.concatenate([own[:-1] if n_own else own[:0], land])
    half[m] = 0.5
    along = np.clip(
        (half[n_own:] * 2 * length - (curve.length_mm - s_tip[0])) / tip_radius, 0, None
    )
    land_places = tip_radius * directions(half_angle - along)
    places = np.concatenate([curve.point(s_tip[:-1]), land_places])
    places[m] = [tip_radius, 0.0]
    return (
        np.concatenate([places, places[-2::-1] * [1.0, -1.0]]),
        np.concatenate([half, 1 - half[-2::-1]]),
    )


def _root_line(profile: ToothForm, low: Floats) -> tuple[Floats, Floats]:
    """Upper edge of a side block from the cut to the split point, and relative positions."""
    radius = profile.root_radius_mm
    start = profile.root_half_angle_rad
    root = radius * (pi / profile.teeth - start)
    size = float(np.diff(low).mean())
    breaks = low + root
    if root > 1e-9 * radius:
        breaks = np.concatenate([even_breaks(0.0, root, size)[:-1], breaks])
    path = with_middles(breaks)
    on_root = path < root
    places = np.where(
        on_root[:, None],
        radius * directions(pi / profile.teeth - path / radius),
        profile.curve.point(np.maximum(path - root, 0.0)),
    )
    return places, (path - path[0]) / (path[-1] - path[0])
