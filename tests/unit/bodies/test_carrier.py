"""Carriers of planetary stages: beams between plates, twist by the torque, imported matrices."""

from pathlib import Path

import numpy as np
import pytest

from flankload.bodies.carrier import carrier_compliance
from flankload.errors import SceneError
from flankload.scene.carrier import Carrier

LENGTH, DIAMETER, RADIUS = 40.0, 20.0, 63.0
ANGLES = 2 * np.pi * np.arange(3) / 3
INERTIA = np.pi / 64 * DIAMETER**4
BENDING = 206000.0 * INERTIA
#: Cowper's shear coefficient of a solid circle.
SHEAR = 206000.0 / 2.6 * np.pi / 4 * DIAMETER**2 * 6 * 1.3 / (7 + 6 * 0.3)
TANGENTIAL = np.stack([-np.sin(ANGLES), np.cos(ANGLES)], axis=1)


def plates(**keys):
    table = Carrier(plate_distance_mm=LENGTH, pin_diameter_mm=DIAMETER, **keys)
    return carrier_compliance(table, ANGLES, RADIUS, Path())


def of_tangential_forces(compliance):
    """Tangential displacement and slope of pin 2 under unit tangential forces on all pins."""
    forces = np.zeros((3, 6))
    forces[:, :2] = TANGENTIAL
    moved = np.einsum("ixjy,jy->ix", compliance, forces)[1]
    # du/dz = (theta_y, -theta_x)
    return moved[:2] @ TANGENTIAL[1], np.array([moved[4], -moved[3]]) @ TANGENTIAL[1]


@pytest.mark.parametrize(("ends", "part"), [("hinged", 48), ("clamped", 192)])
def test_deflection_of_a_beam(ends, part):
    moved, slope = of_tangential_forces(plates(pin_ends=ends))
    assert moved == pytest.approx(LENGTH**3 / (part * BENDING) + LENGTH / (4 * SHEAR), rel=1e-12)
    assert slope == pytest.approx(0.0, abs=1e-20)


@pytest.mark.parametrize(("end", "sign"), [("II", -1), ("I", 1)])
def test_a_plate_that_turns(end, sign):
    """Each plate carries half of all forces; pins lean towards the one that turns."""
    stiffness = 5.0
    twisted = plates(pin_ends="hinged", torsional_stiffness_Nm_per_mrad=stiffness, torque_end=end)
    moved, slope = (
        one - other
        for one, other in zip(
            of_tangential_forces(twisted),
            of_tangential_forces(plates(pin_ends="hinged")),
            strict=True,
        )
    )
    turn = 3 * RADIUS / 2 / (stiffness * 1e6)
    assert moved == pytest.approx(0.5 * RADIUS * turn, rel=1e-10)
    assert slope == pytest.approx(sign * RADIUS * turn / LENGTH, rel=1e-10)
    matrix = twisted.reshape(18, 18)
    np.testing.assert_array_equal(matrix, matrix.T)


def test_planets_beside_the_middle_of_the_plates():
    """A force at a third of a hinged beam: Pa²b²/(3EIl)."""
    moved, _ = of_tangential_forces(plates(pin_ends="hinged", plate_offset_mm=LENGTH / 6))
    a, b = LENGTH / 3, 2 * LENGTH / 3
    bent = a**2 * b**2 / (3 * BENDING * LENGTH)
    assert moved == pytest.approx(bent + a * b / (LENGTH * SHEAR), rel=1e-12)


@pytest.mark.parametrize("suffix", [".csv", ".npy"])
def test_an_imported_matrix(tmp_path, suffix):
    matrix = plates().reshape(18, 18)
    path = tmp_path / f"carrier{suffix}"
    if suffix == ".npy":
        np.save(path, matrix)
    else:
        np.savetxt(path, matrix, delimiter=",", fmt="%.17g")
    table = Carrier(compliance_file=path.name)
    found = carrier_compliance(table, ANGLES, RADIUS, tmp_path)
    np.testing.assert_array_equal(found.reshape(18, 18), matrix)
    with pytest.raises(
        SceneError, match="24 rows of 24 numbers, 6 per planet, found 18 rows of 18"
    ):
        carrier_compliance(table, np.arange(4.0), RADIUS, tmp_path)
    with pytest.raises(SceneError, match=r"stage\.carrier\.compliance_file: expected a \.csv"):
        carrier_compliance(Carrier(compliance_file="none.csv"), ANGLES, RADIUS, tmp_path)


@pytest.mark.parametrize(
    ("change", "line"),
    [
        (np.diag([1e-6] * 17 + [-1e-6]), "a positive semidefinite matrix"),
        (np.triu(np.ones((18, 18))), "a symmetric matrix, found an asymmetric one"),
    ],
)
def test_refused_matrices(change, line):
    table = Carrier(compliance=tuple(map(tuple, change.tolist())))
    with pytest.raises(SceneError, match=line):
        table.check({}, "stage.carrier", 3)


@pytest.mark.parametrize(
    ("keys", "line"),
    [
        ({}, "stage.carrier: expected one of compliance, compliance_file and plate_distance_mm"),
        ({"plate_distance_mm": 40}, "stage.carrier.pin_diameter_mm: expected a value, beside"),
        (
            {"plate_distance_mm": 40, "pin_diameter_mm": 9, "plate_offset_mm": 20},
            "stage.carrier.plate_offset_mm: expected less than half",
        ),
        (
            {"plate_distance_mm": 40, "pin_diameter_mm": 9, "pin_bore_diameter_mm": 9},
            "stage.carrier.pin_bore_diameter_mm: expected less than stage.carrier.pin_diameter_mm",
        ),
        (
            {"plate_distance_mm": 40, "pin_diameter_mm": 9, "torque_end": "I"},
            "stage.carrier.torque_end: expected nothing without stage.carrier.torsional_stiffness",
        ),
        (
            {
                "plate_distance_mm": 40,
                "pin_diameter_mm": 9,
                "torsional_stiffness_Nm_per_mrad": 1.0,
            },
            "stage.carrier.torque_end: expected 'I' or 'II'",
        ),
        (
            {"compliance_file": "a.csv", "pin_diameter_mm": 9},
            "stage.carrier.pin_diameter_mm: expected nothing beside stage.carrier.compliance_file",
        ),
    ],
)
def test_refused_plates(keys, line):
    with pytest.raises(SceneError) as error:
        Carrier(**keys).check(keys, "stage.carrier", 3)
    assert line in str(error.value)
