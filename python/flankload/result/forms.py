"""Access to the torques of a result, and its forms as text, files and tables."""

from __future__ import annotations

from math import isclose
from typing import TYPE_CHECKING, Any

from flankload.base.arguments import is_number
from flankload.base.card import Card
from flankload.base.rounding import TIE
from flankload.errors import InputError
from flankload.result.export import CsvForm, results_to_csv, results_to_json, to_xarray
from flankload.result.frames import pairs_frame, positions_frame, summary_frame
from flankload.result.plotting import Plots
from flankload.result.stiffness_table import StiffnessTable, stiffness_table
from flankload.result.table import cost_table, texts_of
from flankload.result.torque_axis import TorqueAxis
from flankload.result.workbook import results_to_xlsx

if TYPE_CHECKING:
    from pathlib import Path

    from flankload.result.result import Result


class ResultForms(Card, TorqueAxis):
    """Access to single torques, and forms of a result as text, files and tables."""

    def at(self, torque_Nm: float) -> Result:
        """Return the result of one torque.

        Parameters
        ----------
        torque_Nm : float
            One of `torques_Nm`, up to rounding.

        Returns
        -------
        Result
            Without an axis of torques.

        Raises
        ------
        InputError
            If the result has no such torque.
        """
        for one in self.by_torque:
            if is_number(torque_Nm) and isclose(one.torque_Nm, torque_Nm, rel_tol=TIE):
                return one
        known = ", ".join(f"{torque:.12g}" for torque in self.torques_Nm)
        raise InputError(f"torque_Nm: expected one of {known}, found {torque_Nm!r}")

    @property
    def plot(self) -> Plots:
        """Plots by name: `result.plot.transmission_error(axes)`, `result.plot.all(folder)`."""
        return Plots(self)

    def stiffness_table(self) -> StiffnessTable:
        """Return stiffness and transmission error over the period, for multibody programs."""
        return stiffness_table(self.by_torque)

    def to_json(self, path: str | Path | None = None) -> str:
        """Return the result as strict JSON (null for NaN and infinity); write it to `path`.

        A list of torques gives {"torques_Nm": [...], "results": [...]}.
        """
        return results_to_json(self.by_torque if self.has_torque_list else self.by_torque[0], path)

    def to_csv(
        self,
        path: str | Path | None = None,
        *,
        separator: str | None = None,
        decimal_comma: bool = False,
        degrees: bool = False,
    ) -> str:
        """Return the result as CSV, a row per torque and position; write it to `path`.

        Options as for `CsvForm`.
        """
        return results_to_csv(self.by_torque, path, CsvForm(separator, decimal_comma, degrees))

    def to_xlsx(self, path: str | Path) -> None:
        """Write the result as a workbook; needs the extra [xlsx]."""
        results_to_xlsx(self.by_torque, path)

    def to_xarray(self) -> Any:
        """Return the result as a labelled `xarray.Dataset` with units; needs the extra [xarray].

        A list of torques has the dimension `torque`.
        """
        return to_xarray(self.by_torque if self.has_torque_list else self.by_torque[0])

    def to_dataframe(self) -> Any:
        """Return a `pandas.DataFrame`, a row per torque and position; needs the extra [pandas].

        Its columns are those of CSV without single pairs, and angles also in degrees.
        """
        return positions_frame(self.by_torque)

    def pairs_dataframe(self) -> Any:
        """Return a `pandas.DataFrame`, a row per torque, position and flank pair."""
        return pairs_frame(self.by_torque)

    def summary_dataframe(self) -> Any:
        """Return a `pandas.DataFrame`, a row per torque with the numbers of the summary."""
        return summary_frame(self.by_torque)

    def table(self) -> str:
        """Return the result as text: a row per position, then the summary, for each torque."""
        return texts_of(self.by_torque)

    def cost_table(self) -> str:
        """Return the cost of the run as text, stage by stage, beside the prediction."""
        return cost_table(self.by_torque[0].cost)
