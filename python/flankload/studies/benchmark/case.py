"""Cases of the benchmark set: inputs, reference values and their uncertainties."""

from __future__ import annotations

import re
from math import inf, isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Any

import msgspec

from flankload.base.files import read_file
from flankload.errors import SceneError, reason_of
from flankload.scene.refusal import refuse

if TYPE_CHECKING:
    from collections.abc import Sequence

#: Name of a quantity and its indices: "line_load[3, -1]".
IDENTIFIER = re.compile(r"(?P<name>[a-z_]+)\[(?P<place>-?[0-9.]+(, -?[0-9.]+)*)\]")


class Quantity(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A reference value, with its uncertainty in the same unit.

    The difference of two converged programs of the same model is less than the uncertainty.
    """

    value: float
    uncertainty: float
    unit: str


class Case(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A case of the benchmark set: the content of its `case.json`.

    `name` is that of its folder; `inputs` are all data of the problem, with units in the names;
    `conventions` are the meaning of the quantities, `source` says where the values come from,
    `uncertainty` is the basis of their uncertainties; `quantities` are by identifier,
    "name[index, …]".
    """

    name: str
    title: str
    inputs: dict[str, Any]
    conventions: str
    source: str
    uncertainty: str
    quantities: dict[str, Quantity]


def place_of(identifier: str) -> tuple[str, tuple[float, ...]]:
    """Name and indices of a quantity by its identifier, "name[index, …]"."""
    found = IDENTIFIER.fullmatch(identifier)
    if found is None:
        raise ValueError(identifier)
    return found["name"], tuple(float(index) for index in found["place"].split(", "))


def read_cases(folder: Path, names: Sequence[str] = ()) -> tuple[Case, ...]:
    """Read the cases with these names, in this order, by default all; each has a folder.

    Raises SceneError if a case does not exist or its file `case.json` does not follow the format.
    """
    known = sorted(path.parent.name for path in folder.glob("*/case.json"))
    if not known:
        refuse("folder", "a folder for each case, with case.json", "none", folder)
    for name in names:
        if name not in known:
            refuse("case", ", ".join(known), name, folder)
    return tuple(_read_case(folder / name / "case.json") for name in names or known)


def _read_case(path: Path) -> Case:
    try:
        case = msgspec.json.decode(read_file(path), type=Case)
    except OSError as error:
        refuse("case", "a case to read", reason_of(error), path)
    except (ValueError, RecursionError) as error:  # no JSON, or another form
        raise SceneError(file=path, key="case", expected="a case", found=error) from None
    if case.name != path.parent.name:
        refuse("name", f"{path.parent.name}, as its folder", case.name, path)
    for identifier, quantity in case.quantities.items():
        if IDENTIFIER.fullmatch(identifier) is None:
            refuse("quantities", 'a name such as "force[0, 1]"', identifier, path)
        if not (isfinite(quantity.value) and 0.0 < quantity.uncertainty < inf):
            found = f"{quantity.value} and {quantity.uncertainty}"
            refuse(f"quantities.{identifier}", "a finite value and an uncertainty > 0", found, path)
    return case
