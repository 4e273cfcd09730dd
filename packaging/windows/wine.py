"""Tries the wheel for Windows under Wine: references, demo, names with umlauts, pools of processes.

wine.py FOLDER [VERSION]: takes the wheel for this version of Python (3.12) from FOLDER; the
interpreter, the packages and Wine's prefix are in build-windows, which later calls use again.
"""

from __future__ import annotations

import csv
import os
import re
import shutil
import subprocess
import sys
import tempfile
from functools import cached_property
from pathlib import Path

import pefile
from wheel import PYTHON, TARGET, python_of_windows, run

ROOT = Path(__file__).resolve().parents[2]
WORK = ROOT / "build-windows"
#: What the references need beside the wheel.
OF_TESTS = ("mpmath>=1.3",)
#: Wine 8 of Debian 12 lacks the complex functions of the C library, which numpy calls: they come
#: from mingw-w64. The new name is as long as the old one, so that it replaces it in place.
OF_WINDOWS = b"api-ms-win-crt-math-l1-1-0.dll"
OF_MINGW = b"flankload-wine-complexmath.dll"
#: Of examples/studies/tip_relief.toml.
QUANTITIES = ("transmission_error_peak_to_peak_um", "peak_pressure_MPa")
COMPLEX = re.compile(
    "c(abs|acosh?|arg|asinh?|atanh?|cosh?|exp|imag|log|log10|onj|pow|proj|real|sinh?|sqrt|tanh?)"
    "([fl]?)"
)
REAL = {"cos", "cosf", "cosl", "cosh", "coshf", "coshl"}


class Windows:
    """A Python for Windows with its packages, started through Wine."""

    def __init__(self, version: str) -> None:
        self.version = version
        self.digits = version.replace(".", "")
        self.home = WORK / f"python{self.digits}"
        self.packages = self.home / "Lib/site-packages"

    @cached_property
    def environment(self) -> dict[str, str]:
        """A prefix of its own, no messages of Wine, one thread."""
        one = dict.fromkeys(("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS"), "1")
        quiet = {"WINEPREFIX": str(WORK / "prefix"), "WINEDEBUG": "-all", "PYTHONUTF8": "0"}
        return os.environ | one | quiet

    def install_interpreter(self) -> None:
        """Arrange the files of the JavaCPP presets as an installation."""
        if self.home.exists():
            return
        with tempfile.TemporaryDirectory() as temporary:
            found = python_of_windows(Path(temporary), self.version)
            made = WORK / "python.part"
            shutil.rmtree(made, ignore_errors=True)
            shutil.copytree(found / "lib", made / "Lib")
            (made / "DLLs").mkdir()
            for path in [*made.glob("Lib/*.pyd"), *made.glob("Lib/*.dll")]:
                path.rename(made / "DLLs" / path.name)
            # The propsys of Wine 8 ends every program that asks WMI for the version of Windows.
            (made / "DLLs/_wmi.pyd").unlink()
            for name in ("vcruntime140.dll", "vcruntime140_1.dll"):
                (made / "DLLs" / name).rename(made / name)
            for path in (found / "bin/python.exe", found / f"python{self.digits}.dll"):
                shutil.copy(path, made)
            made.rename(self.home)

    def install(self, wheels: Path) -> None:
        """The wheel and what it requires, for Windows, whatever machine this is."""
        [wheel] = wheels.glob(f"flankload-*cp{self.digits}-win_amd64.whl")
        for former in self.packages.glob("flankload*"):
            shutil.rmtree(former)
        where = ("--only-binary", ":all:", "--platform", "win_amd64")
        where += ("--python-version", self.version)
        pip = (sys.executable, "-m", "pip", "install", "--quiet", "--disable-pip-version-check")
        run(*pip, "--no-compile", "--upgrade", *where, "--target", self.packages, wheel, *OF_TESTS)
        self.replace_complex_functions()

    def replace_complex_functions(self) -> None:
        """Let all modules import the C library's mathematics from a DLL of mingw-w64.

        It forwards the real functions to the library that Wine has.
        """
        names = set()
        for path in [*self.packages.rglob("*.pyd"), *self.packages.rglob("*.dll")]:
            data = path.read_bytes()
            if OF_WINDOWS not in data and OF_MINGW not in data:
                continue
            file = pefile.PE(data=data, fast_load=True)
            file.parse_data_directories([pefile.DIRECTORY_ENTRY["IMAGE_DIRECTORY_ENTRY_IMPORT"]])
            for library in file.DIRECTORY_ENTRY_IMPORT:
                if library.dll in (OF_WINDOWS, OF_MINGW):
                    names |= {symbol.name.decode() for symbol in library.imports}
            path.write_bytes(data.replace(OF_WINDOWS, OF_MINGW))
        lines = ["EXPORTS", *(f"  {name} = {self.source_of(name)}" for name in sorted(names))]
        definition = WORK / "complex.def"
        definition.write_text("\n".join(lines) + "\n", encoding="utf-8")
        made = self.home / OF_MINGW.decode()
        run(f"{TARGET}-gcc-posix", "-static", "-shared", "-o", made, definition)

    @staticmethod
    def source_of(name: str) -> str:
        """Where a function comes from; `long double` of Windows is `double`."""
        found = COMPLEX.fullmatch(name)
        if found is None or name in REAL:
            return f"ucrtbase.{name}"
        return f"c{found[1]}{found[2].replace('l', '')}"

    def python(self, *arguments: str, folder: Path = ROOT) -> str:
        """Output of a call, which ends this program if it fails."""
        done = subprocess.run(
            ["wine", str(self.home / "python.exe"), *arguments],
            cwd=folder,
            env=self.environment,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            check=False,
        )
        text = done.stdout.decode(errors="replace").replace("\r\n", "\n")
        if done.returncode:
            raise SystemExit(f"under Wine, python {' '.join(arguments)}:\n{text}")
        return text


