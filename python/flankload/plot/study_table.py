"""A design study by design and torque, its Pareto front, words for variables and quantities."""

from __future__ import annotations

import json
import re
from textwrap import fill
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from flankload.studies.design import DesignStudy

TORQUE = "load.torque_Nm"
#: Units at the end of names, as they are printed.
UNITS = {
    "um": "µm", "mm": "mm", "MPa": "MPa", "N": "N", "Nm": "N m", "rad": "rad", "mrad": "mrad",
    "deg": "°", "K": "K", "J": "J", "W": "W", "s": "s", "rpm": "1/min", "kg_m3": "kg/m³",
}  # fmt: skip
_UNIT = "|".join(UNITS)
AT_END = re.compile(f"_(?:({_UNIT})_per_({_UNIT})|per_({_UNIT})|({_UNIT}))(?=(?:\\[\\d+])?$)")
#: Tables of a scene whose keys need no table before them.
PLAIN_TABLES = ("pair", "load", "effects", "accuracy", "positions")
#: Letters of a line of a label.
WIDTH = 44


class StudyTable:
    """A study by designs and torques.

    The torque of a factorial study with other variables is a column, like a list of torques.

    Attributes
    ----------
    variables : tuple of str
        Names of those that have several values; without a torque that is a column.
    designs : list of dict
        Values of the variables.
    torques_Nm : (designs, torques) array
        NaN for failed designs.
    """

    def __init__(self, study: DesignStudy) -> None:
        self._study = study
        torques = [[result["torque_Nm"] for result in row.outcome.results] for row in study.rows]
        most = max(map(len, torques), default=1) or 1
        self._has_lists = study.has_torques or most > 1
        kind = study.designs.kind
        alone = kind == "one-at-a-time"  # with the value of the scene
        names = [v.name for v in study.designs.variables if alone or len(v.values) != 1]
        as_column = (
            kind == "factorial"
            and TORQUE in names
            and len(names) > 1
            and not self._has_lists
            and all(_is_number(row.values[TORQUE]) for row in study.rows)
        )
        self.variables = tuple(name for name in names if not as_column or name != TORQUE)
        whole = [study.scene_values | row.values for row in study.rows]
        if as_column:
            columns = sorted({values[TORQUE] for values in whole})
            groups: dict[str, dict[float, int]] = {}
            for i, values in enumerate(whole):
                key = json.dumps([_cell(values[name]) for name in self.variables])
                groups.setdefault(key, {})[values[TORQUE]] = i
            self._rows = np.array([[group[x] for x in columns] for group in groups.values()])
            self._columns = np.zeros_like(self._rows)
            self.torques_Nm = np.tile(np.array(columns, dtype=float), (len(groups), 1))
        else:
            self._rows, self._columns = np.indices((len(whole), most))
            padded = [[*row, *[np.nan] * (most - len(row))] for row in torques]
            self.torques_Nm = np.array(padded, dtype=float)
        self.designs = [{name: whole[i][name] for name in self.variables} for i in self._rows[:, 0]]

    @property
    def numbers(self) -> tuple[str, ...]:
        """Quantities with one number per design and torque that any design has."""
        return tuple(
            name
            for name in self._study.quantities
            if (values := self.values(name)).ndim == 2
            and values.dtype == float
            and np.isfinite(values).any()
        )

    @property
    def curves(self) -> tuple[str, ...]:
        """Quantities over the positions."""
        names = [name for name in self._study.quantities if name != "position_rad"]
        shapes = {name: self.values(name).shape for name in names}
        positions = self.values("position_rad").shape
        return tuple(n for n in names if len(shapes[n]) == 3 and shapes[n] == positions)

    def values(self, quantity: str) -> NDArray[Any]:
        """Values (designs, torques) of a quantity, of a curve (designs, torques, points).

        Raises
        ------
        ValueError
            If the study has no such quantity.
        """
        if quantity not in (*self._study.quantities, "position_rad"):
            expected = ", ".join(self._study.quantities)
            raise ValueError(f"quantity: expected {expected}, found {quantity!r}")
        values = self._study.values(quantity)
        values = values if self._has_lists else values[:, None]
        return np.asarray(values[self._rows, self._columns])

    def gathered(
        self, quantity: str, names: Sequence[str]
    ) -> tuple[list[list[Any]], NDArray[np.float64]]:
        """Values over some variables; the least over the others.

        Parameters
        ----------
        quantity : str
        names : sequence of k str

        Returns
        -------
        k lists
            Values of each variable: numbers ascend, others are text in their order.
        (n_1, …, n_k, torques) array
            NaN where no design has a solution.

        Raises
        ------
        ValueError
            If a name is no variable with several values.
        """
        for name in names:
            if name not in self.variables:
                expected = ", ".join(self.variables) or "nothing: no variable has several values"
                raise ValueError(f"variable: expected {expected}, found {name!r}")
        alone = self._study.designs.kind == "one-at-a-time"
        found: dict[tuple[Any, ...], NDArray[np.float64]] = {}
        for i, design, values in zip(
            self._rows[:, 0], self.designs, self.values(quantity), strict=True
        ):
            place = tuple(_cell(design[name]) for name in names)
            others = alone and not set(self._study.rows[i].values) <= set(names)
            if not others and None not in place:
                found[place] = np.fmin(found.get(place, np.nan), values)
        axes = [_ordered([place[k] for place in found]) for k in range(len(names))]
        array = np.full((*map(len, axes), self.torques_Nm.shape[1]), np.nan)
        for place, values in found.items():
            array[tuple(axis.index(x) for axis, x in zip(axes, place, strict=True))] = values
        return axes, array

    def torque(self, column: int) -> str:
        """A torque with its unit; empty if it differs among designs."""
        known = np.unique(self.torques_Nm[:, column])
        known = known[np.isfinite(known)]
        return f"{known[0]:g} N m" if known.size == 1 else ""

    def design(self, number: int) -> str:
        """A design in words: its variables with their values."""
        found = [
            f"{words(name)} = {value:.5g} {unit_of(name)}".rstrip()
            if isinstance(value, int | float)
            else f"{words(name)} = {_cell(value)}"
            for name, value in self.designs[number].items()
        ]
        return ", ".join(found)


