"""Speed as ratios in one run: `./dev bench [NAME …]`; without names the short ones."""

import argparse
import importlib
import inspect
import pkgutil
import sys

import tests.benchmarks as benches

#: Benches that are run by name alone, and how long they take.
LONG = {
    "estimate": "25 minutes",
    "explore": "a minute; needs Chromium",
    "fuzz": "an hour",
    "leaning-planet": "10 minutes; needs CalculiX",
    "nonlinear-fe": "6 minutes",
    "optimise": "5 minutes",
    "tolerance": "half an hour",
}


def main(arguments: list[str]) -> int:
    """Run the named benches; each is a module of this folder with `run() -> str`.

    `--seed` and `--part` go to those that take them.
    """
    parser = argparse.ArgumentParser(prog="./dev bench")
    parser.add_argument("names", metavar="NAME", nargs="*")
    parser.add_argument("--seed", type=int, help="of trials at random")
    parser.add_argument("--part", type=float, help="of the trials of a whole run")
    asked = vars(parser.parse_args(arguments))
    names = asked.pop("names")
    options = {key: value for key, value in asked.items() if value is not None}
    modules = {m.name.replace("_", "-"): m.name for m in pkgutil.iter_modules(benches.__path__)}
    available = sorted(name for name in modules if name[0] != "-")
    unknown = [name for name in names if name not in available]
    if unknown:
        print(f"bench: expected one of {', '.join(available)}, found {unknown[0]}", file=sys.stderr)
        return 2
    for name in names or [name for name in available if name not in LONG]:
        print(f"== {name}", flush=True)
        run = importlib.import_module(f"tests.benchmarks.{modules[name]}").run
        strange = options.keys() - inspect.signature(run).parameters.keys()
        if strange:
            print(f"bench: {name} knows no --{min(strange)}", file=sys.stderr)
            return 2
        print(run(**options), flush=True)
    if not names:
        left = (f"{name} ({time})" for name, time in LONG.items())
        print(f"left out, by name alone: {', '.join(left)}")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
