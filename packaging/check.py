"""Tries all of packaging/ but the wheel for Windows, and the files that describe the project.

check.py FOLDER: builds there. Needs the Python packages cffconvert, py-rattler-build,
pypandoc-binary and typst, go, nix-bin, and for the Debian packages debhelper, lintian and
libopenblas-dev.
A line for each.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
ACTIONLINT = "github.com/rhysd/actionlint/cmd/actionlint@v1.7.7"


def run(*command: str | Path, **variables: str) -> str:
    """Output of a command in the root of the project; ends this program if it fails."""
    done = subprocess.run(
        [str(word) for word in command],
        cwd=ROOT,
        env=os.environ | variables,
        capture_output=True,
        text=True,
        check=False,
    )
    if done.returncode:
        raise SystemExit(f"{' '.join(map(str, command))}\n{done.stdout}{done.stderr}")
    return done.stdout


def check_workflow(work: Path) -> str:
    """The workflow by actionlint, compiled from the Go module."""
    if shutil.which("go") is None:
        return "workflow: not linted, because go is missing"
    run("go", "install", ACTIONLINT, GOPATH=str(work / "go"))
    run(work / "go/bin/actionlint", *sorted(ROOT.glob(".github/workflows/*.yml")))
    return "workflow: actionlint finds nothing"


def check_citation() -> str:
    """CITATION.cff against its schema."""
    run(Path(sys.executable).with_name("cffconvert"), "--validate", "-i", "CITATION.cff")
    return "CITATION.cff: valid"


def check_conda() -> str:
    """The recipe as rattler-build reads and renders it; its build needs packages of conda-forge."""
    from rattler_build import RenderConfig, Stage0Recipe, VariantConfig

    recipe = Stage0Recipe.from_file(ROOT / "packaging/conda/recipe.yaml")
    # what conda-forge sets for all recipes
    pinned = VariantConfig({"c_stdlib": ["sysroot"], "c_stdlib_version": ["2.28"]})
    [variant] = recipe.render(pinned, RenderConfig())
    made = variant.recipe.package
    return f"conda recipe: rattler-build renders {made.name} {made.version}"


#: What the recipe for nixpkgs becomes if each package is its name.
NIX = """let recipe = import ./packaging/nix/package.nix; in
with recipe (builtins.mapAttrs (name: _: name) (builtins.functionArgs recipe) // {
  lib = { cleanSource = _: "checkout"; licenses.bsd3 = "BSD-3-Clause"; platforms.unix = [ ]; };
  buildPythonPackage = recipe: recipe;
  pythonOlder = _: false;
}); "${pname} ${version}: ${toString (build-system ++ nativeBuildInputs ++ buildInputs)}"
"""


def check_nix() -> str:
    """The recipe for nixpkgs, evaluated without nixpkgs."""
    if shutil.which("nix-instantiate") is None:
        return "nix recipe: not evaluated, because nix-instantiate is missing"
    found = run("nix-instantiate", "--eval", "--strict", "--store", "dummy://", "-E", NIX)
    return f"nix recipe: {found.strip()[1:-1]}"


def check_debian(work: Path) -> str:
    """The packages of the last commit, built and judged by lintian."""
    needed = ("dpkg-buildpackage", "dh", "lintian")
    if missing := [name for name in needed if shutil.which(name) is None]:
        return f"Debian packages: not built, because {', '.join(missing)} is missing"
    run("packaging/debian/build.sh", work / "debian")
    made = sorted(path.name for path in (work / "debian").glob("*.deb"))
    return f"Debian packages: {', '.join(made)}; lintian finds no error"


def check_paper(work: Path) -> str:
    """Figures and PDF of the paper."""
    return run(sys.executable, "paper/build.py", work / "paper").strip()


def main(work: Path) -> None:
    """All of it."""
    work.mkdir(parents=True, exist_ok=True)
    print(check_workflow(work), flush=True)
    print(check_citation(), flush=True)
    print(check_conda(), flush=True)
    print(check_nix(), flush=True)
    print(check_paper(work), flush=True)
    print(check_debian(work), flush=True)


if __name__ == "__main__":
    main(Path(sys.argv[1]).resolve())
