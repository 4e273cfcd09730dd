"""Co-simulation FMU (FMI 2.0) of a table of rotation and stiffness, in C, with a Linux binary."""

from __future__ import annotations

import io
import os
import platform
import re
import shlex
import shutil
import subprocess
import uuid
from hashlib import sha256
from html import escape
from importlib.metadata import version
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING
from zipfile import ZIP_DEFLATED, ZipFile, ZipInfo

from flankload.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Iterable

    from flankload.result.stiffness_table import StiffnessTable

#: Sources that all FMUs share.
SHARED = ("flankload_fmu.c", "table.h")
#: Longest part of a scene's name in the names of files, which have at most 255 characters.
LONGEST_NAME = 100
#: Compiled with these; the binary depends on sources and compiler only.
FLAGS = ("-std=c99", "-O2", "-ffp-contract=off", "-fvisibility=hidden", "-fPIC", "-shared", "-s")
LINKED = ("-Wl,--build-id=none", "-lm")
#: Date of all files in the archive.
DATE = (1980, 1, 1, 0, 0, 0)
#: Units with their factor and exponents of base units.
UNITS = {
    "rad": 'rad="1"',
    "N.m": 'kg="1" m="2" s="-2"',
    "um": 'm="1" factor="1e-6"',
    "mm": 'm="1" factor="1e-3"',
    "N.m/rad": 'kg="1" m="2" s="-2" rad="-1"',
}


def fmu_of(table: StiffnessTable, *, binary: bool | None = None) -> tuple[bytes, bool]:
    """Content of the FMU of a checked table, and whether it contains a library for linux64.

    By default it does if this is such a machine with a C compiler ($CC, cc or gcc). The bytes are
    the same for the same table and compiler.

    Raises
    ------
    InputError
        If a library is requested and cannot be compiled.
    """
    name = _identifier(table.name)
    numbers = _numbers(table)
    guid = "{" + str(uuid.UUID(bytes=sha256(numbers.encode()).digest()[:16])) + "}"
    folder = Path(__file__).parent
    sources = {file: (folder / file).read_text(encoding="utf-8") for file in SHARED}
    sources["table.c"] = f'#include "table.h"\n\nconst char table_guid[] = "{guid}";\n{numbers}'
    files = {"modelDescription.xml": _description(table, name, guid).encode()}
    compiler = _compiler() if binary is not False else None
    if compiler is not None:
        files[f"binaries/linux64/{name}.so"] = _compiled(compiler, sources)
    elif binary:
        raise InputError("fmu: expected a C compiler on x86-64 Linux, found none")
    files |= {f"sources/{file}": text.encode() for file, text in sources.items()}
    return _archive(files), compiler is not None


def _identifier(name: str) -> str:
    """A name in C."""
    found = re.sub(r"\W+", "_", name, flags=re.ASCII).strip("_")
    return f"flankload_{found[:LONGEST_NAME]}" if found else "flankload"


def _numbers(table: StiffnessTable) -> str:
    """Definitions of the table in C."""
    lines = [
        f"const double start_torque_Nm = {float(table.torques_Nm[-1])!r};",
        f"const double reference_radius_mm = {float(table.reference_radius_mm)!r};",
        f"const double period_rad = {float(table.period_rad)!r};",
        f"const int n_angles = {table.angle_rad.size}, n_torques = {table.torques_Nm.size};",
    ]
    for key, values in (
        ("angles_rad", table.angle_rad),
        ("torques_Nm", table.torques_Nm),
        ("table_rotation_rad", table.rotation_rad),
        ("table_stiffness_Nm_per_rad", table.values["stiffness_tangent_Nm_per_rad"]),
    ):
        # an integer in C would be divided as one
        rows = (f"    {float(value)!r}," for value in values.ravel())
        lines += [f"const double {key}[] = {{", *rows, "};"]
    return "\n".join(lines) + "\n"


