"""The finished study: its rows as a table, as labelled arrays and as text."""

from __future__ import annotations

import json
from dataclasses import dataclass, field, replace
from pathlib import Path
from statistics import fmean, stdev
from typing import TYPE_CHECKING, Any

import numpy as np

from flankload.base.card import Card
from flankload.base.files import write_atomically
from flankload.base.optional import optional
from flankload.base.text_table import text_table
from flankload.result.export import CsvForm
from flankload.result.quantities import ALONG_POSITIONS
from flankload.result.summary import NO_VALUE
from flankload.studies.design.run import SOLVED
from flankload.studies.settings import estimated_error, left_out

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Mapping, Sequence

    from numpy.typing import NDArray

    from flankload.studies.design.designs import Designs
    from flankload.studies.design.run_designs import Row


@dataclass(frozen=True, eq=False, repr=False)
class DesignStudy(Card):
    """Results of many designs of one scene; from `study`.

    Attributes
    ----------
    name : str
        Name of the scene.
    designs : Designs
        Variables and kind of the designs.
    quantities : tuple of str
    rows : tuple of Row
        One per design, in their order; failed ones included.
    scene_values : dict
        By name of the variable: the value in the scene itself, None if it is not a number.
    has_torques : bool
        Whether the scene has a list of torques.
    settings : mapping
        Keys that were set for all designs, and their values.
    """

    name: str
    designs: Designs
    quantities: tuple[str, ...]
    rows: tuple[Row, ...]
    scene_values: dict[str, Any]
    has_torques: bool
    settings: Mapping[str, Any] = field(default_factory=dict)

    @property
    def failed(self) -> tuple[Row, ...]:
        """Rows without a solution; `row.outcome.error` is the reason."""
        return tuple(row for row in self.rows if row.outcome.status != SOLVED)

    @property
    def best(self) -> dict[str, Row]:
        """By quantity that is a number: the design whose largest value of all torques is least."""
        found: dict[str, Row] = {}
        for name in self.quantities:
            largest = ((_largest_of(row, name), row) for row in self.rows)
            known = [(value, row.number, row) for value, row in largest if value is not None]
            if known:
                found[name] = min(known)[2]
        return found

    def with_estimates(self, rows: Sequence[Row], estimated: Sequence[Row]) -> DesignStudy:
        """The study with the error estimates of other runs of some of its rows."""
        changed = {}
        for row, other in zip(rows, estimated, strict=True):
            if other.outcome.status == SOLVED:
                pairs = zip(row.outcome.results, other.outcome.results, strict=True)
                results = tuple(one | {"estimate": more["estimate"]} for one, more in pairs)
                changed[row.number] = replace(row, outcome=replace(row.outcome, results=results))
        return replace(self, rows=tuple(changed.get(row.number, row) for row in self.rows))

    def values(self, name: str) -> NDArray[Any]:
        """Values of a quantity in the order of the designs.

        Parameters
        ----------
        name : str
            One of `quantities`, or "position_rad" if there are curves.

        Returns
        -------
        (designs,) array
            (designs, torques) with a list of torques; one more dimension for curves and harmonics.
            NaN if a design failed or has no such value.
        """
        return self._array(lambda result: result["quantities"].get(name))

    def columns(self) -> dict[str, list[Any]]:
        """Return the table by columns.

        Returns
        -------
        dict of list
            A row per design and torque: `design`, variables, `torque_Nm`, quantities (curves as
            lists), `estimate_…` (estimated relative errors), `seconds`, `status`, `error`.
        """
        nothing: dict[str, Any] = {"torque_Nm": None, "quantities": {}, "estimate": {}}
        lines = [(row, res) for row in self.rows for res in row.outcome.results or (nothing,)]
        found: dict[str, list[Any]] = {"design": [row.number for row, _ in lines]}
        for variable in self.designs.variables:
            found[variable.name] = _labels([self._value(row, variable.name) for row, _ in lines])
        found["torque_Nm"] = [result["torque_Nm"] for _, result in lines]
        for part, before in (("quantities", ""), ("estimate", "estimate_")):
            for name in self._names(part):
                found[f"{before}{name}"] = [result[part].get(name) for _, result in lines]
        for name in ("seconds", "status", "error"):
            found[name] = [getattr(row.outcome, name) for row, _ in lines]
        return found

    def to_csv(self, path: str | Path | None = None) -> str:
        """Return the table as CSV; write it to `path`.

        A curve has a column for each of its points, NAME[0], NAME[1], …; a cell without a value is
        empty.
        """
        columns: dict[str, list[Any]] = {}
        for name, cells in self.columns().items():
            count = _longest(cells)
            if count is None:
                columns[name] = cells
            for k in range(count or 0):
                points = ((cell or [])[k : k + 1] for cell in cells)
                columns[f"{name}[{k}]"] = [point[0] if point else None for point in points]
        text = CsvForm().lines([list(columns), *zip(*columns.values(), strict=True)])
        if path is not None:
            write_atomically(path, text)
        return text

    def to_parquet(self, path: str | Path) -> None:
        """Write the table as Parquet, curves as lists.

        Raises
        ------
        ImportError
            If pyarrow is not installed.
        """
        pyarrow = optional("pyarrow", "to_parquet", extra="parquet")
        parquet = optional("pyarrow.parquet", "to_parquet", extra="parquet")
        stream = pyarrow.BufferOutputStream()
        parquet.write_table(pyarrow.table(self.columns()), stream)
        write_atomically(path, stream.getvalue().to_pybytes())

    def to_xarray(self) -> Any:
        """Return the study as a labelled dataset.

        Returns
        -------
        xarray.Dataset
            A factorial study has a dimension for each variable, with its name and values; other
            studies have the dimension `design`, with the variables as coordinates. Further
            dimensions: `torque` if the scene has a list of torques, `position` of curves and
            `harmonic`. Variables: quantities, `estimate_…`, `seconds`, `status`, `error`.

        Raises
        ------
        ImportError
            If xarray is not installed.
        """
        xarray = optional("xarray", "to_xarray")
        variables = self.designs.variables
        if self.designs.kind == "factorial":
            dims = tuple(variable.name for variable in variables)
            coords = {v.name: (v.name, _labels(list(v.values))) for v in variables}
        else:
            dims = ("design",)
            coords = {
                v.name: (dims[0], _labels([self._value(row, v.name) for row in self.rows]))
                for v in variables
            }
        shape = tuple(len(coords[name][1]) for name in dims if name in coords) or (len(self.rows),)
        data: dict[str, Any] = {}

        def add(name: str, values: NDArray[Any], more: Sequence[str]) -> None:
            units = {"units": ALONG_POSITIONS[name]} if name in ALONG_POSITIONS else {}
            data[name] = ((*dims, *more), values.reshape(shape + values.shape[1:]), units)

        torque = ("torque",) if self._has_torque_dimension else ()
        if torque:
            add("torque_Nm", self._array(lambda result: result["torque_Nm"]), torque)
        for name in self._names("quantities"):
            values = self.values(name)
            along = "harmonic" if "harmonics" in name else "position"
            add(name, values, (*torque, *[along] * (values.ndim - 1 - len(torque))))
        for name in self._names("estimate"):
            found = self._array(lambda result, name=name: result["estimate"].get(name))  # type: ignore[misc]
            add(f"estimate_{name}", found, torque)
        add("seconds", np.array([row.outcome.seconds for row in self.rows]), ())
        for name in ("status", "error"):
            add(name, np.array([getattr(row.outcome, name) or "" for row in self.rows]), ())
        return xarray.Dataset(data, coords=coords, attrs={"name": self.name})

    def __str__(self) -> str:
        """Return the range of each quantity over the designs."""
        rows = [["", "least", "mean", "standard deviation", "largest"]]
        for name in self.quantities:
            known = [x for x in np.ravel(self.values(name)) if isinstance(x, float) and x == x]
            if known:
                spread = stdev(known) if len(known) > 1 else 0.0
                numbers = (min(known), fmean(known), spread, max(known))
                rows.append([name, *(f"{number:.5g}" for number in numbers)])
        head = f"{self.name}: {len(self.rows)} designs"
        if self.failed:
            head += f", {len(self.failed)} of them failed; first: {self.failed[0].outcome.error}"
        further = [*self._without_value(), *self._best_lines(), *left_out(self.settings)]
        return "\n".join([head, *text_table(rows, left=1), *further])

    def _without_value(self) -> Iterator[str]:
        """Quantities that some solved designs lack, with the number of these and the reason."""
        solved = [row for row in self.rows if row.outcome.status == SOLVED]
        for name in set(self.quantities) & set(NO_VALUE):
            found = [[one["quantities"][name] for one in row.outcome.results] for row in solved]
            if count := sum(None in values for values in found):
                yield f"{name} has no value in {count} designs: {NO_VALUE[name]}"

    def _best_lines(self) -> Iterator[str]:
        """The design with the least value of each quantity, with its estimated error."""
        for name, row in self.best.items():
            values = ", ".join(f"{key} = {value}" for key, value in row.values.items())
            errors = [estimated_error(result["estimate"], name) for result in row.outcome.results]
            known = [error for error in errors if error is not None]
            error = f" (+- {100 * max(known):.1f} %)" if known else ""
            yield f"least {name}{error}: design {row.number}, {values or 'the scene itself'}"

    @property
    def _has_torque_dimension(self) -> bool:
        return self.has_torques or any(len(row.outcome.results) > 1 for row in self.rows)

    def _value(self, row: Row, name: str) -> Any:
        """Value of a variable in a design."""
        return row.values[name] if name in row.values else self.scene_values[name]

    def _names(self, part: str) -> list[str]:
        """Names of the quantities or estimates that any row has, chosen ones in their order."""
        found = dict.fromkeys(
            name for row in self.rows for result in row.outcome.results for name in result[part]
        )
        return list(found) if part == "estimate" or found else list(self.quantities)

    def _array(self, value_of: Callable[[dict[str, Any]], Any]) -> NDArray[Any]:
        """A value of each result as an array: designs, torques (if several), points of a curve."""
        cells = [[value_of(result) for result in row.outcome.results] for row in self.rows]
        flat = [cell for of_design in cells for cell in of_design]
        count = _longest(flat)
        words = any(isinstance(cell, str) for cell in flat)
        torques = max((len(of_design) for of_design in cells), default=1) or 1
        found = np.full((len(cells), torques, count or 1), "" if words else np.nan, dtype=object)
        for i, of_design in enumerate(cells):
            for t, cell in enumerate(of_design):
                points = cell if isinstance(cell, list) else [cell]
                found[i, t, : len(points)] = [np.nan if x is None else x for x in points]
        found = found if words else found.astype(float)
        found = found if count is not None else found[:, :, 0]
        return found if self._has_torque_dimension else found[:, 0]


def _longest(cells: list[Any]) -> int | None:
    """Length of the longest list; None if there is no list."""
    return max((len(cell) for cell in cells if isinstance(cell, list)), default=None)


def _labels(values: list[Any]) -> list[Any]:
    """Values as cells of a column: lists and tables as JSON, and all as text if some are text."""
    plain = [json.dumps(x) if isinstance(x, list | tuple | dict) else x for x in values]
    if any(isinstance(x, str) for x in plain):
        return ["" if x is None else str(x) for x in plain]
    return plain


def _largest_of(row: Row, name: str) -> float | None:
    """Largest number of a quantity over all torques of a design; None if it has none."""
    values = [result["quantities"].get(name) for result in row.outcome.results]
    known = [x for x in values if isinstance(x, int | float) and not isinstance(x, bool) and x == x]
    return max(known) if known and len(known) == len(values) else None
