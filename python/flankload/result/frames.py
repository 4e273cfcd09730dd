"""Results as tables of pandas: a row per position, per flank pair, or per torque."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from flankload.base.optional import optional
from flankload.result.quantities import (
    ALONG_POSITIONS,
    along_positions,
    column,
    over_sites,
    units_of,
)

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from flankload.result.result import Result


def positions_frame(results: Sequence[Result]) -> Any:
    """A row per torque and position.

    Parameters
    ----------
    results : sequence of Result
        Of one scene, one per torque.

    Returns
    -------
    pandas.DataFrame
        The columns that CSV has before those of single pairs, and each angle also in degrees. NaN:
        not known.

    Raises
    ------
    ImportError
        If pandas is not installed.
    """
    pandas = optional("pandas", "to_dataframe")
    return pandas.concat([pandas.DataFrame(_positions(one)) for one in results], ignore_index=True)


def pairs_frame(results: Sequence[Result]) -> Any:
    """A row per torque, position and flank pair.

    Parameters
    ----------
    results : sequence of Result
        Of one scene, one per torque; each with its own pairs.

    Returns
    -------
    pandas.DataFrame
        Torque, position in rad and in degrees, pair number, and the quantities that CSV has for
        each pair. NaN: open, or not known.

    Raises
    ------
    ImportError
        If pandas is not installed.
    """
    pandas = optional("pandas", "pairs_dataframe")
    return pandas.concat([pandas.DataFrame(_pairs(one)) for one in results], ignore_index=True)


def summary_frame(results: Sequence[Result]) -> Any:
    """A row per torque with the numbers of `Result.summary`.

    Parameters
    ----------
    results : sequence of Result
        Of one scene, one per torque.

    Returns
    -------
    pandas.DataFrame
        Entries of tables and lists have dotted names, counted from 0. NaN: not known.

    Raises
    ------
    ImportError
        If pandas is not installed.
    """
    pandas = optional("pandas", "summary_dataframe")
    return pandas.DataFrame(
        [{"torque_Nm": one.torque_Nm, **dict(_flat(one.summary))} for one in results]
    )


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


def _flat(table: Mapping[str, Any], before: str = "") -> Iterator[tuple[str, Any]]:
    """Numbers of a table by dotted names."""
    for key, value in table.items():
        if isinstance(value, dict):
            yield from _flat(value, f"{before}{key}.")
        elif isinstance(value, list | tuple):
            inner = {str(n): item for n, item in enumerate(value)}
            yield from _flat(inner, f"{before}{key}.")
        else:
            yield f"{before}{key}", np.nan if value is None else value
