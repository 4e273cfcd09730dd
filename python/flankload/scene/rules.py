"""The rules of a whole scene file, in the order in which they are asked."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from flankload.scene.belt_rules import check_belt
from flankload.scene.cam_rules import check_cam, check_follower
from flankload.scene.cam_tables import Cam, Follower
from flankload.scene.chain_rules import check_chain
from flankload.scene.effect_rules import check_effects
from flankload.scene.gear_rules import check_teeth
from flankload.scene.gear_tables import Gear, RingKeys, SplineShaft
from flankload.scene.mesh_rules import check_sets
from flankload.scene.mesh_tables import MeshBody
from flankload.scene.pair_rules import check_kinds, check_positions
from flankload.scene.refusal import refuse

if TYPE_CHECKING:
    from flankload.scene.tables import BodySpec, SceneFile


def check_body(body: BodySpec, given: Mapping[str, Any], key: str) -> None:
    """Check one body by itself.

    Parameters
    ----------
    body : Gear, Ring, …
    given : mapping
        The keys that the scene names.
    key : str
        "body_1" or "body_2".

    Raises
    ------
    SceneError
    """
    if isinstance(body, Cam):
        check_cam(body, key)
    elif isinstance(body, Follower):
        check_follower(body, key)
    elif isinstance(body, MeshBody):
        check_sets(body, given, key)
        check_teeth(body, given, key)
    elif isinstance(body, Gear | RingKeys | SplineShaft):
        check_teeth(body, given, key)
    # Nothing else has rules of its own: teeth and all else of a compliance stand in its file,
    # chains and belts are checked with what they lie on.


def check_whole(asked: SceneFile, given: Mapping[str, Any]) -> None:
    """Check what lies between the tables.

    Parameters
    ----------
    asked : SceneFile
    given : mapping
        The scene as it stands in the file.

    Raises
    ------
    SceneError
        At the first key that contradicts another one; names key, expected and found.
    """
    check_chain(asked, given)
    check_belt(asked, given)
    if asked.pair is not None:
        check_kinds(asked, asked.pair)
    check_effects(asked, given)
    check_positions(asked.positions, given.get("positions", {}))
    torque = asked.load.torque_Nm
    loaded = any(torque) if isinstance(torque, tuple) else torque > 0
    if loaded and asked.body_1.rigid and asked.body_2.rigid:
        refuse(
            "body_2.rigid",
            "false, since body_1.rigid is true: where neither body yields, nothing says how the "
            "flanks share the torque",
            True,
        )