def _description(table: StiffnessTable, name: str, guid: str) -> str:
    """Content of modelDescription.xml."""
    torque = float(table.torques_Nm[-1])
    inputs = 'causality="input" variability="continuous"'
    output = 'causality="output" variability="continuous" initial="calculated"'
    offset = 'causality="parameter" variability="tunable" initial="exact"'
    constant = 'causality="local" variability="constant" initial="exact"'
    variables = (
        ("angle_rad", inputs, "rad", 0.0, "angle of body 1 from position zero"),
        ("torque_Nm", inputs, "N.m", torque, "torque on body 1"),
        ("rotation_rad", output, "rad", None, "rotation of body 1 beyond ideal, rigid flanks"),
        ("transmission_error_um", output, "um", None, "rotation times reference radius"),
        ("stiffness_Nm_per_rad", output, "N.m/rad", None, "tangent stiffness about axis 1"),
        ("angle_offset_rad", offset, "rad", 0.0, "added to the angle"),
        ("period_rad", constant, "rad", float(table.period_rad), "the table repeats after it"),
        ("reference_radius_mm", constant, "mm", float(table.reference_radius_mm), "of body 1"),
    )
    scalars = "".join(
        f'    <ScalarVariable name="{key}" valueReference="{k}" {kind} '
        f'description="{escape(text)}">\n'
        f'      <Real unit="{unit}"{_start(start)}/>\n'
        "    </ScalarVariable>\n"
        for k, (key, kind, unit, start, text) in enumerate(variables)
    )
    units = "".join(
        f'    <Unit name="{unit}">\n      <BaseUnit {base}/>\n    </Unit>\n'
        for unit, base in UNITS.items()
    )
    outputs = [k + 1 for k, (_, kind, *_) in enumerate(variables) if kind == output]
    return (
        '<?xml version="1.0" encoding="UTF-8"?>\n'
        f'<fmiModelDescription fmiVersion="2.0" modelName="{escape(table.name or name)}" '
        f'guid="{guid}"\n    description="transmission error and stiffness over angle and torque: '
        'periodic in the angle, bilinear"\n'
        f'    generationTool="flankload {version("flankload")}" numberOfEventIndicators="0">\n'
        f'  <CoSimulation modelIdentifier="{name}" canHandleVariableCommunicationStepSize="true"\n'
        '      canNotUseMemoryManagementFunctions="true">\n    <SourceFiles>\n'
        '      <File name="flankload_fmu.c"/>\n      <File name="table.c"/>\n'
        "    </SourceFiles>\n  </CoSimulation>\n"
        f"  <UnitDefinitions>\n{units}  </UnitDefinitions>\n"
        f"  <ModelVariables>\n{scalars}  </ModelVariables>\n"
        "  <ModelStructure>\n"
        f"    <Outputs>\n{_unknowns(outputs, '1 2 6')}    </Outputs>\n"
        f"    <InitialUnknowns>\n{_unknowns(outputs, '1 2 6')}    </InitialUnknowns>\n"
        "  </ModelStructure>\n</fmiModelDescription>\n"
    )


def _start(value: float | None) -> str:
    return "" if value is None else f' start="{value!r}"'


def _unknowns(numbers: Iterable[int], known: str) -> str:
    return "".join(f'      <Unknown index="{k}" dependencies="{known}"/>\n' for k in numbers)


def _compiler() -> list[str] | None:
    """Command of a C compiler for linux64; None if there is none."""
    if platform.system() != "Linux" or platform.machine() != "x86_64":
        return None
    for command in (os.environ.get("CC"), "cc", "gcc"):
        words = shlex.split(command or "")
        if words and shutil.which(words[0]):
            return words
    return None


def _compiled(compiler: list[str], sources: dict[str, str]) -> bytes:
    """The shared library of C sources."""
    with TemporaryDirectory(prefix="flankload_") as name:
        folder = Path(name)
        for file, text in sources.items():
            (folder / file).write_text(text, encoding="utf-8")
        code = [file for file in sources if file.endswith(".c")]
        command = [*compiler, *FLAGS, *code, "-o", "fmu.so", *LINKED]
        done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
        if done.returncode:
            said = (done.stderr.strip() or "no message").splitlines()[0]
            raise InputError(f"fmu: expected a C compiler, found {shlex.join(compiler)}: {said}")
        return (folder / "fmu.so").read_bytes()


def _archive(files: dict[str, bytes]) -> bytes:
    """A zip archive whose bytes follow from its files."""
    content = io.BytesIO()
    with ZipFile(content, "w", ZIP_DEFLATED) as archive:
        for name, data in files.items():
            entry = ZipInfo(name, DATE)
            entry.create_system, entry.compress_type = 3, ZIP_DEFLATED
            entry.external_attr = 0o644 << 16
            archive.writestr(entry, data)
    return content.getvalue()
