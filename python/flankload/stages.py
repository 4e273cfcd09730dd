"""The stages between the bodies of a scene and its states, as every run takes them."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING

from flankload.compliance import BodyCompliance, flank_compliance
from flankload.effects import effects_of
from flankload.given_compliance import given_compliance
from flankload.growth import grown
from flankload.nodal_loads import nodes_of
from flankload.resolution import Resolution, choose_resolution
from flankload.sweep import sweep

if TYPE_CHECKING:
    from collections.abc import Callable

    from scipy.sparse import csc_matrix

    from flankload.assembly import BodyPair
    from flankload.bodies import Body
    from flankload.growth import Growth
    from flankload.root_fillet import RootFillets
    from flankload.scene import Scene
    from flankload.sweep import Sweep

#: Influence numbers of finite forces are linear through so many steps of each force. Where they
#: grow evenly with it 10 steps have 5 % more of that growth than steps without number, 3 steps
#: 14 %.
FINITE_STEPS = 10
#: What asks for loads along the flanks.
FRICTION, FINITE = "effects.friction_coefficient", "effects.influence = 'finite'"


def compliance_of(
    body: Body,
    scene: Scene,
    resolution: Resolution | None = None,
    *,
    fillets: RootFillets | None = None,
    growth: Growth | None = None,
    matrix: csc_matrix | None = None,
    estimate: bool = False,
) -> BodyCompliance:
    """Compliance of one body: from its elements, or as it brings it along.

    Parameters
    ----------
    body : Body
        That yields.
    scene : Scene
        Decides on plane and pressure modes.
    resolution : Resolution, optional
        Knobs; those of the scene if absent.
    fillets : RootFillets, optional
        Where stress is wanted, too.
    growth : Growth, optional
        By what the body grows.
    matrix : csc_matrix, optional
        Stiffness of its mesh, where it is there already.
    estimate : bool
        What elements miss is estimated, too.

    Returns
    -------
    BodyCompliance
    """
    resolution, effects = resolution or choose_resolution(scene), effects_of(scene)
    # what moves along the flank under normal loads is what these move the other way round
    tangential = effects.friction or effects.finite_influence
    if body.given is not None:
        found = given_compliance(
            body,
            modes=scene.accuracy.modes,
            default_modes=resolution.modes,
            plane=scene.accuracy.plane,
            tangential=(FRICTION if effects.friction else FINITE) if tangential else None,
            nodal=effects.nodal_near_field,
        )
        if growth is not None:
            found = replace(found, expansion=growth.strain)
    else:
        found = flank_compliance(
            body,
            n_modes=modes_of(body, scene, resolution),
            plane=scene.accuracy.plane,
            friction=tangential,
            along=effects.friction and effects.finite_influence,
            nodal=effects.nodal_near_field,
            coast_flanks=scene.effects.coast_flank,
            fillets=fillets,
            sectors=scene.sectors,
            growth=growth,
            matrix=matrix,
            estimate=estimate,
        )
    return found if scene.effects.tooth_coupling else found.without_coupling()


def grown_pair(
    pair: BodyPair, compliances: tuple[BodyCompliance, BodyCompliance]
) -> tuple[BodyPair, tuple[BodyCompliance, BodyCompliance]]:
    """Both as the bodies have grown as a whole; from here on nobody asks how they were made.

    Parameters
    ----------
    pair : BodyPair
    compliances : two BodyCompliance

    Returns
    -------
    BodyPair
    two BodyCompliance
    """
    if not any(compliance.expansion for compliance in compliances):
        return pair, compliances
    one, two = compliances
    pair = replace(
        pair,
        body_1=grown(pair.body_1, one.expansion),
        body_2=grown(pair.body_2, two.expansion),
    )
    return pair, (one.grown(), two.grown())


def sweep_of(scene: Scene, pair: BodyPair) -> Callable[..., tuple[Sweep, ...]]:
    """The sweep of a scene: positions, torques, compliances and cells are still open.

    Parameters
    ----------
    scene : Scene
    pair : BodyPair
        Its bodies.

    Returns
    -------
    callable
        `sweep` with all that the scene says given.
    """
    return partial(
        sweep,
        (pair.body_1, pair.body_2),
        pairing=pair.pairing,
        face_width_mm=scene.pair.face_width_mm,
        friction=pair.friction,
        level=scene.effects.contact,
        finite_steps=FINITE_STEPS if pair.effects.finite_influence else 0,
    )


def modes_of(body: Body, scene: Scene, resolution: Resolution) -> int:
    """Pressure modes of a flank of a body with elements, or its nodes that carry unit forces.

    Parameters
    ----------
    body : Body
    scene : Scene
        May name their number.
    resolution : Resolution

    Returns
    -------
    int
        Where the scene names none, of a degree at most half the number of flank elements: more
        makes a coarse mesh worse.
    """
    if scene.effects.near_field == "nodes" and body.mesh is not None:
        return nodes_of(body.mesh).size
    asked, wanted = scene.accuracy.modes, resolution.modes
    if body.modes_part > 1.0:
        asked, wanted = None, round(body.modes_part * (asked or wanted))
    if asked is not None or body.mesh is None:
        return asked or 0
    count = max(2, min(wanted, body.mesh.flank_elements // 2 + 1))
    return count - 1 + count % 2 if body.curve.closed else count
