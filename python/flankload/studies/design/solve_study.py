"""A design study: from its definition, also in a file (TOML), to its rows."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from contextlib import closing, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from msgspec import Meta

from flankload.base.arguments import require, require_path
from flankload.base.files import path_of
from flankload.errors import SceneError
from flankload.scene import Scene, SceneLike, scene_of
from flankload.scene.form import read_table
from flankload.scene.reader import read_scene, read_tables
from flankload.scene.refusal import in_file, refuse, shown
from flankload.scene.table import Table, Text
from flankload.scene.tree import number_at
from flankload.studies.design.design_study import DesignStudy
from flankload.studies.design.designs import ChosenDesigns, Designs
from flankload.studies.design.run_designs import run_designs
from flankload.studies.design.store import Store
from flankload.studies.settings import ESTIMATE, settings_for
from flankload.studies.variables import paths_of, variables_of

if TYPE_CHECKING:
    from concurrent.futures import Executor

    from flankload.studies.design.run_designs import Progress, Row


#: Quantities of a study that names none.
QUANTITIES = (
    "transmission_error_mean_um",
    "transmission_error_peak_to_peak_um",
    "peak_pressure_MPa",
    "contact_ratio_under_load",
    "stiffness_tangent_mean_N_per_um",
)


def study(
    scene: SceneLike,
    variables: Mapping[str, Any],
    design: str = "factorial",
    *,
    n: int | None = None,
    seed: int = 0,
    quantities: Sequence[str] = QUANTITIES,
    store: str | Path | None = None,
    executor: Executor | None = None,
) -> DesignStudy:
    """Solve many designs of one scene.

    Parameters
    ----------
    scene : Scene, path or mapping
        As for `solve`.
    variables : mapping
        By path of a key as in `Scene.replace` (several paths, separated by commas, have the same
        value): a list of values, or a distribution: {"distribution": "normal", "mean": 0,
        "standard_deviation": 3} (optionally "lower", "upper"), {"distribution": "uniform",
        "lower": 0, "upper": 30}, {"distribution": "iso_1328", "class": 7} for pitch errors and
        helix slopes of a body, or any frozen distribution of scipy.stats. Values have the unit of
        the key.
    design : str
        With values: "factorial" (all combinations), "list" (the i-th value of each), or
        "one-at-a-time" (the scene, then each value alone). With distributions: "sobol" or
        "random".
    n : int, optional
        Number of designs of "sobol" and "random".
    seed : int
        Seed of these two; more designs of the same seed begin with the same ones.
    quantities : sequence of str
        Names in `Result.summary` (of tables: dotted) or arrays over the positions. Tangents that
        none needs are left out, and so are error estimates but for the designs with the least
        values, unless the scene has `accuracy.tangents` or `accuracy.estimate`.
    store : path, optional
        SQLite file. Runs that it has are not solved again; each further run is written at once.
    executor : concurrent.futures.Executor, optional
        Threads, processes, dask or MPI; by default a thread for each processor.

    Returns
    -------
    DesignStudy
        With a row for each design, including those that failed.

    Raises
    ------
    SceneError
        Before anything is solved, if the study contradicts itself, the first design or one at the
        end of a bounded distribution is not a scene, or the store is another file; after the first
        run, if it does not have a quantity.
    FlankloadError, KeyboardInterrupt
        If a worker is lost, after Ctrl-C; finished runs are in the store.
    """
    scene = scene_of(scene)
    require_path("store", store)
    fits = executor is None or hasattr(executor, "submit")
    require("executor", executor, "an Executor", fits=fits)
    designs = Designs(variables_of(variables), design, n, seed)
    return run_study(scene, designs, quantities, store, executor)


def run_study(
    scene: Scene,
    designs: Designs,
    quantities: Sequence[str] = QUANTITIES,
    store: str | Path | None = None,
    executor: Executor | None = None,
    progress: Progress | None = None,
) -> DesignStudy:
    """Solve given designs as `study` does, with progress as for `run_designs`.

    If no design has error estimates, the best ones are solved again with these.
    """
    designs, names = checked(scene, designs, quantities)
    settings, values = settings_for(scene, names, designs.paths), _values_in(scene, designs)
    with closing(Store(None if store is None else Path(store))) as opened:

        def solved(settings: Mapping[str, Any], asked: Designs | ChosenDesigns) -> tuple[Row, ...]:
            tell = progress if asked is designs else None
            return run_designs(scene.replace(settings), asked, names, opened, executor, tell)

        rows = solved(settings, designs)
        found = DesignStudy(
            scene.name, designs, names, rows, values, scene.has_torque_list, settings
        )
        if ESTIMATE not in settings or not found.best:
            return found
        best = tuple({row.number: row for row in found.best.values()}.values())
        wanted = {key: value for key, value in settings.items() if key != ESTIMATE}
        again = solved(wanted, ChosenDesigns(designs, tuple(row.values for row in best)))
    return found.with_estimates(best, again)


def checked(
    scene: Scene, designs: Designs, quantities: Sequence[str]
) -> tuple[Designs, tuple[str, ...]]:
    """Designs with the distributions of a scene, and names of quantities, once each.

    Raises SceneError if the study contradicts itself or its first design is not a scene.
    """
    designs.check()
    designs = designs.in_scene(scene)
    check_first(scene, designs)
    if isinstance(quantities, str) or not isinstance(quantities, Iterable) or not quantities:
        refuse("quantities", "a non-empty list of names", shown(quantities))
    return designs, tuple(dict.fromkeys(quantities))


def check_first(scene: Scene, designs: Designs) -> None:
    """Refuse variables whose first values, or bounds, do not give a scene.

    The key of the SceneError is `variables.PATH` if it is that of a variable.
    """
    for values in designs.first():
        try:
            scene.replace(designs.changes(values))
        except SceneError as error:
            paths = [path for variable in designs.variables for path in variable.paths]
            for table, names in (("variables", paths), ("changes", designs.fixed)):
                if any(error.key.startswith(path) for path in names):
                    refuse(f"{table}.{error.key}", error.expected, error.found)
            raise


def _values_in(scene: Scene, designs: Designs) -> dict[str, Any]:
    """Values of the variables in the scene itself; None where it has no number."""
    found: dict[str, Any] = {}
    with suppress(SceneError):
        scene = scene.replace(designs.changes({}))
    for variable in designs.variables:
        found[variable.name] = None
        with suppress(SceneError):
            found[variable.name] = number_at(scene, variable.paths[0])
    return found


# --- study files ----------------------------------------------------------------------------------
Names = Annotated[tuple[Text, ...], Meta(min_length=1)]


class StudyKeys(Table, frozen=True, kw_only=True):
    """Keys of a study file beside its tables [variables] and [changes], as for `study`.

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
    with in_file(path):
        variables, changes = (tree.pop(name, {}) for name in ("variables", "changes"))
        found = variables_of(variables)
        keys = read_table(StudyKeys, tree, "")
        if not isinstance(changes, dict):
            refuse("changes", "a table of paths with values", shown(changes))
        designs = Designs(found, keys.design, keys.n, keys.seed, paths_of(changes))
        designs.check()
    scene = read_scene(path.parent / path_of(keys.scene))
    with in_file(path):
        designs = designs.in_scene(scene)
        check_first(scene, designs)
    store = path.with_suffix(".sqlite")
    if keys.store is not None:
        store = path.parent / path_of(keys.store)
    return StudyFile(path, scene, designs, keys.quantities, store)
