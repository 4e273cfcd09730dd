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

from flankload.result.harmonics import over_positions
from flankload.scene.refusal import refuse

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from flankload.result import Result

    Floats = NDArray[np.float64]

#: Directions onto which the phasor of a harmonic is projected; the largest projection is at most
#: 1 - cos(pi / 64) = 0.12 % below the amplitude.
DIRECTIONS = 64
HARMONIC = re.compile(r"transmission_error_(mesh_)?harmonics_um\[(\d+)\]")
#: Part of the name of an entry of the summary.
PART = re.compile(r"(\w+)((?:\[\d+\])*)")


@dataclass(frozen=True)
class Figure:
    """A key figure: the sum of the largest entries of one or two arrays.

    Attributes
    ----------
    name : str
        As in `Result.summary`; parts of tables behind dots, entries of lists in brackets.
    maxima : tuple of callables
        Each returns an array of any length for a result.
    """

    name: str
    maxima: tuple[Callable[[Result], Floats], ...]

    def value(self, result: Result) -> float:
        """The figure as the summary has it."""
        return float(entry(result.summary, self.name))


def figure_of(name: str, result: Result, key: str) -> Figure:
    """Find a key figure by its name.

    Parameters
    ----------
    name : str
    result : Result
        Of the scene.
    key : str
        Where the name is given, for the error.

    Returns
    -------
    Figure

    Raises
    ------
    SceneError
        If the summary of the result has no such number.
    """
    value = entry(result.summary, name)
    if isinstance(value, bool) or not isinstance(value, int | float):
        known = ", ".join(sorted(names_of(result.summary)))
        found = f"'{name}'" if value is None else f"'{name}', which is no number"
        refuse(key, f"a key figure of this scene ({known})", found)
    harmonic = HARMONIC.fullmatch(name)
    if name in MAXIMA:
        return Figure(name, MAXIMA[name])
    if harmonic and over_positions(result).even:
        every = result.period_pitches if harmonic[1] else 1
        return Figure(name, (partial(_projections, order=every * (int(harmonic[2]) + 1)),))
    return Figure(name, (partial(_number, name=name),))


def entry(summary: Mapping[str, Any], name: str) -> Any:
    """Entry of a summary by its name, as "root_stress_1.tension.stress_MPa"; None if absent."""
    found: Any = summary
    for part in name.split("."):
        match = PART.fullmatch(part)
        if match is None or not isinstance(found, Mapping):
            return None
        found = found.get(match[1])
        for index in re.findall(r"\d+", match[2]):
            if not isinstance(found, list | tuple) or int(index) >= len(found):
                return None
            found = found[int(index)]
    return found


def names_of(summary: Any, before: str = "") -> list[str]:
    """Names of all numbers of a summary."""
    if isinstance(summary, Mapping):
        dot = f"{before}." if before else ""
        return [x for key, value in summary.items() for x in names_of(value, f"{dot}{key}")]
    if isinstance(summary, list | tuple):
        return [x for k, value in enumerate(summary) for x in names_of(value, f"{before}[{k}]")]
    is_number = isinstance(summary, int | float) and not isinstance(summary, bool)
    return [before] if is_number else []


def _number(result: Result, *, name: str) -> Floats:
    return np.array([entry(result.summary, name)], dtype=float)


def _projections(result: Result, *, order: int) -> Floats:
    """Projections of the phasor of a harmonic of the transmission error, um."""
    error = result.transmission_error_um
    phasor = 2.0 / error.size * np.fft.rfft(error)[order]
    angle = 2.0 * np.pi / DIRECTIONS * np.arange(DIRECTIONS)
    return np.asarray(phasor.real * np.cos(angle) + phasor.imag * np.sin(angle))


def _line_loads(result: Result) -> Floats:
    """Line load, summed over the flanks, divided by its mean: all positions and slices."""
    slices = result.slices
    assert slices is not None
    summed = (slices.force_N / slices.width_mm).sum(axis=1)
    mean = slices.force_N.sum(axis=(1, 2)) / slices.width_mm.sum()
    return np.asarray((summed / mean[:, None]).ravel())


def _root_tension(result: Result, *, body: int) -> Floats:
    stress = result.root_stress[body]
    assert stress is not None
    return np.asarray(stress.tension.stress_MPa.ravel())


#: Figures that are maxima over positions, pairs and slices.
MAXIMA: dict[str, tuple[Callable[[Any], Floats], ...]] = {
    "transmission_error_peak_to_peak_um": (
        lambda result: result.transmission_error_um,
        lambda result: -result.transmission_error_um,
    ),
    "peak_pressure_MPa": (lambda result: result.peak_pressure_MPa.ravel(),),
    "peak_pressure_off_corners_MPa": (
        lambda result: np.where(result.corner_contact, 0.0, result.peak_pressure_MPa).ravel(),
    ),
    "peak_line_load_N_per_mm": (lambda result: result.slice_line_load_N_per_mm.ravel(),),
    "face_load_factor": (_line_loads,),
    "root_stress_1.tension.stress_MPa": (partial(_root_tension, body=0),),
    "root_stress_2.tension.stress_MPa": (partial(_root_tension, body=1),),
}
