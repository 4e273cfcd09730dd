"""Tables of all quantities of a result, for docs/reference/result_quantities.md."""

from __future__ import annotations

import inspect
import pkgutil
import re
from functools import cache
from importlib import import_module
from types import SimpleNamespace
from typing import Any, NamedTuple

from reference_markdown import table, unit_shown

import flankload as fl
from flankload import result as result_package
from flankload.cost import COUNTERS
from flankload.result import friction, quantities, root_stress
from flankload.result.drives import BeltDrive, ChainDrive
from flankload.result.optional_results import OVER_COAST_SITES
from flankload.result.stage import StageLoads


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
    chains, belts, stages = (
        group(drive.units("P"), "(P,)", drive) + group(drive.units("PS"), "(P, S)", drive)
        for drive in (ChainDrive, BeltDrive, StageLoads)
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
        ("Planetary stages", "`result.stage`; the sites are the planets.", stages),
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
