"""Description of a plane mesh: size, quality, sets."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from flankload.meshes.plane_mesh import (
    aspect_ratios,
    boundary_edges,
    chain,
    circle_through,
    counter_clockwise,
    raise_to_quadratic,
    scaled_jacobians,
)

if TYPE_CHECKING:
    from flankload.base.arrays import Cells, Floats, Numbers
    from flankload.meshes.io import RawMesh

    Rows = list[tuple[str, str]]

#: Usual range of radii, mm; smaller ones are probably in metres, larger ones in micrometres.
SMALL_MM, LARGE_MM = 1.0, 1e4
#: Largest relative difference of equal radii.
RADIUS_TOLERANCE = 1e-6
#: Limits of the scaled Jacobian, the sine of the worst angle. The error of an element is inversely
#: proportional to it: twice that of a square at the first limit, five times at the second.
GOOD, USABLE = 0.5, 0.2
#: Largest distance of the number of sectors in a turn from a whole number.
SECTOR_COUNT_TOLERANCE = 1e-3


def quality_rows(nodes: Floats, cells: Cells) -> Rows:
    """Least scaled Jacobian with a verdict and largest aspect ratio of quadratic elements."""
    rows = []
    for name, measure, worst_of in (
        ("least scaled Jacobian", scaled_jacobians, np.argmin),
        ("largest aspect ratio", aspect_ratios, np.argmax),
    ):
        values = np.concatenate([measure(nodes, kind, data) for kind, data in cells])
        centres = np.vstack([nodes[data].mean(axis=1) for _, data in cells])
        worst = int(worst_of(values))
        x, y = centres[worst]
        rows.append((name, f"{values[worst]:.2f} (at x = {x:.3f}, y = {y:.3f} mm)"))
        if measure is scaled_jacobians:
            rows.append(("shape of the elements", verdict(float(values[worst]))))
    return rows


def verdict(scaled_jacobian: float) -> str:
    """Verdict on the least scaled Jacobian of a mesh."""
    if scaled_jacobian >= GOOD:
        return "good"
    if scaled_jacobian >= USABLE:
        return f"usable: errors of the worst element up to {1 / USABLE:g} times those of a square"
    if scaled_jacobian > 0:
        return "poor: the worst element nearly collapses; expect wrong stresses and estimates there"
    return "invalid: an element folds over"


def mesh_rows(raw: RawMesh) -> Rows:
    """Nodes, elements, size, quality and material of a mesh."""
    low, high = raw.nodes.min(axis=0), raw.nodes.max(axis=0)
    radii = np.hypot(*raw.nodes.T)
    rows = [
        ("nodes", f"{len(raw.nodes)}"),
        *((kind, f"{len(data)} elements") for kind, data in raw.cells),
        ("x", f"{low[0]:g} to {high[0]:g} mm"),
        ("y", f"{low[1]:g} to {high[1]:g} mm"),
        ("nodes lie at radii", f"{radii.min():g} to {radii.max():g} mm from the origin"),
    ]
    nodes, cells = _oriented(raw)
    rows += quality_rows(nodes, cells)
    if raw.elastic is not None:
        modulus, ratio = raw.elastic
        rows.append(("material in the file", f"E = {modulus:g}, nu = {ratio:g}; not used"))
    return rows


def set_rows(raw: RawMesh) -> Rows:
    """Shape of each named set: a line of the boundary, an arc, all nodes, …"""
    nodes, cells = _oriented(raw)
    edges = boundary_edges(cells)
    rows = []
    for name, members in sorted(raw.sets.items(), key=lambda item: natural(item[0])):
        text = "all nodes" if members.size == len(raw.nodes) else _shape(nodes, edges, members)
        rows.append((name, f"{members.size} nodes: {text}" if members.size > 1 else "1 node"))
    return rows


def natural(name: str) -> list[tuple[str, int]]:
    """Sort key that puts FLANK_2 before FLANK_10."""
    parts = re.findall(r"(\D*)(\d*)", name)
    return [(text.casefold(), int(number or 0)) for text, number in parts]


def hints(raw: RawMesh) -> Iterator[str]:
    """Properties that are probably wrong but may be intended."""
    largest = float(np.hypot(*raw.nodes.T).max())
    if largest < SMALL_MM:
        yield (
            f"all nodes lie within {largest:.4g} mm of the origin: is the file in metres? "
            "Coordinates must be in millimetres"
        )
    if largest > LARGE_MM:
        yield (
            f"nodes lie up to {largest:.4g} mm from the origin: is the file in micrometres? "
            "Coordinates must be in millimetres"
        )
    for name, members in sorted(raw.sets.items()):
        circle = circle_through(raw.nodes[members])
        if circle is not None and np.hypot(*circle[0]) > 1e-3 * circle[1]:
            (x, y), radius = circle
            yield (
                f"set {name!r} is a circle of radius {radius:.4g} about x = {x:.4g}, y = {y:.4g} "
                "mm: should the body's axis, the origin, be there?"
            )
    for (first, second), count in _sectors(raw).items():
        yield f"sets {first!r} and {second!r} match when turned by 360/{count} deg: teeth = {count}"


def _oriented(raw: RawMesh) -> tuple[Floats, Cells]:
    """Quadratic elements, counter-clockwise if possible."""
    nodes, cells = raise_to_quadratic(raw.nodes, raw.cells)
    return nodes, counter_clockwise(nodes, cells)[0]


def _shape(nodes: Floats, edges: Numbers, members: Numbers) -> str:
    """Shape of a set on the boundary."""
    chosen = edges[np.isin(edges[:, :2], members).all(axis=1)]
    radii = np.hypot(*nodes[members].T)
    span = f"radii {radii.min():.4f} to {radii.max():.4f} mm"
    if not len(chosen):
        return f"not on the boundary, {span}"
    runs = chain(chosen)
    closed = [run for run in runs if run[0, 0] == run[-1, 1]]
    if np.ptp(radii) <= RADIUS_TOLERANCE * radii.max():
        whole = "a circle" if len(closed) == 1 == len(runs) else "an arc" if len(runs) == 1 else ""
        return f"{whole or f'{len(runs)} arcs'} of radius {radii.mean():.4f} mm about the origin"
    if len(runs) > 1:
        return f"{len(runs)} separate lines, {span}"
    steps = np.linalg.norm(nodes[runs[0][:, 1]] - nodes[runs[0][:, 0]], axis=1)
    kind = "a closed line" if closed else "a line"
    return f"{kind} of {len(steps)} edges up to {steps.max():.3g} mm, {span}"


def _sectors(raw: RawMesh) -> dict[tuple[str, str], int]:
    """Pairs of sets that match by a rotation about the origin, and the number of sectors."""
    found: dict[tuple[str, str], int] = {}
    lines = {}
    known = set()
    for name, members in sorted(raw.sets.items()):
        if members.tobytes() in known:
            continue
        known.add(members.tobytes())
        radii = np.hypot(*raw.nodes[members].T)
        order = np.argsort(radii)
        radii, places = radii[order], raw.nodes[members[order]]
        if members.size < 3 or members.size > len(raw.nodes) / 3 or not np.diff(radii).min() > 0:
            continue
        lines[name] = radii, np.arctan2(places[:, 1], places[:, 0])
    names = list(lines)
    for k, first in enumerate(names):
        for second in names[k + 1 :]:
            (radii, angles), (other, apart) = lines[first], lines[second]
            if radii.size != other.size or np.abs(radii - other).max() > 1e-6 * radii.max():
                continue
            turns = np.exp(1j * (apart - angles))
            count = 2 * np.pi / abs(float(np.angle(turns.mean())) or np.inf)
            whole = round(count)
            same_turn = np.abs(turns - turns.mean()).max() < 1e-5
            if same_turn and 3 <= whole <= 1000 and abs(count - whole) < SECTOR_COUNT_TOLERANCE:
                found[first, second] = whole
    # several pairs are the flanks of a whole body, not cut faces
    return found if len(found) == 1 else {}
