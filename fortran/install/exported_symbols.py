"""Write the version script of the shared library: flat interface and module `flankload`.

Called by the build: exported_symbols.py FACADE OUTPUT SOURCE…
"""

from __future__ import annotations

import re
import sys
from pathlib import Path


def statements(path: Path) -> list[str]:
    """Return the lines of a source in lower case, without comments, continued lines joined."""
    lines = (line.split("!")[0] for line in path.read_text(encoding="utf-8").splitlines())
    text = re.sub(r"&\s*\n\s*&?", " ", "\n".join(lines)).lower()
    return [line.strip() for line in text.splitlines() if line.strip()]


def public_names(facade: Path) -> set[str]:
    """Return the public names of module `flankload` as they are in the modules that define them."""
    lists, original = [], {}
    for line in statements(facade):
        if head := re.match(r"(?:[^!:]*,\s*)?public\b[^:]*::(.*)", line):
            lists.append(head[1])
        original |= dict(re.findall(r"(\w+)\s*=>\s*(\w+)", line))
    names = {name.split("=")[0].strip() for part in lists for name in part.split(",")}
    return {original.get(name, name) for name in names}


def types_of(sources: list[Path]) -> dict[str, set[str]]:
    """Return each type with the types of its components and the type that it extends."""
    found: dict[str, set[str]] = {}
    for path in sources:
        inside = None
        for line in statements(path):
            if head := re.match(r"type\s*(,.*)?::\s*(\w+)$", line):
                inside = head[2]
                found[inside] = set(re.findall(r"extends\s*\(\s*(\w+)", line))
            elif re.match(r"end\s*type", line):
                inside = None
            elif inside:
                found[inside] |= set(re.findall(r"(?:type|class)\s*\(\s*(\w+)\s*\)", line))
    return found


def patterns(facade: Path, sources: list[Path]) -> list[str]:
    """Return names and patterns of all symbols that programs may use."""
    public, types = public_names(facade), types_of(sources)
    reached: set[str] = set()
    waiting = public & set(types)
    while waiting:
        reached |= waiting
        waiting = {part for name in waiting for part in types[name]} & set(types) - reached
    # Names of gfortran; those generated for a type (table, default, copy, end) begin with `__`.
    procedures = [f"__flankload*_MOD_{name}" for name in sorted(public - set(types))]
    tables = [f"__flankload*_MOD___*_{name.capitalize()}" for name in sorted(reached)]
    return ["flankload_*", *procedures, *tables]


if __name__ == "__main__":
    facade, output, *sources = map(Path, sys.argv[1:])
    listed = "".join(f"        {name};\n" for name in patterns(facade, sources))
    output.write_text(f"{{\n    global:\n{listed}    local: *;\n}};\n", encoding="ascii")
