"""Flanks that are left out by bounds of their gaps."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import TYPE_CHECKING

import numpy as np
import pytest

import flankload as fl
from flankload.contact.body_record import records_of
from flankload.contact.meshes import Motion, solve_meshes
from tests.support.pair_job import Job
from tests.support.paths import SCENES
from tests.support.tolerances import ROUND_OFF

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from flankload.pairing.pairing import Pairing

POSITIONS = 12
#: Displacements along x and y, mm, and rotation, rad, of body 2: the last ones close more than the
#: distance within which flanks are searched.
MOVED = ((0.0, 0.0, 0.0), (0.1, -0.05, 0.001), (-0.4, 0.6, 0.0), (0.0, -0.3, -0.05))
#: Largest deviation of a flank, mm: a flank far from its mate is then the first one to touch.
DEVIATION_MM = 0.5


@pytest.mark.parametrize("moved", MOVED)
@pytest.mark.parametrize("scene", ["external_gear", "internal_gear"])
def test_the_first_flank_to_touch_is_found(scene: str, moved: tuple[float, float, float]) -> None:
    """Without torque, body 1 turns as far as the least of its flanks one by one allows."""
    job = job_of(scene)
    pairing = job.bodies.pairing
    draws = np.random.default_rng(5).uniform(-DEVIATION_MM, DEVIATION_MM, pairing.sites.size)
    pairing = replace(pairing, site_deviations_mm=(draws, np.zeros(draws.size)))
    whole = first_touch(job, pairing, moved)
    alone = [first_touch(job, only(pairing, k), moved) for k in range(draws.size)]
    least = np.nanmin(alone, axis=0)
    assert np.unique(np.nanargmin(alone, axis=0)).size > 1
    np.testing.assert_allclose(whole, least, rtol=0, atol=ROUND_OFF)


@cache
def job_of(scene: str) -> Job:
    """An example."""
    return Job(fl.read_scene(SCENES / f"{scene}.toml"))


def only(pairing: Pairing, k: int) -> Pairing:
    """The pairing with one of its sites."""
    names = ("site_teeth", "site_angles_rad", "site_deviations_mm")
    of_bodies = {name: tuple(v[k : k + 1] for v in getattr(pairing, name)) for name in names}
    return replace(pairing, sites=pairing.sites[k : k + 1], **of_bodies)


def first_touch(
    job: Job, pairing: Pairing, moved: tuple[float, float, float]
) -> NDArray[np.float64]:
    """Rotation of body 1 at first contact, NaN without any."""
    contact = job.contact(job.bodies.discretization.grid, "lumped")
    mesh, *bodies = records_of(replace(contact, mesh=replace(job.bodies, pairing=pairing)))
    angles = np.stack(pairing.turns(job.positions(POSITIONS)), axis=-1)[:, None]
    displacements = np.zeros((POSITIONS, 2, 3))
    displacements[:, 1] = moved
    states = solve_meshes(bodies, [mesh], [Motion(0)], angles, [[0.0]], displacements)
    return states.motion[:, 0, 0]
