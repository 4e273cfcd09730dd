"""Reading of a study file (TOML)."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from msgspec import Meta

from flankload.errors import SceneError
from flankload.scene.form import read_table
from flankload.scene.reader import read_scene, read_tables
from flankload.scene.refusal import refuse, shown
from flankload.scene.table import Table, Text
from flankload.studies.design.designs import Designs
from flankload.studies.design.solve_study import QUANTITIES, check_first
from flankload.studies.variables import paths_of, variables_of

if TYPE_CHECKING:
    from flankload.scene import Scene

Names = Annotated[tuple[Text, ...], Meta(min_length=1)]


class StudyKeys(Table, frozen=True, kw_only=True):
    """Keys of a study file beside its tables [variables] and [changes], as of `study`.

    The paths of the scene and the store are relative to the folder of the study; the store is by
    default the name of the study file with the suffix .sqlite.
    """

    scene: Text
    design: Text = "factorial"
    n: int | None = None
    seed: int = 0
    quantities: Names = QUANTITIES
    store: Text | None = None


@dataclass(frozen=True)
class StudyFile:
    """A study as its file defines it."""

    file: Path
    scene: Scene
    designs: Designs
    quantities: tuple[str, ...]
    store: Path


def read_study(path: str | Path) -> StudyFile:
    """Read a study file and its scene.

    Raises SceneError if a file cannot be read, or the study or its first design is invalid.
    """
    path = Path(path)
    tree = read_tables(path, "a study file")
    try:
        variables, changes = (tree.pop(name, {}) for name in ("variables", "changes"))
        found = variables_of(variables)
        keys = read_table(StudyKeys, tree, "")
        if not isinstance(changes, dict):
            refuse("changes", "a table of paths with values", shown(changes))
        fixed = paths_of(changes)
        designs = Designs(found, keys.design, keys.n, keys.seed, fixed)
        designs.check()
    except SceneError as error:
        raise error.with_file(path) from None
    scene = read_scene(path.parent / keys.scene)
    try:
        designs = designs.in_scene(scene)
        check_first(scene, designs)
    except SceneError as error:
        raise (error if error.file else error.with_file(path)) from None
    store = path.with_suffix(".sqlite") if keys.store is None else path.parent / keys.store
    return StudyFile(path, scene, designs, keys.quantities, store)
