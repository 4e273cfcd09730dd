"""Scatter to first order: variances of the variables through derivatives of the results.

With independent variables x_v of covariance C_v and the derivatives g_v of a quantity at their
means, its variance is the sum of g_vᵀ C_v g_v over the variables; each term is a share.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from flankload.result.quantities import least_of
from flankload.scene.refusal import refuse
from flankload.studies.design.run import SOLVED, Outcome, row_of
from flankload.studies.design.run_designs import refuse_unknown
from flankload.studies.prepared import solve_scene
from flankload.studies.quality import JointNormal
from flankload.studies.sensitivity import sensitivity

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flankload.base.arrays import Floats
    from flankload.mechanisms import Parts
    from flankload.result import Result
    from flankload.scene import Scene
    from flankload.studies.variables import Variable


#: Deviation of one tooth, um, if the mean has equal teeth. Samples have different teeth, so their
#: key figures refer to another period; with this deviation the mean has the same period.
UNEVEN_UM = 1e-9


@dataclass(frozen=True, eq=False)
class FirstOrder:
    """A quantity to first order; arrays have the dimensions (torques if there is a list, points).

    Attributes
    ----------
    mean, standard_deviation : array
        The mean is the value with all variables at their means.
    shares : dict of array
        By variable, the largest first: part of the variance.
    kinks : dict of array
        By variable: standard deviation times half the difference of both one-sided derivatives;
        not 0 where the quantity has a kink at the mean.
    least : float
        Least possible value, such as 0 of a peak to peak; minus infinity if there is none.
    """

    mean: Floats
    standard_deviation: Floats
    shares: dict[str, Floats]
    kinks: dict[str, Floats]
    least: float = -np.inf

    def percentile(self, percent: float) -> Floats:
        """Values that are not exceeded with a probability in percent, if normally distributed.

        NaN below the least possible value, where the distribution is not normal.
        """
        found = self._normal(percent)
        return np.where(found < self.least, np.nan, found)

    def impossible(self, percent: float) -> float | None:
        """Percentile of the normal distribution if it is below the least possible value."""
        found = self._normal(percent)
        lowest = float(np.nanmin(found, initial=np.inf))
        return lowest if lowest < self.least else None

    def _normal(self, percent: float) -> Floats:
        from scipy.special import ndtri

        return np.asarray(self.mean + ndtri(percent / 100.0) * self.standard_deviation)


def first_order(
    scene: Scene, variables: Sequence[Variable], names: Sequence[str], parts: Parts
) -> tuple[dict[str, FirstOrder], int]:
    """Scatter of quantities to first order, by name, and the number of derivatives.

    The variables have distributions; `parts` are those of similar scenes.

    Raises SceneError and FlankloadError as `sensitivity`; if a quantity is unknown or no number.
    """
    base = scene.replace({k: v for one in variables for k, v in one.changes(_mean(one)).items()})
    results = solve_scene(base, None, parts).by_torque
    shapes = [value.shape for value in _values(results[0], names)]
    sites = {int(site) for result in results for site in result.sites}
    loads = [_loads(one, sites) for one in variables]
    found = sensitivity(base, [path for paths, _ in loads for path in paths], parts)

    def together(result: Result) -> Floats:
        return np.concatenate([np.ravel(value) for value in _values(result, names)])

    ends = np.cumsum([int(np.prod(shape)) for shape in shapes])

    def split(values: Floats) -> dict[str, Floats]:
        """Arrays (torques, points of all quantities) by quantity."""
        parts = zip(names, shapes, np.split(values, ends[:-1], axis=1), strict=True)
        found = {name: part.reshape(len(values), *shape) for name, shape, part in parts}
        return found if base.has_torque_list else {name: part[0] for name, part in found.items()}

    slopes, sides = found.derivative(together), found.to_each_side(together)
    jumps = np.nan_to_num(0.5 * (sides[1] - sides[0]))  # NaN: the end of a range
    scatter, kinks, first = {}, {}, 0
    for variable, (paths, factor) in zip(variables, loads, strict=True):
        own = slice(first, first := first + len(paths))
        scatter[variable.name] = split(_variance(factor, slopes[own]))
        kinks[variable.name] = split(np.sqrt(_variance(factor, jumps[own])))
    mean = split(np.stack([together(result) for result in found.results]))
    return {
        name: _first_order(
            mean[name],
            {variable: of_one[name] for variable, of_one in scatter.items()},
            {variable: of_one[name] for variable, of_one in kinks.items()},
            least_of(name),
        )
        for name in names
    }, len(found.paths)


def _first_order(
    mean: Floats, scatter: dict[str, Floats], kinks: dict[str, Floats], least: float
) -> FirstOrder:
    """The record of a quantity; the variable with the largest variance is the first."""
    variance = np.sum(list(scatter.values()), axis=0)
    with np.errstate(invalid="ignore"):
        shares = {name: np.nan_to_num(of_one / variance) for name, of_one in scatter.items()}
    order = sorted(shares, key=lambda name: -float(np.nansum(scatter[name])))
    ordered = {name: shares[name] for name in order}
    return FirstOrder(mean, np.sqrt(variance), ordered, kinks, least)


def _mean(variable: Variable) -> Any:
    """Mean of a variable, in the form of its key."""
    distribution = variable.distribution
    if not isinstance(distribution, JointNormal):
        return float(distribution.mean())
    if not distribution.is_list:
        return float(distribution.mean[0])
    mean = distribution.mean.copy()
    if not np.ptp(mean):
        mean[mean.size // 2] += UNEVEN_UM
    return mean.tolist()


def _loads(variable: Variable, sites: set[int]) -> tuple[list[str], Floats]:
    """Paths (p) of numbers, and their deviations (p, m) per independent standard number.

    For a list, these are the entries of teeth that carry load; the tooth of pair j has entry -j.
    """
    distribution = variable.distribution
    if not isinstance(distribution, JointNormal):
        return list(variable.paths), np.full((len(variable.paths), 1), distribution.std())
    if not distribution.is_list:
        return list(variable.paths), distribution.factor
    entries = sorted({-site % distribution.mean.size for site in sites})
    return [f"{variable.name}[{entry}]" for entry in entries], distribution.factor[entries]


def _variance(factor: Floats, slopes: Floats) -> Floats:
    """Variance (...) by deviations (p, m), through the slopes (p, ...)."""
    return np.asarray((np.tensordot(factor.T, slopes, 1) ** 2).sum(axis=0))


def _values(result: Result, names: Sequence[str]) -> list[Floats]:
    """Numbers and curves of a result; a name that it does not have is refused."""
    row = row_of(result, tuple(names))
    unknown = tuple(name for name in names if name not in row["quantities"])
    refuse_unknown(Outcome(SOLVED, results=(row,), unknown=unknown))
    found = []
    for name in names:
        try:
            found.append(np.asarray(row["quantities"][name], dtype=float))
        except ValueError:
            refuse("quantities", "names of numbers and curves", f"'{name}', which is text")
    return found
