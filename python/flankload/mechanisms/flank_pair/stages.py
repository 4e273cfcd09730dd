"""The stages between the bodies of a scene and its states, common to all runs."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from flankload.analysis.period_error import ALIKE, teeth_until_alike
from flankload.contact.flank_contact import FlankContact
from flankload.elasticity.compliance import BodyCompliance
from flankload.mechanisms.elements import solve_bodies
from flankload.mechanisms.flank_pair.assembly import build_bodies
from flankload.pairing.body_pair import BodyPair
from flankload.pairing.expansion import expanded, expanded_slices, with_expanded_height

if TYPE_CHECKING:
    from flankload.mechanisms.reuse import Parts
    from flankload.mechanisms.stage_clock import Kept, StageClock
    from flankload.scene import Scene
    from flankload.scene.discretization import Grid

Compliances = tuple[BodyCompliance, BodyCompliance]
#: Number of load steps for finite influence coefficients. For coefficients proportional to the
#: force, 10 steps overestimate their increase by 5 %, 3 steps by 14 %.
FINITE_STEPS = 10


def compliances_of(
    scene: Scene, pair: BodyPair, clock: StageClock, kept: Kept, parts: Parts | None = None
) -> tuple[BodyPair, Compliances]:
    """Solve the elements of both bodies; return also the pair with period and expansion."""
    one, two = solve_bodies(scene, pair, clock, kept, parts)
    return expanded_pair(with_compliance_period(scene, pair, (one, two)), (one, two))


def with_compliance_period(scene: Scene, pair: BodyPair, compliances: Compliances) -> BodyPair:
    """Add the positions required by teeth of different compliance."""
    part = ALIKE * scene.accuracy.tolerance
    one, two = (
        teeth_until_alike(compliance, body.teeth, part)
        for compliance, body in zip(compliances, pair.bodies, strict=True)
    )
    if (one, two) == (1, 1):
        return pair
    longer = build_bodies(scene, pair.discretization, bodies=pair.bodies, groups=(one, two))
    return replace(longer, flank_distance_note=pair.flank_distance_note)


def expanded_pair(pair: BodyPair, compliances: Compliances) -> tuple[BodyPair, Compliances]:
    """Apply the expansion of whole bodies to both; later stages are independent of its origin."""
    first, second = (compliance.expansion for compliance in compliances)
    if not any((first.strain, first.axial_strain, second.strain, second.axial_strain)):
        return pair, compliances
    one, two = compliances
    slices = expanded_slices(pair.slices, pair.bodies, (first.axial_strain, second.axial_strain))
    bodies = (
        expanded(pair.body_1, first.strain, first.axial_strain),
        expanded(pair.body_2, second.strain, second.axial_strain),
    )
    slices = with_expanded_height(slices, bodies, (first.strain, second.strain))
    return replace(pair, bodies=bodies, slices=slices), (one.expanded(), two.expanded())


def contact_of(
    scene: Scene, pair: BodyPair, compliances: Compliances, grid: Grid | None = None
) -> FlankContact:
    """The contact of the bodies of a scene, on the cells of their discretization or others."""
    return FlankContact(
        pair,
        compliances,
        grid or pair.discretization.grid,
        scene.effects.contact,
        finite_steps=FINITE_STEPS if pair.effects.finite_influence else 0,
    )
