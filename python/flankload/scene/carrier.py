"""The table of the carrier of a planetary stage (`[stage.carrier]`) and its rules."""

from collections.abc import Mapping
from typing import Annotated, Any, Literal

import numpy as np
from msgspec import Meta

from flankload.scene.refusal import refuse, shown
from flankload.scene.table import (
    USUAL_SIZE,
    Length,
    PoissonRatio,
    Table,
    Text,
    YoungModulus,
    about,
)

Entry = Annotated[float, Meta(ge=-1, le=1)]
Rows = Annotated[tuple[tuple[Entry, ...], ...], Meta(min_length=6)]
#: Keys of a carrier with two plates that are required, and the optional ones.
PLATES = ("plate_distance_mm", "pin_diameter_mm")
OPTIONAL_KEYS = (
    *("plate_offset_mm", "pin_bore_diameter_mm", "pin_ends", "torsional_stiffness_Nm_per_mrad"),
    *("torque_end", "young_modulus_MPa", "poisson_ratio"),
)
#: Largest asymmetry of a compliance, and negative eigenvalue, over its largest entry: digits of a
#: file.
ASYMMETRY = 1e-6
#: Meaning of a compliance.
COMPLIANCE = (
    "6 n rows of 6 n numbers for n planets: displacements and rotations (x, y, z) of each pin in "
    "the middle of its planet under forces (N) and moments (N mm) on all pins, planet after "
    "planet, in the frame of the carrier; rotations about z are ignored"
)


class Carrier(Table, frozen=True, kw_only=True):
    """An elastic carrier with its pins, by its compliance or as two plates."""

    compliance: Annotated[Rows | None, about(COMPLIANCE, "mm/N, rad/N, rad/(N mm)")] = None
    compliance_file: Annotated[
        Text | None,
        about(
            ".csv or .npy file with such rows, relative to the folder of the scene file, instead "
            "of compliance"
        ),
    ] = None
    plate_distance_mm: Annotated[
        Length | None,
        about(
            "distance of the middle of both plates that hold the ends of the pins",
            "mm",
            usual=USUAL_SIZE,
        ),
    ] = None
    plate_offset_mm: Annotated[
        float,
        Meta(ge=-1e5, le=1e5),
        about("axial position of the middle between both plates from that of the planets", "mm"),
    ] = 0.0
    pin_diameter_mm: Annotated[
        Length | None, about("diameter of the pins", "mm", usual=USUAL_SIZE)
    ] = None
    pin_bore_diameter_mm: Annotated[
        Length | None, about("diameter of the bore of hollow pins", "mm", usual=USUAL_SIZE)
    ] = None
    pin_ends: Annotated[
        Literal["clamped", "hinged"],
        about("'clamped': the ends of a pin do not tilt in the plates; 'hinged': they do"),
    ] = "clamped"
    torsional_stiffness_Nm_per_mrad: Annotated[
        Annotated[float, Meta(ge=1e-6, le=1e9)] | None,
        about(
            "torsional stiffness of the webs between both plates; absent = the plates do not turn "
            "relative to each other",
            "N m/mrad",
            usual=(1e-2, 1e6),
        ),
    ] = None
    torque_end: Annotated[
        Literal["I", "II"] | None,
        about(
            "plate from which the torque leaves the carrier, which is at rest (I: smaller z, II: "
            "larger z); required with a torsional stiffness"
        ),
    ] = None
    young_modulus_MPa: YoungModulus = 206000.0
    poisson_ratio: PoissonRatio = 0.3

    def check(self, given: Mapping[str, Any], key: str, planets: int) -> None:
        """Check that the carrier is described in one way, completely."""
        ways = ("compliance", "compliance_file", "plate_distance_mm")
        there = [name for name in ways if getattr(self, name) is not None]
        if len(there) != 1:
            found = " and ".join(there) or "nothing"
            refuse(key, "one of compliance, compliance_file and plate_distance_mm", found)
        if there[0] != "plate_distance_mm":
            for name in (*PLATES, *OPTIONAL_KEYS):
                if name in given:
                    refuse(f"{key}.{name}", f"nothing beside {key}.{there[0]}", shown(given[name]))
        if self.compliance is not None:
            check_compliance(self.compliance, planets, f"{key}.compliance")
        if there[0] == "plate_distance_mm":
            self._check_plates(key)

    def _check_plates(self, key: str) -> None:
        """Check the sizes of plates and pins."""
        for name in PLATES:
            if getattr(self, name) is None:
                refuse(f"{key}.{name}", f"a value, beside {key}.plate_distance_mm", None)
        assert self.plate_distance_mm is not None
        assert self.pin_diameter_mm is not None
        if 2.0 * abs(self.plate_offset_mm) >= self.plate_distance_mm:
            expected = f"less than half of {key}.plate_distance_mm: planets are between the plates"
            refuse(f"{key}.plate_offset_mm", expected, self.plate_offset_mm)
        if (self.pin_bore_diameter_mm or 0.0) >= self.pin_diameter_mm:
            expected = f"less than {key}.pin_diameter_mm ({self.pin_diameter_mm:g})"
            refuse(f"{key}.pin_bore_diameter_mm", expected, self.pin_bore_diameter_mm)
        twists, end = self.torsional_stiffness_Nm_per_mrad is not None, self.torque_end
        if twists and end is None:
            refuse(f"{key}.torque_end", f"'I' or 'II', with {key}.torsional_stiffness", None)
        if not twists and end is not None:
            expected = f"nothing without {key}.torsional_stiffness_Nm_per_mrad"
            refuse(f"{key}.torque_end", expected, shown(end))


def check_compliance(rows: Any, planets: int, key: str) -> None:
    """Check size, symmetry and sign of the compliance of a carrier."""
    wanted = f"{6 * planets} rows of {6 * planets} numbers, 6 per planet"
    lengths = {len(row) for row in rows}
    if len(rows) != 6 * planets or lengths != {6 * planets}:
        refuse(key, wanted, f"{len(rows)} rows of {', '.join(map(str, sorted(lengths)))}")
    matrix = np.array(rows, dtype=float)
    if not np.isfinite(matrix).all():
        refuse(key, "finite numbers", "others")
    size = np.sqrt(np.abs(np.diag(matrix)))
    scale = np.outer(size, size) + np.finfo(float).tiny
    if (np.abs(matrix - matrix.T) > ASYMMETRY * scale).any():
        refuse(key, "a symmetric matrix", "an asymmetric one")
    scaled = 0.5 * (matrix + matrix.T) / scale
    if (np.diag(matrix) < 0).any() or np.linalg.eigvalsh(scaled).min() < -ASYMMETRY:
        refuse(key, "a positive semidefinite matrix, since forces never do negative work", "none")
