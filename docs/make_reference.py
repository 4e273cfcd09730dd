"""Reference pages of the documentation site, made from the code when the site is built.

Each function of `TEXTS` returns Markdown. `python docs/make_reference.py NAME` prints one of them.
Nothing here needs Sphinx.
"""

from __future__ import annotations

import inspect
import pkgutil
import re
import sys
from functools import cache
from importlib import import_module
from pathlib import Path
from types import SimpleNamespace
from typing import Any, NamedTuple, get_args

import msgspec
from msgspec import inspect as kinds_of

import flankload as fl
from flankload import result as result_package
from flankload.cli import parser
from flankload.contact.status import EXCEPTIONS, status_text
from flankload.cost import COUNTERS
from flankload.result import friction, quantities, root_stress
from flankload.result.drives import BeltDrive, ChainDrive
from flankload.result.parts import OVER_COAST_SITES
from flankload.scene.form import expected_of, fields_of, is_required, types_of
from flankload.scene.scene import Body1, Body2, SceneFile
from flankload.scene.table import Table
from flankload.scene.usual import _usual_ranges

sys.path.insert(0, str(Path(__file__).parent))

import make_manual

#: Statuses of the core are at most this far below 0; `info` has other meanings below.
LAST_STATUS = -100


def table(heads: tuple[str, ...], rows: list[tuple[str, ...]]) -> str:
    """A Markdown table; `|` and line breaks in cells are escaped."""
    lines = [heads, ("---",) * len(heads), *rows]
    cells = (
        " | ".join(" ".join(cell.replace("|", "\\|").split()) for cell in row) for row in lines
    )
    return "\n".join(f"| {line} |" for line in cells) + "\n"


# --- scene keys -----------------------------------------------------------------------------------
class Key(NamedTuple):
    """A key of a table of the scene; name "shaft.lengths_mm" for a table in the table."""

    name: str
    unit: str
    expected: str
    usual: str
    default: str
    meaning: str


def body_tables() -> dict[str, tuple[type[Table], tuple[str, ...]]]:
    """Tables of all kinds of body by kind, with the bodies that can be of it."""
    found: dict[str, tuple[type[Table], tuple[str, ...]]] = {}
    for body, forms in (("body_1", Body1), ("body_2", Body2)):
        for form in get_args(forms):
            kind = str(form.__struct_config__.tag)
            found[kind] = form, (*found.get(kind, (form, ()))[1], body)
    return found


def keys_of(form: type[Table], before: str = "") -> list[Key]:
    """Keys of a table and of the tables in it, in their order."""
    found = []
    fields, usual = fields_of(form), _usual_ranges(form)
    for name, whole in types_of(form).items():
        bare, extra = whole, {}
        if isinstance(bare, kinds_of.Metadata):
            extra, bare = bare.extra_json_schema or {}, bare.type
        members = bare.types if isinstance(bare, kinds_of.UnionType) else (bare,)
        inner = [part.cls for part in members if isinstance(part, kinds_of.StructType)]
        for part in inner:
            found += keys_of(part, f"{before}{name}.")
        if inner:
            continue
        field = fields[name]
        default = "required" if is_required(field) else shown(field.default)
        low_high = "{:g} to {:g}".format(*usual[name]) if name in usual else ""
        meaning = str(extra.get("description", ""))
        unit = str(extra.get("unit", "")).replace("-", "")
        found.append(Key(before + name, unit, expected_of(whole), low_high, default, meaning))
    return found


def shown(value: Any) -> str:
    """A default as in a scene file; absent for None."""
    if value is None or value is msgspec.NODEFAULT or value == ():
        return "absent"
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, tuple):
        return f"[{', '.join(shown(part) for part in value)}]"
    return f'`"{value}"`' if isinstance(value, str) else f"{value:g}"


def scene_sections() -> list[tuple[str, str, list[Key]]]:
    """Title, introduction and keys of each section of the page."""
    found = []
    for kind, (form, bodies) in body_tables().items():
        partner = getattr(form, "partner", None)
        beside = f" The other body must be a `{partner}`." if partner else ""
        tables = " or ".join(f"`[{body}]`" for body in bodies)
        text = f'{tables} with `kind = "{kind}"`.{beside}'
        found.append((f"Body: {kind}", text, keys_of(form)))
    for name in ("pair", "load", "positions", "effects", "accuracy"):
        (form,) = (
            part.cls
            for part in _members(types_of(SceneFile)[name])
            if isinstance(part, kinds_of.StructType)
        )
        found.append((f"[{name}]", f"{inspect.cleandoc(str(form.__doc__))}", keys_of(form)))
    return found


def _members(whole: Any) -> tuple[Any, ...]:
    bare = whole.type if isinstance(whole, kinds_of.Metadata) else whole
    return bare.types if isinstance(bare, kinds_of.UnionType) else (bare,)


