"""Discretization parameters of a scene, their steps, and the finest affordable discretization."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from math import inf
from typing import TYPE_CHECKING, Any

from flankload.mechanisms.registry import mechanism_of
from flankload.pairing.slices import SLICES as DEFAULT_SLICES
from flankload.scene import axial
from flankload.scene.axial import AXIAL_DEGREE
from flankload.scene.discretization import DEFAULT, IN_SLICES
from flankload.scene.effects import effects_of, is_spatial
from flankload.scene.named_discretization import NamedDiscretization, scene_at
from flankload.scene.steps import (
    COUNT,
    DEGREE,
    ELEMENTS,
    LOAD_DEGREE,
    MODES,
    SLICES,
    STEPS,
    STRIPS,
    STRIPS_IN_SLICES,
    ZONE,
)
from flankload.studies.plan.coarse_runs import CoarseRuns

if TYPE_CHECKING:
    from flankload.scene import Scene

#: Largest number of steps of a belt, whose whole tooth has this length: a finer one would take
#: gigabytes.
BELT_STEPS = 4
#: Adaptive positions in addition to even ones: tolerances, and initial numbers.
ADAPTIVE = (0.03, 0.01, 0.003, 0.001)
ADAPTIVE_START = 8
#: The same for the reference, which begins with the largest number of even positions.
KINKS = 3e-4
#: The finest discretization: more modes reduce the convergence of the elements, most of all on
#: splines, and wider zones are unloaded.
FINEST_MODES, FINEST_ZONE = 8, 3.0
#: Steps of the elements in three dimensions, relative to the default; coarse bodies.
SPATIAL_STEPS = 3
COARSE: dict[str, Any] = {name: STEPS[name].coarse for name in (MODES, DEGREE, LOAD_DEGREE, SLICES)}
#: Limits of a discretization by parameter: elements and positions relative to the default, all else
#: as it is.
Fineness = Mapping[str, float]


@dataclass(frozen=True)
class Finest:
    """Possible limits of the finest discretization, finest first.

    Among the steps of parameters are as many `solutions` with its elements.
    """

    limits: tuple[Fineness, ...]
    solutions: float


FINEST = Finest(
    tuple(
        {"flank_element_mm": part, "strips_per_half_width": strips, "count": positions}
        for part, strips, positions in ((0.125, 40, 4), (0.25, 40, 4), (0.25, 20, 2), (0.5, 20, 2))
    ),
    1.5,
)
SPATIAL_KEYS = (
    *("flank_element_mm", "axial_degree", "load_degree_z"),
    *("strips_per_half_width", "count"),
)
SPATIAL_FINEST = Finest(
    tuple(
        dict(zip(SPATIAL_KEYS, limits, strict=True))
        for limits in ((0.5, 12, 8, 24, 4), (0.5, 10, 6, 24, 4), (1.0, 10, 6, 12, 2))
    ),
    3.5,
)
#: Part of the budget for the steps of parameters; number of runs at the finest cells and positions
#: among them.
LADDERS_PART, LADDER_SWEEPS = 0.6, 20.0


@dataclass(frozen=True)
class Refinements:
    """Steps of each parameter of a scene by the names of `NamedDiscretization`, coarse steps first.

    `base` has the default parameters, named explicitly; `possible`: limits of the finest ones;
    `can_adapt`: whether adaptive positions are possible.
    """

    ladders: dict[str, tuple[float, ...]]
    base: NamedDiscretization
    finest: NamedDiscretization
    possible: Finest = FINEST
    can_adapt: bool = True

    @property
    def spatial(self) -> bool:
        """Whether the bodies are three-dimensional."""
        return "slices" in self.ladders


def refinements_of(scene: Scene) -> Refinements:
    """All parameters of a scene with all steps.

    The finest discretization is the first of `FINEST`, or of `SPATIAL_FINEST`.
    """
    steps, most, base, possible = (_of_drive if scene.is_drive else _of_flanks)(scene)
    length = base.flank_element_mm
    lengths, further = steps.pop("flank_element_mm"), steps
    ladders: dict[str, tuple[float, ...]] = {}
    if length is not None:
        ladders["flank_element_mm"] = tuple(_rounded(length * part) for part in lengths)
        base = replace(base, flank_element_mm=_rounded(length))
    if modes := tuple(int(mode) for mode in STEPS[MODES].study if mode <= most):
        ladders["modes"] = modes
        base = replace(base, modes=max(mode for mode in modes if mode <= DEFAULT.modes))
    ladders |= further
    if base.count is not None:
        counts = {round(base.count * part) for part in STEPS[COUNT].study if base.count * part >= 1}
        ladders["count"] = tuple(sorted(counts))
    found = Refinements(ladders, base, base, possible, can_adapt=not scene.is_drive)
    return finest_within(found, possible.limits[0])


#: Steps by parameter, element lengths relative to the default; the largest number of modes; the
#: default, with the exact length of elements; limits of the finest ones.
_Of = tuple[dict[str, tuple[float, ...]], int, NamedDiscretization, Finest]


def _of_flanks(scene: Scene) -> _Of:
    """Cells of plane bodies; degrees along the axis, slices and perhaps cells of others."""
    mechanism = mechanism_of(scene)
    parameters = mechanism.parameters(scene)
    named: dict[str, Any] = {"flank_element_mm": parameters.element_mm}
    if scene.positions.angles_deg is None:
        several = mechanism.build(scene).position_rad.size > 1
        named |= {"count": scene.positions.count} if several else {}
    rigid = scene.body_1.rigid and scene.body_2.rigid
    most = 0 if rigid else parameters.most_modes
    steps: dict[str, tuple[float, ...]]
    if not is_spatial(scene).on:
        steps = {name: STEPS[name].study for name in (STRIPS, ZONE)}
        cells = {key: getattr(DEFAULT.grid, key) for key in steps}
        base = NamedDiscretization(**named, **cells)
        return {ELEMENTS: STEPS[ELEMENTS].study, **steps}, most, base, FINEST
    steps = {name: STEPS[name].study for name in (DEGREE, LOAD_DEGREE, SLICES)}
    named |= zip(steps, (AXIAL_DEGREE, axial.LOAD_DEGREE, DEFAULT_SLICES), strict=True)
    if not effects_of(scene).lumped_contact:
        steps[STRIPS] = STRIPS_IN_SLICES
        named["strips_per_half_width"] = IN_SLICES.strips_per_half_width
    steps[ELEMENTS] = STEPS[ELEMENTS].study[:SPATIAL_STEPS]
    return steps, most, NamedDiscretization("slices", **named), SPATIAL_FINEST


def _of_drive(scene: Scene) -> _Of:
    """Positions of chains and belts, and the elements of belts."""
    base = NamedDiscretization(
        flank_element_mm=mechanism_of(scene).parameters(scene).element_mm,
        count=scene.positions.count if scene.positions.angles_deg is None else None,
    )
    return {ELEMENTS: STEPS[ELEMENTS].study[:BELT_STEPS]}, 0, base, FINEST


def finest_within(refinements: Refinements, fineness: Fineness) -> Refinements:
    """The parameters with a given finest discretization, without finer steps than that."""
    kept, base = dict(refinements.ladders), refinements.base
    finest: dict[str, Any] = {}
    for name, steps in refinements.ladders.items():
        limit = fineness.get(name, inf)
        if name == "flank_element_mm":
            least = 0.99 * limit * (base.flank_element_mm or 0.0)
            kept[name] = tuple(length for length in steps if length >= least)
        else:
            most = limit * (base.count or 1) if name == "count" else limit
            kept[name] = tuple(number for number in steps if number <= most)
        finest[name] = kept[name][-1]
    if "modes" in kept:
        finest["modes"] = max(mode for mode in kept["modes"] if mode <= FINEST_MODES)
    if "zone_half_widths" in kept:
        finest["zone_half_widths"] = FINEST_ZONE
    return replace(refinements, ladders=kept, finest=replace(base, **finest))


def affordable(
    scene: Scene, refinements: Refinements, spent: Mapping[str, float], budget_s: float
) -> Refinements:
    """The finest parameters whose steps a budget pays.

    Their seconds are those spent in the stages of the base run, times the ratio of the counters.
    """
    runs = CoarseRuns(scene)
    base, found = runs.price(scene_at(scene, refinements.base)), refinements
    for fineness in refinements.possible.limits:
        found = finest_within(refinements, fineness)
        finest = runs.price(scene_at(scene, found.finest))
        seconds = {
            name: spent[name] * account.cpu_s / base[name].cpu_s
            for name, account in finest.items()
            if name in spent and base[name].cpu_s > 0.0
        }
        elements = sum(s for name, s in seconds.items() if name.startswith("compliance"))
        solutions = elements * refinements.possible.solutions
        states = seconds.get("sweep", 0.0)
        if solutions + LADDER_SWEEPS * states <= LADDERS_PART * budget_s:
            break
    return found


def _rounded(length: float) -> float:
    return float(f"{length:.3g}")


def can_lump(scene: Scene) -> bool:
    """Whether lumped contact is another model: not for conforming flanks and chains."""
    lumped = is_spatial(scene).on and effects_of(scene).lumped_contact
    return not (scene.body_1.conforms or scene.is_drive or lumped)


def can_be_nodal(scene: Scene) -> bool:
    """Whether nodal forces are possible: for two open flanks with finite elements."""
    effects, bodies = scene.effects, (scene.body_1, scene.body_2)
    return (
        not scene.is_drive
        and not is_spatial(scene).on
        and scene.body_2.has_teeth
        and not any(body.from_file for body in bodies)
        and not (effects.coast_flank or effects.temperature_rise_K or effects.speed_rpm)
    )
