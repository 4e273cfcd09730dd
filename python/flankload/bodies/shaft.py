"""A shaft on bearings: the compliance of its section at the gear, or a flexible beam in the bore.

The shaft is a round Timoshenko beam, to which the gear adds no stiffness. The unknowns are the
forces of the bearings and the motion of the section at which the beam is clamped. Its flexibility
is an integral over the steps, exact for any positions of bearings and gear, however close. A
flexible shaft fills the bore over its width; the parts outside of the bore, with their bearings,
act on both ends as condensed stiffnesses.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np

from flankload.base.gauss import leggauss
from flankload.base.read_only import KeepsReadOnly

if TYPE_CHECKING:
    from flankload.base.arrays import Flags, Floats
    from flankload.bodies.body import Material
    from flankload.scene import shaft as keys

    Extent = tuple[float, float]
    #: Axial stiffness; stiffness in a plane of bending: force/displacement, force/rotation,
    #: moment/rotation.
    Springs = tuple[float, float, float, float]

#: N/mm per N/um, and N mm/rad per N m/mrad.
PER_MM, PER_RAD = 1e3, 1e6


@dataclass(frozen=True)
class FlexibleShaft:
    """A round shaft that bends and twists in the bore of a body, which follows it.

    Attributes
    ----------
    range_mm : (float, float)
        Ends of the bore on the common axis direction z.
    radius_mm, inner_radius_mm : float
        Radius of the bore of the body, and of that of the shaft, 0 if it is solid.
    stiffness : (float, float, float, float)
        Extension E A (N), bending E I (N mm²), shear k G A (N) and torsion G I_p (N mm²) of the
        beam in the bore.
    beyond : two tuples of four floats
        Stiffness of the shaft beyond each end, with its bearings, at this end: axial (N/mm); in a
        plane of bending force per displacement (N/mm), force per rotation (N), moment per rotation
        (N mm).
    end_radii_mm : (float, float)
        Outer radius of the shaft just beyond each end; 0 if there is none.
    bearings : tuple of (z, radial, axial, tilt)
        Bearings within the width of the bore: mm, N/mm, N/mm, N mm/rad.
    axially_held : bool
        Whether a bearing resists axial forces.
    torque_end : "I", "II" or "even"
        Section at which the torque enters, whose rotation is that of the body; "even": the torque
        is distributed over the width, and the rotation is the mean.
    """

    range_mm: Extent
    radius_mm: float
    inner_radius_mm: float
    stiffness: tuple[float, float, float, float]
    beyond: tuple[Springs, Springs]
    end_radii_mm: tuple[float, float]
    bearings: tuple[tuple[float, float, float, float], ...]
    axially_held: bool
    torque_end: Literal["I", "II", "even"]


@dataclass(frozen=True, eq=False)
class Shaft(KeepsReadOnly):
    """A shaft and its bearings.

    Attributes
    ----------
    compliance : (6, 6) array
        Displacements and rotations of the section per force and moment there, mm/N, rad/N,
        rad/(N mm); symmetric, with zeros in row and column 6.
    z_mm : float
        Axial position of the section: the middle of the face width.
    bearing_loads : (B, 3, 6) array
        Force on each bearing per force and moment at the section, -, 1/mm; B = 0 for a shaft from a
        compliance.
    flexible : FlexibleShaft or None
        The shaft as a part of the elastic body, if it bends and twists under the teeth; the section
        then serves only the tilt and the bearing forces.
    """

    compliance: Floats
    z_mm: float
    bearing_loads: Floats
    flexible: FlexibleShaft | None = None


def build_shaft(table: keys.Shaft, z_mm: float) -> Shaft:
    """Shaft from its table, with the axial position of the middle of the face width, mm."""
    if table.compliance is not None:
        rows = np.array(table.compliance)
        return Shaft(0.5 * (rows + rows.T), z_mm, np.zeros((0, 3, 6)))
    gear = table.dimensions.gear_position_mm
    low = np.array(table.dimensions.bearing_positions_mm) < gear
    parts = [_part(table, gear, -1, low), _part(table, gear, 1, ~low)]
    bent = _inverse(parts[0].bending + parts[1].bending)
    # both planes: u_x' = theta_y, u_y' = -theta_x
    to_x, to_y = np.zeros((2, 6)), np.zeros((2, 6))
    to_x[[0, 1], [0, 4]] = 1.0
    to_y[[0, 1], [1, 3]] = 1.0, -1.0
    compliance = to_x.T @ bent @ to_x + to_y.T @ bent @ to_y
    forces = np.zeros((low.size, 3, 6))
    for part in parts:
        forces[part.bearings, 0] = part.radial_forces @ bent @ to_x
        forces[part.bearings, 1] = part.radial_forces @ bent @ to_y
    axial = parts[0].axial + parts[1].axial
    if axial:  # else there is no axial force
        compliance[2, 2] = 1.0 / axial
        for part in parts:
            forces[part.bearings, 2, 2] = part.axial_forces / axial
    return Shaft(0.5 * (compliance + compliance.T), z_mm, forces)


def flexible_shaft(
    table: keys.Shaft, middle_mm: float, range_mm: Extent, bore_diameter_mm: float
) -> FlexibleShaft:
    """The shaft in a bore, with `under_teeth = "flexible"`.

    The middle is that of the face width. Metal of the shaft outside the diameter of the bore
    belongs to the body. A bearing or a step at an end of the bore, up to the tolerance of
    positions, is that of the bore.
    """
    assert table.torque_end is not None
    shift = middle_mm - table.dimensions.gear_position_mm
    low, high = (end - shift for end in range_mm)
    places, stiffness = _bearings(table)
    below, above = (
        side * (places - end) > table.tolerance_mm for side, end in ((-1, low), (1, high))
    )
    inside = ~(below | above)
    modulus, shear_modulus = _moduli(table)
    inner = table.bore_diameter_mm or 0.0
    area, moment, sheared = round_section(np.array(bore_diameter_mm), inner, table.poisson_ratio)
    return FlexibleShaft(
        range_mm=range_mm,
        radius_mm=0.5 * bore_diameter_mm,
        inner_radius_mm=0.5 * inner,
        stiffness=(
            modulus * float(area),
            modulus * float(moment),
            shear_modulus * float(sheared),
            2.0 * shear_modulus * float(moment),
        ),
        beyond=(_part(table, low, -1, below).springs, _part(table, high, 1, above).springs),
        end_radii_mm=(_radius_beyond(table, low, -1), _radius_beyond(table, high, 1)),
        bearings=tuple(
            zip((places + shift)[inside].tolist(), *stiffness[:, inside].tolist(), strict=True)
        ),
        axially_held=bool(stiffness[1].any()),
        torque_end=table.torque_end,
    )


@dataclass(frozen=True, eq=False)
class _Part:
    """The part of a shaft on one side of a section, with its bearings.

    Attributes
    ----------
    bearings : (B,) array
        Which bearings of the shaft belong to the part; n of them.
    bending : (2, 2) array
        Force and moment on the section by its displacement and rotation in a plane of bending.
    axial : float
    radial_forces : (n, 2) array
        Forces of the bearings by displacement and rotation of the section.
    axial_forces : (n,) array
    """

    bearings: Flags
    bending: Floats
    axial: float
    radial_forces: Floats
    axial_forces: Floats

    @property
    def springs(self) -> Springs:
        """The stiffness as `FlexibleShaft.beyond` has it."""
        return self.axial, *self.bending[[0, 0, 1], [0, 1, 1]].tolist()


def _part(table: keys.Shaft, section_mm: float, side: int, bearings: Flags) -> _Part:
    """The part of a shaft on the side of smaller (-1) or larger z (1) of a section.

    The forces r of the springs k deflect the part, clamped at the section, by its flexibility F:
    (F + 1/k) r = H q under motions q of the section, which requires the forces H' r.
    """
    places, stiffness = _bearings(table)
    x, (radial, axial, tilt) = side * (places[bearings] - section_mm), stiffness[:, bearings]
    bent, pushed = _flexibility(table, section_mm, side, x)
    motions = np.zeros((2 * x.size, 2))  # displacement and rotation of each bearing, along x
    motions[::2, 0], motions[::2, 1], motions[1::2, 1] = 1.0, side * x, side
    forces = _spring_forces(bent, np.stack([radial, tilt], axis=1).ravel(), motions)
    along = _spring_forces(pushed, axial, np.ones((x.size, 1)))
    return _Part(bearings, motions.T @ forces, float(along.sum()), forces[::2], along[:, 0])


def _spring_forces(flexibility: Floats, stiffness: Floats, motions: Floats) -> Floats:
    """Forces (n, q) of springs, some of which may be 0: (F + 1/k) r = H."""
    forces, held = np.zeros_like(motions), stiffness > 0.0
    if held.any():
        own = flexibility[np.ix_(held, held)] + np.diag(1.0 / stiffness[held])
        forces[held] = _inverse(own) @ motions[held]
    return forces


def _flexibility(
    table: keys.Shaft, section_mm: float, side: int, x: Floats
) -> tuple[Floats, Floats]:
    """Flexibility of a shaft clamped at a section, at distances x (n,) from it on one side.

    Deflection and rotation under a force and a moment, (2n, 2n), and extension (n, n): over the
    distance s up to the nearer of both places,

        integral of m m'/(E I) + v v'/(k G A) ds, m = (x - s, 1), v = (1, 0)
        integral of 1/(E A) ds
    """
    sizes = table.dimensions
    ends = np.cumsum(sizes.lengths_mm)
    steps = side * (np.stack([ends - sizes.lengths_mm, ends])[::side] - section_mm)
    near, far = np.clip(
        steps[:, np.newaxis, np.newaxis], 0.0, np.minimum.outer(x, x)[..., np.newaxis]
    )
    points, weights = leggauss(2)  # exact for the square of an arm
    s = 0.5 * (near + far)[..., np.newaxis] + 0.5 * (far - near)[..., np.newaxis] * points
    ds = 0.5 * (far - near)[..., np.newaxis] * weights
    modulus, shear_modulus = _moduli(table)
    area, moment, sheared = round_section(
        np.array(sizes.diameters_mm), table.bore_diameter_mm or 0.0, table.poisson_ratio
    )
    moments = np.stack(np.broadcast_arrays(x[:, np.newaxis, np.newaxis, np.newaxis] - s, 1.0))
    found = np.einsum("aijeg,bjieg,ijeg,e->iajb", moments, moments, ds, 1.0 / (modulus * moment))
    found[:, 0, :, 0] += np.einsum("ijeg,e->ij", ds, 1.0 / (shear_modulus * sheared))
    stretched = np.einsum("ijeg,e->ij", ds, 1.0 / (modulus * area))
    return found.reshape(2 * x.size, 2 * x.size), stretched


def _bearings(table: keys.Shaft) -> tuple[Floats, Floats]:
    """Positions (B,) of the bearings, mm; radial, axial and tilting stiffness (3, B).

    In N/mm and N mm/rad.
    """
    sizes = table.dimensions
    none = (0.0,) * len(sizes.bearing_positions_mm)
    stiffness = np.array(
        [
            sizes.radial_stiffness_N_per_um,
            table.axial_stiffness_N_per_um or none,
            table.tilt_stiffness_Nm_per_mrad or none,
        ]
    )
    per_mm = np.array([[PER_MM], [PER_MM], [PER_RAD]])
    return np.array(sizes.bearing_positions_mm), stiffness * per_mm


def _moduli(table: keys.Shaft) -> tuple[float, float]:
    """Young's modulus and shear modulus, MPa."""
    return table.young_modulus_MPa, table.young_modulus_MPa / (2.0 * (1.0 + table.poisson_ratio))


