"""How two bodies stand to each other, and where the pair is looked at."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from flankload.scene.cam_rules import check_cam_pair
from flankload.scene.gear_tables import SplineHub, SplineShaft
from flankload.scene.refusal import refuse

if TYPE_CHECKING:
    from flankload.scene.pair_tables import Pair, Positions
    from flankload.scene.tables import SceneFile

#: Fewer positions to begin with overlook pairs that carry on a part of a pitch only.
LEAST_START = 8


def check_kinds(asked: SceneFile, pair: Pair) -> None:
    """Check that a shaft stands in a hub, on an offset, all other bodies on a centre distance.

    Raises
    ------
    SceneError
    """
    check_cam_pair(asked)
    splines = isinstance(asked.body_1, SplineShaft), isinstance(asked.body_2, SplineHub)
    if any(splines) and not all(splines):
        refuse(
            "body_2.kind",
            "'spline_hub' with body_1.kind 'spline_shaft': the two go together and with no other",
            f"'{asked.body_2.kind}' with body_1.kind '{asked.body_1.kind}'",
        )
    distance, offset = pair.center_distance_mm, pair.center_offset_mm
    if all(splines) and distance is not None:
        refuse(
            "pair.center_distance_mm",
            "nothing: a spline's axes stand on pair.center_offset_mm (absent = 0)",
            distance,
        )
    if not any(splines) and offset is not None:
        refuse(
            "pair.center_offset_mm",
            f"nothing: a {asked.body_1.kind} and a {asked.body_2.kind} stand on "
            "pair.center_distance_mm, only splines on an offset",
            offset,
        )
    if not any(splines) and distance is None:
        refuse("pair.center_distance_mm", "a number from 0.001 to 100000", "nothing")


def check_positions(positions: Positions, given: Mapping[str, Any]) -> None:
    """Check that angles stand alone, and that what steers adaptive positions stands with them.

    Parameters
    ----------
    positions : Positions
    given : mapping
        The keys that the scene names.

    Raises
    ------
    SceneError
    """
    if positions.angles_deg is not None:
        for key in ("count", "pitches", "adaptive", "tolerance", "max_count"):
            if key in given:
                refuse(
                    "positions.angles_deg",
                    f"nothing beside positions.{key}: one of the two",
                    positions.angles_deg,
                )
    if not positions.adaptive:
        for key in ("tolerance", "max_count"):
            if key in given:
                refuse(f"positions.{key}", "nothing, unless positions.adaptive is true", given[key])
        return
    if positions.count < LEAST_START:
        refuse(
            "positions.count",
            f"at least {LEAST_START} to begin adaptive positions with",
            positions.count,
        )
    if positions.max_count is not None and positions.max_count < positions.count:
        refuse(
            "positions.max_count",
            f"at least positions.count ({positions.count})",
            positions.max_count,
        )
