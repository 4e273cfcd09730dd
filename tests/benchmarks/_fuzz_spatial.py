"""Valid scenes in three dimensions drawn at random, and exact identities of their results."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from math import log

import numpy as np

import flankload as fl
from flankload.errors import FlankloadError
from tests.benchmarks._fuzz_scenes import faults_of
from tests.support.finer_solutions import TooLongError, at_most
from tests.support.gear_scenes import resized
from tests.support.random_scenes import Scene
from tests.support.random_spatial_scenes import mirrored, spatial_scene
from tests.support.tally import Tally

#: Coarse scenes take a second.
MOST_CPU_S = 60.0
#: Rotations and line loads of images of a scene, of the largest: forces are iterated to 1e-6 and
#: then follow by Newton's method; contacts on the verge of loading turn rounding into more.
ROTATION, LINE_LOAD = 1e-9, 1e-7
#: Gaps of contacts that carry, and penetration, of the transmission error.
GAP = 1e-9
#: Factors of the size of a scene.
SMALLEST, LARGEST = 0.05, 20.0

Answer = tuple[fl.Result, ...] | FlankloadError


def fuzz_spatial(seed: int, count: int) -> Tally:
    """Solve so many scenes, their mirror images, and the scenes at another size.

    Parameters
    ----------
    seed : int
    count : int

    Returns
    -------
    Tally
        wrong: a result that is not finite, pulls, penetrates or does not balance its torque, or an
        image with another result; too long.
    """
    tally = Tally("scenes in three dimensions")
    for k in range(count):
        place = f"seed [{seed}, {k}]"
        try:
            with warnings.catch_warnings(), at_most(MOST_CPU_S):
                warnings.simplefilter("error")
                for fault in _faults(np.random.default_rng([seed, k])):
                    tally.fault("wrong", f"{place}: {fault}")
        except TooLongError:
            tally.fault("wrong", f"{place}: more than {MOST_CPU_S:g} s")
        except Exception as error:
            tally.fault("traceback", f"{place}: {type(error).__name__}: {str(error)[:120]}")
        tally.tried += 1
    return tally


def _faults(rng: np.random.Generator) -> Iterator[str]:
    scene = spatial_scene(rng)
    size = float(np.exp(rng.uniform(log(SMALLEST), log(LARGEST))))
    answer, mirror, scaled = (_answer(s) for s in (scene, mirrored(scene), resized(scene, size)))
    if not isinstance(answer, FlankloadError):
        for result in answer:
            yield from faults_of(result)
            yield from contact_faults(result)
    for name, other, factor in (("mirror image", mirror, None), (f"size {size:g}", scaled, size)):
        for fault in image_faults(answer, other, factor):
            yield f"{name}: {fault}"


def _answer(scene: Scene) -> Answer:
    try:
        return fl.solve(fl.Scene.from_dict(scene)).by_torque
    except FlankloadError as error:
        return error


def contact_faults(result: fl.Result) -> list[str]:
    """Contacts that carry have no gap, others do not penetrate; slices sum up to flanks."""
    faults = []
    scale = GAP * max(1e-300, float(np.abs(result.transmission_error_um).max()))
    for p, table in enumerate(result.pair_tables):
        if (table.gap_um < -scale).any():
            faults.append(f"position {p}: a penetration of {-table.gap_um.min():.2g} um")
        gaps = np.abs(table.gap_um[table.force_N > 0])
        if (gaps > scale).any():
            faults.append(f"position {p}: a force over a gap of {gaps.max():.2g} um")
    assert result.slices is not None
    apart = np.abs(result.slices.force_N.sum(axis=2) - result.site_force_N)
    if apart.max(initial=0.0) > GAP * result.site_force_N.max(initial=0.0):
        faults.append("forces of slices do not add up")
    return faults


def image_faults(answer: Answer, other: Answer, size: float | None) -> list[str]:
    """Differences between a scene and its mirror image (size None) or itself at another size."""
    if isinstance(answer, FlankloadError) or isinstance(other, FlankloadError):
        same = type(answer) is type(other)
        return [] if same else [f"{_named(other)} in place of {_named(answer)}"]
    faults = []
    for one, two in zip(answer, other, strict=True):
        assert one.slices is not None
        assert two.slices is not None
        load = two.slices.line_load_N_per_mm
        load = load[..., ::-1] if size is None else load / size
        if not _alike(two.rotation_rad, one.rotation_rad, ROTATION):
            faults.append(f"another rotation under {one.torque_Nm:g} N m")
        if not _alike(load, one.slices.line_load_N_per_mm, LINE_LOAD):
            faults.append(f"other line loads under {one.torque_Nm:g} N m")
        if (one.status != two.status).any() and not (one.status.any() and two.status.any()):
            faults.append(f"status {two.status.tolist()} in place of {one.status.tolist()}")
    return faults


def _named(answer: Answer) -> str:
    return f"{answer!r:.120}" if isinstance(answer, FlankloadError) else "a result"


def _alike(one: np.ndarray, two: np.ndarray, tolerance: float) -> bool:
    return bool(np.abs(one - two).max(initial=0.0) <= tolerance * np.abs(two).max(initial=0.0))
