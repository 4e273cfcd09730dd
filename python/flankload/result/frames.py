"""Results as tables of pandas: a row per position, per flank pair, or per torque."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from flankload.base.optional import optional
from flankload.result.export import OVER_SITES, along_positions, more_arrays
from flankload.result.friction import ALONG_POSITIONS as FRICTION

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
    columns: dict[str, Any] = {"torque_Nm": np.full(result.position_rad.size, result.torque_Nm)}
    for key in along_positions(result):
        columns[key] = getattr(result, key)
        if key.endswith("_rad") and "_per_" not in key:
            columns[key.removesuffix("rad") + "deg"] = np.degrees(columns[key])
    if result.friction is not None:
        columns |= {f"friction_{key}": getattr(result.friction, key) for key in FRICTION}
    if result.drive is not None:
        columns |= {key: getattr(result.drive, key) for key in result.drive.along}
    return columns


def _pairs(result: Result) -> dict[str, Any]:
    """Columns of the flank pairs of one torque."""
    count, sites = result.position_rad.size, result.sites.size
    over = {key: getattr(result, key) for key in OVER_SITES}
    over["line_load_N_per_mm"] = result.site_force_N / result.face_width_mm  # not by slices
    over |= {key: values for key, (values, _) in more_arrays(result).items()}
    return {
        "torque_Nm": np.full(count * sites, result.torque_Nm),
        "position_rad": np.repeat(result.position_rad, sites),
        "position_deg": np.repeat(result.position_deg, sites),
        "pair": np.tile(result.sites, count),
        **{key: np.ravel(values) for key, values in over.items()},
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
