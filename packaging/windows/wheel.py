"""Builds the wheel for Windows on x86-64 with the cross compilers of Debian and Ubuntu.

wheel.py FOLDER [VERSION]: writes the wheel for this version of Python (3.12) into FOLDER. Needs the
Debian packages maven and gfortran-mingw-w64-x86-64-posix, the Python packages wheel and delvewheel.
Everything else comes from registries: the headers and the import library of Python from Maven
Central (JavaCPP presets of CPython), numpy's headers and OpenBLAS (scipy-openblas32, BSD) from
PyPI. The module is made by f2py, which cannot use the limited API: each version has its own wheel.
"""

from __future__ import annotations

import json
import re
import subprocess
import sys
import tempfile
from importlib.metadata import version
from pathlib import Path
from zipfile import ZipFile

HERE = Path(__file__).resolve().parent
#: Presets by version of Python; a wheel is for every release of its version.
PRESETS = {"3.12": "3.12.1-1.5.10", "3.13": "3.13.5-1.5.12"}
#: The version without an argument, and that of ./dev check windows.
PYTHON = "3.12"
OPENBLAS = "scipy-openblas32==0.3.34.481.3"
TARGET = "x86_64-w64-mingw32"


def run(*command: str | Path) -> str:
    """Output of a command, which ends this program if it fails."""
    done = subprocess.run(
        [str(word) for word in command], capture_output=True, text=True, check=False
    )
    if done.returncode:
        raise SystemExit(f"{' '.join(map(str, command))}\n{done.stdout}{done.stderr}")
    return done.stdout


def from_pypi(folder: Path, version_of_python: str, *requirements: str) -> None:
    """Unpack the Windows wheels of packages, without what they require."""
    where = ("--only-binary", ":all:", "--platform", "win_amd64")
    where += ("--python-version", version_of_python)
    pip = (sys.executable, "-m", "pip", "download", "--quiet", "--disable-pip-version-check")
    with tempfile.TemporaryDirectory() as work:
        run(*pip, "--no-deps", *where, "--dest", work, *requirements)
        for path in Path(work).glob("*.whl"):
            with ZipFile(path) as wheel:
                wheel.extractall(folder)


def python_of_windows(folder: Path, version_of_python: str = PYTHON) -> Path:
    """The root of a CPython for Windows: headers, libraries, interpreter."""
    jar_file = f"org.bytedeco:cpython:{PRESETS[version_of_python]}:jar:windows-x86_64"
    run("mvn", "-q", "dependency:copy", f"-Dartifact={jar_file}", f"-DoutputDirectory={folder}")
    [jar] = folder.glob("cpython-*.jar")
    with ZipFile(jar) as archive:
        archive.extractall(folder)
    jar.unlink()
    return folder / "org/bytedeco/cpython/windows-x86_64"


def build_details(python: Path, version_of_python: str) -> dict[str, object]:
    """How extensions for that Python are built (PEP 739)."""
    digits = version_of_python.replace(".", "")
    return {
        "schema_version": "1.0",
        "base_prefix": str(python),
        "platform": "win-amd64",
        "language": {"version": version_of_python},
        "implementation": {"name": "cpython"},
        "abi": {
            "flags": [],
            "extension_suffix": f".cp{digits}-win_amd64.pyd",
            "stable_abi_suffix": ".pyd",
        },
        "libpython": {"dynamic": f"libs/python{digits}.lib", "link_extensions": True},
        "c_api": {"headers": "include"},
    }


def import_openblas(folder: Path) -> Path:
    """An import library of OpenBLAS under the usual names, and its .pc file.

    The DLL of scipy-openblas32 exports ``scipy_dgemm_`` for ``dgemm_``.
    """
    library = folder / "scipy_openblas32/lib"
    listed = run(f"{TARGET}-nm", library / "libscipy_openblas.lib")
    names = sorted(set(re.findall(r" T scipy_(\w+_)$", listed, re.MULTILINE)))
    lines = ["LIBRARY libscipy_openblas.dll", "EXPORTS"]
    lines += [f"{name} == scipy_{name}" for name in names]
    (folder / "openblas.def").write_text("\n".join(lines) + "\n", encoding="utf-8")
    made = folder / "libopenblas.dll.a"
    run(f"{TARGET}-dlltool", "-d", folder / "openblas.def", "-l", made)
    number = OPENBLAS.partition("==")[2]
    (folder / "openblas.pc").write_text(
        f"Name: openblas\nDescription: OpenBLAS of {OPENBLAS}\nVersion: {number}\nLibs: {made}\n",
        encoding="utf-8",
    )
    return library


