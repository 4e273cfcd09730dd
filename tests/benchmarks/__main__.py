"""Speed as ratios in one run: `./dev bench [NAME …]`; without names every bench runs."""

import importlib
import pkgutil
import sys

import tests.benchmarks as benches


def main(arguments: list[str]) -> int:
    """Run the named benches; each is a module of this folder with `run() -> str`."""
    modules = {m.name.replace("_", "-"): m.name for m in pkgutil.iter_modules(benches.__path__)}
    available = sorted(name for name in modules if name[0] != "-")
    unknown = [name for name in arguments if name not in available]
    if unknown:
        print(f"bench: expected one of {', '.join(available)}, found {unknown[0]}", file=sys.stderr)
        return 2
    for name in arguments or available:
        print(f"== {name}")
        print(importlib.import_module(f"tests.benchmarks.{modules[name]}").run(), flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