def scene_keys() -> str:
    """Every key of a scene file, table by table."""
    parts = []
    for title, text, keys in scene_sections():
        rows = []
        for key in keys:
            value = key.expected.replace("a number from ", "").replace("a number ", "")
            name, unit = f"`{key.name}`", unit_shown(key.unit)
            rows.append((name, key.meaning, unit, value, key.usual, key.default))
        heads = ("key", "meaning", "unit", "value", "usual", "default")
        parts.append(f"## {title}\n\n{text}\n\n{table(heads, rows)}")
    return "\n".join(parts)


# --- result quantities ----------------------------------------------------------------------------
class Quantity(NamedTuple):
    """An array or number of a result, with the class that documents it."""

    name: str
    unit: str
    axes: str
    owner: type
    attribute: str


def result_groups() -> list[tuple[str, str, list[Quantity]]]:
    """Quantities that leave a result (JSON, CSV, xarray), by group, with a note on each group."""

    def group(units: dict[str, str], axes: str, owner: type = fl.Result) -> list[Quantity]:
        return [Quantity(name, unit, axes, owner, name) for name, unit in units.items()]

    of_friction = [
        Quantity(f"friction_{name}", unit, "(P,)", friction.FrictionResult, name)
        for name, unit in friction.ALONG_POSITIONS.items()
    ]
    # the names do not depend on the stresses
    # the value of each array is the name of the attribute that documents it
    of_extremes = SimpleNamespace(
        **{name: name for name in ("stress_MPa", "arc_length_mm", "z_mm")}
    )
    names = ("slice_tension_MPa", "slice_compression_MPa")
    stress: Any = SimpleNamespace(
        tension=of_extremes, compression=of_extremes, **{name: name for name in names}
    )
    roots = [
        Quantity(name, unit, axes, owner, attribute)
        for z in (0, 1)
        for axes, owner, arrays in (
            ("(P, S)", root_stress.Extremes, root_stress.root_arrays(stress, z)),
            ("(P, S, J)", root_stress.RootStress, root_stress.slice_root_arrays(stress, z)),
        )
        for name, (attribute, unit) in arrays.items()
    ]
    chains, belts = (
        group(drive.units("P"), "(P,)", drive) + group(drive.units("PS"), "(P, S)", drive)
        for drive in (ChainDrive, BeltDrive)
    )
    return [
        ("Numbers", "In every result.", group(quantities.SINGLE_NUMBERS, "")),
        ("Over the positions", "In every result.", group(quantities.ALONG_POSITIONS, "(P,)")),
        (
            "Over the positions of some pairs",
            "`None` in a result without them.",
            group(quantities.ALONG_SOME_POSITIONS, "(P,)"),
        ),
        (
            "Over positions and flank pairs",
            "In every result.",
            group(quantities.OVER_SITES, "(P, S)"),
        ),
        (
            "Over positions, flank pairs and slices",
            "In every result; a plane scene has one slice.",
            group(quantities.OVER_SLICES, "(P, S, J)"),
        ),
        ("Friction", "With `effects.friction_coefficient`; `result.friction`.", of_friction),
        (
            "Coast flanks",
            "With `effects.coast_flank = true`.",
            group(OVER_COAST_SITES, "(P, S)"),
        ),
        (
            "Tooth root stress",
            (
                "With `effects.root_stress = true`; `result.root_stress`. Arrays with `_z_mm` and "
                "over slices in three dimensions only."
            ),
            roots,
        ),
        ("Chain drives", "`result.drive` of a chain on its sprocket.", chains),
        ("Belt drives", "`result.drive` of a belt on its pulley.", belts),
    ]


def result_quantities() -> str:
    """Every array and number that leaves a result, with unit, shape and meaning."""
    parts = []
    for title, text, group in result_groups():
        rows = [
            (f"`{q.name}`", unit_shown(q.unit), q.axes, meaning_of(q.owner, q.attribute))
            for q in group
        ]
        heads = ("name", "unit", "shape", "meaning")
        parts.append(f"## {title}\n\n{text}\n\n{table(heads, rows)}")
    summary = inspect.cleandoc(str(fl.Result.summary.__doc__)).split("\n", 2)[2]
    counted = [(f"`{name}`", meaning) for name, meaning in COUNTERS.items()]
    parts.append(f"## Summary\n\n`result.summary` has these entries: {summary}\n")
    parts.append(
        "## Counters of the cost\n\n`result.cost` has the sum of all stages under these names.\n\n"
        + table(("name", "one count is"), counted)
    )
    return "\n".join(parts)


def unit_shown(unit: str) -> str:
    """A unit; nothing for a pure number."""
    return "" if unit == "1" else re.sub(r"\bum\b", "µm", unit)


def meaning_of(owner: type, name: str) -> str:
    """What the documentation of a class says about an attribute or property.

    Raises
    ------
    LookupError
        If nothing documents it.
    """
    for form in (*owner.__mro__, *result_classes()):
        found = documented(form).get(name)
        if found:
            found = found[0].upper() + found[1:]
            return found if ". " in found else found.removesuffix(".")
    raise LookupError(f"{owner.__name__}.{name} has no documentation")


