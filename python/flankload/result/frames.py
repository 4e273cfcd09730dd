"""Results of one scene, one per torque, as tables of pandas; NaN: open, or not known."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from flankload.base.optional import optional
from flankload.result.quantities import (
    ALONG_POSITIONS,
    along_positions,
    by_path,
    column,
    over_sites,
    units_of,
)

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from flankload.result.result import Result


def positions_frame(results: Sequence[Result]) -> Any:
    """A row per torque and position: columns of CSV, and each angle also in degrees."""
    return _joined("to_dataframe", map(_positions, results))


def pairs_frame(results: Sequence[Result]) -> Any:
    """A row per torque, position and flank pair: the quantities that CSV has for each pair."""
    return _joined("pairs_dataframe", map(_pairs, results))


def summary_frame(results: Sequence[Result]) -> Any:
    """A row per torque with the numbers of the summary, those of tables and lists by paths."""
    pandas = optional("pandas", "summary_dataframe")
    rows = [dict(by_path(one.summary, ".{}".format)) for one in results]
    return pandas.DataFrame(
        [
            {"torque_Nm": one.torque_Nm}
            | {key: np.nan if value is None else value for key, value in row.items()}
            for one, row in zip(results, rows, strict=True)
        ]
    )


def _joined(user: str, tables: Iterable[dict[str, Any]]) -> Any:
    """One table below the other."""
    pandas = optional("pandas", user)
    return pandas.concat([pandas.DataFrame(columns) for columns in tables], ignore_index=True)


def _positions(result: Result) -> dict[str, Any]:
    """Columns of the positions of one torque."""
    along = along_positions(result)
    columns: dict[str, Any] = {"torque_Nm": np.full(result.position_rad.size, result.torque_Nm)}
    for key, unit in units_of([along], ALONG_POSITIONS).items():
        columns[key] = column(result, along, key)
        if unit == "rad":
            columns[key.removesuffix("rad") + "deg"] = np.degrees(columns[key])
    return columns


def _pairs(result: Result) -> dict[str, Any]:
    """Columns of the flank pairs of one torque."""
    count, sites = result.position_rad.size, result.sites.size
    return {
        "torque_Nm": np.full(count * sites, result.torque_Nm),
        "position_rad": np.repeat(result.position_rad, sites),
        "position_deg": np.repeat(result.position_deg, sites),
        "pair": np.tile(result.sites, count),
        **{key: np.ravel(values) for key, (values, _) in over_sites(result).items()},
    }