def pareto_front(points: NDArray[np.float64]) -> NDArray[np.int64]:
    """Rows that no other row equals or surpasses in both columns.

    Parameters
    ----------
    points : (n, 2) array
        Less is better.

    Returns
    -------
    (m,) array
        Indices; the first column ascends, the second descends.
    """
    order = np.lexsort((points[:, 1], points[:, 0]))
    least = np.minimum.accumulate(points[order, 1])
    return np.asarray(order[np.diff(least, prepend=np.inf) < 0])


def on_one_grid(
    angles: NDArray[np.float64], curves: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Interpolate curves linearly at the positions of the first.

    Parameters
    ----------
    angles, curves : (n, P) array
        NaN after the last point of a curve.

    Returns
    -------
    (p,) array
        Angles; those that no curve reaches are dropped.
    (n, p) array
        NaN where a curve does not reach.
    """
    order = np.argsort(angles[0], kind="stable")
    place = angles[0][order][np.isfinite(angles[0][order])]
    found = np.full((len(curves), place.size), np.nan)
    for row, angle, curve in zip(found, angles, curves, strict=True):
        known = np.flatnonzero(np.isfinite(angle) & np.isfinite(curve))
        known = known[np.argsort(angle[known], kind="stable")]
        row[:] = np.interp(place, angle[known], curve[known], left=np.nan, right=np.nan)
    kept = np.isfinite(found).any(axis=0)
    return place[kept], found[:, kept]


def label(name: str) -> str:
    """Words and unit of a variable or quantity, on lines that fit an axis."""
    unit = unit_of(name)
    return fill(words(name) + (f" in {unit}" if unit else ""), WIDTH)


def unit_of(name: str) -> str:
    """Unit of a variable or quantity; empty if it has none."""
    found = AT_END.search(name)
    if found is None:
        return ""
    above, below, inverse, alone = (UNITS.get(part or "", "") for part in found.groups())
    if below or inverse:
        return f"{above or 1}/{below or inverse}"
    return alone


def words(name: str) -> str:
    """Words for a path or several, or for a quantity."""
    paths = [AT_END.sub("", path.strip()) for path in name.split(",")]
    bodies = {path.removeprefix("body_1.").removeprefix("body_2.") for path in paths}
    if len(paths) == 2 and len(bodies) == 1:
        return f"{_plain(bodies.pop())} of both bodies"
    found = []
    for path in paths:
        table, _, key = path.partition(".")
        if key and table in ("body_1", "body_2"):
            found.append(f"{_plain(key)} of body {table[-1]}")
        else:
            found.append(_plain(key if key and table in PLAIN_TABLES else path))
    return ", ".join(found)


def _plain(path: str) -> str:
    return path.replace("_", " ").replace(".", ", ")


def _cell(value: Any) -> Any:
    """A number as it is, anything else as text."""
    return (
        value if value is None or _is_number(value) or isinstance(value, str) else json.dumps(value)
    )


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _ordered(values: list[Any]) -> list[Any]:
    """Distinct values; numbers ascend."""
    distinct = dict.fromkeys(values)
    return list(distinct) if any(isinstance(x, str) for x in distinct) else sorted(distinct)
