"""Rules between the keys of a body with involute teeth, or of one that comes as a mesh."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import pairwise
from math import cos, pi, radians
from typing import Any

from flankload.scene.gear_tables import Gear, InvoluteKeys, RingKeys, SplineHub, SplineShaft
from flankload.scene.mesh_tables import MeshBody
from flankload.scene.refusal import refuse

#: Bore over tip diameter: a body that is held in a point turns about it without resistance.
LEAST_BORE = 1e-3
#: Pitch error over base pitch: beyond it the teeth of one space would change places.
LARGEST_PITCH_ERROR = 0.1


def check_teeth(
    body: Gear | RingKeys | SplineShaft | MeshBody, given: Mapping[str, Any], key: str
) -> None:
    """Check that circles follow each other, and that what belongs together is there.

    Parameters
    ----------
    body : Gear, Ring, SplineShaft, SplineHub or MeshBody
    given : mapping
        The keys that the scene names.
    key : str
        "body_1" or "body_2".

    Raises
    ------
    SceneError
    """
    teeth = body.number_of_teeth
    if body.pitch_errors_um and len(body.pitch_errors_um) != teeth:
        refuse(
            f"{key}.pitch_errors_um",
            f"one entry per tooth: {teeth}, as in {key}.teeth",
            f"{len(body.pitch_errors_um)} entries",
        )
    _check_pitch_errors(body, key)
    if isinstance(body, MeshBody):
        _check_profile(body, given, key)
        return
    _check_tip(body, given, key)
    if isinstance(body, RingKeys):
        _check_ring(body, key)
    else:
        _check_bore(body, key)


def _check_profile(body: MeshBody, given: Mapping[str, Any], key: str) -> None:
    """A mesh has a profile of as many teeth, or a radius in its place."""
    if body.profile is None:
        if body.reference_radius_mm is None:
            refuse(
                f"{key}.reference_radius_mm",
                f"a number > 0, since there is no {key}.profile to take it from",
                "nothing",
            )
        return
    _check_tip(body.profile, given["profile"], f"{key}.profile")
    teeth = body.number_of_teeth
    if body.profile.teeth not in (None, teeth):
        refuse(
            f"{key}.profile.teeth",
            f"{teeth} as in {key}.teeth, or nothing",
            body.profile.teeth,
        )


def _check_bore(body: Gear | SplineShaft, key: str) -> None:
    """The bore lies within the tip circle, and is no point."""
    if body.bore_diameter_mm < LEAST_BORE * body.tip_diameter_mm:
        refuse(
            f"{key}.bore_diameter_mm",
            f"at least {LEAST_BORE:g} of {key}.tip_diameter_mm "
            f"({LEAST_BORE * body.tip_diameter_mm:g}), since the body is held there",
            body.bore_diameter_mm,
        )
    if body.bore_diameter_mm >= body.tip_diameter_mm:
        refuse(
            f"{key}.bore_diameter_mm",
            f"less than {key}.tip_diameter_mm ({body.tip_diameter_mm:g})",
            body.bore_diameter_mm,
        )


def _check_ring(ring: RingKeys, key: str) -> None:
    """Tip circle, root circle and outside of the rim follow each other outwards."""
    circles = ("tip_diameter_mm", "root_diameter_mm", "outer_diameter_mm")
    for inner, outer in pairwise(circles):
        if getattr(ring, outer) <= getattr(ring, inner):
            refuse(
                f"{key}.{outer}",
                f"more than {key}.{inner} ({getattr(ring, inner):g}), since the teeth of a "
                f"{'hub' if isinstance(ring, SplineHub) else 'ring'} stand inwards",
                getattr(ring, outer),
            )


def _check_pitch_errors(body: Gear | RingKeys | SplineShaft | MeshBody, key: str) -> None:
    """A tooth cannot stand beside its place by more than a part of the pitch."""
    profile = body.profile if isinstance(body, MeshBody) else body
    if profile is not None:
        base_pitch = pi * profile.module_mm * cos(radians(profile.pressure_angle_deg))
    else:
        assert isinstance(body, MeshBody)
        base_pitch = 2 * pi * (body.reference_radius_mm or 0.0) / body.number_of_teeth
    for i, error in enumerate(body.pitch_errors_um):
        if base_pitch and abs(error) > LARGEST_PITCH_ERROR * 1000 * base_pitch:
            refuse(
                f"{key}.pitch_errors_um[{i}]",
                f"at most {LARGEST_PITCH_ERROR:g} of the base pitch, "
                f"{LARGEST_PITCH_ERROR * 1000 * base_pitch:.0f} um",
                error,
            )


def _check_tip(body: InvoluteKeys, given: Mapping[str, Any], key: str) -> None:
    """A tip has a rounding or a chamfer, a relief has depth and start."""
    if body.tip_radius_mm is not None and body.tip_chamfer_mm is not None:
        refuse(
            f"{key}.tip_radius_mm",
            f"nothing beside {key}.tip_chamfer_mm: a tip has one or the other",
            f"{body.tip_radius_mm:g} and {body.tip_chamfer_mm:g}",
        )
    start = body.tip_relief_start_diameter_mm
    if body.tip_relief_um is None:
        for name in ("tip_relief_start_diameter_mm", "tip_relief_shape"):
            if name in given:
                refuse(
                    f"{key}.tip_relief_um",
                    f"a number >= 0, since there is a {key}.{name}",
                    "nothing",
                )
    elif start is None:
        refuse(
            f"{key}.tip_relief_start_diameter_mm",
            f"a number > 0, since there is a {key}.tip_relief_um",
            "nothing",
        )
    elif (
        start <= body.tip_diameter_mm
        if isinstance(body, RingKeys)
        else start >= body.tip_diameter_mm
    ):
        side = "more" if isinstance(body, RingKeys) else "less"
        refuse(
            f"{key}.tip_relief_start_diameter_mm",
            f"{side} than {key}.tip_diameter_mm ({body.tip_diameter_mm:g})",
            start,
        )
