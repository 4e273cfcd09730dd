"""Cylinders that slide on each other through the whole core against the closed form.

A rigid cylinder that slides on an elastic half-plane has the pressure p = A (x+a)^α (b-x)^(1-α),
α = 1/2 - λ, tan(π λ) = μ (1 - 2ν)/(2 - 2ν): K. L. Johnson, Contact Mechanics, 7.1(b). With the
logarithm's strength c and the jump's strength j that is tan(π λ) = 2 μ j/(π c); a width L follows
from the load as L² = 2 c R F/(α (1 - α)), and the force acts 4 λ L/3 behind the place where an
unloaded cylinder touches. Where both bodies are equally elastic, λ is 0 and the contact is that of
Hertz.
"""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from flankload.bodies.body import Material
from flankload.contact.flank_contact import FlankContact
from flankload.contact.sweep import sweep
from flankload.elasticity.compliance import BodyCompliance, FlankModes, NearField
from flankload.elasticity.near_field import jump_strength, logarithm_strength
from flankload.pairing.friction import Friction
from flankload.pairing.gear_mesh import GearMesh
from flankload.pairing.slices import plane_slice
from flankload.scene.discretization import Grid
from tests.support.pressed_cylinders import arc, one_site

RADII = (20.0, 35.0)
#: The contact lies at (LEVER, ASIDE), its normal along y; both axes at y = 0, DISTANCE apart.
LEVER, ASIDE, DISTANCE = 36.0, 10.0, 90.0
MATERIAL = Material(206000.0, 0.25)
LOAD_N_PER_MM = 800.0
#: Of the offset and of the width, relative: cells of a twentieth of the half-width.
CLOSED_FORM = 1e-2


def sliding_contact(mu: float, *, elastic: tuple[bool, bool], sense: int = 1) -> np.ndarray:
    """Places x of the pairs from (LEVER, ASIDE), forces and torque levers, (3, n)."""
    one = arc((LEVER, ASIDE - RADII[0]), RADII[0], np.pi / 2 + 0.3, np.pi / 2 - 0.3)
    two = arc((LEVER - DISTANCE, ASIDE + RADII[1]), RADII[1], -np.pi / 2 + 0.2, -np.pi / 2 - 0.2)
    yielding = BodyCompliance(
        smooth=np.zeros((1, 1, 1)),
        near=NearField(
            logarithm_strength(MATERIAL, "strain"), jump=jump_strength(MATERIAL, "strain")
        ),
        modes=FlankModes((0.0, 1.0)),
        tangential=np.zeros((1, 1, 1)),
    )
    rigid = BodyCompliance(np.zeros((1, 1, 1)), NearField(0.0), FlankModes((0.0, 1.0)))
    # body 1 turns faster than body 2, so that body 2 slides along +x, towards the tip of body 1
    (state,) = sweep(
        FlankContact(
            GearMesh(
                (
                    SimpleNamespace(curve=one, rigid=not elastic[0], teeth=1, active_range_mm=None),
                    SimpleNamespace(curve=two, rigid=not elastic[1], teeth=1, active_range_mm=None),
                ),
                one_site(DISTANCE),
                plane_slice(1.0),
                Friction(np.zeros(1), np.full((1, 1), mu), sense),
            ),
            (yielding if elastic[0] else rigid, yielding if elastic[1] else rigid),
            Grid(strips_per_half_width=20),
        ),
        np.zeros(1),
        [LOAD_N_PER_MM * (LEVER + sense * mu * ASIDE)],
    )
    column = state.pairs.column
    return np.stack([column("x") - LEVER, column("force"), column("lever")])


def closed_form(mu: float) -> tuple[float, float]:
    """Offset of the force and width of the contact on one half-plane."""
    strength, jump = logarithm_strength(MATERIAL, "strain"), jump_strength(MATERIAL, "strain")
    exponent = np.arctan(2 * mu * jump / (np.pi * strength)) / np.pi
    radius = 1 / sum(1 / r for r in RADII)
    width = np.sqrt(2 * strength * radius * LOAD_N_PER_MM / (0.25 - exponent**2))
    return 4 * exponent * width / 3, width


@pytest.mark.parametrize("sense", [1, -1])
@pytest.mark.parametrize("mu", [0.2, 1.0])
@pytest.mark.parametrize(("elastic", "side"), [((True, False), -1), ((False, True), 1)])
def test_rigid_cylinder_slides_on_a_half_plane(
    mu: float, elastic: tuple[bool, bool], side: int, sense: int
) -> None:
    """Friction drags body 1 along +x (sense 1): its surface sinks in front of the load.

    So it carries more behind; body 2 is dragged the other way and does the same.
    """
    x, force, lever = sliding_contact(mu, elastic=elastic, sense=sense)
    offset, width = closed_form(mu)
    # the lever P.n differs over the contact by a tenth, since flanks have normals of their own
    assert force @ lever == pytest.approx(LOAD_N_PER_MM * (LEVER + sense * mu * ASIDE), rel=1e-12)
    assert force.sum() == pytest.approx(LOAD_N_PER_MM, rel=5e-3)
    carries = x[force > 0]
    found = carries.max() - carries.min() + np.diff(x).mean()
    assert found == pytest.approx(width, abs=1.5 * np.diff(x).mean())
    # the effect of pairing on circles and of the flanks' own normals without friction
    x_0, force_0, _ = sliding_contact(0.0, elastic=elastic, sense=sense)
    moved = x @ force / force.sum() - x_0 @ force_0 / force_0.sum()
    assert moved == pytest.approx(side * sense * offset, abs=CLOSED_FORM * width)
    assert abs(moved) > 0.5 * offset


def test_equal_cylinders_do_not_feel_the_tangential_load() -> None:
    x, force, _ = sliding_contact(0.5, elastic=(True, True))
    x_0, force_0, _ = sliding_contact(0.0, elastic=(True, True))
    moved = x @ force / force.sum() - x_0 @ force_0 / force_0.sum()
    assert abs(moved) < 0.02 * closed_form(0.5)[0]
