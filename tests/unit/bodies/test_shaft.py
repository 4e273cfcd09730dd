"""Shafts on bearings: compliance of a section against closed forms of Timoshenko beams."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import flankload as fl
from flankload.bodies.shaft import FlexibleShaft, Shaft, build_shaft, flexible_shaft
from flankload.elasticity.axial_basis import AxialBasis
from flankload.elasticity.prism.flexible_bore import beam_stiffness
from flankload.mechanisms.flank_pair.assembly import build_bodies
from flankload.scene.effects import effects_of, switches_of
from flankload.scene.shaft import Shaft as ShaftTable
from tests.support.gear_scenes import ABSENT, changed, example, one_line, refusal, resized
from tests.support.tolerances import ROUND_OFF

#: Beams in closed form.
CLOSED = 1e-10
E, NU = 206000.0, 0.3
BEAM: dict[str, Any] = {
    "diameters_mm": [30.0, 30.0],
    "lengths_mm": [60.0, 90.0],
    "gear_position_mm": 60.3,
    "bearing_positions_mm": [10.0, 140.0],
    "radial_stiffness_N_per_um": [200.0, 300.0],
    "axial_stiffness_N_per_um": [0.0, 100.0],
}
#: Between the bearings, left and right of the gear.
LEFT, RIGHT = 50.3, 79.7
SPAN = LEFT + RIGHT
SPRINGS = 2e5, 3e5


def made(**changes: Any) -> Shaft:
    keys = {**BEAM, **changes}
    values = {k: tuple(v) if isinstance(v, list) else v for k, v in keys.items() if v is not ABSENT}
    return build_shaft(ShaftTable(**values), 2.0)


def section(outer: float, inner: float = 0.0) -> tuple[float, float, float]:
    """E A, E I and the shear stiffness; Cowper 1966, with the ratio m of the diameters."""
    m = inner / outer
    area = np.pi / 4.0 * (outer**2 - inner**2)
    factor = 6.0 * (1.0 + NU) * (1.0 + m**2) ** 2
    factor /= (7.0 + 6.0 * NU) * (1.0 + m**2) ** 2 + (20.0 + 12.0 * NU) * m**2
    shear = factor * area * E / (2.0 * (1.0 + NU))
    return E * area, E * np.pi / 64.0 * (outer**4 - inner**4), shear


def test_a_shaft_between_two_bearings() -> None:
    """Bending, shear and springs, in both planes with the signs of rotations."""
    push, bend, shear = section(30.0)
    a, b, span, (one, two) = LEFT, RIGHT, SPAN, SPRINGS
    u = a**2 * b**2 / (3.0 * bend * span) + a * b / (shear * span)
    u += (b / span) ** 2 / one + (a / span) ** 2 / two
    turned = (a**3 + b**3) / (3.0 * bend * span**2) + 1.0 / (shear * span)
    turned += (1.0 / one + 1.0 / two) / span**2
    tilt = a * b * (b - a) / (3.0 * bend * span) + (a / two - b / one) / span**2
    wanted = np.zeros((6, 6))
    wanted[[0, 1], [0, 1]] = u
    wanted[2, 2] = RIGHT / push + 1e-5
    wanted[[3, 4], [3, 4]] = turned
    wanted[[0, 4], [4, 0]] = tilt
    wanted[[1, 3], [3, 1]] = -tilt
    found = made()
    assert found.z_mm == 2.0
    np.testing.assert_allclose(found.compliance, wanted, rtol=CLOSED, atol=1e-25)
    np.testing.assert_array_equal(found.compliance, found.compliance.T)
    np.testing.assert_allclose(found.bearing_loads[:, 0, 0], [b / span, a / span], rtol=CLOSED)
    np.testing.assert_allclose(found.bearing_loads[:, 1, 3], [1.0 / span, -1.0 / span], rtol=CLOSED)
    np.testing.assert_allclose(found.bearing_loads[:, 2, 2], [0.0, 1.0], atol=CLOSED)


def test_an_overhung_hollow_shaft_on_one_bearing() -> None:
    found = made(
        diameters_mm=[30.0],
        lengths_mm=[160.0],
        bore_diameter_mm=10.0,
        gear_position_mm=150.0,
        bearing_positions_mm=[10.0],
        radial_stiffness_N_per_um=[200.0],
        axial_stiffness_N_per_um=ABSENT,
        tilt_stiffness_Nm_per_mrad=[5.0],
    ).compliance
    _, bend, shear = section(30.0, 10.0)
    arm = 140.0
    u = arm**3 / (3.0 * bend) + arm / shear + 1.0 / 2e5 + arm**2 / 5e6
    np.testing.assert_allclose(found[0, 0], u, rtol=CLOSED)
    np.testing.assert_allclose(found[0, 4], arm**2 / (2.0 * bend) + arm / 5e6, rtol=CLOSED)
    np.testing.assert_allclose(found[3, 3], arm / bend + 1.0 / 5e6, rtol=CLOSED)
    assert found[2, 2] == 0.0


def test_a_stepped_shaft() -> None:
    """Rotation under a moment at an overhung end: the sum of its steps."""
    found = made(
        diameters_mm=[40.0, 20.0],
        lengths_mm=[50.0, 30.0],
        gear_position_mm=80.0,
        bearing_positions_mm=[0.0],
        radial_stiffness_N_per_um=[200.0],
        axial_stiffness_N_per_um=ABSENT,
        tilt_stiffness_Nm_per_mrad=[5.0],
    ).compliance
    wanted = 50.0 / section(40.0)[1] + 30.0 / section(20.0)[1] + 1.0 / 5e6
    np.testing.assert_allclose(found[3, 3], wanted, rtol=CLOSED)


def test_a_bearing_at_the_rounded_end_of_a_step() -> None:
    """0.1 + 0.2 is not 0.3."""
    steps = {"lengths_mm": [0.1, 0.2, 149.7], "diameters_mm": [30.0] * 3}
    bearings = {"bearing_positions_mm": [0.3, 140.0]}
    one, other = made(**steps, **bearings), made(**bearings)
    np.testing.assert_allclose(one.compliance, other.compliance, rtol=CLOSED, atol=1e-20)


def test_a_gear_position_on_half_a_micrometre() -> None:
    """Regression: positions were rounded to 1 um in two ways, which moved the gear to a bearing."""
    shaft = {"diameters_mm": [25.0], "lengths_mm": [100.0], "bearing_positions_mm": [10.0, 90.0]}
    between = made(**shaft, gear_position_mm=20.0045)
    below, above = (made(**shaft, gear_position_mm=20.0045 + d).compliance for d in (-1e-6, 1e-6))
    close = 0.5 * (below + above)
    np.testing.assert_allclose(between.compliance, close, rtol=1e-12, atol=1e-20)
    np.testing.assert_allclose(between.bearing_loads[:, 0, 0], [69.9955 / 80.0, 10.0045 / 80.0])


def test_a_step_beside_the_gear_has_no_effect_however_short() -> None:
    """Elements of a nanometre between nodes would cost half of the digits."""
    whole = made(diameters_mm=[30.0], lengths_mm=[150.0]).compliance
    split = made(lengths_mm=[60.3 + 1e-6, 150.0 - 60.3 - 1e-6]).compliance
    np.testing.assert_allclose(split, whole, rtol=ROUND_OFF, atol=1e-25)


def test_a_symmetric_shaft_does_not_tilt() -> None:
    found = made(gear_position_mm=75.0, radial_stiffness_N_per_um=[200.0, 200.0]).compliance
    assert abs(found[0, 4]) < 1e-12 * np.sqrt(found[0, 0] * found[4, 4])


def test_a_mirrored_shaft_tilts_the_other_way() -> None:
    mirrored = made(
        lengths_mm=[90.0, 60.0],
        gear_position_mm=150.0 - 60.3,
        radial_stiffness_N_per_um=[300.0, 200.0],
    ).compliance
    sign = np.array([1.0, 1.0, -1.0, -1.0, -1.0, 1.0])
    wanted = made(axial_stiffness_N_per_um=[100.0, 0.0]).compliance
    wanted = wanted * np.outer(sign, sign)
    for pair in ((0, 0), (0, 4), (3, 3), (1, 3)):
        np.testing.assert_allclose(mirrored[pair], wanted[pair], rtol=CLOSED)


def test_a_shaft_requires_three_dimensions() -> None:
    scene = fl.Scene.from_dict(changed(body_1__shaft=BEAM))
    assert effects_of(scene).three_dimensions
    assert switches_of(scene)["three_dimensions"].because == "body_1.shaft"
    one_line(
        {"body_1__shaft": BEAM, "effects__dimension": 2},
        "effects.dimension",
        "3 or nothing, since there is a body_1.shaft",
        "2",
    )


SOFT = np.diag([1e-6, 1e-6, 1e-6, 1e-9, 1e-9, 0.0])


def altered(i: int, j: int, value: float) -> list[list[float]]:
    rows = SOFT.copy()
    rows[i, j] = value
    return rows.tolist()


def coupled() -> list[list[float]]:
    rows = SOFT.copy()
    rows[0, 4] = rows[4, 0] = 1e-7
    return rows.tolist()


UNHELD = (
    "numbers > 0 for bearings at 2 positions at least, or for one with a "
    "KEY.tilt_stiffness_Nm_per_mrad > 0: fewer do not hold the shaft"
)


@pytest.mark.parametrize(
    ("changes", "key", "expected", "found"),
    [
        ({"lengths_mm": ABSENT}, "lengths_mm", "a value, since there is no KEY.compliance", None),
        (
            {"lengths_mm": [60.0]},
            "lengths_mm",
            "one entry per step: 2, as in KEY.diameters_mm",
            "1 entries",
        ),
        (
            {"axial_stiffness_N_per_um": [1.0, 2.0, 3.0]},
            "axial_stiffness_N_per_um",
            "one entry per bearing: 2, as in KEY.bearing_positions_mm",
            "3 entries",
        ),
        (
            {"bore_diameter_mm": 30},
            "bore_diameter_mm",
            "less than the smallest of KEY.diameters_mm (30)",
            "30.0",
        ),
        (
            {"gear_position_mm": 151},
            "gear_position_mm",
            "at most the length of the shaft, 150 (sum of KEY.lengths_mm)",
            "151.0",
        ),
        (
            {"bearing_positions_mm": [10, 160]},
            "bearing_positions_mm[1]",
            "at most the length of the shaft, 150 (sum of KEY.lengths_mm)",
            "160.0",
        ),
        (
            {"radial_stiffness_N_per_um": [200, 0]},
            "radial_stiffness_N_per_um",
            UNHELD,
            "[200.0, 0.0]",
        ),
        (
            {"bearing_positions_mm": [10, 10 + 1e-13]},
            "radial_stiffness_N_per_um",
            UNHELD,
            "[200.0, 300.0]",
        ),
        (
            {"compliance": SOFT.tolist()},
            "diameters_mm",
            "nothing beside KEY.compliance",
            "[30.0, 30.0]",
        ),
    ],
)
def test_refused_shafts(
    changes: dict[str, Any], key: str, expected: str, found: str | None
) -> None:
    table = {k: v for k, v in {**BEAM, **changes}.items() if v is not ABSENT}
    name = "body_2.shaft"
    expected = expected.replace("KEY", name)
    one_line({"body_2__shaft": table}, f"{name}.{key}", expected, found or "nothing")


@pytest.mark.parametrize(
    ("rows", "key", "expected", "found"),
    [
        (
            altered(1, 1, -1e-6),
            "",
            "a matrix without negative eigenvalues, since loads never do negative work",
            "one of -1 relative to the diagonal",
        ),
        (
            coupled(),
            "",
            "a matrix without negative eigenvalues, since loads never do negative work",
            "one of -2.16 relative to the diagonal",
        ),
        (altered(0, 4, 1e-8), "[0][4]", "0, as in [4][0]: a compliance is symmetric", "1e-08"),
        (
            altered(5, 5, 1e-9),
            "[5][5]",
            "0, since the rotation about the axis is that of the drive",
            "1e-09",
        ),
    ],
)
def test_refused_compliances(rows: list[list[float]], key: str, expected: str, found: str) -> None:
    one_line(
        {"body_1__shaft": {"compliance": rows}}, f"body_1.shaft.compliance{key}", expected, found
    )


def test_a_compliance_has_six_rows() -> None:
    error = refusal(changed(body_1__shaft={"compliance": SOFT[:5].tolist()}))
    assert error.key == "body_1.shaft.compliance"
    assert error.expected == "a list of 6 lists of 6 numbers from -1 to 1"


def test_a_helical_gear_needs_an_axial_bearing() -> None:
    helix = {"body_1__helix_angle_deg": 15, "body_1__hand": "right"}
    helix |= {"body_2__helix_angle_deg": 15, "body_2__hand": "left"}
    shaft = {key: value for key, value in BEAM.items() if not key.startswith("axial")}
    one_line(
        {**helix, "body_1__shaft": shaft},
        "body_1.shaft.axial_stiffness_N_per_um",
        "a number > 0 for one bearing at least: the axial force of the helix moves the shaft",
        "nothing",
    )


# a shaft that bends and twists under the teeth

FLEXIBLE = {"under_teeth": "flexible", "torque_end": "I"}


def carried(ends_mm: tuple[float, float], bore_mm: float, **changes: Any) -> FlexibleShaft:
    keys = {**BEAM, **FLEXIBLE, **changes}
    values = {k: tuple(v) if isinstance(v, list) else v for k, v in keys.items() if v is not ABSENT}
    return flexible_shaft(ShaftTable(**values), 0.0, ends_mm, bore_mm)


@pytest.mark.parametrize("inner", [0.0, 12.0])
def test_parts_of_a_flexible_shaft_make_the_whole_one(inner: float) -> None:
    """Beam in the bore and springs beyond it: the compliance of the section at an end."""
    hollow = {"bore_diameter_mm": inner or ABSENT, "bearing_positions_mm": [10.0, 65.0, 140.0]}
    hollow |= {"radial_stiffness_N_per_um": [200.0, 50.0, 300.0]}
    hollow |= {"axial_stiffness_N_per_um": [0.0, 20.0, 100.0]}
    hollow |= {"tilt_stiffness_Nm_per_mrad": [1.0, 0.5, 0.0]}
    parts = carried((-10.0, 15.0), 30.0, **hollow)
    basis, degree = AxialBasis((-10.0, 15.0), 11), 11
    stiffness = beam_stiffness(parts, basis, degree, 0.0)
    scale = np.repeat([1.0, 1.0 / 15.0], 3)
    ends = [
        np.kron(row, np.eye(6)) * np.tile(scale, degree + 1)
        for row in basis.values(np.array([-10.0, 15.0]))
    ]
    for end, (axial, force, mixed, moment) in zip(ends, parts.beyond, strict=True):
        spring = np.diag([force, force, axial, moment, moment, 0.0])
        spring[[0, 4], [4, 0]] = mixed
        spring[[1, 3], [3, 1]] = -mixed
        stiffness += end.T @ spring @ end
    turns = np.arange(5, len(stiffness), 6)
    free = np.setdiff1d(np.arange(len(stiffness)), turns)
    load = ends[1][:5, free].T
    found = load.T @ np.linalg.solve(stiffness[np.ix_(free, free)], load)
    wanted = made(gear_position_mm=60.3 + 15.0, **hollow).compliance[:5, :5]
    size = np.sqrt(np.outer(np.diag(wanted), np.diag(wanted)))
    # a kink of the beam at the bearing in the bore is not a polynomial
    np.testing.assert_allclose(found / size, wanted / size, rtol=0, atol=2e-4)


def test_the_shaft_fills_the_bore_of_a_web_or_hub() -> None:
    scene = changed(body_1__hub_diameter_mm=40.0, body_1__hub_width_mm=30.0)
    scene["body_1"]["shaft"] = {**BEAM, **FLEXIBLE}
    axial = build_bodies(fl.Scene.from_dict(scene)).body_1.axial
    assert axial.flexible is not None
    assert axial.flexible.range_mm == (-15.0, 15.0)
    assert axial.flexible.end_radii_mm == (15.0, 15.0)


@pytest.mark.parametrize("lengths", [[50.3, 25.0, 74.7], [52.0, 20.0, 78.0]])
def test_the_shaft_beyond_an_end_of_the_bore_is_its_own_step(lengths: list[float]) -> None:
    """Also where the step begins at the end of the bore, up to rounding."""
    steps = {"diameters_mm": [36.0, 30.0, 40.0], "lengths_mm": lengths}
    assert carried((-10.0, 15.0), 30.0, **steps).end_radii_mm == (18.0, 20.0)
    tenth = resized({**BEAM, **steps}, 0.1)
    assert carried((-1.0, 1.5), 3.0, **tenth).end_radii_mm == pytest.approx((1.8, 2.0))
    assert carried((-60.3, 89.7), 30.0, **steps).end_radii_mm == (0.0, 0.0)


def test_a_bearing_at_an_end_of_the_bore_is_in_the_bore() -> None:
    shaft = carried((-10.0, 15.0), 30.0, bearing_positions_mm=[50.3, 75.3 + 1e-9])
    assert [place for place, *_ in shaft.bearings] == pytest.approx([-10.0, 15.0])
    assert shaft.beyond == ((0.0,) * 4, (0.0,) * 4)


@pytest.mark.parametrize(
    ("changes", "key", "expected", "found"),
    [
        (
            {"torque_end": ABSENT},
            "shaft.torque_end",
            "'I', 'II' or 'even', since body_1.shaft.under_teeth is 'flexible'",
            "nothing",
        ),
        (
            {"under_teeth": ABSENT},
            "shaft.torque_end",
            "nothing, unless body_1.shaft.under_teeth is 'flexible'",
            "'I'",
        ),
        (
            {"diameters_mm": [30.0, 28.0]},
            "shaft.diameters_mm[1]",
            "at least body_1.bore_diameter_mm (30), which a flexible shaft fills",
            "28.0",
        ),
        (
            {"gear_position_mm": 5.0},
            "shaft.gear_position_mm",
            "a position at which the shaft (150 mm long) fills all of the bore",
            "5: the bore is from -2 to 12 mm",
        ),
        (
            {"diameters_mm": [40.0, 40.0], "bore_diameter_mm": 32.0},
            "shaft.bore_diameter_mm",
            "less than body_1.bore_diameter_mm (30)",
            "32.0",
        ),
    ],
)
def test_refused_flexible_shafts(
    changes: dict[str, Any], key: str, expected: str, found: str
) -> None:
    table = {**BEAM, **FLEXIBLE, **changes}
    table = {k: v for k, v in table.items() if v is not ABSENT}
    one_line({"body_1__shaft": table}, f"body_1.{key}", expected, found)


@pytest.mark.parametrize(
    ("name", "body"), [("external_gear_mesh", "body_1"), ("internal_gear", "body_2")]
)
def test_a_body_without_a_bore_has_no_flexible_shaft(name: str, body: str) -> None:
    scene = example(name)
    scene[body]["shaft"] = {**BEAM, **FLEXIBLE}
    error = refusal(scene)
    assert error.key == f"{body}.shaft.under_teeth"
    assert error.expected == f"'rigid', since there is no {body}.bore_diameter_mm"


def test_a_compliance_does_not_bend_under_the_teeth() -> None:
    one_line(
        {"body_1__shaft": {"compliance": SOFT.tolist(), "under_teeth": "flexible"}},
        "body_1.shaft.under_teeth",
        "nothing beside body_1.shaft.compliance",
        "'flexible'",
    )
