"""Distance between the flanks of bodies whose files give the places of the flanks."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from flankload.contact.sweep import FlankContact, sweep
from flankload.elasticity.compliance import no_compliance
from flankload.errors import SceneError
from flankload.scene import MeshBody

if TYPE_CHECKING:
    from flankload.cost import Account
    from flankload.pairing.body_pair import BodyPair
    from flankload.scene import Scene

#: Largest distance between such flanks, as part of the pitch: a larger one means another tooth or
#: another centre distance.
LARGEST_STANDING_GAP = 0.25


def with_standing_gap(scene: Scene, pair: BodyPair, account: Account) -> BodyPair:
    """Add a note on the distance between the flanks if the files give their places.

    The state without load is counted in the account. Raises a SceneError if the flanks are too far
    apart.
    """
    if pair.body_1.flank_angle_known and pair.body_2.flank_angle_known:
        return pair
    (unloaded,) = sweep(
        FlankContact(
            (pair.body_1, pair.body_2),
            compliances=(no_compliance(pair.body_1), no_compliance(pair.body_2)),
            pairing=pair.pairing,
            face_width_mm=scene.pair.face_width_mm,
            grid=pair.discretization.grid,
        ),
        pair.position_rad[:1],
        [0.0],
        account=account,
    )
    radius = pair.body_1.reference_radius_mm
    gap_mm = float(unloaded.rotation_rad[0]) * radius
    apart = "overlap by" if gap_mm < 0 else "stand apart by"
    if abs(gap_mm) > LARGEST_STANDING_GAP * pair.pairing.pitch_rad * radius:
        _blame_flank(scene, pair, f"{apart} {abs(gap_mm):.3f} mm")
        raise SceneError(
            file=scene.file,
            key="pair.center_distance_mm",
            expected="bodies whose flanks nearly touch (to a quarter pitch) as their files stand",
            found=f"{scene.pair.axes_apart_mm:g} mm, where they {apart} {abs(gap_mm):.3f} mm",
        )
    note = (
        f"as the files stand, the flanks {apart} {1000 * abs(gap_mm):.3g} um at the first "
        "position; rotation and transmission error count from there"
    )
    return replace(pair, standing_note=note)


def _blame_flank(scene: Scene, pair: BodyPair, stand: str) -> None:
    """Refuse a mesh flank that faces clockwise if that of its mate faces counter-clockwise."""
    if pair.body_1.mirrored == pair.body_2.mirrored:
        return
    key, spec = ("body_1", scene.body_1) if pair.body_1.mirrored else ("body_2", scene.body_2)
    assert isinstance(spec, MeshBody)
    sets = spec.flank_sets
    name = "flank_set" if sets is None else "flank_sets"
    raise SceneError(
        file=scene.file,
        key=f"{key}.{name}",
        expected="the other flank of the tooth: one that faces counter-clockwise about the axis of "
        "its body, as that of the mate does",
        found=f"{(sets or (spec.flank_set,))[0]!r}, which faces clockwise: in their "
        f"mirror image the flanks {stand}",
    )
