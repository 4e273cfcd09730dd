"""The commands check and schema: print an interpreted scene or mesh file, and keys of scenes."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING

from flankload.cli.outputs import refuse
from flankload.cli.settings import settings_of

if TYPE_CHECKING:
    from argparse import Namespace
    from collections.abc import Iterable
    from pathlib import Path


def check(arguments: Namespace) -> None:
    """Print the interpreted input; raise an error if it is invalid."""
    from flankload.meshes.io import is_mesh_name

    if not is_mesh_name(arguments.file):
        _check_scene(arguments.file, arguments.settings, modes=arguments.modes)
        return
    if arguments.settings:
        refuse("--set", "a scene, whose keys it sets", f"the mesh {arguments.file}")
    if arguments.modes:
        refuse("--modes", "the scene of a planetary stage", f"the mesh {arguments.file}")
    _check_mesh(arguments.file)


def _check_scene(path: Path, settings: Iterable[str], *, modes: bool) -> None:
    from flankload.mechanisms.registry import mechanism_of, modes_of
    from flankload.scene import read_scene
    from flankload.scene.derived import derived_rows
    from flankload.studies.tolerance import first_discretization, first_scene

    scene = read_scene(path, changes=settings_of(settings))
    picked = first_discretization(scene).tables()
    description = mechanism_of(scene).describe(first_scene(scene))
    found = modes_of(first_scene(scene)) if modes else ()
    print(f"{scene.name}: a valid scene")
    if derived := derived_rows(scene):
        _print_rows("derived from other keys", derived)
    for title, rows in description.rows.items():
        _print_rows(title, rows)
    if picked:
        keys = [(key, f"{value}") for table in picked.values() for key, value in table.items()]
        _print_rows(f"initial discretization for a tolerance of {scene.accuracy.tolerance:g}", keys)
    for one in found:
        print(f"\nnatural modes at {one.torque_Nm:g} N m, with the mean stiffness of a pitch")
        _print_rows("inertias", one.inertia_rows())
        print("\n".join(["", *one.rows()]))
    if description.notes:
        print()
    for note in description.notes:
        print(f"warning: {note}")


def _check_mesh(path: Path) -> None:
    from flankload.errors import MeshError
    from flankload.meshes.defects import find_defects
    from flankload.meshes.io import read_mesh
    from flankload.meshes.report import hints, mesh_rows, set_rows

    mesh = read_mesh(path)
    defects = list(find_defects(mesh))
    print(f"{path}: a plane mesh" + (" with defects" if defects else ""))
    _print_rows("mesh", mesh_rows(mesh))
    _print_rows("sets", set_rows(mesh) or [("none", "a scene needs flank and fixed sets")])
    remarks = [*mesh.notes, *hints(mesh)]
    if remarks:
        print()
    for remark in remarks:
        print(f"note: {remark}")
    if not defects:
        return
    print("\nwrong")
    for defect in defects:
        print(f"  expected {defect.expected}, found {defect.found}")
    raise MeshError(file=path, key="", expected=defects[0].expected, found=defects[0].found)


def _print_rows(title: str, rows: Iterable[tuple[str, str]]) -> None:
    rows = list(rows)
    width = max(24, *(len(name) for name, _ in rows))
    print(f"\n{title}")
    for name, value in rows:
        print(f"  {name:<{width}}  {value}")


def schema(arguments: Namespace) -> None:
    """Print the JSON schema of a scene file, or the paths of its keys."""
    from flankload.scene import scene_paths, scene_schema

    if arguments.paths:
        for key in scene_paths():
            kinds = f" ({key.kinds})" if key.kinds else ""
            unit = f" [{key.unit}]" if key.unit else ""
            print(f"{key.path}{unit}: {key.expected}; {key.meaning}{kinds}")
        return
    print(json.dumps(scene_schema(), indent=2, ensure_ascii=False))
