"""The cheapest setting that meets a tolerance, by laws."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from flankload.setting import Setting
from flankload.steering.knobs import LEAST_MODES, knobs_of
from flankload.steering.laws import BOUND, LAWS, Law

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from flankload.scene import Scene
    from flankload.steering.knobs import Knobs

    Floats = NDArray[np.float64]

#: Ladders: elements over those of the default, four steps to a half, and strips.
PARTS = 2.0 ** (np.arange(4, -13, -1) / 4.0)
STRIPS = np.array([7.0, 10.0, 14.0, 20.0, 28.0, 40.0, 56.0, 80.0])
#: Finer elements than this, over the default, only for tolerances below FINE: half the
#: length takes four times the seconds.
LEAST_PART, FINE = 2.0**-2.25, 1e-3
#: What a tightened setting is aimed at, as part of the tolerance: laws err, too.
AIM = 0.85
#: What cannot come so low is taken nearly as low as it comes, to so many times as much, before
#: anything is known of a scene and after; then as long as that takes no more than so many times as
#: long as what was run, or as what meets all else.
FIRST_NEARLY, NEARLY, PATIENCE = 1.02, 1.3, 3.0
#: Adaptive positions begin with so many on a pitch; what they may leave in doubt of harmonics and
#: peak to peak, as parts of them, over the tolerance, which binds parts of the whole; and how many
#: they will be, at the least and by a power of the tolerance.
POSITIONS, DOUBT, LEAST_DOUBT, MOST_DOUBT = 8, 3.0, 3e-4, 0.03
EXPECTED, EXPECTED_AT, EXPECTED_ORDER = 25, 0.03, 0.3


@dataclass(frozen=True)
class Pick:
    """A setting, and what the laws say of it.

    Attributes
    ----------
    setting : Setting
        Knobs that are open; others are None.
    part, modes, strips : float, int, float
        All of them, elements over their default length.
    errors : dict of str to float
        Of each bound quantity.
    sources : dict of str to dict of str to float
        By source and quantity.
    seconds : float
        CPU seconds on some machine: good to compare settings with.
    """

    setting: Setting
    part: float
    modes: int
    strips: float
    errors: dict[str, float]
    sources: dict[str, dict[str, float]]
    seconds: float

    def as_dict(self) -> dict[str, Any]:
        """What a plan shows of it."""
        worst = max(self.errors, key=lambda quantity: self.errors[quantity])
        return {
            "keys": self.setting.tables(),
            "errors": dict(self.errors),
            "dominant_source": max(self.sources, key=lambda name: self.sources[name][worst]),
        }


def first_pick(scene: Scene, knobs: Knobs | None = None) -> Pick:
    """What a scene begins with, before anything is known of it.

    Parameters
    ----------
    scene : Scene
        That names a tolerance.
    knobs : Knobs, optional
        From `knobs_of`.

    Returns
    -------
    Pick
    """
    knobs = knobs_of(scene) if knobs is None else knobs
    tolerance = scene.accuracy.tolerance
    positions, states = Setting(), float(knobs.states)
    if knobs.is_open("positions"):
        doubt = float(np.clip(DOUBT * tolerance, LEAST_DOUBT, MOST_DOUBT))
        positions = Setting(count=POSITIONS, adaptive=doubt)
        states *= EXPECTED * (EXPECTED_AT / doubt) ** EXPECTED_ORDER / scene.positions.count
    return cheapest(LAWS[knobs.kind], knobs, tolerance, positions=positions, states=states)


def finest_part(tolerance: float) -> float:
    """The shortest elements that a tolerance may buy, over the default."""
    return LEAST_PART if tolerance >= FINE else float(PARTS[-1])


def cheapest(
    law: Law,
    knobs: Knobs,
    tolerance: float,
    *,
    positions: Setting,
    states: float,
    done: Pick | None = None,
    same_elements: bool = False,
    aim: float = 1.0,
) -> Pick:
    """The cheapest step of the ladders that meets a tolerance by a law, or comes nearest.

    Parameters
    ----------
    law : Law
    knobs : Knobs
    tolerance : float
    positions : Setting
        With the keys of the positions, which are not decided on here.
    states : float
        Positions times torques.
    done : Pick, optional
        A setting that has been run: no knob becomes coarser than there, and its elements, with
        their modes, cost nothing any more.
    same_elements : bool
        Its elements and modes stay.
    aim : float
        Part of the tolerance that is aimed at.

    Returns
    -------
    Pick
    """
    part, modes, strips = _steps(knobs, tolerance, done, same_elements=same_elements)
    seconds = law.elements_seconds(part, modes)
    if done is not None:
        seconds = np.where((part == done.part) & (modes == done.modes), 0.0, seconds)
    seconds = seconds + law.states_seconds(strips, states)
    errors = {quantity: law.errors(quantity, part, modes, strips) for quantity in BOUND}
    wanted = aim * tolerance
    if done is None:
        best = _best(errors, seconds, wanted, nearly=FIRST_NEARLY, least_s=np.inf)
    else:
        best = _best(errors, seconds, wanted, nearly=NEARLY, least_s=done.seconds)
    chosen = float(part[best]), int(modes[best]), float(strips[best])
    one = tuple(np.array(value, dtype=float) for value in chosen)
    found = {quantity: law.sources(quantity, *one) for quantity in BOUND}
    sources = next(iter(found.values()))
    return Pick(
        setting=_setting(knobs, *chosen, positions),
        part=chosen[0],
        modes=chosen[1],
        strips=chosen[2],
        errors={quantity: float(errors[quantity][best]) for quantity in BOUND},
        sources={
            source: {quantity: float(found[quantity][source]) for quantity in BOUND}
            for source in sources
        },
        seconds=float(seconds[best]),
    )


def _steps(
    knobs: Knobs, tolerance: float, done: Pick | None, *, same_elements: bool
) -> tuple[Floats, Floats, Floats]:
    """All steps of elements, modes and strips that are open, each modes that the elements bear."""
    parts = np.array([knobs.part])
    if knobs.is_open("flank_element_mm"):
        parts = PARTS[finest_part(tolerance) <= PARTS]
    modes = np.arange(LEAST_MODES, knobs.most_modes + 1, dtype=float)
    if not knobs.is_open("modes"):
        modes = np.array([float(knobs.modes)])
    strips = STRIPS if knobs.is_open("strips_per_half_width") else np.array([knobs.strips])
    if done is not None and same_elements:
        parts, modes = np.array([done.part]), np.array([float(done.modes)])
    if done is not None:
        parts = parts[parts <= done.part]
        modes = modes[modes >= done.modes]
        strips = strips[strips >= done.strips]
    steps = [values.ravel() for values in np.meshgrid(parts, modes, strips, indexing="ij")]
    borne = np.array([knobs.bears(*step) for step in zip(*steps[:2], strict=True)])
    if borne.any():  # else both are named
        steps = [values[borne] for values in steps]
    return steps[0], steps[1], steps[2]


def _best(
    errors: dict[str, Floats], seconds: Floats, wanted: float, *, nearly: float, least_s: float
) -> int:
    """The cheapest of all steps that meet what can be met, and come near where it cannot."""
    within = np.ones(seconds.shape, dtype=bool)
    hopeless = []
    for quantity, error in errors.items():
        if error.min() <= wanted:
            within &= error <= wanted
        else:
            hopeless.append(quantity)
    if not within.any():  # each alone can be met, not all at once
        hopeless, within = list(errors), np.ones(seconds.shape, dtype=bool)
    if not hopeless:
        return int(np.where(within, seconds, np.inf).argmin())
    if len(hopeless) < len(errors):
        within &= seconds <= PATIENCE * max(least_s, float(seconds[within].min()))
    # each beside the least that it can come to
    worst = np.max([errors[quantity] / errors[quantity].min() for quantity in hopeless], axis=0)
    near = within & (worst <= nearly * worst[within].min())
    return int(np.where(near, seconds, np.inf).argmin())


def _setting(knobs: Knobs, part: float, modes: int, strips: float, positions: Setting) -> Setting:
    """Knobs that are open."""
    length = None
    if knobs.is_open("flank_element_mm") and knobs.element_mm is not None:
        length = float(f"{part * knobs.element_mm:.3g}")
    return replace(
        positions,
        flank_element_mm=length,
        modes=modes if knobs.is_open("modes") else None,
        strips_per_half_width=strips if knobs.is_open("strips_per_half_width") else None,
    )
