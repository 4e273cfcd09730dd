"""Command line: parse, call, print. The only package that prints."""

from __future__ import annotations

import argparse
import contextlib
import os
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn

from flankload.cli.checking import check
from flankload.cli.compliance import compliance
from flankload.cli.planning import plan
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
    arguments = parser().parse_args(argv)
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
    except KeyboardInterrupt:
        return _fail("interrupted", INTERRUPTED)
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
        sys.exit(_fail(f"{message} (flankload --help lists what there is)", BAD_INPUT))


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

    run_parser = commands.add_parser("run", help="solve a scene; prints the table of the result")
    run_parser.add_argument("scene", metavar="SCENE", type=Path, help="scene file (TOML)")
    run_parser.add_argument(
        "--json", metavar="FILE", help="write the result as JSON (- for stdout)"
    )
    run_parser.add_argument(
        "--csv", metavar="FILE", help="write the positions as CSV (- for stdout)"
    )
    run_parser.add_argument(
        "--stiffness-csv",
        metavar="FILE",
        help="write transmission error and stiffness over angle and torque (- for stdout)",
    )
    run_parser.add_argument(
        "--plot", metavar="DIR", type=Path, help="write the pictures to this folder"
    )
    run_parser.add_argument(
        "--cost", action="store_true", help="print what each stage was predicted to take, and took"
    )
    run_parser.add_argument("--quiet", action="store_true", help="no table and no progress")
    run_parser.set_defaults(command=run)

    plan_parser = commands.add_parser(
        "plan",
        help="say before a run which effects it will have, why, what they cost and change",
    )
    plan_parser.add_argument("scene", metavar="SCENE", type=Path, help="scene file (TOML)")
    plan_parser.add_argument("--json", action="store_true", help="print JSON instead of the table")
    plan_parser.add_argument(
        "--levels", action="store_true", help="also try the levels of the model that are off"
    )
    plan_parser.set_defaults(command=plan)

    mesh_parser = commands.add_parser("mesh", help="write the finite element meshes of both bodies")
    mesh_parser.add_argument("scene", metavar="SCENE", type=Path, help="scene file (TOML)")
    mesh_parser.add_argument(
        "-o", dest="folder", metavar="DIR", type=Path, required=True, help="folder"
    )
    mesh_parser.add_argument(
        "--format", choices=("msh", "vtu", "inp"), default="msh", help="default: msh"
    )
    mesh_parser.set_defaults(command=mesh)

    compliance_parser = commands.add_parser(
        "compliance", help="write the flanks and their compliance, to be used again"
    )
    compliance_parser.add_argument("scene", metavar="SCENE", type=Path, help="scene file (TOML)")
    compliance_parser.add_argument(
        "-o", dest="folder", metavar="DIR", type=Path, required=True, help="folder"
    )
    compliance_parser.set_defaults(command=compliance)

    _add_accuracy(commands)
    _add_verify(commands)

    check_parser = commands.add_parser(
        "check", help="say what was understood of a scene or a mesh file"
    )
    check_parser.add_argument("file", metavar="FILE", type=Path, help="scene (.toml) or mesh file")
    check_parser.set_defaults(command=check)

    schema_parser = commands.add_parser("schema", help="print the JSON schema of a scene file")
    schema_parser.set_defaults(command=schema)
    return top


def _add_accuracy(commands: Any) -> None:
    parser = commands.add_parser(
        "accuracy",
        help="errors beside CPU seconds, knob by knob, and the cheapest settings for 1 %%, 0.1 %%, "
        "0.01 %%",
    )
    parser.add_argument("scene", metavar="SCENE", type=Path, help="scene file (TOML)")
    parser.add_argument(
        "--budget", metavar="S", type=float, default=60.0,
        help="CPU seconds after which no further run is begun; default: 60",
    )  # fmt: skip
    parser.add_argument(
        "--quantities", metavar="Q,…", default="transmission_error,peak_pressure",
        help="what must be exact, of transmission_error, load_share, peak_pressure, stiffness; "
        "default: transmission_error,peak_pressure",
    )  # fmt: skip
    parser.add_argument("--csv", metavar="FILE", help="write a line per run (- for stdout)")
    parser.add_argument("--json", metavar="FILE", help="write the study as JSON (- for stdout)")
    parser.add_argument(
        "--plot", metavar="DIR", type=Path, help="write the work-precision diagram to this folder"
    )
    parser.add_argument(
        "--resume", metavar="FILE", type=Path,
        help="finished runs: read where the file is there, written after each run",
    )  # fmt: skip
    parser.set_defaults(command=accuracy)


def _add_verify(commands: Any) -> None:
    parser = commands.add_parser(
        "verify", help="solve one position by nonlinear finite elements, too (CalculiX)"
    )
    parser.add_argument("scene", metavar="SCENE", type=Path, help="scene file (TOML)")
    parser.add_argument(
        "--position", metavar="K", type=int, default=0, help="index of the position; default: 0"
    )
    parser.add_argument(
        "-o", dest="folder", metavar="DIR", type=Path, help="keep deck and output in this folder"
    )
    parser.add_argument("--no-run", action="store_true", help="write the deck, solve nothing")
    parser.add_argument("--json", action="store_true", help="print JSON instead of the table")
    parser.add_argument(
        "--large-displacement", action="store_true", help="CalculiX follows the deformed geometry"
    )
    parser.add_argument(
        "--elements", metavar="N", type=float, default=6.0,
        help="elements on the half-width of a contact; default: 6",
    )  # fmt: skip
    parser.add_argument(
        "--time-limit", metavar="S", type=float, help="seconds after which CalculiX is stopped"
    )
    parser.add_argument(
        "--program", metavar="CCX", default="ccx", help="name or path of CalculiX; default: ccx"
    )
    parser.set_defaults(command=verify)
