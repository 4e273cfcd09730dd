"""Laws of the error estimate and of CPU seconds, by the knobs.

What the estimate tells of a source goes with a power of its knob; how much it is at the default
knobs was measured on scenes drawn from a seed (`./dev bench tolerance` draws the same ones). Of a
run that is done the estimate itself says how much it is, and the laws only how it will change.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    Floats = NDArray[np.float64]
    Errors = dict[str, float]

#: What a tolerance binds.
BOUND = (
    "transmission_error",
    "transmission_error_mean",
    "transmission_error_peak_to_peak",
    "load_share",
    "peak_pressure",
    "stiffness_secant",
)
#: Knobs that the amounts of the laws are told at, and the strips of the default.
AT_MODES, AT_STRIPS = 5, 10.0
#: Errors of several sources cancel or add up by their signs, doubts by their squares: all together
#: were within this of the root of the squares of what each source alone would leave.
LEAST_TOGETHER, MOST_TOGETHER = 0.8, 1.2
#: Strips: error by a power of their width; where a peak is not resolved they help more slowly.
STRIPS_ORDER, UNRESOLVED_ORDER, UNRESOLVED = 2.0, 1.5, 0.01
#: Seconds: elements by a power of their length over what they take in any case, modes, strips.
ELEMENTS_COST, ELEMENTS_COST_ORDER, MODES_COST = 0.7, 1.85, 0.01
STRIPS_COST, STRIPS_COST_ORDER = 0.4, 1.4


@dataclass(frozen=True)
class Law:
    """Errors told by the estimate, and seconds.

    Attributes
    ----------
    elements, modes, strips, rest : dict of str to float
        What each source leaves of each bound quantity with default elements, 5 modes, 10 strips;
        rest: sources that no knob of these answers for.
    series : tuple of float
        What 3, 4, … 12 modes leave, over what 5 leave.
    order, by_modes, in_modes : float
        Elements: error by a power of their length, and of the modes that they have to bear; those
        that are too coarse for the highest modes show in these, too, by this part of their error.
    strips_order : dict of str to float
    together : dict of str to float
        What is told of all sources over the root of the squares of what is told of each.
    elements_s : float
        CPU seconds of default elements; 0 where they need not be solved.
    state_s : float
        Of a position under a torque, with its tangent and its part of the estimate.
    """

    elements: Mapping[str, float]
    modes: Mapping[str, float]
    strips: Mapping[str, float]
    series: tuple[float, ...]
    order: float
    by_modes: float
    in_modes: float
    elements_s: float
    state_s: float
    rest: Mapping[str, float]
    strips_order: Mapping[str, float]
    together: Mapping[str, float]

    def sources(
        self, quantity: str, part: Floats, modes: Floats, strips: Floats
    ) -> dict[str, Floats]:
        """What each source leaves of a quantity.

        Parameters
        ----------
        quantity : str
        part : array
            Length of elements over the default.
        modes, strips : arrays that broadcast with it

        Returns
        -------
        dict of str to array
        """
        elements = self.elements[quantity] * part**self.order * (modes / AT_MODES) ** self.by_modes
        left = self.modes[quantity] * np.asarray(self.series)[np.asarray(modes, dtype=int) - 3]
        order = self.strips_order[quantity]
        return {
            "elements": elements,
            "modes": np.hypot(left, self.in_modes * elements),
            "strips": self.strips[quantity] * (AT_STRIPS / strips) ** order,
            "rest": np.asarray(self.rest[quantity]),
        }

    def errors(self, quantity: str, part: Floats, modes: Floats, strips: Floats) -> Floats:
        """What all sources leave of a quantity."""
        found = self.sources(quantity, part, modes, strips).values()
        return np.asarray(self.together[quantity] * np.sqrt(sum(error**2 for error in found)))

    def elements_seconds(self, part: Floats, modes: Floats) -> Floats:
        """CPU seconds of elements."""
        return np.asarray(self.elements_s * elements_cost(part, modes))

    def states_seconds(self, strips: Floats, states: float) -> Floats:
        """CPU seconds of all states."""
        return np.asarray(states * self.state_s * states_cost(strips))


def elements_cost(part: Floats | float, modes: Floats | float) -> Floats:
    """Seconds of elements over those of the default."""
    size = 1.0 - ELEMENTS_COST + ELEMENTS_COST * part**-ELEMENTS_COST_ORDER
    return np.asarray(size * (1.0 + MODES_COST * (modes - AT_MODES)))


def states_cost(strips: Floats | float) -> Floats:
    """Seconds of a state over those on 10 strips."""
    return np.asarray(1.0 - STRIPS_COST + STRIPS_COST * (strips / AT_STRIPS) ** STRIPS_COST_ORDER)


def together(told: Mapping[str, Mapping[str, float]], of_all: Mapping[str, float]) -> Errors:
    """What is told of all sources over the root of the squares of what is told of each.

    Parameters
    ----------
    told : mapping of str to mapping
        By source and bound quantity, what each alone would leave.
    of_all : mapping of str to float
        By bound quantity.

    Returns
    -------
    dict of str to float
        1 where nothing is told.
    """
    found = dict.fromkeys(BOUND, 1.0)
    for quantity, error in of_all.items():
        alone = sum(errors.get(quantity, 0.0) ** 2 for errors in told.values()) ** 0.5
        if alone > 0:
            found[quantity] = float(np.clip(error / alone, LEAST_TOGETHER, MOST_TOGETHER))
    return found


def as_told(
    law: Law,
    told: Mapping[str, Mapping[str, float]],
    together: Mapping[str, float],
    *,
    part: float,
    modes: int,
    strips: float,
) -> Law:
    """The law with its amounts from what an estimate tells at some knobs.

    Parameters
    ----------
    law : Law
    told : mapping of str to mapping
        By source and bound quantity, what each alone would leave.
    together : mapping of str to float
        By bound quantity, from `together`.
    part, modes, strips
        The knobs of that run.

    Returns
    -------
    Law
    """
    shape = part**law.order * (modes / AT_MODES) ** law.by_modes
    series = law.series[modes - 3] if modes >= 3 else 1.0
    known = {source: dict.fromkeys(BOUND, 0.0) for source in ("elements", "modes", "strips")}
    rest, order = dict.fromkeys(BOUND, 0.0), dict.fromkeys(BOUND, STRIPS_ORDER)
    for quantity in BOUND:
        elements = told.get("elements", {}).get(quantity, 0.0)
        in_modes = told.get("modes", {}).get(quantity, 0.0)
        in_strips = told.get("strips", {}).get(quantity, 0.0)
        # of what shows in the modes, some is the elements'; the rest is at least a part of it
        own = max(in_modes**2 - (law.in_modes * elements) ** 2, (0.3 * in_modes) ** 2) ** 0.5
        if in_strips > UNRESOLVED:
            order[quantity] = UNRESOLVED_ORDER
        known["elements"][quantity] = elements / shape
        known["modes"][quantity] = own / series
        known["strips"][quantity] = in_strips * (strips / AT_STRIPS) ** order[quantity]
        others = (told[source].get(quantity, 0.0) for source in told if source not in known)
        rest[quantity] = sum(error**2 for error in others) ** 0.5
    return replace(
        law,
        elements=known["elements"],
        modes=known["modes"],
        strips=known["strips"],
        rest=rest,
        strips_order=order,
        together=together,
    )


def _law(
    elements: tuple[float, ...],
    modes: tuple[float, ...],
    strips: tuple[float, ...],
    series: tuple[float, ...],
    powers: tuple[float, float, float],
    seconds: tuple[float, float],
) -> Law:
    return Law(
        dict(zip(BOUND, elements, strict=True)),
        dict(zip(BOUND, modes, strict=True)),
        dict(zip(BOUND, strips, strict=True)),
        series,
        *powers,
        *seconds,
        rest=dict.fromkeys(BOUND, 0.0),
        strips_order=dict.fromkeys(BOUND, STRIPS_ORDER),
        together=dict.fromkeys(BOUND, 1.0),
    )


NONE = (0.0,) * len(BOUND)
#: By kind of pair, amounts in the order of `BOUND`: what seven of ten of the drawn scenes stay
#: below (of strips in peaks, where they do not resolve some, nine of ten of gears and of cams).
LAWS = {
    "gears": _law(
        elements=(1.5e-3, 7.5e-4, 1.7e-4, 1.4e-3, 2.5e-3, 8e-4),
        modes=(7.1e-3, 1.6e-3, 2.4e-3, 5.4e-3, 6e-3, 1.3e-3),
        strips=(1.5e-4, 3e-5, 8e-5, 1.3e-4, 5.4e-3, 3e-5),
        series=(41.0, 7.1, 1.0, 0.71, 0.41, 0.28, 0.26, 0.17, 0.145, 0.12),
        powers=(1.7, 2.4, 0.1),
        seconds=(0.14, 5e-3),
    ),
    "splines": _law(
        elements=(4e-4, 4e-4, 8e-5, 2e-4, 2.4e-2, 2e-4),
        modes=(5e-4, 1.4e-4, 8e-5, 5e-4, 1.3e-3, 3e-5),
        strips=(3e-4, 6e-5, 2e-4, 1e-3, 4.7e-2, 1e-5),
        series=(20.0, 5.0, 1.0, 0.7, 0.5, 0.4, 0.3, 0.3, 0.3, 0.3),
        powers=(1.4, 2.6, 0.1),
        seconds=(0.3, 0.37),
    ),
    "cams": _law(
        elements=(5e-4, 5e-4, 2e-5, 0.0, 1e-5, 5e-4),
        modes=(2.4e-5, 5e-6, 1e-5, 0.0, 5e-6, 5e-6),
        strips=(1e-5, 1e-6, 4e-6, 0.0, 5e-3, 2e-6),
        series=(400.0, 7.6, 1.0, 0.95, 0.45, 0.45, 0.45, 0.4, 0.4, 0.4),
        powers=(1.25, 0.7, 0.0),
        seconds=(0.5, 1.1e-2),
    ),
    "belts": _law(
        elements=(1.2e-2, 1.2e-2, 1.5e-3, 3.5e-3, 0.0, 1.2e-2),
        modes=NONE,
        strips=NONE,
        series=(1.0,) * 10,
        powers=(0.75, 0.0, 0.0),
        seconds=(0.4, 1e-3),
    ),
    "chains": _law(
        elements=NONE,
        modes=NONE,
        strips=NONE,
        series=(1.0,) * 10,
        powers=(1.0, 0.0, 0.0),
        seconds=(0.0, 1e-3),
    ),
}
