"""Measures `docs/reference/accuracy.md` and its pictures: `./dev measure` (a quarter of an hour).

Finished runs are kept in out/accuracy, so that an interrupted measurement goes on where it was.
"""

from __future__ import annotations

import tomllib
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np

import flankload as fl
from flankload.base.files import write_atomically
from flankload.plot.style import png_of
from flankload.plot.work_precision import plot_work_precision
from flankload.scene.named_discretization import NamedDiscretization
from flankload.studies.accuracy.quantities import CORNER, HEADS
from flankload.studies.accuracy.reference import Reference
from flankload.studies.accuracy.refinements import FINEST_MODES
from flankload.studies.accuracy.runs import Runs
from flankload.studies.accuracy.study_text import NAMED, PARAMETER_LABELS

DOCS = Path(__file__).parent
PAGE = DOCS / "reference"
SCENES = DOCS.parent / "examples" / "scenes"
KEPT = DOCS.parent / "out" / "accuracy"
QUANTITIES = ("transmission_error", "load_share", "peak_pressure", "stiffness")
#: CPU seconds for each study; enough for all its runs.
BUDGET_S = 60.0
PAIRS = {
    "external_gear": "External pair",
    "internal_gear": "Internal pair",
    "spline": "Spline",
}
#: What is asked of the external pair: errors of the transmission error at every position and of the
#: peak pressure, CPU seconds, and the setting that is to do it.
WANTED = {"transmission_error": 1e-3, "peak_pressure": 5e-3}
WANTED_S = 1.0
WANTED_SETTING = NamedDiscretization("pairs", 0.4, 8, 10.0, 2.5, 32)
#: Strips on the half-width on which corners are looked at, and the tip radius that cures them.
CORNER_LADDER, TIP_RADIUS_MM = (5.0, 10.0, 20.0, 40.0), 0.5


def main() -> None:
    """Measure, draw, write."""
    KEPT.mkdir(parents=True, exist_ok=True)
    studies = {}
    for name in PAIRS:
        print(f"{name} …", flush=True)
        scene = fl.read_scene(SCENES / f"{name}.toml")
        studies[name] = fl.accuracy(scene, QUANTITIES, BUDGET_S, resume=KEPT / f"{name}.jsonl")
        picture = png_of(plot_work_precision(studies[name]))
        write_atomically(DOCS / "pictures" / f"accuracy_{name}.png", picture)
    write_atomically(PAGE / "accuracy.md", "\n".join(_page(studies)) + "\n")


def _page(studies: dict[str, fl.AccuracyStudy]) -> Iterator[str]:
    text = (PAGE / "accuracy.in.md").read_text(encoding="utf-8")
    parts = {
        "PAIRS": "\n".join(line for name in PAIRS for line in _pair(name, studies[name])),
        "SHARES": "\n".join(_shares(studies)),
        "LEVELS": "\n".join(_levels(studies)),
        "WANTED": "\n".join(_wanted(studies["external_gear"])),
        "CORNERS": "\n".join(_corners()),
        "MODES": "\n".join(_modes(studies["spline"])),
    }
    for key, part in parts.items():
        text = text.replace(f"@{key}@", part)
    yield text.rstrip()


def _percent(error: float | None) -> str:
    if error is None:
        return "–"
    return "0" if error < 5e-9 else f"{100 * error:.2g}"


def _table(head: list[str], rows: list[list[str]]) -> Iterator[str]:
    yield f"| {' | '.join(head)} |"
    yield f"|{'|'.join('---' for _ in head)}|"
    yield from (f"| {' | '.join(row)} |" for row in rows)


def _named(study: fl.AccuracyStudy) -> list[str]:
    return [name for name in HEADS if any(name in row.errors for row in study.rows)]


def _pair(name: str, study: fl.AccuracyStudy) -> Iterator[str]:
    """Picture, cheapest settings, ladders of a pair."""
    yield f"### {PAIRS[name]}: `{name}.toml`"
    yield ""
    yield f"![Error over CPU seconds]({'../pictures'}/accuracy_{name}.png)"
    yield ""
    names = _named(study)
    rows = []
    for tolerance in NAMED:
        found = [study.cheapest(tolerance, measure) for measure in names]
        found.append(study.cheapest(tolerance))
        doubts = [*(study.doubt(measure) for measure in names), study.doubt()]
        cells = [
            f"{row.run.cpu_s:.2f}"
            if row is not None
            else "?"
            if (doubt or 0.0) > tolerance
            else "none"
            for row, doubt in zip(found, doubts, strict=True)
        ]
        rows.append([f"{100 * tolerance:g} %", *cells])
    doubts = [f"{_percent(study.doubts[measure])} %" for measure in names]
    rows.append(["uncertainty of the reference", *doubts, f"{_percent(study.doubt())} %"])
    yield "CPU seconds of the cheapest setting:"
    yield ""
    yield from _table(["to", *(HEADS[measure] for measure in names), "all"], rows)
    yield ""
    for tolerance in NAMED:
        row = study.cheapest(tolerance)
        if row is not None:
            keys = [
                f"{key} = {str(value).lower() if isinstance(value, bool) else value}"
                for table in row.run.discretization.tables().values()
                for key, value in table.items()
            ]
            yield f"- {100 * tolerance:g} % in all: `{', '.join(keys)}`"
    yield ""


