"""The stages between the bodies of a scene and its states, common to all runs."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING

from flankload.analysis.period_error import ALIKE, teeth_until_alike
from flankload.contact.flank_contact import FlankContact
from flankload.cost import Account, held_bytes
from flankload.elasticity.compliance import (
    BodyCompliance,
    Expansion,
    JobOptions,
    flank_compliance,
    no_compliance,
)
from flankload.elasticity.compliance.modified_flank import on_modified_flank
from flankload.elasticity.imported_compliance import imported_compliance
from flankload.elasticity.nodal_loads import nodes_of
from flankload.elasticity.prism import Prism, prism_compliance
from flankload.mechanisms.flank_pair.assembly import build_bodies
from flankload.mechanisms.reuse import Parts
from flankload.pairing.body_pair import BodyPair
from flankload.pairing.expansion import expanded, expanded_slices
from flankload.scene.axial import degrees_of
from flankload.scene.discretization import Discretization, choose_discretization
from flankload.scene.effects import effects_of

if TYPE_CHECKING:
    from flankload.bodies import Body
    from flankload.bodies.root_fillet import RootFillets
    from flankload.mechanisms.stage_clock import Kept, StageClock
    from flankload.pairing.expansion import BodyLoad
    from flankload.scene import Scene
    from flankload.scene.discretization import Grid
    from flankload.scene.effects import Effects

Compliances = tuple[BodyCompliance, BodyCompliance]
#: Number of load steps for finite influence coefficients. For coefficients proportional to the
#: force, 10 steps overestimate their increase by 5 %, 3 steps by 14 %.
FINITE_STEPS = 10
#: Effects that need loads along the flanks.
FRICTION, FINITE = "effects.friction_coefficient", "effects.influence = 'finite'"


def elements_call(
    body: Body,
    scene: Scene,
    discretization: Discretization,
    *,
    fillets: RootFillets | None = None,
    body_load: BodyLoad | None = None,
    estimate: bool = False,
    tangential: bool = False,
) -> partial[BodyCompliance]:
    """The call that computes the compliance of an elastic body; its arguments determine it.

    Parameters as in `compliance_of`; `tangential`: loads along the flank are solved in any case.
    """
    effects, own = effects_of(scene), body.for_elements()
    if effects.three_dimensions:
        return partial(
            prism_compliance,
            own,
            prism_of(own, scene),
            n_modes=modes_of(own, scene, discretization),
            friction=has_tangential_loads(body, effects) or tangential,
            fillets=fillets,
            estimate=estimate,
        )
    # tangential displacement under normal loads equals the transposed reaction to tangential loads
    if own.imported is not None:
        return partial(
            imported_compliance,
            own,
            modes=scene.accuracy.modes,
            default_modes=discretization.modes,
            plane=scene.accuracy.plane,
            tangential=asks_tangential(effects),
            nodal=effects.nodal_near_field,
        )
    return partial(
        flank_compliance,
        own,
        JobOptions(
            n_modes=modes_of(own, scene, discretization),
            plane=scene.accuracy.plane,
            friction=has_tangential_loads(body, effects) or tangential,
            along=effects.friction and effects.finite_influence,
            nodal=effects.nodal_near_field,
            coast_flanks=scene.effects.coast_flank,
            fillets=fillets,
            estimate=estimate,
        ),
        sectors=scene.sectors,
        body_load=body_load if body_load is not None and body_load.needs_elements else None,
    )


def has_tangential_loads(body: Body, effects: Effects) -> bool:
    """Whether the elements of a body are solved for tangential loads.

    Friction and finite influence coefficients need them, and modified flanks, whose forces have
    another direction than the flank of the elements.
    """
    return body.elements is not None or asks_tangential(effects) is not None


def asks_tangential(effects: Effects) -> str | None:
    """The effect that requires the response to tangential loads, in words."""
    if effects.friction:
        return FRICTION
    return FINITE if effects.finite_influence else None


def compliance_of(
    body: Body,
    scene: Scene,
    discretization: Discretization | None = None,
    *,
    fillets: RootFillets | None = None,
    body_load: BodyLoad | None = None,
    estimate: bool = False,
) -> BodyCompliance:
    """Compliance of one elastic body: from its finite elements, or imported.

    Parameters
    ----------
    scene : Scene
        Sets plane state and pressure modes.
    discretization : Discretization, optional
        By default that of the scene.
    fillets : RootFillets, optional
        If stress is requested.
    growth : Growth, optional
        Expansion of the body.
    estimate : bool
        Whether the discretization error of the elements is estimated.
    """
    discretization = discretization or choose_discretization(scene)
    call = elements_call(
        body, scene, discretization, fillets=fillets, body_load=body_load, estimate=estimate
    )
    return _in_scene(call(), body, scene, body_load)


def _in_scene(
    found: BodyCompliance, body: Body, scene: Scene, body_load: BodyLoad | None
) -> BodyCompliance:
    """Apply uniform expansion, modified flanks and coupling, which need no elements."""
    if body_load is not None and (body.imported is not None or not body_load.needs_elements):
        found = replace(found, expansion=Expansion(body_load.strain))
    if body.elements is not None:
        found = on_modified_flank(found, body)
    found = replace(found, along_near=None)  # for the modified flanks of other scenes only
    if asks_tangential(effects_of(scene)) is None:
        found = found.without_friction()
    return found if scene.effects.tooth_coupling else found.without_coupling()


def compliances_of(
    scene: Scene, pair: BodyPair, clock: StageClock, kept: Kept, parts: Parts | None = None
) -> Compliances:
    """Solve one finite-element job for each elastic body without imported compliance.

    Those that are missing in `kept` are added to it. A compliance that is found in `parts`, those
    of earlier runs, has no stage and no cost.
    """
    found, elastic, wide = [], pair.elastic, parts or Parts()
    for z, body in enumerate(pair.bodies):
        body_load = pair.body_loads[z]
        if not elastic[z] and (body_load is None or not body_load.needs_elements):
            found.append(no_compliance(body, body_load))
            continue
        stage = f"compliance body {z + 1}"
        if z in kept:
            compliance, account = kept[z]
            clock.stages[stage] = replace(account)
            found.append(compliance)
            continue
        call = elements_call(
            body,
            scene,
            pair.discretization,
            fillets=pair.fillets[z],
            body_load=body_load,
            estimate=(scene.accuracy.estimate or wide.estimate) and elastic[z],
            tangential=wide.tangential,
        )
        key, held = (None, None) if parts is None else parts.find(call)
        if held is not None:
            found.append(_in_scene(held, body, scene, body_load))
            continue
        with clock.stage(stage) as account:
            watched = {"account": Account(on_part=clock.part_progress(stage))}
            solved = call(**(watched if pair.effects.three_dimensions else {}))
            compliance = _in_scene(solved, body, scene, body_load)
            account.count(**compliance.job.counters)
            # the estimate includes the discretization error of the elements
            account.bytes += held_bytes(replace(compliance, fe_error=None))
            account.workspace_bytes += compliance.job.workspace_bytes
            found.append(compliance)
        if parts is not None and key is not None:
            # later runs have no cost
            job = replace(solved.job, seconds={}, counters={}, workspace_bytes=0)
            parts.add(key, replace(solved, job=job))
        kept[z] = (compliance, replace(account))
    return found[0], found[1]


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
    if not any(compliance.expansion.strain for compliance in compliances):
        return pair, compliances
    one, two = compliances
    strains, slices = (one.expansion.strain, two.expansion.strain), pair.slices
    shapes = pair.body_1.axial, pair.body_2.axial
    if slices is not None and shapes[0] is not None and shapes[1] is not None:
        slices = expanded_slices(slices, (shapes[0], shapes[1]), strains)
    pair = replace(
        pair,
        body_1=expanded(pair.body_1, strains[0]),
        body_2=expanded(pair.body_2, strains[1]),
        slices=slices,
    )
    return pair, (one.expanded(), two.expanded())


def contact_of(
    scene: Scene, pair: BodyPair, compliances: Compliances, grid: Grid | None = None
) -> FlankContact:
    """The contact of the bodies of a scene, on the cells of their discretization or others."""
    return FlankContact(
        pair.bodies,
        compliances,
        pair.pairing,
        face_width_mm=scene.pair.face_width_mm,
        grid=grid or pair.discretization.grid,
        level=scene.effects.contact,
        friction=pair.friction,
        finite_steps=FINITE_STEPS if pair.effects.finite_influence else 0,
        slices=pair.slices,
    )


def prism_of(body: Body, scene: Scene) -> Prism:
    """Axial extension of a three-dimensional body, with the polynomial degrees of a scene."""
    axial = body.axial
    assert axial is not None
    degree, load_degree = degrees_of(scene.accuracy)
    return Prism(
        axial.range_mm,
        axial.twist_rad_per_mm,
        degree=degree,
        load_degree=load_degree,
        regions=axial.regions,
        shaft=axial.flexible,
    )


def modes_of(body: Body, scene: Scene, discretization: Discretization) -> int:
    """Number of pressure modes of a flank with elements, or of its nodes that carry unit forces.

    That of the discretization is used if the scene names no number; the degree is at most half the
    number of flank elements, since more modes make a coarse mesh worse.
    """
    if scene.effects.near_field == "nodes" and body.mesh is not None:
        return nodes_of(body.mesh).size
    asked, wanted = scene.accuracy.modes, discretization.modes
    if body.modes_factor > 1.0:
        asked, wanted = None, round(body.modes_factor * (asked or wanted))
    if asked is not None or body.mesh is None:
        return asked or 0
    count = max(2, min(wanted, body.mesh.flank_elements // 2 + 1))
    return count - 1 + count % 2 if body.curve.closed else count
