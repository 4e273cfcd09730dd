"""Fields of the loaded bodies as VTU files, one per body and position, and their PVD collection."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from html import escape
from math import degrees
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from flankload.base.arguments import require, require_path
from flankload.base.files import would_replace, write_atomically
from flankload.errors import SceneError
from flankload.mechanisms.registry import mechanism_of
from flankload.meshes.io import vtu_of
from flankload.result import PairTable, Result
from flankload.scene import Scene, SceneLike, scene_of
from flankload.scene.refusal import refuse
from flankload.studies.tolerance import first_scene

if TYPE_CHECKING:
    from flankload.mechanisms.protocol import FieldsOfBody


#: Name of the collection in each folder.
COLLECTION = "loaded_pair.pvd"
#: Patterns of the names of all files, of one torque and of several.
OF_TORQUE = ("body_[123]_*.vtu", "planet_*.vtu", "contacts_*.vtu", COLLECTION)
NAMES = (*OF_TORQUE, *(f"torque_*_Nm/{name}" for name in OF_TORQUE))


def write_vtu(
    scene: SceneLike,
    results: Result | Sequence[Result],
    folder: str | Path,
    *,
    positions: Sequence[int] | None = None,
) -> tuple[str, ...]:
    """Write the loaded bodies at each position, for ParaView.

    `loaded_pair.pvd` lists all files over the angle of body 1 in degrees. `body_1_0000.vtu`, …, of
    a planetary stage also `planet_1_0000.vtu`, …, have the elements of a whole body at position 0,
    in mm, undeformed, in the frame of the drawings, with displacement_mm, stress_MPa (xx, yy, zz,
    xy, yz, xz), von_mises_MPa, contact_pressure_MPa and contact_force_N of the nodes, in single
    precision: displacement and stress that the contact forces of the result cause in the elements
    of the scene. `contacts_0000.vtu`, … have a line for each contact cell, with pressure_MPa,
    force_N, gap_um and pair, as in `Result.pairs`. Several torques have a folder each.

    Parameters
    ----------
    scene : Scene, typed pair, path or mapping
        As for `solve`.
    results : Result or sequence of Result
        Results of this scene.
    folder : path
    positions : sequence of int, optional
        Indices of positions; by default all.

    Returns
    -------
    tuple of str
        A line for each body: what was written, or why there is no file.

    Raises
    ------
    InputError
        If the results are none.
    SceneError
        If a position does not exist, or a file that the scene reads would be replaced.
    """
    scene = scene_of(scene)
    fits = isinstance(results, Result | Sequence)
    require("results", results, "a Result or a sequence of them", fits=fits)
    require_path("folder", folder)
    several = tuple(results) if isinstance(results, Sequence) else results.by_torque
    chosen = checked_positions(several, positions)
    for key, file in scene.files.items():
        if would_replace(Path(folder), NAMES, file):
            expected = f"a folder whose files do not replace {file} (that of {key})"
            refuse("folder", expected, str(folder))
    mechanism = mechanism_of(scene)
    if mechanism.no_flanks_reason is not None:
        return (f"no fields: the scene has {mechanism.no_flanks_reason}",)
    bodies = mechanism.fields_of_bodies(_as_solved(scene))
    for result in several:
        part = f"torque_{result.torque_Nm:.15g}_Nm" if len(several) > 1 else ""
        _write_torque(Path(folder) / part, result, bodies, chosen)
    places = f"{len(chosen)} position{'s' * (len(chosen) != 1)}"
    counts = {name: found for name, found in bodies.items() if not isinstance(found, str)}
    lines = {n: f"{one.section_nodes} nodes at {places}" for n, one in counts.items()}
    return tuple(f"{name}: {lines.get(name, found)}" for name, found in bodies.items())


def checked_positions(results: Sequence[Result], positions: Sequence[int] | None) -> list[int]:
    """Indices of positions, all if none are given; refused if an index does not exist."""
    count = min(result.position_rad.size for result in results)
    if positions is None:
        return list(range(count))
    for p in positions:
        if not 0 <= p < count:
            raise SceneError(
                key="--vtu-positions", expected=f"indices from 0 to {count - 1}", found=p
            )
    return list(dict.fromkeys(positions))


def _as_solved(scene: Scene) -> Scene:
    """The scene with a discretization and with the effects of its result."""
    scene = first_scene(scene)
    if scene.effects.choose is not None:
        from flankload.studies.plan.choice import choose_effects

        scene, _ = choose_effects(scene)
    return scene


def _write_torque(
    folder: Path,
    result: Result,
    bodies: Mapping[str, FieldsOfBody | str],
    positions: Sequence[int],
) -> None:
    """Write the files of one torque; the collection is the last one."""
    folder.mkdir(parents=True, exist_ok=True)
    listed = []
    for p in positions:
        files = {
            name: _fields_of(body, result, p)
            for name, body in bodies.items()
            if not isinstance(body, str)
        }
        tables = [result.pairs(p)]
        if result.coast is not None:
            tables.append(result.coast.pair_tables[p])
        if any(len(table) for table in tables):
            files["contacts"] = _contacts_of(tables)
        angle = degrees(float(result.position_rad[p]))
        for part, (name, content) in enumerate(files.items()):
            file = f"{name}_{p:04d}.vtu"
            write_atomically(folder / file, content)
            listed.append(
                f'    <DataSet timestep="{angle!r}" group="" part="{part}" '
                f'name="{escape(name)}" file="{escape(file)}"/>\n'
            )
    write_atomically(
        folder / COLLECTION,
        '<?xml version="1.0"?>\n<VTKFile type="Collection" version="0.1">\n  <Collection>\n'
        + "".join(listed)
        + "  </Collection>\n</VTKFile>\n",
    )


def _fields_of(body: FieldsOfBody, result: Result, p: int) -> bytes:
    """Content of the file of a body at a position."""
    fields = body.at(result, p)
    values = {
        "displacement_mm": fields.displacement_mm,
        "stress_MPa": fields.stress_MPa,
        "von_mises_MPa": fields.von_mises_MPa,
        "contact_pressure_MPa": fields.contact_pressure_MPa,
        "contact_force_N": fields.force_N,
    }
    return vtu_of(
        fields.points_mm,
        body.cells,
        {name: field.astype(np.float32) for name, field in values.items()},
    )


def _contacts_of(tables: Sequence[PairTable]) -> bytes:
    """Content of the file of the contact cells of a position, each a line along the flank."""
    ends, columns = [], []
    for table in tables:
        none = np.zeros(len(table))
        height = none if table.z_mm is None else table.z_mm
        place = np.column_stack([table.x_mm, table.y_mm, height])
        tangent = np.column_stack([table.normal_y, -table.normal_x, none])
        half = 0.5 * table.cell_mm[:, None] * tangent
        ends.append(np.stack([place - half, place + half], axis=1))
        columns.append((table.pressure_MPa, table.force_N, table.gap_um, table.site))
    points = np.concatenate(ends).reshape(-1, 3)
    pressure, force, gap, pair = (np.concatenate(column) for column in zip(*columns, strict=True))
    return vtu_of(
        points,
        [("line", np.arange(len(points)).reshape(-1, 2))],
        {},
        {"pressure_MPa": [pressure], "force_N": [force], "gap_um": [gap], "pair": [pair]},
    )
