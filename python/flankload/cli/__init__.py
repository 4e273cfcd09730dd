"""Command line: parse, call, print. The only package that prints."""

from __future__ import annotations

import argparse
import shlex
import sys
import warnings
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn

from flankload.cli.checking import check, schema
from flankload.cli.designing import optimise, study
from flankload.cli.exploring import explore
from flankload.cli.judging import accuracy, benchmark, verify
from flankload.cli.outputs import drop, say
from flankload.cli.solving import plan, report, run
from flankload.cli.writing import compliance, mesh, record, scene
from flankload.errors import FlankloadError, SceneError, one_line, readable, reason_of

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

#: Types of values by their words; of others, text.
KINDS = {"DIR": Path, "S": float, "ID": int}
#: An option that may be repeated.
REPEATED: dict[str, Any] = {"action": "append", "default": []}
JSON_TABLE = "print JSON instead of the table"

SOLVED, NOT_SOLVED, BAD_INPUT, INTERRUPTED = 0, 1, 2, 130


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line, by default with the arguments of the process.

    Returns 0 if done, 1 if not solved, 2 for invalid input, 130 if interrupted.
    """
    line = readable(shlex.join(["flankload", *(sys.argv[1:] if argv is None else argv)]))
    arguments = parser().parse_args(argv, argparse.Namespace(line=line))
    command: Callable[[argparse.Namespace], None] = arguments.command
    try:
        with warnings.catch_warnings():
            warnings.showwarning = _show_warning
            command(arguments)
        if sys.stdout is not None:  # None if the caller closed it
            sys.stdout.flush()
    except SceneError as error:
        return _fail(error, BAD_INPUT)
    except FlankloadError as error:
        asked = vars(arguments).get("scene") or vars(arguments).get("file")
        return _fail(f"{asked}: {error}", NOT_SOLVED)
    except OSError as error:
        if error.filename is None:
            drop(sys.stdout)
        if isinstance(error, BrokenPipeError):  # the reader closed the pipe
            return SOLVED
        place = "stdout" if error.filename is None else str(error.filename)
        return _fail(f"{place}: {reason_of(error)}", NOT_SOLVED)
    except MemoryError:
        return _fail("not enough memory: fewer positions or torques need less", NOT_SOLVED)
    except KeyboardInterrupt as stop:
        return _fail(stop if stop.args else "interrupted", INTERRUPTED)
    return SOLVED


def _show_warning(message: Warning | str, *_: Any, **__: Any) -> None:
    """Print a warning in one line, such as that of a key of earlier versions."""
    say(f"flankload: warning: {one_line(message)}")


def _fail(message: object, code: int) -> int:
    say(f"flankload: {one_line(message)}")
    return code


# --- arguments ------------------------------------------------------------------------------------
class _Parser(argparse.ArgumentParser):
    def error(self, message: str) -> NoReturn:
        """Report an argument error in one line, as every other error."""
        sys.exit(_fail(f"{message} (flankload --help lists commands and options)", BAD_INPUT))


class _Version(argparse.Action):
    def __call__(self, *_: Any) -> None:
        import flankload

        print(f"flankload {flankload.__version__}")
        sys.exit(SOLVED)


def parser() -> argparse.ArgumentParser:
    """All commands with their arguments; each stores its function in `command`."""
    top = _Parser(
        prog="flankload",
        description="Load distribution on the flanks of two elastic bodies on parallel axes.",
        epilog="exit codes: 0 done, 1 could not solve, 2 bad input, 130 interrupted",
    )
    top.add_argument("--version", action=_Version, nargs=0, help="print the version")
    commands = top.add_subparsers(metavar="COMMAND", required=True)
    for add in (
        *(
            _add_run,
            _add_explore,
            _add_report_and_plan,
            _add_bodies,
            _add_accuracy,
            _add_study,
        ),
        *(_add_verify, _add_benchmark, _add_optimise, _add_scene, _add_check_and_schema),
    ):
        add(commands)
    return top


def _command(
    commands: Any,
    name: str,
    function: Callable[..., None],
    text: str,
    file: tuple[str, str] | None = ("SCENE", "scene file (TOML)"),
) -> partial[None]:
    """Add a command that reads a file; return the function that adds its options."""
    escaped = text.replace("%", "%%")  # in the list of commands, not in the text of a single one
    parser = commands.add_parser(name, help=escaped, description=f"{text[0].upper()}{text[1:]}.")
    if file is not None:
        key = "scene" if file[0] == "SCENE" else "file"
        parser.add_argument(key, metavar=file[0], type=Path, help=file[1])
    parser.set_defaults(command=function)
    return partial(_add, parser)


def _add(parser: Any, option: str, text: str, **options: Any) -> None:
    """Add an option, with the word for its value behind it; without a value it is a switch."""
    name, _, word = option.partition(" ")
    kinds: dict[str, Any] = {"metavar": word} if word else {"action": "store_true"}
    if word in KINDS:
        kinds["type"] = KINDS[word]
    parser.add_argument(name, help=text, **(kinds | options))


def _add_set(add: partial[None], words: str = "set a key of the scene") -> None:
    """Add the option that sets keys of the scene."""
    text = f"{words}, such as body_1.tip_relief_um=20 (an empty value removes the key)"
    add("--set KEY=VALUE", f"{text}; may be repeated", dest="settings", **REPEATED)


def _add_run(commands: Any) -> None:
    add = _command(commands, "run", run, "solve a scene and print a table of the result")
    _add_set(add)
    add("--json FILE", "write the result as JSON (- for stdout)")
    add("--csv FILE", "write the positions as CSV (- for stdout)")
    add(
        "--stiffness-csv FILE",
        "write transmission error and stiffness over angle and torque (- for stdout)",
    )
    add(
        "--csv-format WORD,…",
        "form of both CSV files: semicolon or tab (separator), decimal-comma, degrees",
        default="",
    )
    add("--xlsx FILE", "write a workbook with a sheet per quantity")
    add("--modelica FILE", "write tables over angle and torque for Modelica (- for stdout)")
    add("--fmu FILE", "write these tables as an FMU for co-simulation (FMI 2.0)")
    add(
        "--vtu DIR",
        "write displacement, stress and pressure of the bodies to this folder, for ParaView",
    )
    add("--vtu-positions K,…", "indices of the positions of --vtu; default: all", default="")
    add("--plot DIR", "write plots to this folder")
    add("--report FILE", "write a self-contained HTML page (- for stdout)")
    add(
        "--format F,…",
        "format of the plots: png, svg, pdf, or several; may be repeated; default: png",
        dest="formats",
        **REPEATED,
    )
    add("--dpi N", "pixels per inch of PNG files, 30 to 1200; default: 160")
    add(
        "--size WxH",
        "width and height of a plot in mm; plots with several panels keep their ratio to it; "
        "default: 183x107",
    )
    add("--cost", "print predicted and actual cost of each stage")
    add("--quiet", "print no table and no progress")


def _add_explore(commands: Any) -> None:
    words = "open a page in the browser whose sliders change a scene while its results follow"
    add = _command(commands, "explore", explore, words)
    _add_set(add)
    add(
        "--vary PATH[=LOW:HIGH]",
        "key with a slider, and its range; may be repeated; default: those that designers adjust",
        **REPEATED,
    )
    add("--port N", "port of the page on this machine; default: any free port", type=int,
        default=0)  # fmt: skip
    add("--no-browser", "print the address and open no browser")


def _add_report_and_plan(commands: Any) -> None:
    words = (
        "solve a scene and write one self-contained HTML page about it; adaptive positions if the "
        "scene names none"
    )
    add = _command(commands, "report", report, words)
    add("-o FILE", "page to write (- for stdout)", dest="output", required=True)
    _add_set(add)
    add("--quiet", "print no progress and no file name")

    words = "print the effects that a run will include, with reason, cost and size"
    add = _command(commands, "plan", plan, words)
    _add_set(add)
    add("--json", JSON_TABLE)
    add("--levels", "also try the model levels that are off")
    add("--dimension", "also try three dimensions of a plane scene")


def _add_bodies(commands: Any) -> None:
    add = _command(commands, "mesh", mesh, "write the finite element meshes of both bodies")
    _add_set(add)
    add("-o DIR", "output folder", dest="folder", required=True)
    add("--format", "default: msh", action="store", choices=("msh", "vtu", "inp"), default="msh")

    words = "write the flanks of both bodies and their compliance"
    add = _command(commands, "compliance", compliance, words)
    _add_set(add)
    add("-o DIR", "output folder", dest="folder", required=True)

    words = "write the bodies, their meshes, motions and torques for programs in Fortran and C"
    add = _command(commands, "record", record, words)
    _add_set(add)
    add("-o DIR", "output folder", dest="folder", required=True)
    add(
        "--format",
        "numbers as text (default, .dat) or as their bytes (.bin)",
        action="store",
        choices=("text", "bytes"),
        default="text",
    )


def _add_accuracy(commands: Any) -> None:
    words = (
        "print error and CPU time for each discretization parameter, and the cheapest "
        "discretizations for errors of 1 %, 0.1 % and 0.01 %"
    )
    add = _command(commands, "accuracy", accuracy, words)
    _add_set(add)
    add("--budget S", "CPU seconds after which no further run starts; default: 60", default=60.0)
    add(
        "--quantities Q,…",
        "quantities to judge: transmission_error, load_share, peak_pressure, stiffness, "
        "face_load_factor; default: transmission_error,peak_pressure",
        default="transmission_error,peak_pressure",
    )
    add("--csv FILE", "write one line per run (- for stdout)")
    add("--json FILE", "write the study as JSON (- for stdout)")
    add("--plot DIR", "write the work-precision diagram to this folder")
    words = "file of finished runs: read if it exists, updated after each run"
    add("--resume FILE", words, type=Path)


def _add_study(commands: Any) -> None:
    words = (
        "solve many designs of a scene and print the range of each quantity; after an interruption "
        "the same command resumes"
    )
    add = _command(commands, "study", study, words, ("STUDY", "study file (TOML)"))
    add(
        "-o FILE",
        "write a row per design as CSV or Parquet, by the suffix (- for CSV on stdout); may "
        "be repeated",
        dest="outputs",
        **REPEATED,
    )
    add("--plot DIR", "write the plots that suit the study to this folder")
    add("--workers N", "number of workers; default: one per processor", type=int)
    workers = partial(_add, add.args[0].add_mutually_exclusive_group())
    workers("--processes", "use processes instead of threads")
    workers("--scheduler ADDRESS", "use the workers of this dask scheduler")
    add("--quiet", "print no table and no progress")


def _add_verify(commands: Any) -> None:
    words = "compare one position with a nonlinear finite element solution (CalculiX)"
    add = _command(commands, "verify", verify, words)
    _add_set(add)
    add("--position K", "index of the position; default: 0", type=int, default=0)
    add("-o DIR", "folder that keeps input deck and output", dest="folder")
    add("--no-run", "only write the input deck")
    add("--json", JSON_TABLE)
    add("--large-displacement", "let CalculiX include the deformation of the geometry")
    add(
        "--dimension",
        "solve the scene as plane bodies or as solids in both programs; default: as it is",
        action="store",
        type=int,
        choices=(2, 3),
    )
    add(
        "--elements N",
        "elements on the half-width of each contact; default: 6, for solids 1 (their other "
        "elements and layers follow in proportion)",
        type=float,
    )
    add(
        "--most-unknowns N",
        "refuse a larger deck, with its size; default: 400000",
        type=int,
    )
    add("--time-limit S", "stop CalculiX after this many seconds")
    add("--program CCX", "name or path of CalculiX; default: ccx", default="ccx")


def _add_benchmark(commands: Any) -> None:
    words = "compare with reference results of other programs and closed forms"
    add = _command(commands, "benchmark", benchmark, words, None)
    words = "cases to compare in all quantities; default: all cases, with a line each"
    add("cases CASE", words, nargs="*")
    add("--folder DIR", "folder of the cases; default: benchmarks", default=Path("benchmarks"))
    words = "compare the answers in this file (JSON), written by another program, instead"
    add("--answers FILE", words, type=Path)
    words = "write the answers to this file (JSON; - for stdout, in place of the table)"
    add("-o FILE", words, dest="output", type=Path)
    add("--json", JSON_TABLE)


def _add_optimise(commands: Any) -> None:
    words = "minimise a key figure over values of scene keys, with gradients"
    file = ("OPTIMISATION", "file (TOML) with the scene, variables, objective and constraints")
    add = _command(commands, "optimise", optimise, words, file)
    add("-o FILE", "write the optimal scene to this file", dest="output", type=Path)


def _add_scene(commands: Any) -> None:
    words = "write the scene of a gear stage of a REXS gearbox model; without -o, list the stages"
    file = ("GEARBOX", "model (.rexs, .rexsj, .rexsz, .rexs.zip)")
    add = _command(commands, "scene", scene, words, file)
    add("--stage ID", "id of the stage; default: the only one")
    add("-o FILE", "write the scene to this file (- for stdout)", dest="output", type=Path)
    words = "torque on gear 1; required if the model has none for this stage"
    add("--torque-Nm T", words, dest="torque_Nm", type=float)
    add("--load-case ID", "id of the load case; default: the only one")
    add(
        "--flank",
        "loaded flank, if the model does not define it and the flanks of a gear differ",
        action="store",
        choices=("left", "right"),
    )
    _add_set(add, "set a key of the scene, in place of the value of the model")


def _add_check_and_schema(commands: Any) -> None:
    words = "validate a scene or a mesh file and print how it is interpreted"
    add = _command(commands, "check", check, words, ("FILE", "scene (.toml) or mesh file"))
    _add_set(add)
    add(
        "--modes", "print the natural frequencies of a planetary stage, from its computed stiffness"
    )

    add = _command(commands, "schema", schema, "print the JSON schema of scene files", None)
    add("--paths", "print a line for each key instead: path, unit, range, meaning")
