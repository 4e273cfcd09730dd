"""Robust design: scatter of results by tolerances, to first order beside Monte Carlo."""

from __future__ import annotations

from dataclasses import dataclass, field
from time import perf_counter
from typing import TYPE_CHECKING, Any

import numpy as np

from flankload.base.card import Card
from flankload.base.text_table import text_table
from flankload.errors import FlankloadError
from flankload.mechanisms import Parts
from flankload.scene import SceneLike, scene_of
from flankload.scene.refusal import refuse, shown
from flankload.studies.design import DesignStudy, run_study
from flankload.studies.design.designs import OF_DRAWS, Designs
from flankload.studies.design.solve_study import checked
from flankload.studies.prepared import Prepared
from flankload.studies.robustness.first_order import FirstOrder, first_order
from flankload.studies.robustness.samples import Failures, Samples
from flankload.studies.settings import left_out, settings_for
from flankload.studies.variables import variables_of

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence
    from concurrent.futures import Executor
    from pathlib import Path


#: Quantities if none are named.
QUANTITIES = (
    "transmission_error_mean_um",
    "transmission_error_peak_to_peak_um",
    "peak_pressure_MPa",
)
#: Percentiles of the report.
PERCENT = (5.0, 50.0, 95.0)
#: Samples that have a standard deviation.
LEAST_SAMPLES = 2
FAILED_WORDS = (
    "failed designs are worse than all others: percentiles below 50 % count them below all values, "
    "others above; mean and standard deviation are those of the solved designs, and first order "
    "includes no failure"
)
#: Cell of a percentile among the failed designs.
FAILED = "failed"
#: First order holds if its percentiles are this part of a standard deviation beside those of the
#: distribution: the value that should be exceeded in 5 % of all cases is then exceeded in 4 to 6 %.
HOLDS = 0.1


@dataclass(frozen=True, eq=False, repr=False)
class Robust(Card):
    """Scatter of a scene's results; from `robust`.

    Attributes
    ----------
    name : str
        Name of the scene.
    torques_Nm : tuple of float or None
        If the scene has a list of torques.
    first_order : dict of FirstOrder
        By name of the quantity.
    study : DesignStudy or None
        Designs of the Monte Carlo simulation, if there is one.
    solutions : int
        Number of derivatives to first order.
    seconds : dict
        Elapsed seconds of `first_order` and `monte_carlo`.
    settings : mapping
        Keys that were set for all runs, and their values.
    """

    name: str
    torques_Nm: tuple[float, ...] | None
    first_order: dict[str, FirstOrder]
    study: DesignStudy | None
    solutions: int
    seconds: dict[str, float]
    settings: Mapping[str, Any] = field(default_factory=dict)

    @property
    def failures(self) -> Failures | None:
        """Failed designs of the simulation, if there is one."""
        study = self.study
        return None if study is None else Failures(len(study.failed), len(study.rows))

    def samples(self, quantity: str) -> Samples:
        """Monte Carlo samples of a quantity, one of the names in `first_order`.

        Failed designs have no value. Raises SceneError if there is no such quantity, or no
        simulation.
        """
        if quantity not in self.first_order or self.study is None:
            known = ", ".join(self.first_order) if self.study else "a name, after a run with n > 0"
            refuse("quantity", known, shown(quantity))
        return Samples(self.study.values(quantity))

    @property
    def notes(self) -> tuple[str, ...]:
        """Quantities for which first order does not hold, and failed designs."""
        found = []
        for name, linear in self.first_order.items():
            found += _impossible(name, linear, sampled=self.study is not None)
            bent = [
                variable
                for variable, size in linear.kinks.items()
                if np.any(size > HOLDS * linear.standard_deviation + _noise(linear))
            ]
            if bent:
                words = "first order does not hold: its derivatives to both sides differ for"
                found.append(f"{name}: {words} {', '.join(bent)}")
            if self.study is not None and (missed := _missed(linear, self.samples(name))):
                percent, size = missed
                words = f"its {percent:g} % percentile differs by {size:.3g} from Monte Carlo"
                found.append(f"{name}: first order does not hold: {words}")
        if self.study is not None and self.study.failed:
            first = self.study.failed[0].outcome.error
            found.append(f"{FAILED_WORDS}; the first failed with: {first}")
        return tuple(found)

    def __str__(self) -> str:
        """Return both results beside each other, the shares of the variables, and the notes."""
        percents = [f"{percent:g} %" for percent in PERCENT]
        rows = [["", "", "mean", "standard deviation", *percents]]
        shares = ["variance by variable, first order:"]
        for label, name, at in self._lines():
            linear = self.first_order[name]
            rows.append([label, "first order", *_numbers(_of(linear), at)])
            parts = [f"{v} {100 * share[at]:.1f} %" for v, share in linear.shares.items()]
            shares.append(f"  {label}: {', '.join(parts)}")
            if self.study is not None:
                samples = self.samples(name)
                ends = [samples.interval(percent) for percent in PERCENT]
                errors = [2.0 * samples.mean_error, 2.0 * samples.deviation_error]
                errors += [0.5 * (high - low) for low, high in ends]
                rows.append(["", "Monte Carlo", *_numbers(_of(samples), at, unknown=FAILED)])
                rows.append(["", "  +-", *_numbers(errors, at)])
        lines = [self._head, *text_table(rows, left=2)]
        if self.failures is not None:
            lines.append(f"failed designs: {self.failures}")
        lines += [*shares, *left_out(self.settings)]
        return "\n".join([*lines, *(f"note: {note}" for note in self.notes)])

    @property
    def _head(self) -> str:
        head = f"{self.name}: first order by {self.solutions} derivatives in "
        head += f"{self.seconds['first_order']:.2g} s"
        if self.study is not None:
            n = len(self.study.rows)
            head += f"; Monte Carlo with {n} designs in {self.seconds['monte_carlo']:.2g} s"
        return head

    def _lines(self) -> Iterator[tuple[str, str, tuple[int, ...]]]:
        """Label, quantity and index of each line; of a curve, the place of the largest scatter."""
        for name, linear in self.first_order.items():
            deviation = linear.standard_deviation
            for t, torque in enumerate(self.torques_Nm or (None,)):
                label, at = name, () if torque is None else (t,)
                if deviation.ndim > len(at):
                    place = int(np.argmax(np.nan_to_num(deviation[at])))
                    label, at = f"{name}[{place}]", (*at, place)
                yield label if torque is None else f"{label}, {torque:g} N m", name, at


