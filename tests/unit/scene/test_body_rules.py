"""Keys of one body that do not go together: gears, rings, meshes."""

from collections.abc import Mapping
from typing import Any

import pytest

from tests.support.gear_scenes import MESH, PROFILE, RING, changed, one_line, refusal

OTHER_STARTS = "(or tip_relief_start_roll_angle_deg, tip_relief_length_mm, tip_relief_length)"


@pytest.mark.parametrize(
    ("changes", "key", "expected", "found"),
    [
        (
            {"body_1__tip_radius_mm": 0.2, "body_1__tip_chamfer_mm": 0.3},
            "body_1.tip_radius_mm",
            "nothing beside body_1.tip_chamfer_mm: a tip has one or the other",
            "0.2 and 0.3",
        ),
        (
            {"body_1__tip_relief_um": 20},
            "body_1.tip_relief_start_diameter_mm",
            f"a number > 0 {OTHER_STARTS}, since there is a body_1.tip_relief_um",
            "nothing",
        ),
        (
            {"body_1__tip_relief_start_diameter_mm": 80},
            "body_1.tip_relief_um",
            "a number >= 0, since there is a body_1.tip_relief_start_diameter_mm",
            "nothing",
        ),
        (
            {"body_1__tip_relief_shape": "linear"},
            "body_1.tip_relief_um",
            "a number >= 0, since there is a body_1.tip_relief_shape",
            "nothing",
        ),
        (
            {"body_1__tip_relief_um": 20, "body_1__tip_relief_start_diameter_mm": 90},
            "body_1.tip_relief_start_diameter_mm",
            "less than body_1.tip_diameter_mm (82.46)",
            "90.0",
        ),
        (
            {"body_1__bore_diameter_mm": 90},
            "body_1.bore_diameter_mm",
            "less than body_1.tip_diameter_mm (82.46)",
            "90.0",
        ),
        (
            {"body_1__pitch_errors_um": [1, 2]},
            "body_1.pitch_errors_um",
            "one entry per tooth: 16, as in body_1.teeth",
            "2 entries",
        ),
        (
            {"body_1": {"kind": "mesh", "teeth": 16}},
            "body_1.file",
            "a non-empty string",
            "nothing",
        ),
        (
            {"body_1": {**MESH, "cut_sets": ["A"]}},
            "body_1.cut_sets",
            "a list of 2 non-empty strings",
            "['A']",
        ),
        (
            {"body_1": {**MESH, "cut_sets": ["A", "A"]}},
            "body_1.cut_sets",
            "two different names",
            "['A', 'A']",
        ),
        (
            {"body_1": {k: v for k, v in MESH.items() if k != "profile"}},
            "body_1.reference_radius_mm",
            "a number > 0, since there is no body_1.profile that determines it",
            "nothing",
        ),
        (
            {"body_1": {**MESH, "profile": {**PROFILE, "teeth": 17}}},
            "body_1.profile.teeth",
            "16 as in body_1.teeth, or nothing",
            "17",
        ),
        (
            {"body_1": {**MESH, "profile": {**PROFILE, "bore_diameter_mm": 17}}},
            "body_1.profile.bore_diameter_mm",
            "a known key (did you mean tip_diameter_mm?)",
            "the unknown key 'bore_diameter_mm'",
        ),
        (
            {"body_1": {**MESH, "flank_sets": ["A", "B"], "cut_sets": ["L", "R"]}},
            "body_1.cut_sets",
            "nothing beside body_1.flank_sets: those are of a whole body",
            "['L', 'R']",
        ),
        (
            {"body_1": {**MESH, "flank_sets": ["A", "B"], "flank_set": "C"}},
            "body_1.flank_set",
            "nothing beside body_1.flank_sets: those are of a whole body",
            "'C'",
        ),
        (
            {"body_1": {**MESH, "flank_sets": ["A", "B", "A"]}},
            "body_1.flank_sets[2]",
            "each set once",
            "'A'",
        ),
        (
            {"body_1": {**MESH, "teeth": 3, "flank_sets": ["A", "B", "C", "D"]}},
            "body_1.teeth",
            "at least 4, as many as in body_1.flank_sets",
            "3",
        ),
        (
            {"body_1": {k: v for k, v in MESH.items() if k != "teeth"}},
            "body_1.teeth",
            "an integer >= 3, since there is no body_1.flank_sets to count",
            "nothing",
        ),
        (
            {"body_2": {**RING, "root_diameter_mm": 260}},
            "body_2.root_diameter_mm",
            (
                "more than body_2.tip_diameter_mm (262), since the teeth of a ring point inwards "
                "(kind = 'gear' for teeth that point outwards)"
            ),
            "260.0",
        ),
        (
            {"body_2": {**RING, "outer_diameter_mm": 281}},
            "body_2.outer_diameter_mm",
            "more than body_2.root_diameter_mm (281), since the teeth of a ring point inwards",
            "281.0",
        ),
        (
            {
                "body_2": {
                    **RING,
                    **{"tip_relief_um": 9, "tip_relief_start_diameter_mm": 261},
                }
            },
            "body_2.tip_relief_start_diameter_mm",
            "more than body_2.tip_diameter_mm (262)",
            "261.0",
        ),
        (
            {"body_2": {k: v for k, v in RING.items() if k != "outer_diameter_mm"}},
            "body_2.outer_diameter_mm",
            "a number from 0.001 to 100000",
            "nothing",
        ),
        (
            {"body_2": {**RING, "bore_diameter_mm": 30}},
            "body_2.bore_diameter_mm",
            "a known key (did you mean outer_diameter_mm?)",
            "the unknown key 'bore_diameter_mm'",
        ),
        (
            {"body_2__kind": "ring"},
            "body_2.kind",
            "'gear', which has all keys of this table",
            "'ring', which has no bore_diameter_mm",
        ),
        (
            {"body_1__bore": "free"},
            "body_1.bore",
            "'held' or 'torque'",
            "'free'",
        ),
        (
            {
                "body_1__bore": "torque",
                "body_1__shaft": {
                    **{"diameters_mm": [30.0], "lengths_mm": [100.0], "gear_position_mm": 50.0},
                    **{"bearing_positions_mm": [0.0, 100.0], "under_teeth": "flexible"},
                    **{"radial_stiffness_N_per_um": [200.0, 200.0], "torque_end": "I"},
                },
            },
            "body_1.bore",
            "'held', since body_1.shaft.under_teeth is 'flexible': the bore follows the shaft",
            "'torque'",
        ),
        (
            {
                "body_1__shaft": {
                    **{"diameters_mm": [30.0], "lengths_mm": [100.0], "gear_position_mm": 50.0},
                    **{"bearing_positions_mm": [0.0, 100.0], "under_teeth": "flexible"},
                    **{"radial_stiffness_N_per_um": [200.0, 200.0], "torque_end": "I"},
                },
                "effects__body": "tooth",
            },
            "effects.body",
            "'whole', since body_1.shaft.under_teeth is 'flexible': a segment is held at its bore",
            "'tooth'",
        ),
        (
            {"body_2": {**RING, "rim": "torque"}, "effects__body": "tooth"},
            "effects.body",
            "'whole', since body_2.rim is 'torque': a segment is held at its cuts",
            "'tooth'",
        ),
        (
            {"body_2": {**RING, "pitch_errors_um": [1]}},
            "body_2.pitch_errors_um",
            "one entry per tooth: 60, as in body_2.teeth",
            "1 entries",
        ),
        (
            {"body_1": {**MESH, "profile": {**PROFILE, "tip_relief_um": 3}}},
            "body_1.profile.tip_relief_start_diameter_mm",
            f"a number > 0 {OTHER_STARTS}, since there is a body_1.profile.tip_relief_um",
            "nothing",
        ),
    ],
    ids=lambda value: next(iter(value), "") if isinstance(value, Mapping) else "",
)
def test_impossible_body_gets_one_line(
    changes: dict[str, Any], key: str, expected: str, found: str
) -> None:
    one_line(changes, key, expected, found)


@pytest.mark.parametrize(
    ("changes", "line"),
    [
        (
            {"body_1__bore_diameter_mm": 0.08},
            (
                "body_1.bore_diameter_mm: expected at least 0.001 of body_1.tip_diameter_mm "
                "(0.08246), since the body is fixed there, found 0.08"
            ),
        ),
        (
            {"body_1__pitch_errors_um": [0.0, -1e4, *14 * [0.0]]},
            (
                "body_1.pitch_errors_um[1]: expected at most 0.1 of the base pitch, 1328 um, "
                "found -10000.0"
            ),
        ),
    ],
)
def test_nonsense_of_the_right_type_is_refused(changes: dict[str, Any], line: str) -> None:
    found, _, unusual = str(refusal(changed(**changes))).partition("; unusual: ")
    assert found == f"a.toml: {line}"
    assert unusual.startswith(f"{next(iter(changes)).replace('__', '.')} = ")
    assert ", did you mean " in unusual
