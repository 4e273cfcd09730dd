"""Speed as ratios in one run: `./dev bench [NAME …]`; without names the short ones."""

import importlib
import pkgutil
import sys

import tests.benchmarks as benches

#: Benches that are run by name alone, and how long they take.
LONG = {"estimate": "25 minutes", "tolerance": "half an hour", "nonlinear-fe": "6 minutes"}


def main(arguments: list[str]) -> int:
    """Run the named benches; each is a module of this folder with `run() -> str`."""
    modules = {m.name.replace("_", "-"): m.name for m in pkgutil.iter_modules(benches.__path__)}
    available = sorted(name for name in modules if name[0] != "-")
    unknown = [name for name in arguments if name not in available]
    if unknown:
        print(f"bench: expected one of {', '.join(available)}, found {unknown[0]}", file=sys.stderr)
        return 2
    for name in arguments or [name for name in available if name not in LONG]:
        print(f"== {name}")
        print(importlib.import_module(f"tests.benchmarks.{modules[name]}").run(), flush=True)
    if not arguments:
        left = (f"{name} ({time})" for name, time in LONG.items())
        print(f"left out, by name alone: {', '.join(left)}")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