def robust(
    scene: SceneLike | Prepared,
    variables: Mapping[str, Any],
    quantities: Sequence[str] = QUANTITIES,
    *,
    n: int = 0,
    seed: int = 0,
    design: str = "random",
    store: str | Path | None = None,
    executor: Executor | None = None,
) -> Robust:
    """Scatter of results by tolerances: to first order, and by Monte Carlo.

    Parameters
    ----------
    scene : Scene, path, mapping or Prepared
        As for `solve`. A prepared scene lends its bodies and compliances to the first order.
    variables : mapping
        Distributions as for `study`; independent of each other.
    quantities : sequence of str
        Names in `Result.summary` or arrays over the positions. Estimates and tangents that none
        needs are left out, unless the scene has `accuracy.estimate` or `accuracy.tangents`.
    n : int
        Designs of the Monte Carlo simulation; 0: none.
    seed : int
    design : str
        "random" or "sobol". The sampling errors are those of random designs.
    store, executor
        As for `study`.

    Returns
    -------
    Robust

    Raises
    ------
    SceneError, FlankloadError, KeyboardInterrupt
        As `sensitivity` and `study`.
    """
    parts = scene.parts if isinstance(scene, Prepared) else Parts()
    scene = scene.scene if isinstance(scene, Prepared) else scene_of(scene)
    if design not in OF_DRAWS:
        refuse("design", " or ".join(f"'{kind}'" for kind in OF_DRAWS), shown(design))
    designs = Designs(variables_of(variables), design, n or 1, seed)
    designs, names = checked(scene, designs, quantities)
    settings = settings_for(scene, names, designs.paths)
    scene = scene.replace(settings)
    begin = perf_counter()
    linear, solutions = first_order(scene, designs.variables, names, parts)
    middle = perf_counter()
    found = run_study(scene, designs, names, store, executor) if n else None
    if found is not None and len(found.rows) - len(found.failed) < LEAST_SAMPLES:
        reason = found.failed[0].outcome.error if found.failed else "n is 1"
        raise FlankloadError(f"fewer than {LEAST_SAMPLES} designs have a solution: {reason}")
    seconds = {"first_order": middle - begin, "monte_carlo": perf_counter() - middle}
    torques = scene.torques_Nm if scene.has_torque_list else None
    return Robust(scene.name, torques, linear, found, solutions, seconds, settings)


def _of(found: FirstOrder | Samples) -> list[Any]:
    """Mean, standard deviation and percentiles of the report."""
    return [found.mean, found.standard_deviation, *(found.percentile(p) for p in PERCENT)]


def _numbers(values: list[Any], at: tuple[int, ...], *, unknown: str = "") -> list[str]:
    """Entries of arrays as cells; a word for those that are unknown."""
    found = [float(np.asarray(value)[at]) for value in values]
    return [unknown if np.isnan(number) else f"{number:.5g}" for number in found]


def _impossible(name: str, linear: FirstOrder, *, sampled: bool) -> list[str]:
    """Note on the lowest percentile that is below the least possible value, if there is one."""
    beyond = {percent: linear.impossible(percent) for percent in PERCENT}
    known = {percent: value for percent, value in beyond.items() if value is not None}
    if not known:
        return []
    percent, value = min(known.items())
    words = f"its {percent:g} % percentile would be {value:.5g}, and no value is below "
    advice = "use that of Monte Carlo" if sampled else "sample with n > 0"
    return [f"{name}: first order does not hold: {words}{linear.least:g}; {advice}"]


def _missed(linear: FirstOrder, samples: Samples) -> tuple[float, float] | None:
    """Percentile of the worst failure of first order, and its size; None if it holds."""
    worst = (0.0, 0.0)
    allowed = HOLDS * samples.standard_deviation + _noise(linear)
    for percent in PERCENT:
        value, (low, high) = linear.percentile(percent), samples.interval(percent)
        low, high = np.nan_to_num(low, nan=-np.inf), np.nan_to_num(high, nan=np.inf)
        beyond = np.maximum(low - value, value - high)
        distance = np.abs(value - samples.percentile(percent))
        missed = (beyond > allowed) & np.isfinite(distance)  # not finite: among failed designs
        if missed.any():
            worst = max(worst, (float(distance[missed].max()), percent))
    size, percent = worst
    return (percent, size) if size else None


def _noise(linear: FirstOrder) -> Any:
    """Rounding error of the values, so that a quantity without scatter is no failure."""
    return 1e-9 * np.abs(linear.mean)
