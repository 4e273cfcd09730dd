"""Folders of the source tree that tests and benches read."""

from __future__ import annotations

from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
BUILD = ROOT / "build"
DOCS = ROOT / "docs"
EXAMPLES = ROOT / "examples"
FORTRAN = ROOT / "fortran"
#: Scenes and meshes of the examples.
SCENES = EXAMPLES / "scenes"
MESHES = EXAMPLES / "meshes"
#: Data used by the tests only.
SUPPORT = ROOT / "tests" / "support"
TEST_MESHES = SUPPORT / "meshes"
REFERENCE_SOLUTIONS = SUPPORT / "reference_solutions"
CALCULIX_OUTPUT = SUPPORT / "calculix_output"
CALCULIX_SOLIDS = SUPPORT / "calculix_solids"
