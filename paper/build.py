"""Makes the figures and the PDF of the paper.

build.py FOLDER: writes paper.pdf there. The figures are made by the Python of .venv; this one needs
pypandoc-binary (pandoc with its reader of citations) and typst.
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pypandoc
import typst

HERE = Path(__file__).resolve().parent
REFERENCE = re.compile(r"\\autoref\{fig:(\w+)\}")
LABEL = re.compile(r"\\label\{fig:(\w+)\}")


def numbered(text: str) -> str:
    """References to figures as JOSS's own tools write them."""
    names = LABEL.findall(text)
    text = LABEL.sub("", text)
    return REFERENCE.sub(lambda found: f"Figure {names.index(found[1]) + 1}", text)


def main(folder: Path) -> None:
    """Figures, then Typst, then PDF."""
    folder.mkdir(parents=True, exist_ok=True)
    python = HERE.parent / ".venv/bin/python"
    one = {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
    subprocess.run([python, HERE / "make_figures.py"], check=True, env=os.environ | one)
    words = ["--citeproc", f"--bibliography={HERE / 'paper.bib'}", "--standalone"]
    text = numbered((HERE / "paper.md").read_text(encoding="utf-8"))
    made = pypandoc.convert_text(text, "typst", format="markdown", extra_args=words)
    source = folder / "paper.typ"
    source.write_text(made, encoding="utf-8")
    for figure in HERE.glob("*.png"):
        (folder / figure.name).write_bytes(figure.read_bytes())
    typst.compile(str(source), output=str(folder / "paper.pdf"))
    print(f"paper: {folder / 'paper.pdf'}, {len(text.split())} words")


if __name__ == "__main__":
    main(Path(sys.argv[1]).resolve())
