"""Compliances of the bodies of a scene, one at a time, for every kind of drive."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Protocol

from flankload.bodies.free_corner import has_sharp_tip
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
from flankload.mechanisms.reuse import Parts
from flankload.mechanisms.stage_clock import elements_stage
from flankload.pairing.body_pair import BodyJob
from flankload.scene.axial import degrees_of
from flankload.scene.discretization import Discretization, choose_discretization
from flankload.scene.effects import effects_of
from flankload.scene.steps import REDUCED_DEGREES, REDUCED_MODES

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from flankload.bodies import Body
    from flankload.elasticity.prism import Prism
    from flankload.mechanisms.stage_clock import Kept, StageClock
    from flankload.pairing.slices import Slices
    from flankload.scene import Scene
    from flankload.scene.effects import Effects


class ElasticBodies(Protocol):
    """Bodies with their elements before these are solved."""

    @property
    def names(self) -> tuple[str, ...]:
        """Tables of the bodies in the scene."""

    @property
    def bodies(self) -> tuple[Body, ...]:
        """Bodies in this order."""

    @property
    def jobs(self) -> tuple[BodyJob, ...]:
        """Purposes of their elements."""

    @property
    def discretization(self) -> Discretization:
        """Size of the elements, and number of pressure modes."""

    @property
    def effects(self) -> Effects:
        """Effects of the run."""


#: Effects that need loads along the flanks.
FRICTION, FINITE = "effects.friction_coefficient", "effects.influence = 'finite'"


def elements_call(
    body: Body,
    scene: Scene,
    discretization: Discretization,
    job: BodyJob,
    *,
    estimate: bool = False,
    tangential: bool = False,
) -> partial[BodyCompliance]:
    """The call that computes the compliance of an elastic body; its arguments determine it.

    Parameters as in `compliance_of`; `tangential`: loads along the flank are solved in any case.
    """
    body_load = job.body_load
    effects, own = effects_of(scene), body.for_elements()
    # tangential displacement under normal loads equals the transposed reaction to tangential loads
    if own.imported is not None:
        return partial(
            imported_compliance,
            own,
            modes=scene.accuracy.modes,
            default_modes=discretization.modes,
            plane=scene.accuracy.plane,
            tangential=asks_tangential(effects),
            turns=job.turns,
            nodal=effects.nodal_near_field,
        )
    return partial(
        flank_compliance,
        own,
        JobOptions(
            n_modes=modes_of(own, scene, discretization),
            plane=scene.accuracy.plane,
            friction=has_tangential_loads(body, job, effects) or tangential,
            along=effects.friction and effects.finite_influence,
            nodal=effects.nodal_near_field,
            coast_flanks=job.coast_flanks or scene.effects.coast_flank,
            fillets=job.fillets,
            estimate=estimate,
            rim=job.rim,
            prism=prism_of(own, scene),
        ),
        sectors=scene.sectors,
        body_load=body_load if body_load is not None and body_load.needs_elements else None,
    )


def has_tangential_loads(body: Body, job: BodyJob, effects: Effects) -> bool:
    """Whether the elements of a body are solved for tangential loads.

    Beside the cases in which the compliance holds them, modified flanks need them, whose forces
    have another direction than the flank of the elements.
    """
    return body.elements is not None or holds_tangential(job, effects)


def holds_tangential(job: BodyJob, effects: Effects) -> bool:
    """Whether the compliance of a body holds the response to tangential loads.

    Friction and finite influence coefficients need it, and forces that turn over sharp tips.
    """
    turns = job.turns and job.elastic and not effects.nodal_near_field
    return turns or asks_tangential(effects) is not None


def counted_loads(counters: Mapping[str, int], *, asked: bool) -> dict[str, int]:
    """Counters with the tangential loads of turned forces under their own name.

    `asked`: these loads have another purpose.
    """
    found = dict(counters)
    if not asked and found.get("unit_loads_tangential"):
        found["corner_readings"] = found.pop("unit_loads_tangential")
    return found


def asks_tangential(effects: Effects) -> str | None:
    """The effect that requires the response to tangential loads, in words."""
    if effects.friction:
        return FRICTION
    return FINITE if effects.finite_influence else None


def compliance_of(
    body: Body,
    scene: Scene,
    discretization: Discretization | None = None,
    job: BodyJob | None = None,
    *,
    estimate: bool = False,
) -> BodyCompliance:
    """Compliance of one elastic body: from its finite elements, or imported.

    Parameters
    ----------
    scene : Scene
        Sets plane state and pressure modes.
    discretization : Discretization, optional
        By default that of the scene.
    job : BodyJob, optional
        By default for contact forces alone.
    estimate : bool
        Whether the discretization error of the elements is estimated.
    """
    discretization = discretization or choose_discretization(scene)
    job = job or BodyJob(True, turns=has_sharp_tip(body))
    call = elements_call(body, scene, discretization, job, estimate=estimate)
    return _in_scene(call(), body, scene, job)


def _in_scene(found: BodyCompliance, body: Body, scene: Scene, job: BodyJob) -> BodyCompliance:
    """Apply uniform expansion, modified flanks and coupling, which need no elements."""
    body_load, effects = job.body_load, effects_of(scene)
    if body_load is not None and (body.imported is not None or not body_load.needs_elements):
        found = replace(found, expansion=Expansion(body_load.strain))
    if body.elements is not None:
        found = on_modified_flank(found, body)
    found = replace(found, along_near=None)  # for the modified flanks of other scenes only
    if asks_tangential(effects) is None:
        found = found.without_friction(turns=holds_tangential(job, effects))
    turns = job.turns and found.tangential is not None and found.modes.nodes is None
    found = replace(found, turns=turns)
    return found if scene.effects.tooth_coupling else found.without_coupling()


def solve_body(
    scene: Scene,
    name: str,
    body: Body,
    job: BodyJob,
    discretization: Discretization,
    clock: StageClock,
    kept: Kept,
    parts: Parts | None = None,
) -> BodyCompliance:
    """Compliance of a body: from one finite-element job, imported, or none of a rigid body.

    A compliance that is missing in `kept` is added to it. One that is found in `parts`, those of
    earlier runs, has no stage and no cost.
    """
    stage, wide = elements_stage(name), Parts() if parts is None else parts
    if job.mirrored:
        body = body.in_mirror_image()
    if not job.needs_elements:
        return no_compliance(body, job.body_load)
    if name in kept:
        compliance, account = kept[name]
        clock.stages[stage] = replace(account)
        return compliance
    call = elements_call(
        body,
        scene,
        discretization,
        job,
        estimate=(scene.accuracy.estimate or wide.estimate) and job.elastic,
        tangential=wide.tangential,
    )
    key, held = (None, None) if parts is None else parts.find(call)
    if held is not None:
        return _in_scene(held, body, scene, job)
    with clock.stage(stage) as account:
        watched = {"account": Account(on_part=clock.part_progress(stage))}
        solved = call(**(watched if body.imported is None else {}))
        compliance = _in_scene(solved, body, scene, job)
        asked = wide.tangential or body.elements is not None or asks_tangential(effects_of(scene))
        account.count(**counted_loads(compliance.job.counters, asked=bool(asked)))
        # the estimate includes the discretization error of the elements
        account.bytes += held_bytes(replace(compliance, fe_error=None))
        account.workspace_bytes += compliance.job.workspace_bytes
    if parts is not None and key is not None:
        # later runs have no cost
        counts = replace(solved.job, seconds={}, counters={}, workspace_bytes=0)
        parts.add(key, replace(solved, job=counts))
    kept[name] = (compliance, replace(account))
    return compliance


def solve_bodies(
    scene: Scene,
    assembly: ElasticBodies,
    clock: StageClock,
    kept: Kept,
    parts: Parts | None = None,
) -> tuple[BodyCompliance, ...]:
    """Compliances of all bodies, each from one finite-element job."""
    return tuple(
        solve_body(scene, name, body, job, assembly.discretization, clock, kept, parts)
        for name, body, job in zip(assembly.names, assembly.bodies, assembly.jobs, strict=True)
    )


def variants_of(
    compliances: tuple[BodyCompliance, ...],
    slices: Slices,
    compared: Mapping[str, object],
) -> dict[str, Mapping[str, object]]:
    """Arguments of the repeated sweeps of an estimate, by the source of errors that they show.

    `compared`: arguments of a sweep with other slices, where bodies have a width.
    """
    found: dict[str, Mapping[str, object]] = {
        "modes": {"compliances": tuple(each.fewer_modes(REDUCED_MODES) for each in compliances)}
    }
    if any(each.fe_error is not None for each in compliances):
        found["elements"] = {"compliances": tuple(each.with_fe_error(1.0) for each in compliances)}
    if slices.plane:
        return found
    fewer = tuple(each.fewer_axial_modes(REDUCED_DEGREES) for each in compliances)
    return {**found, "slices": compared, "axial": {"compliances": fewer}}


def account_errors_of_elements(
    clock: StageClock, names: Sequence[str], compliances: Sequence[BodyCompliance]
) -> None:
    """Move the cost of the estimated errors of elements from their stage to the estimate."""
    for name, compliance in zip(names, compliances, strict=True):
        clock.account("estimate").bytes += held_bytes(compliance.fe_error)
        clock.move(compliance.job.seconds, elements_stage(name), "estimate")


def prism_of(body: Body, scene: Scene) -> Prism | None:
    """Axial extension of a body, with the polynomial degrees of a scene; None in the plane."""
    from flankload.elasticity.prism import Prism

    if not effects_of(scene).three_dimensions:
        return None
    axial = body.axial
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

    If the scene sets no number, that of the discretization is used; the degree is at most half the
    number of flank elements, since more modes would increase the error on a coarse mesh.
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