def _shares(studies: dict[str, fl.AccuracyStudy]) -> Iterator[str]:
    """Errors of each parameter at its default."""
    for name, study in studies.items():
        names = _named(study)
        rows = []
        for parameter, words in PARAMETER_LABELS.items():
            for row in study.steps.get(parameter, ()):
                at_default = getattr(row.run.discretization, parameter) == getattr(
                    study.knobs.base, parameter
                )
                if at_default and row.run.discretization.adaptive is None:
                    cells = [_percent(row.alone.get(measure)) for measure in names]
                    rows.append([f"{words} {getattr(row.run.discretization, parameter):g}", *cells])
        default = next(row for row in study.rows if row.group == "default")
        cells = [_percent(default.errors.get(measure)) for measure in names]
        rows.append([f"all of them, {default.run.cpu_s:.2f} CPU s", *cells])
        yield f"{PAIRS[name]}:"
        yield ""
        yield from _table(["default", *(HEADS[measure] for measure in names)], rows)
        yield ""


def _levels(studies: dict[str, fl.AccuracyStudy]) -> Iterator[str]:
    names = list(HEADS)
    rows = []
    for name, study in studies.items():
        base = study.knobs.base
        for row in study.rows:
            level, apart = row.run.discretization.level, row.run.discretization.flank_element_mm
            plain = row.run.discretization.count == base.count and apart == base.flank_element_mm
            if level == "nodes":
                plain = row.run.discretization.count == base.count
                level = "nodes" if apart is None else f"nodes, {apart:g} mm"
            if row.group == "default" or (row.group == row.run.discretization.level and plain):
                cells = [_percent(row.errors.get(measure)) for measure in names]
                sweep = row.run.stages.get("sweep", 0.0)
                said = [f"{row.run.cpu_s:.3f}", f"{1000 * sweep:.0f}"]
                rows.append([PAIRS[name], level, *said, *cells])
    head = ["", "level", "CPU s", "of which sweeps, ms", *(HEADS[measure] for measure in names)]
    yield from _table(head, rows)


def _wanted(study: fl.AccuracyStudy) -> Iterator[str]:
    """A run with even positions against the limits of the study."""
    runs = Runs(fl.read_scene(SCENES / "external_gear.toml"), KEPT / "external_gear.jsonl")
    run = runs.at(WANTED_SETTING)
    errors = Reference(runs.done, study.knobs).errors(run)
    asked = ", ".join(f"{100 * b:g} % of the {n.replace('_', ' ')}" for n, b in WANTED.items())
    got = ", ".join(f"{100 * errors[n]:.2g} % ({n.replace('_', ' ')})" for n in WANTED)
    yield (
        f"{asked} at {WANTED_SETTING.count} positions for at most {WANTED_S:g} CPU second, "
        f"elements included: {got} for {run.cpu_s:.2f} CPU seconds, with"
    )
    yield ""
    yield "```toml"
    yield run.discretization.lines()
    yield "```"


def _corners() -> Iterator[str]:
    """Largest pressure on sharp tips and on rounded ones, by strips."""
    tree = tomllib.loads((SCENES / "external_gear.toml").read_text(encoding="utf-8"))
    sharp = fl.Scene.from_dict(tree)
    for body in ("body_1", "body_2"):
        tree[body] = tree[body] | {"tip_radius_mm": TIP_RADIUS_MM}
    round_ = fl.Scene.from_dict(tree)
    rows = []
    for scene, words in ((sharp, "sharp tips"), (round_, f"tip radius {TIP_RADIUS_MM:g} mm")):
        runs = Runs(scene)
        cells, errors = [], []
        for strips in CORNER_LADDER:
            discretization = NamedDiscretization(strips_per_half_width=strips, modes=FINEST_MODES)
            values = runs.at(replace(discretization, flank_element_mm=0.5)).values
            assert values is not None
            corner, smooth = (float(np.max(values[key])) for key in (CORNER, "largest_pressure"))
            cells.append(f"{max(corner, smooth):.0f}{'*' * (corner > smooth)}")
            errors.append(float(values["transmission_error_mean"][0]))
        rows.append([words, *cells, f"{100 * abs(errors[0] / errors[-1] - 1):.2g} %"])
    yield from _table(
        [
            "largest pressure, MPa",
            *(f"{n:g} strips" for n in CORNER_LADDER),
            "change of the mean TE",
        ],
        rows,
    )


def _modes(study: fl.AccuracyStudy) -> Iterator[str]:
    """Modes on the default elements, against the limit of all parameters."""
    base = study.knobs.base
    rows = []
    for elements, words in ((base.flank_element_mm, "default"), (None, "finest")):
        cells = []
        for modes in study.knobs.ladders["modes"]:
            discretization = replace(base if elements else study.knobs.finest, modes=int(modes))
            row = next(
                (row for row in study.rows if row.run.discretization == discretization), None
            )
            cells.append("–" if row is None else _percent(row.errors.get("peak_pressure")))
        rows.append([f"{words} elements", *cells])
    modes_of = [f"{int(modes)} modes" for modes in study.knobs.ladders["modes"]]
    yield from _table(["error of the peak pressure, %", *modes_of], rows)


if __name__ == "__main__":
    main()
