"""Key figures of a result as sums of maxima of smooth numbers.

A peak to peak is the largest transmission error plus the largest negative one; a peak pressure is
the largest of all positions and pairs; the amplitude of a harmonic is the largest projection of its
phasor. Maxima are not differentiable where two numbers are equal, and this is where an optimum
lies. The optimisation therefore receives all numbers of each maximum with their gradients.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from flankload.errors import FlankloadError
from flankload.result.corners import off_corners
from flankload.result.harmonics import over_positions
from flankload.result.summary import NO_VALUE
from flankload.scene.refusal import refuse

if TYPE_CHECKING:
    from flankload.base.arrays import Floats
    from flankload.result import Result


#: Directions onto which the phasor of a harmonic is projected; the largest projection is at most
#: 1 - cos(pi / 64) = 0.12 % below the amplitude.
DIRECTIONS = 64
HARMONIC = re.compile(r"transmission_error_(mesh_)?harmonics_um\[(\d+)\]")


@dataclass(frozen=True)
class Figure:
    """A key figure: the sum of the largest entries of one or two arrays.

    Its name is that in `Result.summary`; parts of tables behind dots, entries of lists in brackets.
    Each of the maxima returns an array of any shape for a result; values of positions and sites in
    its first axes, in this order.
    """

    name: str
    maxima: tuple[Callable[[Result], Floats], ...]

    def value(self, result: Result) -> float:
        """The figure as the summary has it; NaN for None."""
        return numbers_of(result.summary).get(self.name, np.nan)


def figure_of(name: str, result: Result, key: str) -> Figure:
    """Find a key figure of a result by its name, which the key of a table gives.

    Raises SceneError if the summary of the result has no such number, FlankloadError if the figure
    is None in this result.
    """
    numbers = numbers_of(result.summary)
    if name in NO_VALUE and result.summary[name] is None:
        raise FlankloadError(f"{name} has no value: {NO_VALUE[name]}")
    if name not in numbers:
        refuse(key, f"a key figure of this scene ({', '.join(sorted(numbers))})", f"'{name}'")
    harmonic = HARMONIC.fullmatch(name)
    if name in MAXIMA:
        return Figure(name, MAXIMA[name])
    if harmonic and over_positions(result).even:
        every = result.period_pitches if harmonic[1] else 1
        return Figure(name, (partial(_projections, order=every * (int(harmonic[2]) + 1)),))
    return Figure(name, (partial(_number, name=name),))


def numbers_of(summary: Any, name: str = "") -> dict[str, float]:
    """All numbers of a summary, as "root_stress_1.tension.stress_MPa" or "…harmonics_um[0]"."""
    if isinstance(summary, Mapping):
        parts = [(f"{name}.{key}" if name else key, part) for key, part in summary.items()]
    elif isinstance(summary, list | tuple):
        parts = [(f"{name}[{k}]", part) for k, part in enumerate(summary)]
    else:
        is_number = isinstance(summary, int | float) and not isinstance(summary, bool)
        return {name: float(summary)} if is_number else {}
    return {key: x for path, part in parts for key, x in numbers_of(part, path).items()}


def _number(result: Result, *, name: str) -> Floats:
    return np.array([numbers_of(result.summary).get(name, np.nan)])


def _projections(result: Result, *, order: int) -> Floats:
    """Projections of the phasor of a harmonic of the transmission error, um."""
    error = result.transmission_error_um
    phasor = 2.0 / error.size * np.fft.rfft(error)[order]
    angle = 2.0 * np.pi / DIRECTIONS * np.arange(DIRECTIONS)
    return np.asarray(phasor.real * np.cos(angle) + phasor.imag * np.sin(angle))


def _line_loads(result: Result, *, name: str) -> Floats:
    """Line loads relative to their mean, by the name of an array of the slices."""
    values: Floats = getattr(result.slices, name)
    return values


def _root_tension(result: Result, *, body: int) -> Floats:
    stress = result.root_stress[body]
    assert stress is not None
    return stress.tension.stress_MPa


#: Figures that are maxima over positions, pairs and slices.
MAXIMA: dict[str, tuple[Callable[[Any], Floats], ...]] = {
    "transmission_error_peak_to_peak_um": (
        lambda result: result.transmission_error_um,
        lambda result: -result.transmission_error_um,
    ),
    "peak_pressure_MPa": (off_corners,),
    "peak_line_load_N_per_mm": (lambda result: result.mean_line_load_N_per_mm,),
    "load_share_max": (lambda result: result.load_share,),
    "face_load_factor": (partial(_line_loads, name="relative_mean_line_load"),),
    "line_load_factor": (partial(_line_loads, name="relative_line_load"),),
    "root_stress_1.tension.stress_MPa": (partial(_root_tension, body=0),),
    "root_stress_2.tension.stress_MPa": (partial(_root_tension, body=1),),
}
