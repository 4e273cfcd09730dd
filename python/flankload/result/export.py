"""Export of results: strict JSON, CSV, labelled arrays."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from math import degrees, isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from flankload.base.files import write_atomically
from flankload.base.number_text import number_of
from flankload.base.optional import optional
from flankload.base.plain import plain
from flankload.errors import InputError
from flankload.result.notes import warning_lines
from flankload.result.quantities import (
    ALONG_POSITIONS,
    OVER_SITES,
    SINGLE_NUMBERS,
    UNLOADED,
    along_positions,
    column,
    curves_of,
    over_sites,
    over_slices,
    over_some_sites,
    site_column,
    torques_of,
    units_of,
)

if TYPE_CHECKING:
    from flankload.result.result import Result

#: Letters with which a formula of a spreadsheet may begin, also in full width.
FORMULA_BEGINS = tuple("=+-@\t\r\n＝＋－＠")
#: Separators by name; the name is that of the command line.
SEPARATORS = {"comma": ",", "semicolon": ";", "tab": "\t"}


@dataclass(frozen=True)
class CsvForm:
    """How numbers are written; the defaults are those of files without options.

    Attributes
    ----------
    separator : str or None
        "," or ";" or a tab; None: ",", with a decimal comma ";".
    decimal_comma : bool
        Numbers have a comma in place of the decimal point.
    degrees : bool
        Angles in rad are written in degrees, and their names end with _deg; quantities per rad
        stay.
    """

    separator: str | None = None
    decimal_comma: bool = False
    degrees: bool = False

    def __post_init__(self) -> None:
        """Refuse unknown separators, and a comma for two purposes.

        Raises
        ------
        InputError
        """
        if self.separator not in (None, *SEPARATORS.values()):
            raise InputError(f"separator: expected ',' or ';' or a tab, found {self.separator!r}")
        if self.decimal_comma and self.separator == ",":
            raise InputError("separator: expected ';' or a tab with a decimal comma, found ','")

    def head(self, key: str, unit: str) -> str:
        """Name of a column."""
        return f"{key.removesuffix('_rad')}_deg" if self._turns(unit) else key

    def cell(self, value: Any, unit: str = "") -> str:
        """A number as text, empty if it is not finite; a bool as 0 or 1."""
        plain = value.item() if isinstance(value, np.generic) else value
        if isinstance(plain, bool):
            return str(int(plain))
        if self._turns(unit):
            plain = degrees(plain)
        if isinstance(plain, float) and not isfinite(plain):
            return ""
        text = repr(plain)
        return text.replace(".", ",") if self.decimal_comma else text

    def lines(self, rows: Iterable[Iterable[Any]]) -> str:
        """Rows of texts and numbers as CSV; no text is a formula in a spreadsheet."""
        out = io.StringIO()
        separator = self.separator or (";" if self.decimal_comma else ",")
        writer = csv.writer(out, lineterminator="\n", delimiter=separator)
        writer.writerows(map(_harmless, row) for row in rows)
        return out.getvalue()

    def _turns(self, unit: str) -> bool:
        return self.degrees and unit == "rad"


def _harmless(cell: Any) -> Any:
    """A cell; an apostrophe before a text that a spreadsheet would take for a formula.

    This is the advice of OWASP (CSV Injection, owasp.org/www-community/attacks/CSV_Injection).
    """
    if not isinstance(cell, str) or not cell.startswith(FORMULA_BEGINS):
        return cell
    try:
        number_of(cell.replace(",", "."))
    except ValueError:
        return f"'{cell}"
    return cell


def results_to_json(results: Result | Sequence[Result], path: str | Path | None = None) -> str:
    """A result, or results of single torques, as strict JSON.

    Parameters
    ----------
    results : Result or sequence of Result
        A list of torques, or a sequence, gives {"torques_Nm": [...], "results": [...]}.
    path : path, optional
        File to write.

    Returns
    -------
    str
    """
    if isinstance(results, Sequence) or results.has_torque_list:
        results = results if isinstance(results, Sequence) else results.by_torque
        tree: Any = {
            "torques_Nm": [result.torque_Nm for result in results],
            "results": [_tree(result) for result in results],
        }
    else:
        tree = _tree(results)
    text = json.dumps(plain(tree), allow_nan=False, ensure_ascii=False) + "\n"
    if path is not None:
        write_atomically(path, text)
    return text


def _tree(result: Result) -> dict[str, Any]:
    along = [key for key, (owner, *_) in curves_of(result).items() if owner is result]
    keys = ["name", *SINGLE_NUMBERS, "closed", "whole_circle", "sites", *along, *OVER_SITES]
    keys += ["summary", "estimate", "cost", "warnings"]
    tree = {key: getattr(result, key) for key in keys}
    if result.outside_limits:
        tree["outside_limits"] = result.outside_limits
    if result.slices is not None:
        tree["slice_z_mm"] = result.slice_z_mm
        tree |= {key: values for key, (values, _) in over_slices(result).items()}
        for key in ("axial_force_N", "tilting_moment_Nm", "tilting_moments_Nm"):
            if (values := getattr(result.slices, key)) is not None:
                tree[key] = values
    if result.shafts is not None:
        tree |= result.shafts.bearing_forces
    tree["friction"] = result.friction.as_dict() if result.friction is not None else None
    if result.accuracy is not None:
        tree["accuracy"] = result.accuracy
    if result.drive is not None:
        tree[result.drive.key] = result.drive.as_dict()
    tree |= {key: values for key, (values, _) in over_some_sites(result).items()}
    tree["pairs"] = [table.columns() for table in result.pair_tables]
    if result.coast is not None:
        tree["coast_pairs"] = [table.columns() for table in result.coast.pair_tables]
    return tree


def results_to_csv(
    results: Result | Sequence[Result],
    path: str | Path | None = None,
    form: CsvForm | None = None,
) -> str:
    """A result, or results of single torques, as CSV: a row per position (and torque).

    Parameters
    ----------
    results : Result or sequence of Result
    path : path, optional
        File to write.
    form : CsvForm, optional
        Separator, decimal sign and unit of angles.

    Returns
    -------
    str
        Column names contain units, and the pair number for columns of a single pair; an empty cell
        is not a number.
    """
    several = torques_of(results)
    form = CsvForm() if form is None else form
    sites = sorted({int(site) for result in several for site in result.sites})
    along = [along_positions(result) for result in several]
    over = [over_sites(result) for result in several]
    word = several[0].engagement.site_word
    keys, site_keys = units_of(along, ALONG_POSITIONS), units_of(over, OVER_SITES)
    units = {
        "torque_Nm": "N m",
        **keys,
        **{f"{key}_{word}_{j}": unit for j in sites for key, unit in site_keys.items()},
    }
    rows = [[form.head(key, unit) for key, unit in units.items()]]
    for result, alone, at_sites in zip(several, along, over, strict=True):
        columns = [column(result, alone, key) for key in keys]
        columns += [site_column(result, at_sites, key, j) for j in sites for key in site_keys]
        for row in zip(*columns, strict=True):
            rows.append(list(map(form.cell, (result.torque_Nm, *row), units.values())))
    text = form.lines(rows)
    if path is not None:
        write_atomically(path, text)
    return text


def to_xarray(results: Result | Sequence[Result]) -> Any:
    """A result, or results of single torques, as a labelled `xarray.Dataset`.

    Dimensions `position` (coordinate: angle of body 1, rad), `site` (pair number) and `slice`
    (axial position, mm; one in a plane scene); units in the attributes of each variable. A list of
    torques, or a sequence, has the dimension `torque` in front (coordinate: N m); a pair that a
    torque never loads has the values of an open pair there.
    """
    xarray = optional("xarray", "to_xarray")
    if not isinstance(results, Sequence) and not results.has_torque_list:
        return _dataset(results)
    several = torques_of(results)
    torque = [one.torque_Nm for one in several]
    sets = [_dataset(one) for one in several]
    joined = xarray.concat(
        sets,
        xarray.IndexVariable("torque", torque, {"units": "N m"}),
        data_vars="all",
        coords="minimal",
        compat="equals",
        join="outer",
        fill_value={key: UNLOADED.get(key, np.nan) for data in sets for key in data},
        combine_attrs="override",
    )
    del joined.attrs["torque_Nm"]
    return joined.assign_attrs(warnings=warning_lines(several))


def _dataset(result: Result) -> Any:
    """Dataset of one torque."""
    import xarray

    arrays = along_positions(result) | over_sites(result) | over_slices(result)
    arrays["line_load_N_per_mm"] = result.line_load_N_per_mm, "N/mm"  # by slices, if there are any
    angle = arrays.pop("position_rad")[0]
    axes = ("position", "site", "slice")
    return xarray.Dataset(
        {
            key: (axes[: values.ndim], values, {"units": unit})
            for key, (values, unit) in arrays.items()
        },
        coords={
            "position": ("position", angle, {"units": "rad"}),
            "site": ("site", result.sites, {"long_name": f"{result.engagement.site_word} number"}),
            "slice": ("slice", result.slice_z_mm, {"units": "mm"}),
        },
        attrs={
            "name": result.name,
            **{key: getattr(result, key) for key in SINGLE_NUMBERS},
            "warnings": list(result.warnings),
        },
    )