@cache
def result_classes() -> tuple[type, ...]:
    """All classes of the package `flankload.result`."""
    modules = [
        import_module(f"{result_package.__name__}.{part.name}")
        for part in pkgutil.iter_modules(result_package.__path__)
    ]
    return tuple(
        form
        for module in modules
        for form in vars(module).values()
        if inspect.isclass(form) and form.__module__ == module.__name__
    )


@cache
def documented(form: type) -> dict[str, str]:
    """Attributes and properties of a class with their documentation, without shapes."""
    found = {}
    text = inspect.cleandoc(str(form.__doc__ or ""))
    section = re.search(r"^(?:Attributes|Parameters)\n-+\n(.*)", text, re.MULTILINE | re.DOTALL)
    entries = re.split(r"^(?=\S)", section[1], flags=re.MULTILINE) if section else []
    for entry in filter(str.strip, entries):
        head, *body = entry.rstrip().splitlines()
        said = " ".join(" ".join(body).split())
        names = [name.strip() for name in head.split(" : ")[0].split(",")]
        # several names: one meaning for all, or one for each with semicolons between
        each = said.split("; ") if said.count("; ") == len(names) - 1 else [said] * len(names)
        found.update(zip(names, each, strict=True))
    for name, value in vars(form).items():
        function = getattr(value, "fget", getattr(value, "func", None))
        if function is not None and function.__doc__:
            first = inspect.cleandoc(function.__doc__).split("\n\n")[0]
            found[name] = re.sub(r"^\([A-Z, ]+\) ", "", " ".join(first.split()))
    return found


# --- statuses, command line, Python ---------------------------------------------------------------
def statuses() -> str:
    """Every status of the core with its words and its exception."""
    unknown = status_text(LAST_STATUS).replace(str(LAST_STATUS), "{}")
    rows = []
    for code in range(9, LAST_STATUS, -1):
        said = status_text(code)
        if said == unknown.format(code):
            continue
        error = EXCEPTIONS.get(code)
        if code == fl.NegativeForce.code:
            error = fl.NegativeForce
        rows.append((str(code), said, f"`{error.__name__}`" if error else ""))
    return table(("status", "meaning", "exception"), rows)


def command_line() -> str:
    """Every command with its arguments, from the parser."""
    top = parser()
    names, described = make_manual.commands(top)
    parts = []
    for name, command in names.items():
        usage = " ".join(command.format_usage().split()).removeprefix("usage: ")
        actions = [a for a in command._actions if type(a).__name__ != "_HelpAction"]
        rows = [argument(action) for action in actions]
        text = f"{described[name][0].upper()}{described[name][1:]}.".replace("%%", "%")
        listed = table(("argument", "meaning"), rows) if rows else ""
        parts.append(f"## {name}\n\n{text}\n\n```\n{usage}\n```\n\n{listed}")
    codes = str(top.epilog).removeprefix("exit codes: ")
    return "\n".join([*parts, f"## Exit codes\n\n{codes}.\n"])


def argument(action: Any) -> tuple[str, str]:
    """Names, value and help of an argument."""
    value = action.metavar if action.nargs != 0 else None
    if value is None and action.choices:
        value = "{" + ",".join(map(str, action.choices)) + "}"
    names = ", ".join(action.option_strings)
    text = " ".join(part for part in (names, str(value or "")) if part)
    return f"`{text}`", str(action.help or "").replace("%%", "%")


def public_names() -> dict[str, list[str]]:
    """Public names of the package by their kind."""
    found: dict[str, list[str]] = {"Functions": [], "Classes": [], "Exceptions": []}
    for name in fl.__all__:
        value = getattr(fl, name)
        if inspect.isclass(value):
            found["Exceptions" if issubclass(value, BaseException) else "Classes"].append(name)
        elif callable(value):
            found["Functions"].append(name)
    return found


def python_api() -> str:
    """Every public name with its documentation (by Sphinx)."""
    parts = []
    for title, names in public_names().items():
        kind = "autofunction" if title == "Functions" else "autoclass"
        more = "" if title == "Functions" else "\n   :members:\n   :inherited-members: Exception"
        if title == "Exceptions":
            more = "\n   :show-inheritance:"
        blocks = [f"### {name}\n\n```{{eval-rst}}\n.. {kind}:: flankload.{name}{more}\n```\n"
                  for name in names]  # fmt: skip
        parts.append("\n".join([f"## {title}\n", *blocks]))
    return "\n".join(parts)


TEXTS = {
    "scene_keys": scene_keys,
    "result_quantities": result_quantities,
    "statuses": statuses,
    "command_line": command_line,
    "python_api": python_api,
}

if __name__ == "__main__":
    print(TEXTS[sys.argv[1]]())
