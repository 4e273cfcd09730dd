"""Keys that do not go together: one line, which names both."""

from collections.abc import Mapping
from typing import Any

import pytest

from tests.support.gear_scenes import MESH, ROUNDED, one_line

#: Reason for the refusal of two rigid bodies.
UNDETERMINED = "the load sharing of two rigid bodies is undetermined"


@pytest.mark.parametrize(
    ("changes", "key", "expected", "found"),
    [
        (
            {"effects__near_field": "nodes", "accuracy__modes": 5},
            "accuracy.modes",
            "nothing with effects.near_field 'nodes': nodal forces replace modes",
            "5",
        ),
        (
            {"effects__near_field": "nodes", "body_1": {**MESH, "profile": ROUNDED}},
            "effects.near_field",
            (
                "'analytic' with body_1.profile.tip_radius_mm: the carrying edges of a flank "
                "set from a file end at the tip rounding or chamfer"
            ),
            "'nodes'",
        ),
        (
            {"effects__near_field": "nodes", "effects__contact": "lumped"},
            "effects.contact",
            "'pairs' with effects.near_field 'nodes': nodal forces need resolved contact",
            "'lumped'",
        ),
        (
            {"effects__influence": "finite", "effects__contact": "lumped"},
            "effects.contact",
            "'pairs' with effects.influence 'finite': finite forces need resolved contact",
            "'lumped'",
        ),
        (
            {"positions": {"adaptive": True, "angles_deg": [0.0, 3.0]}},
            "positions.angles_deg",
            "nothing beside positions.adaptive: one of the two",
            "[0.0, 3.0]",
        ),
        (
            {"positions": {"pitches": "hunting", "angles_deg": [0.0]}},
            "positions.angles_deg",
            "nothing beside positions.pitches: one of the two",
            "[0.0]",
        ),
        (
            {"positions__tolerance": 0.01},
            "positions.tolerance",
            "nothing, unless positions.adaptive is true",
            "0.01",
        ),
        (
            {"positions__max_count": 100},
            "positions.max_count",
            "nothing, unless positions.adaptive is true",
            "100",
        ),
        (
            {"positions": {"adaptive": True, "max_count": 31}},
            "positions.max_count",
            "at least positions.count (32)",
            "31",
        ),
        (
            {"positions": {"adaptive": True, "count": 7}},
            "positions.count",
            "at least 8 to begin adaptive positions with",
            "7",
        ),
        (
            {"positions": {"count": 4, "angles_deg": [0.0]}},
            "positions.angles_deg",
            "nothing beside positions.count: one of the two",
            "[0.0]",
        ),
        (
            {"body_1__rigid": True, "body_2__rigid": True},
            "body_2.rigid",
            f"false, since body_1.rigid is true: {UNDETERMINED}",
            "true",
        ),
    ],
    ids=lambda value: next(iter(value), "") if isinstance(value, Mapping) else "",
)
def test_impossible_pair_of_keys_gets_one_line(
    changes: dict[str, Any], key: str, expected: str, found: str
) -> None:
    one_line(changes, key, expected, found)