def paths_file(work: Path, python: Path, version_of_python: str) -> Path:
    """The part of the cross file that names folders of this build."""
    details = work / "build-details.json"
    details.write_text(json.dumps(build_details(python, version_of_python)), encoding="utf-8")
    path = work / "paths.ini"
    path.write_text(
        f"[properties]\nnumpy-include-dir = '{work}/numpy/_core/include'\n"
        f"[built-in options]\npkg_config_path = ['{work}']\npython.build_config = '{details}'\n",
        encoding="utf-8",
    )
    return path


def license_of_libraries(work: Path) -> str:
    """Who is inside the wheel, and the notices: OpenBLAS and the libraries of gfortran."""
    [openblas] = work.glob("scipy_openblas32-*.dist-info/licenses/LICENSE.txt")
    compilers = Path("/usr/share/doc/gcc-mingw-w64-base/copyright").read_text(encoding="utf-8")
    runtime = Path("/usr/share/doc/mingw-w64-x86-64-dev/copyright").read_text(encoding="utf-8")
    head = (
        "This wheel of flankload contains OpenBLAS as a DLL, unchanged, and in its module\n"
        "libgfortran, libgomp, libquadmath, libgcc and the start-up code of mingw-w64."
    )
    parts = [
        head,
        f"Notice of {OPENBLAS}\n\n{openblas.read_text('utf-8')}",
        f"Notice of gcc-mingw-w64 (Debian)\n\n{compilers}",
        f"Notice of mingw-w64 (Debian)\n\n{runtime}",
    ]
    return f"\n\n{'=' * 80}\n".join(parts)


def add_licenses(wheel: Path, text: str, work: Path) -> None:
    """Put the notices into the wheel; its metadata name them."""
    run(sys.executable, "-m", "wheel", "unpack", wheel, "--dest", work)
    [folder] = work.glob("flankload-*/")
    [metadata] = folder.glob("*.dist-info/METADATA")
    named = metadata.read_text(encoding="utf-8")
    line = "License-File: LICENSE\n"
    assert line in named, "the metadata name no licence"
    added = named.replace(line, f"{line}License-File: LICENSES_bundled.txt\n")
    metadata.write_text(added, encoding="utf-8")
    notices = metadata.parent / "licenses/LICENSES_bundled.txt"
    notices.write_text(text, encoding="utf-8")
    run(sys.executable, "-m", "wheel", "pack", folder, "--dest-dir", wheel.parent)


def build(folder: Path, work: Path, version_of_python: str) -> Path:
    """Compile, name, complete."""
    python = python_of_windows(work / "python", version_of_python)
    # The module is made by the f2py of this numpy.
    from_pypi(work, version_of_python, OPENBLAS, f"numpy=={version('numpy')}")
    dll = import_openblas(work)
    paths = paths_file(work, python, version_of_python)
    setup = [f"--cross-file={HERE / 'cross.ini'}", f"--cross-file={paths}"]
    options = [f"--config-settings=setup-args={word}" for word in setup]
    options.append(f"--config-settings=build-dir={work / 'build'}")
    pip = (sys.executable, "-m", "pip", "wheel", "--quiet", "--disable-pip-version-check")
    run(*pip, "--no-deps", "--no-build-isolation", *options, "-w", work, HERE.parents[1])
    [wheel] = work.glob("flankload-*.whl")
    # meson-python names the wheel for the machine that builds.
    digits = f"cp{version_of_python.replace('.', '')}"
    tags = ("--python-tag", digits, "--abi-tag", digits, "--platform-tag", "win_amd64")
    run(sys.executable, "-m", "wheel", "tags", "--remove", *tags, wheel)
    [wheel] = work.glob("flankload-*.whl")
    run(sys.executable, "-m", "delvewheel", "repair", "--add-path", dll, "-w", folder, wheel)
    [made] = folder.glob(f"flankload-*{digits}-win_amd64.whl")
    add_licenses(made, license_of_libraries(work), work / "unpacked")
    return made


def main(folder: str, version_of_python: str = PYTHON) -> None:
    """Build into the folder, in place of a former wheel for this version."""
    if version_of_python not in PRESETS:
        raise SystemExit(f"Python: expected {' or '.join(PRESETS)}, found {version_of_python}")
    target = Path(folder).resolve()
    target.mkdir(parents=True, exist_ok=True)
    for former in target.glob(f"flankload-*cp{version_of_python.replace('.', '')}-win_amd64.whl"):
        former.unlink()
    with tempfile.TemporaryDirectory() as work:
        print(build(target, Path(work), version_of_python))


if __name__ == "__main__":
    main(*sys.argv[1:])