def check_references(windows: Windows) -> str:
    """All references of tests/regression within their tolerances."""
    printed = windows.python("-m", "tests.regression", "--check")
    same = printed.count("nothing moved")
    moved = len(re.findall(r"^\w+:$", printed, re.MULTILINE))
    if same + moved == 0:
        raise SystemExit(f"no reference was solved:\n{printed}")
    return f"{same + moved} references met, {same} of them in all digits that are written"


def check_demo(windows: Windows, folder: Path) -> str:
    """The demo in a folder whose name has blanks and umlauts, with pictures."""
    scene = folder / "Rädchen größer.toml"
    shutil.copy(ROOT / "examples/scenes/external_gear.toml", scene)
    flankload = ("-m", "flankload")
    files = ("--plot", "Bilder für Ö", "--json", "Werte ü.json")
    windows.python(*flankload, "run", scene.name, *files, folder=folder)
    pictures = sorted((folder / "Bilder für Ö").glob("*.png"))
    if not pictures or not (folder / "Werte ü.json").stat().st_size:
        raise SystemExit("the demo wrote no files under Wine")
    windows.python(*flankload, "report", scene.name, "-o", "Bericht ß.html", folder=folder)
    return f"demo: {len(pictures)} pictures, JSON and report below '{folder.name}'"


def check_processes(windows: Windows, folder: Path) -> str:
    """A study by two processes, which Windows starts anew (spawn), as by threads."""
    study = ROOT / "examples/studies/tip_relief.toml"
    shutil.copytree(ROOT / "examples/scenes", folder / "scenes")
    (folder / "studies").mkdir()
    shutil.copy(study, folder / "studies")
    tables = []
    for name, how in (("a.csv", ["--processes"]), ("b.csv", [])):
        words = ["study", "studies/tip_relief.toml", "--workers", "2", "--quiet", "-o", name, *how]
        windows.python("-m", "flankload", *words, folder=folder)
        for store in (folder / "studies").glob("*.sqlite*"):
            store.unlink()
        with (folder / name).open(encoding="utf-8", newline="") as stream:
            rows = list(csv.DictReader(stream))
        # Estimates are made for some designs, in the order in which they are finished.
        tables.append([[row[name] for name in QUANTITIES] for row in rows])
    if tables[0] != tables[1] or not tables[0]:
        raise SystemExit(f"processes and threads find different designs under Wine: {tables}")
    return f"study of {len(tables[0])} designs: by processes as by threads"


def main(wheels: str, version: str = PYTHON) -> None:
    """All of it, a line for each."""
    WORK.mkdir(exist_ok=True)
    windows = Windows(version)
    windows.install_interpreter()
    windows.install(Path(wheels).resolve())
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary) / "Prüfung mit Leerzeichen"
        folder.mkdir()
        print(check_demo(windows, folder), flush=True)
        print(check_processes(windows, folder), flush=True)
    print(check_references(windows), flush=True)


if __name__ == "__main__":
    main(*sys.argv[1:])
