"""The table of a shaft with its bearings (`[body_1.shaft]`) and its rules."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Annotated, Any, Literal, NamedTuple

import numpy as np
from msgspec import Meta

from flankload.scene.refusal import refuse, shown
from flankload.scene.table import USUAL_SIZE, Length, PoissonRatio, Table, YoungModulus, about

if TYPE_CHECKING:
    from flankload.base.arrays import Floats

#: Relative rounding error of numbers in a file; of positions on a shaft, over its length.
RELATIVE_ROUNDING = 1e-6
Entry = Annotated[float, Meta(ge=-1, le=1)]
Row = Annotated[tuple[Entry, ...], Meta(min_length=6, max_length=6)]
Rows = Annotated[tuple[Row, ...], Meta(min_length=6, max_length=6)]
Lengths = Annotated[tuple[Length, ...], Meta(min_length=1)]
Place = Annotated[float, Meta(ge=0, le=1e5)]
Stiffness = Annotated[float, Meta(ge=0, le=1e9)]
#: Optional keys of a shaft that is described by its dimensions.
OPTIONAL_KEYS = (
    *("bore_diameter_mm", "axial_stiffness_N_per_um", "tilt_stiffness_Nm_per_mrad"),
    *("young_modulus_MPa", "poisson_ratio", "under_teeth", "torque_end"),
)
#: Keys with one entry per bearing.
PER_BEARING = (
    "radial_stiffness_N_per_um",
    "axial_stiffness_N_per_um",
    "tilt_stiffness_Nm_per_mrad",
)


class Dimensions(NamedTuple):
    """Keys of a shaft that are required without a compliance."""

    diameters_mm: tuple[float, ...]
    lengths_mm: tuple[float, ...]
    gear_position_mm: float
    bearing_positions_mm: tuple[float, ...]
    radial_stiffness_N_per_um: tuple[float, ...]


class Shaft(Table, frozen=True, kw_only=True):
    """A round shaft on bearings, by its compliance or by its dimensions."""

    compliance: Annotated[
        Rows | None,
        about(
            "6 rows of 6 numbers: displacements and rotations (x, y, z) of the section in the "
            "middle of the face width under forces (N) and moments (N mm) there; x from axis 1 to "
            "axis 2, z along the axes; zeros in row and column 6, since the rotation about the "
            "axis is that of the drive",
            "mm/N, rad/N, rad/(N mm)",
        ),
    ] = None
    diameters_mm: Annotated[
        Lengths | None,
        about("outer diameters of the steps, in the order of z", "mm", usual=USUAL_SIZE),
    ] = None
    lengths_mm: Annotated[Lengths | None, about("lengths of the steps", "mm", usual=USUAL_SIZE)] = (
        None
    )
    bore_diameter_mm: Annotated[
        Length | None, about("diameter of the bore of a hollow shaft", "mm", usual=USUAL_SIZE)
    ] = None
    gear_position_mm: Annotated[
        Place | None,
        about(
            "distance of the middle of the face width from the end of the shaft of smaller z",
            "mm",
            usual=USUAL_SIZE,
        ),
    ] = None
    bearing_positions_mm: Annotated[
        Annotated[tuple[Place, ...], Meta(min_length=1)] | None,
        about("distances of the bearings from the same end", "mm", usual=USUAL_SIZE),
    ] = None
    radial_stiffness_N_per_um: Annotated[
        tuple[Stiffness, ...] | None,
        about("radial stiffness of each bearing", "N/um", usual=(0.1, 1e5)),
    ] = None
    axial_stiffness_N_per_um: Annotated[
        tuple[Stiffness, ...] | None,
        about("axial stiffness of each bearing; 0 = free", "N/um", usual=(0.1, 1e5)),
    ] = None
    tilt_stiffness_Nm_per_mrad: Annotated[
        tuple[Stiffness, ...] | None,
        about("tilting stiffness of each bearing; 0 = free", "N m/mrad", usual=(1e-3, 1e5)),
    ] = None
    young_modulus_MPa: YoungModulus = 206000.0
    poisson_ratio: PoissonRatio = 0.3
    under_teeth: Annotated[
        Literal["rigid", "flexible"],
        about(
            "flexible: the shaft bends and twists inside the bore, which follows it; rigid: the "
            "bore moves as a whole with the section in the middle of the face width"
        ),
    ] = "rigid"
    torque_end: Annotated[
        Literal["I", "II", "even"] | None,
        about(
            "end of the bore at which the torque enters (I: smaller z, II: larger z), whose "
            "rotation is that of the body; even: all over the bore; required with a flexible "
            "shaft"
        ),
    ] = None

    @property
    def dimensions(self) -> Dimensions:
        """The required keys of a shaft without a compliance."""
        return Dimensions(*(getattr(self, name) for name in Dimensions._fields))

    @property
    def is_flexible(self) -> bool:
        """Whether the shaft bends and twists under the teeth."""
        return self.under_teeth == "flexible"

    @property
    def tolerance_mm(self) -> float:
        """Rounding error of positions on the shaft: closer ones are equal where that matters."""
        return RELATIVE_ROUNDING * sum(self.dimensions.lengths_mm)

    def check(self, given: Mapping[str, Any], key: str, *, helical: bool) -> None:
        """Check that the shaft is complete and that its bearings hold it.

        `given`: keys that the scene sets; `helical`: whether the body has axial forces.
        """
        if self.compliance is not None:
            for name in (*Dimensions._fields, *OPTIONAL_KEYS):
                if name in given:
                    refuse(f"{key}.{name}", f"nothing beside {key}.compliance", shown(given[name]))
            _check_compliance(np.array(self.compliance), key)
            return
        for name in Dimensions._fields:
            if getattr(self, name) is None:
                refuse(f"{key}.{name}", f"a value, since there is no {key}.compliance", "nothing")
        self._check_sizes(key)
        self._check_places(key)
        self._check_bearings(key, helical=helical)
        if self.is_flexible and self.torque_end is None:
            expected = f"'I', 'II' or 'even', since {key}.under_teeth is 'flexible'"
            refuse(f"{key}.torque_end", expected, "nothing")
        if not self.is_flexible and self.torque_end is not None:
            expected = f"nothing, unless {key}.under_teeth is 'flexible'"
            refuse(f"{key}.torque_end", expected, shown(self.torque_end))

    def check_bore(
        self, ends_mm: tuple[float, float], diameter_mm: float, middle_mm: float, body: str
    ) -> None:
        """Check that a flexible shaft fills the bore over its width.

        Arguments are the ends and the diameter of the bore, the axial position of the middle of the
        face width, and "body_1" or "body_2".
        """
        sizes = self.dimensions
        key, bore = f"{body}.shaft", f"{body}.bore_diameter_mm ({diameter_mm:g})"
        low, high = (end - middle_mm + sizes.gear_position_mm for end in ends_mm)
        steps = np.concatenate([[0.0], np.cumsum(sizes.lengths_mm)])
        if low < -self.tolerance_mm or high > steps[-1] + self.tolerance_mm:
            refuse(
                f"{key}.gear_position_mm",
                f"a position at which the shaft ({steps[-1]:g} mm long) fills all of the bore",
                f"{sizes.gear_position_mm:g}: the bore is from {low:g} to {high:g} mm",
            )
        for k, diameter in enumerate(sizes.diameters_mm):
            start, end = low + self.tolerance_mm, high - self.tolerance_mm
            inside = steps[k] < end and start < steps[k + 1]
            if inside and diameter < (1.0 - RELATIVE_ROUNDING) * diameter_mm:
                expected = f"at least {bore}, which a flexible shaft fills"
                refuse(f"{key}.diameters_mm[{k}]", expected, diameter)
        if self.bore_diameter_mm is not None and self.bore_diameter_mm >= diameter_mm:
            refuse(f"{key}.bore_diameter_mm", f"less than {bore}", self.bore_diameter_mm)

    def _check_sizes(self, key: str) -> None:
        """Check the numbers of entries and the bore."""
        smallest = min(self.dimensions.diameters_mm)
        pairs = [("lengths_mm", "diameters_mm", "step")]
        pairs += [(name, "bearing_positions_mm", "bearing") for name in PER_BEARING]
        for name, other, what in pairs:
            count, values = len(getattr(self, other)), getattr(self, name)
            if values is not None and len(values) != count:
                expected = f"one entry per {what}: {count}, as in {key}.{other}"
                refuse(f"{key}.{name}", expected, f"{len(values)} entries")
        if self.bore_diameter_mm is not None and self.bore_diameter_mm >= smallest:
            expected = f"less than the smallest of {key}.diameters_mm ({smallest:g})"
            refuse(f"{key}.bore_diameter_mm", expected, self.bore_diameter_mm)

    def _check_places(self, key: str) -> None:
        """Check that the gear and the bearings are on the shaft."""
        sizes = self.dimensions
        end = sum(sizes.lengths_mm)
        places = {"gear_position_mm": sizes.gear_position_mm}
        for i, place in enumerate(sizes.bearing_positions_mm):
            places[f"bearing_positions_mm[{i}]"] = place
        for name, value in places.items():
            if value > end:
                expected = f"at most the length of the shaft, {end:g} (sum of {key}.lengths_mm)"
                refuse(f"{key}.{name}", expected, value)

    def _check_bearings(self, key: str, *, helical: bool) -> None:
        """Check that the bearings hold the shaft against forces and moments."""
        sizes = self.dimensions
        stiff = zip(sizes.bearing_positions_mm, sizes.radial_stiffness_N_per_um, strict=True)
        holding = [place for place, radial in stiff if radial > 0.0]
        tilts = any(self.tilt_stiffness_Nm_per_mrad or ())
        if not holding or (not tilts and max(holding) - min(holding) <= self.tolerance_mm):
            expected = "numbers > 0 for bearings at 2 positions at least, or for one with a "
            refuse(
                f"{key}.radial_stiffness_N_per_um",
                f"{expected}{key}.tilt_stiffness_Nm_per_mrad > 0: fewer do not hold the shaft",
                self.radial_stiffness_N_per_um,
            )
        if helical and not any(self.axial_stiffness_N_per_um or ()):
            refuse(
                f"{key}.axial_stiffness_N_per_um",
                "a number > 0 for one bearing at least: the axial force of the helix moves the "
                "shaft",
                self.axial_stiffness_N_per_um,
            )


def _check_compliance(rows: "Floats", key: str) -> None:
    """Check that a compliance is symmetric and positive semidefinite, without row and column 6."""
    for i, j in np.ndindex(6, 6):
        entry = f"{key}.compliance[{i}][{j}]"
        if 5 in (i, j) and rows[i, j]:
            expected = "0, since the rotation about the axis is that of the drive"
            refuse(entry, expected, float(rows[i, j]))
        scale = np.sqrt(abs(rows[i, i] * rows[j, j]))
        if abs(rows[i, j] - rows[j, i]) > RELATIVE_ROUNDING * scale:
            expected = f"{rows[j, i]:g}, as in [{j}][{i}]: a compliance is symmetric"
            refuse(entry, expected, float(rows[i, j]))
    scales = np.sqrt(np.abs(np.diag(rows)))
    unit = rows / np.outer(np.where(scales > 0, scales, 1.0), np.where(scales > 0, scales, 1.0))
    least = float(np.linalg.eigvalsh(0.5 * (unit + unit.T))[0])
    if least < -RELATIVE_ROUNDING:
        expected = "a matrix without negative eigenvalues, since loads never do negative work"
        refuse(f"{key}.compliance", expected, f"one of {least:.3g} relative to the diagonal")
