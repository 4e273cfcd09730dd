"""Command line: parse, call, print. The only package that prints."""

from __future__ import annotations

import argparse
import contextlib
import os
import shlex
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn

from flankload.cli.benchmarking import benchmark
from flankload.cli.checking import check
from flankload.cli.compliance import compliance
from flankload.cli.designing import study
from flankload.cli.importing import scene
from flankload.cli.optimising import optimise
from flankload.cli.planning import plan
from flankload.cli.reporting import report
from flankload.cli.solving import mesh, run, schema
from flankload.cli.studying import accuracy
from flankload.cli.verifying import verify
from flankload.errors import FlankloadError, SceneError

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

SOLVED, NOT_SOLVED, BAD_INPUT, INTERRUPTED = 0, 1, 2, 130


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line.

    Parameters
    ----------
    argv : sequence of str, optional
        Arguments; by default those of the process.

    Returns
    -------
    int
        0 done, 1 not solved, 2 invalid input, 130 interrupted.
    """
    line = shlex.join(["flankload", *(sys.argv[1:] if argv is None else argv)])
    arguments = parser().parse_args(argv, argparse.Namespace(line=line))
    command: Callable[[argparse.Namespace], None] = arguments.command
    try:
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
            _drop_stdout()
        if isinstance(error, BrokenPipeError):  # the reader closed the pipe
            return SOLVED
        place = "stdout" if error.filename is None else str(error.filename)
        return _fail(f"{place}: {(error.strerror or str(error)).lower()}", NOT_SOLVED)
    except MemoryError:
        return _fail("not enough memory: fewer positions or torques need less", NOT_SOLVED)
    except KeyboardInterrupt as stop:
        return _fail(stop if stop.args else "interrupted", INTERRUPTED)
    return SOLVED


def _drop_stdout() -> None:
    """Discard the rest of the buffer, which Python would otherwise write at exit."""
    with contextlib.suppress(OSError, ValueError, AttributeError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _fail(message: object, code: int) -> int:
    print(f"flankload: {' '.join(str(message).split())}", file=sys.stderr)
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
    """All commands with their arguments.

    Returns
    -------
    argparse.ArgumentParser
        Each command stores its function in `command`.
    """
    top = _Parser(
        prog="flankload",
        description="Load distribution on the flanks of two elastic bodies on parallel axes.",
        epilog="exit codes: 0 done, 1 could not solve, 2 bad input, 130 interrupted",
    )
    top.add_argument("--version", action=_Version, nargs=0, help="print the version")
    commands = top.add_subparsers(metavar="COMMAND", required=True)

    _add_run(commands)
    _add_report(commands)
    _add_plan(commands)
    _add_mesh(commands)
    compliance_parser = _command(
        commands, "compliance", compliance, "write the flanks of both bodies and their compliance"
    )
    _add_folder(compliance_parser)
    _add_accuracy(commands)
    _add_study(commands)
    _add_verify(commands)
    _add_benchmark(commands)
    _add_optimise(commands)
    _add_scene(commands)
    check_parser = _described(
        commands, "check", "validate a scene or a mesh file and print how it is interpreted"
    )
    check_parser.add_argument("file", metavar="FILE", type=Path, help="scene (.toml) or mesh file")
    check_parser.set_defaults(command=check)
    schema_parser = _described(commands, "schema", "print the JSON schema of scene files")
    schema_parser.add_argument(
        "--paths",
        action="store_true",
        help="print a line for each key instead: path, unit, range, meaning",
    )
    schema_parser.set_defaults(command=schema)
    return top


def _command(commands: Any, name: str, function: Callable[..., None], text: str) -> Any:
    """Parser of a command that reads a scene."""
    parser = _described(commands, name, text)
    parser.add_argument("scene", metavar="SCENE", type=Path, help="scene file (TOML)")
    parser.set_defaults(command=function)
    return parser


def _described(commands: Any, name: str, text: str) -> Any:
    return commands.add_parser(name, help=text, description=f"{text[0].upper()}{text[1:]}.")


def _add_folder(parser: Any) -> None:
    parser.add_argument(
        "-o", dest="folder", metavar="DIR", type=Path, required=True, help="output folder"
    )


def _add_run(commands: Any) -> None:
    parser = _command(commands, "run", run, "solve a scene and print a table of the result")
    parser.add_argument("--json", metavar="FILE", help="write the result as JSON (- for stdout)")
    parser.add_argument("--csv", metavar="FILE", help="write the positions as CSV (- for stdout)")
    parser.add_argument(
        "--stiffness-csv",
        metavar="FILE",
        help="write transmission error and stiffness over angle and torque (- for stdout)",
    )
    parser.add_argument(
        "--csv-format", metavar="WORD,…", default="",
        help="form of both CSV files: semicolon or tab (separator), decimal-comma, degrees",
    )  # fmt: skip
    parser.add_argument("--xlsx", metavar="FILE", help="write a workbook with a sheet per quantity")
    parser.add_argument(
        "--modelica", metavar="FILE",
        help="write tables over angle and torque for Modelica (- for stdout)",
    )  # fmt: skip
    parser.add_argument(
        "--fmu", metavar="FILE",
        help="write these tables as an FMU for co-simulation (FMI 2.0)",
    )  # fmt: skip
    parser.add_argument(
        "--vtu", metavar="DIR", type=Path,
        help="write displacement, stress and pressure of the bodies to this folder, for ParaView",
    )  # fmt: skip
    parser.add_argument(
        "--vtu-positions", metavar="K,…", default="",
        help="indices of the positions of --vtu; default: all",
    )  # fmt: skip
    parser.add_argument("--plot", metavar="DIR", type=Path, help="write plots to this folder")
    parser.add_argument(
        "--report", metavar="FILE", help="write a self-contained HTML page (- for stdout)"
    )
    parser.add_argument(
        "--format", dest="formats", metavar="F,…", action="append", default=[],
        help="format of the plots: png, svg, pdf, or several; may be repeated; default: png",
    )  # fmt: skip
    parser.add_argument(
        "--dpi", metavar="N", help="pixels per inch of PNG files, 30 to 1200; default: 160"
    )
    parser.add_argument(
        "--size", metavar="WxH",
        help="width and height of a plot in mm; plots with several panels keep their ratio to it; "
        "default: 183x107",
    )  # fmt: skip
    parser.add_argument(
        "--cost", action="store_true", help="print predicted and actual cost of each stage"
    )
    parser.add_argument("--quiet", action="store_true", help="print no table and no progress")


def _add_report(commands: Any) -> None:
    parser = _command(
        commands,
        "report",
        report,
        "solve a scene and write one self-contained HTML page about it; adaptive positions if the "
        "scene names none",
    )
    parser.add_argument(
        "-o", dest="output", metavar="FILE", required=True, help="page to write (- for stdout)"
    )
    parser.add_argument("--quiet", action="store_true", help="print no progress and no file name")


def _add_plan(commands: Any) -> None:
    parser = _command(
        commands,
        "plan",
        plan,
        "print the effects that a run will include, with reason, cost and size",
    )
    parser.add_argument("--json", action="store_true", help="print JSON instead of the table")
    parser.add_argument(
        "--levels", action="store_true", help="also try the model levels that are off"
    )
    parser.add_argument(
        "--dimension", action="store_true", help="also try three dimensions of a plane scene"
    )


def _add_mesh(commands: Any) -> None:
    parser = _command(commands, "mesh", mesh, "write the finite element meshes of both bodies")
    _add_folder(parser)
    parser.add_argument(
        "--format", choices=("msh", "vtu", "inp"), default="msh", help="default: msh"
    )


def _add_accuracy(commands: Any) -> None:
    parser = _command(
        commands,
        "accuracy",
        accuracy,
        "print error and CPU time for each discretization parameter, and the cheapest "
        "discretizations for errors of 1 %%, 0.1 %% and 0.01 %%",
    )
    parser.add_argument(
        "--budget", metavar="S", type=float, default=60.0,
        help="CPU seconds after which no further run starts; default: 60",
    )  # fmt: skip
    parser.add_argument(
        "--quantities", metavar="Q,…", default="transmission_error,peak_pressure",
        help="quantities to judge: transmission_error, load_share, peak_pressure, stiffness; "
        "default: transmission_error,peak_pressure",
    )  # fmt: skip
    parser.add_argument("--csv", metavar="FILE", help="write one line per run (- for stdout)")
    parser.add_argument("--json", metavar="FILE", help="write the study as JSON (- for stdout)")
    parser.add_argument(
        "--plot", metavar="DIR", type=Path, help="write the work-precision diagram to this folder"
    )
    parser.add_argument(
        "--resume", metavar="FILE", type=Path,
        help="file of finished runs: read if it exists, updated after each run",
    )  # fmt: skip


def _add_optimise(commands: Any) -> None:
    parser = _described(
        commands,
        "optimise",
        "find the values of scene keys for which a key figure is smallest, with gradients",
    )
    parser.add_argument(
        "file", metavar="OPTIMISATION", type=Path,
        help="file (TOML) with the scene, variables, objective and constraints",
    )  # fmt: skip
    parser.add_argument(
        "-o", dest="output", metavar="FILE", type=Path, help="write the optimal scene to this file"
    )
    parser.set_defaults(command=optimise)


def _add_scene(commands: Any) -> None:
    parser = _described(
        commands,
        "scene",
        "write the scene of a gear stage of a REXS gearbox model; without -o, list the stages",
    )
    parser.add_argument(
        "file", metavar="GEARBOX", type=Path, help="model (.rexs, .rexsj, .rexsz, .rexs.zip)"
    )
    parser.add_argument(
        "--stage", metavar="ID", type=int, help="id of the stage; default: the only one"
    )
    parser.add_argument(
        "-o",
        dest="output",
        metavar="FILE",
        type=Path,
        help="write the scene to this file (- for stdout)",
    )
    parser.add_argument(
        "--torque-Nm", dest="torque_Nm", metavar="T", type=float,
        help="torque on gear 1; required if the model has none of this stage",
    )  # fmt: skip
    parser.add_argument(
        "--load-case", metavar="ID", type=int, help="id of the load case; default: the only one"
    )
    parser.add_argument(
        "--flank", choices=("left", "right"),
        help="loaded flank, if the model does not define it and the flanks of a gear differ",
    )  # fmt: skip
    parser.add_argument(
        "--set", dest="settings", metavar="KEY=VALUE", action="append", default=[],
        help="value of a key of the scene, in place of that of the model; may be repeated",
    )  # fmt: skip
    parser.set_defaults(command=scene)


def _add_benchmark(commands: Any) -> None:
    parser = _described(
        commands, "benchmark", "compare with reference results of other programs and closed forms"
    )
    parser.add_argument(
        "cases", metavar="CASE", nargs="*",
        help="cases, each with all of its quantities; default: all, a line each",
    )  # fmt: skip
    parser.add_argument(
        "--folder", metavar="DIR", type=Path, default=Path("benchmarks"),
        help="folder of the cases; default: benchmarks",
    )  # fmt: skip
    parser.add_argument(
        "--answers", metavar="FILE", type=Path,
        help="compare the answers of another program in this file (JSON) instead",
    )  # fmt: skip
    parser.add_argument(
        "-o",
        dest="output",
        metavar="FILE",
        type=Path,
        help="write the answers to this file (JSON; - for stdout, in place of the table)",
    )
    parser.add_argument("--json", action="store_true", help="print JSON instead of the table")
    parser.set_defaults(command=benchmark)


def _add_study(commands: Any) -> None:
    parser = _described(
        commands,
        "study",
        "solve many designs of a scene and print the range of each quantity; after an interruption "
        "the same command resumes",
    )
    parser.add_argument("file", metavar="STUDY", type=Path, help="study file (TOML)")
    parser.add_argument(
        "-o", dest="outputs", metavar="FILE", action="append", default=[],
        help="write a row per design as CSV or Parquet, by the suffix (- for CSV on stdout); may "
        "be repeated",
    )  # fmt: skip
    parser.add_argument(
        "--plot", metavar="DIR", type=Path,
        help="write the plots that suit the study to this folder",
    )  # fmt: skip
    parser.add_argument(
        "--workers", metavar="N", type=int, help="number of workers; default: one per processor"
    )
    workers = parser.add_mutually_exclusive_group()
    workers.add_argument(
        "--processes", action="store_true", help="use processes instead of threads"
    )
    workers.add_argument(
        "--scheduler", metavar="ADDRESS", help="use the workers of this dask scheduler"
    )
    parser.add_argument("--quiet", action="store_true", help="print no table and no progress")
    parser.set_defaults(command=study)


def _add_verify(commands: Any) -> None:
    parser = _command(
        commands,
        "verify",
        verify,
        "compare one position with a nonlinear finite element solution (CalculiX)",
    )
    parser.add_argument(
        "--position", metavar="K", type=int, default=0, help="index of the position; default: 0"
    )
    parser.add_argument(
        "-o",
        dest="folder",
        metavar="DIR",
        type=Path,
        help="folder that keeps input deck and output",
    )
    parser.add_argument("--no-run", action="store_true", help="only write the input deck")
    parser.add_argument("--json", action="store_true", help="print JSON instead of the table")
    parser.add_argument(
        "--large-displacement",
        action="store_true",
        help="let CalculiX include the deformation of the geometry",
    )
    parser.add_argument(
        "--dimension", type=int, choices=(2, 3),
        help="solve the scene as plane bodies or as solids in both programs; default: as it is",
    )  # fmt: skip
    parser.add_argument(
        "--elements", metavar="N", type=float,
        help="elements on the half-width of each contact; default: 6, or 1 of solids, whose "
        "other elements and layers follow in proportion",
    )  # fmt: skip
    parser.add_argument(
        "--time-limit", metavar="S", type=float, help="stop CalculiX after this many seconds"
    )
    parser.add_argument(
        "--program", metavar="CCX", default="ccx", help="name or path of CalculiX; default: ccx"
    )
