"""The page of a report from its parts."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping, Sequence
from datetime import date
from hashlib import sha256
from importlib.resources import files
from pathlib import Path
from typing import TYPE_CHECKING, Any

import flankload
from flankload.base.arguments import require, require_path
from flankload.base.files import write_atomically
from flankload.base.number_text import error_of
from flankload.errors import FlankloadError, SceneError
from flankload.mechanisms.registry import mechanism_of
from flankload.report.findings import certificate_rows, findings_of, source_rows
from flankload.report.glossary import terms_of
from flankload.report.key_figures import key_rows, percent
from flankload.report.pictures import curve_data, plots_of
from flankload.report.turning import turning
from flankload.result import Result
from flankload.scene import Scene, SceneLike, scene_of
from flankload.scene.axial import three_dimensional_key
from flankload.studies.tolerance import first_scene

if TYPE_CHECKING:
    from flankload.mechanisms.data_sheet import DataSheet

#: A symbol with an index.
INDEXED = re.compile(r"([^\W_]+)_([^\W_]+)")
#: Parts of the page beside the template.
PARTS = ("page.html", "style.css", "script.js")
#: Digits of a digest that are printed.
SHOWN_DIGITS = 16


def write_report(
    results: Result | Sequence[Result], scene: SceneLike, path: str | Path, *, line: str = ""
) -> None:
    """Write the report of a scene, as for `report_html`: completely or not at all.

    Raises
    ------
    OSError
        If the file cannot be written.
    """
    require_path("path", path)
    write_atomically(path, report_html(results, scene, line=line))


def scene_of_report(scene: Scene) -> Scene:
    """Return the scene with adaptive positions if it leaves the positions to the program.

    A report quotes peak to peak and harmonics, which a few even positions miss. The scene stays as
    it is if it names a key of [positions] other than `driver`, if its tolerance chooses the
    positions, or if its bodies have no adaptive positions: belts and chains, cams,
    three-dimensional bodies, whose positions cost more, and splines on common axes.
    """
    named = {key for key in scene.named_discretization_keys if key.startswith("positions.")}
    if named - {"positions.driver"} or scene.names_tolerance:
        return scene
    if scene.is_drive or scene.is_concentric:
        return scene
    if not scene.body_2.has_teeth or three_dimensional_key(scene) is not None:
        return scene
    try:
        return scene.replace({"positions.adaptive": True})
    except SceneError:  # an effect that does not go with them
        return scene


def report_html(
    results: Result | Sequence[Result], scene: SceneLike, *, line: str = "", day: date | None = None
) -> str:
    """Return the report of a scene as one page without references to other files.

    Parameters
    ----------
    results : Result, or sequence of Result
        Results of `solve`, one per torque.
    scene : Scene, typed pair, path or mapping
        The scene that was solved, as for `solve`.
    line : str
        Command line that repeats the run; absent = `flankload report` of the scene's file.
    day : date, optional
        Date of the report; absent = today.

    Returns
    -------
    str
        HTML. All text from the scene is escaped.

    Raises
    ------
    FlankloadError
        If jinja2 is not installed.
    InputError
        If an argument has a wrong type.
    """
    scene = scene_of(scene)
    name = "SCENE" if scene.file is None else scene.file.name
    template = _template()
    content = {
        "line": line or f"flankload report {name} -o report.html",
        "day": (day or date.today()).isoformat(),
        **_content(_by_torque(results), scene),
    }
    return str(template.render(content))


def _by_torque(results: Result | Sequence[Result]) -> tuple[Result, ...]:
    """Results of single torques, ascending."""
    several = results.by_torque if isinstance(results, Result) else results
    fits = isinstance(several, Sequence) and all(isinstance(one, Result) for one in several)
    require("results", results, "a Result or a sequence of them", fits=fits and len(several) > 0)
    return tuple(sorted(several, key=lambda result: result.torque_Nm))


def _template() -> Any:
    try:
        from jinja2 import DictLoader, Environment
    except ImportError:
        raise FlankloadError(
            "a report needs the package jinja2, which is missing: pip install jinja2"
        ) from None
    folder = files("flankload.report") / "page"
    parts = {name: (folder / name).read_text(encoding="utf-8") for name in PARTS}
    environment = Environment(
        loader=DictLoader(parts),
        autoescape=True,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    environment.filters["symbol"] = _symbol
    environment.filters["percent"] = percent
    environment.filters["error_of"] = error_of
    return environment.get_template("page.html")


def _symbol(text: str) -> Any:
    """A symbol with its index as a subscript."""
    from markupsafe import Markup, escape

    return Markup(INDEXED.sub(r"\1<sub>\2</sub>", str(escape(text))))


def _content(results: Sequence[Result], scene: Scene) -> dict[str, Any]:
    """Everything else that the template names."""
    scene_text = scene.to_toml()
    plots = plots_of(results)
    turned = turning(results)
    sheet = mechanism_of(scene).data_sheet(first_scene(scene))
    figures = key_rows(results)
    rows: tuple[Any, ...] = (*sheet.bodies[0], *sheet.bodies[1], *sheet.pair, *figures)
    orders = any("mesh order" in figure.name for figure in figures)
    torques = [f"{result.torque_Nm:g} N m" for result in results]
    stages = results[-1].cost.get("stages", {})  # for all torques together
    return {
        "scene": scene,
        "results": results,
        "version": flankload.__version__,
        "positions": _positions(results[-1]),
        "digest": sha256(scene_text.encode()).hexdigest()[:SHOWN_DIGITS],
        "files": _digests(scene.files),
        "scene_text": scene_text,
        "findings": findings_of(results),
        "figures": figures,
        "sheet": sheet,
        "sheet_rows": _merged(sheet),
        "plots": plots,
        "turned": turned,
        "stages": [(name, one["wall_s"], one["cpu_s"]) for name, one in stages.items()],
        "sources": source_rows(results[-1]),
        "certificates": certificate_rows(results),
        "terms": terms_of((row.symbol for row in rows), path=bool(sheet.path), orders=orders),
        "data": _json({"plots": curve_data(plots, torques), **turned.data}),
    }


def _positions(result: Result) -> str:
    """Number and kind of the positions in words."""
    count = result.position_rad.size
    if result.stands_alike or count == 1:
        return "one position" if count == 1 else f"{count} positions, all alike"
    over = f" over {result.engagement.period_in_words(result)}" if result.closed else ""
    rounds = result.cost.get("position_rounds", 1)
    adaptive = ", placed adaptively" if rounds > 1 else ""
    return f"{count} positions" + over + adaptive


def _digests(paths: Mapping[str, Path]) -> dict[str, str]:
    """Name and digest of each file that the scene reads."""
    return {
        path.name: sha256(path.read_bytes()).hexdigest()[:SHOWN_DIGITS]
        for path in paths.values()
        if path.is_file()
    }


def _merged(sheet: DataSheet) -> list[tuple[str, str, str, str]]:
    """Rows of both bodies side by side: name, symbol, both values; those of one body last."""
    one, two = ({(row.name, row.symbol): row.value for row in rows} for rows in sheet.bodies)
    order = list(one)
    for k, key in enumerate(two):
        if key not in one:
            before = [other for other in list(two)[:k] if other in order]
            order.insert(order.index(before[-1]) + 1 if before else 0, key)
    return [(*key, one.get(key, "–"), two.get(key, "–")) for key in order]


def _json(data: Mapping[str, Any]) -> Any:
    """Data for a script element: no text in it can end the element."""
    from markupsafe import Markup

    text = json.dumps(data, separators=(",", ":"), allow_nan=False)
    for letter in "<>&":
        text = text.replace(letter, f"\\u{ord(letter):04x}")
    return Markup(text)
