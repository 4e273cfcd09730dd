"""Which effects a scene calls for, as data; what it does not call for is not computed."""

from __future__ import annotations

from dataclasses import dataclass

from flankload.scene import BodySpec, Cam, ComplianceBody, Follower, MeshBody, Scene


@dataclass(frozen=True)
class Effects:
    """What a scene calls for.

    Attributes
    ----------
    elastic_body_1, elastic_body_2 : bool
        The body yields: finite elements are solved for it, once, unless its compliance comes from
        a file. Not where it is rigid, and not where no torque loads it.
    flank_modifications : bool
        A profile departs from the involute below its tip circle (relief, crowning, tip radius or
        chamfer), by the keys of the scene.
    pitch_errors : bool
        Teeth stand beside their place; the period of the result is then one of many.
    several_torques : bool
        One result per torque.
    root_stress : bool
        Stress in the tooth roots of the bodies that yield.
    friction : bool
        Flanks rub on each other: their compliance along the tangent is solved, too.
    """

    elastic_body_1: bool
    elastic_body_2: bool
    flank_modifications: bool
    pitch_errors: bool
    several_torques: bool
    friction: bool
    root_stress: bool = False


def effects_of(scene: Scene) -> Effects:
    """Effects that a scene calls for.

    Parameters
    ----------
    scene : Scene

    Returns
    -------
    Effects
    """
    bodies = (scene.body_1, scene.body_2)
    loaded = any(scene.torques_Nm)
    return Effects(
        elastic_body_1=loaded and not scene.body_1.rigid,
        elastic_body_2=loaded and not scene.body_2.rigid,
        flank_modifications=any(_is_modified(body) for body in bodies),
        pitch_errors=any(any(body.pitch_errors_um) for body in bodies),
        several_torques=scene.has_torque_list,
        friction=scene.has_friction,
        root_stress=loaded and scene.effects.root_stress,
    )


def _is_modified(body: BodySpec) -> bool:
    if isinstance(body, ComplianceBody | Cam | Follower):
        return False
    profile = body.profile if isinstance(body, MeshBody) else body
    return profile is not None and any(
        (
            profile.tip_relief_um,
            profile.profile_crowning_um,
            profile.tip_radius_mm,
            profile.tip_chamfer_mm,
        )
    )