def round_section(
    outer: Floats, inner: float, poisson_ratio: float
) -> tuple[Floats, Floats, Floats]:
    """Area, second moment of area and shear area (Cowper 1966) of hollow circles."""
    area = np.pi / 4.0 * (outer**2 - inner**2)
    moment = np.pi / 64.0 * (outer**4 - inner**4)
    nu, ratio = poisson_ratio, (inner / outer) ** 2
    whole = (1.0 + ratio) ** 2
    shear = 6.0 * (1.0 + nu) * whole / ((7.0 + 6.0 * nu) * whole + (20.0 + 12.0 * nu) * ratio)
    return area, moment, shear * area


def end_of_cantilever(
    material: Material, diameter_mm: float, length_mm: float, beyond_mm: float
) -> Floats:
    """(6, 6) Motion of a rigid end of a round cantilever along z by force and moment on it.

    At the distance `beyond_mm` from the end of the cantilever; without twist and axial strain. A
    cantilever of the length L has the deflections F (L³/(3 E I) + L/(k G A)) + M L²/(2 E I) and the
    slopes F L²/(2 E I) + M L/(E I).
    """
    _, moment, sheared = round_section(np.array(diameter_mm), 0.0, material.poisson_ratio)
    bending = material.young_modulus_MPa * float(moment)
    shear = material.shear_modulus_MPa * float(sheared)
    across = length_mm**2 / (2.0 * bending)
    own = np.array(
        [
            [length_mm**3 / (3.0 * bending) + length_mm / shear, across],
            [across, length_mm / bending],
        ]
    )
    moved = np.array([[1.0, beyond_mm], [0.0, 1.0]])
    own = moved @ own @ moved.T
    found = np.zeros((6, 6))
    # du_x/dz is the rotation about y, du_y/dz that about -x
    for first, second, sign in ((0, 4, 1.0), (1, 3, -1.0)):
        signs = np.array([1.0, sign])
        found[np.ix_((first, second), (first, second))] = signs[:, np.newaxis] * own * signs
    return found


def twist_of_shaft(material: Material, diameter_mm: float, length_mm: float) -> float:
    """Twist of a round shaft per torque, rad/(N mm)."""
    return length_mm / (material.shear_modulus_MPa * np.pi / 32.0 * diameter_mm**4)


def _radius_beyond(table: keys.Shaft, section_mm: float, side: int) -> float:
    """Outer radius just beyond a section, towards smaller (-1) or larger z (1); 0 at a free end."""
    ends = np.cumsum(table.dimensions.lengths_mm)
    beyond = section_mm + side * table.tolerance_mm
    if not 0.0 < beyond < ends[-1]:
        return 0.0
    return 0.5 * table.dimensions.diameters_mm[int(np.searchsorted(ends, beyond))]


def _inverse(matrix: Floats) -> Floats:
    """Inverse of a symmetric positive definite matrix, scaled to a unit diagonal; symmetric."""
    scale = 1.0 / np.sqrt(np.diag(matrix))
    both = np.outer(scale, scale)
    found = both * np.linalg.inv(matrix * both)
    return np.asarray(0.5 * (found + found.T))
