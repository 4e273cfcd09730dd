"""Contact pairs of a position, and the data for drawing the bodies."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Any, NamedTuple, TypeVar, overload

import numpy as np
from numpy.typing import NDArray

from flankload.base.card import Card
from flankload.base.rotation import all_around
from flankload.bodies.axial_shape import PLANE_SHAPE, AxialShape

if TYPE_CHECKING:
    from flankload.base.arrays import Floats, Numbers
    from flankload.bodies.profile_deviation import ProfileDeviation


@dataclass(frozen=True, eq=False, repr=False)
class PairPlaces(Card):
    """Places of n contact pairs, in the order of the core.

    Attributes
    ----------
    site : (n,) array
        Number of the flank pair.
    radius_mm : (n,) array
        Distance from the axis of body 1.
    arc_length_1_mm, arc_length_2_mm : (n,) arrays
        Places on both flank curves.
    x_mm, y_mm : (n,) arrays
        Place on undeformed flank 1, world frame (axis of body 1 at the origin, axis of body 2 on
        the positive x axis).
    normal_x, normal_y : (n,) arrays
        Unit normal out of body 1, world frame.
    """

    site: Numbers
    radius_mm: Floats
    arc_length_1_mm: Floats
    arc_length_2_mm: Floats
    x_mm: Floats
    y_mm: Floats
    normal_x: Floats
    normal_y: Floats

    def __len__(self) -> int:
        return len(self.site)

    @property
    def point_mm(self) -> Floats:
        """(n, 2) Places (x, y), world frame."""
        return np.column_stack([self.x_mm, self.y_mm])

    @property
    def normal(self) -> Floats:
        """(n, 2) Unit normals out of body 1, world frame."""
        return np.column_stack([self.normal_x, self.normal_y])


@dataclass(frozen=True, eq=False, repr=False)
class PairTable(PairPlaces):
    """Contact pairs of one position: their places, forces and gaps.

    Attributes
    ----------
    force_N, pressure_MPa : (n,) arrays
        Normal force on the pair's cell over the face width, and its mean pressure.
    gap_um : (n,) array
        Final gap along the normal.
    cell_mm : (n,) array
        Length of the pair's cell on the flank.
    half_width_mm : (n,) array or None
        Half-width of the contact if a pair represents a whole lumped contact; its cell is then π/2
        times as long and its pressure is the peak value of a Hertz contact.
    sliding_mm_per_rad : (n,) array or None
        Speed of flank 2 relative to flank 1, in the direction of increasing arc length of flank 1,
        per rad of the position; None without friction.
    friction_force_N : (n,) array or None
        Friction force on body 1 in the direction of increasing arc length of its flank; None
        without friction.
    z_mm : (n,) array or None
        Axial position of the pair's slice; None in a plane scene.
    """

    force_N: Floats
    pressure_MPa: Floats
    gap_um: Floats
    cell_mm: Floats
    sliding_mm_per_rad: Floats | None = None
    friction_force_N: Floats | None = None
    half_width_mm: Floats | None = None
    z_mm: Floats | None = None

    def columns(self) -> dict[str, NDArray[Any]]:
        """Columns by name, except those that are None."""
        every = {field.name: getattr(self, field.name) for field in fields(self)}
        return {name: column for name, column in every.items() if column is not None}


T = TypeVar("T")


class MadeWhenRead(Sequence[T]):
    """A sequence whose items are made by `item_of` when they are read."""

    def __init__(self, count: int, item_of: Callable[[int], T]) -> None:
        self._count = count
        self._item_of = item_of

    def __len__(self) -> int:
        return self._count

    @overload
    def __getitem__(self, index: int) -> T: ...

    @overload
    def __getitem__(self, index: slice) -> Sequence[T]: ...

    def __getitem__(self, index: int | slice) -> T | Sequence[T]:
        which = range(self._count)[index]
        if isinstance(which, range):
            return tuple(self._item_of(n) for n in which)
        return self._item_of(which)


class PairTables(MadeWhenRead[PairTable]):
    """The pair tables of all positions."""


class DrawnBody(NamedTuple):
    """A body in a drawing.

    Attributes
    ----------
    number : int
        1 or 2: the look of body 1 or body 2.
    outline : (k, 2) array
        Toothed contour of one sector in the body's frame, mm.
    teeth : int
    angle : (P,) array
        Rotation of its frame at each position, rad.
    hole_mm : float or None
        Radius at which it is fixed.
    center_mm : (2,) array
    """

    number: int
    outline: Floats
    teeth: int
    angle: Floats
    hole_mm: float | None
    center_mm: Floats


@dataclass(frozen=True, eq=False)
class PairDrawing:
    """Data for a drawing of the loaded pair in addition to the pair tables.

    Attributes
    ----------
    outline_1, outline_2 : (k, 2) arrays
        Toothed contour of one sector in the body's frame, from cut to cut, mm.
    teeth_1, teeth_2 : int
    center_distance_mm : float
    angle_1, angle_2 : (P,) arrays
        Rotation of both body frames at each position, rad.
    bore_radius_1_mm, bore_radius_2_mm : float or None
        Radius at which each body is fixed.
    profiles : two ProfileDeviation or None
        Profiles of the bodies' flanks, if an involute is known.
    active_roll_mm : two (float, float) or None
        Roll lengths between which the flanks meet, from geometry without load, mm.
    cam_turns_clockwise : bool or None
        For a cam; None for other bodies.
    axial : two AxialShape
        Face width and twist of three-dimensional bodies.
    tilted : bool
        Whether the axes of a spline are at an angle.
    between : tuple of DrawnBody
        Bodies between both, such as planets.
    """

    outline_1: Floats
    outline_2: Floats
    teeth_1: int
    teeth_2: int
    center_distance_mm: float
    angle_1: Floats
    angle_2: Floats
    bore_radius_1_mm: float | None = None
    bore_radius_2_mm: float | None = None
    profiles: tuple[ProfileDeviation | None, ProfileDeviation | None] = (None, None)
    active_roll_mm: tuple[tuple[float, float] | None, tuple[float, float] | None] = (None, None)
    cam_turns_clockwise: bool | None = None
    axial: tuple[AxialShape, AxialShape] = (PLANE_SHAPE, PLANE_SHAPE)
    tilted: bool = False
    between: tuple[DrawnBody, ...] = ()

    @property
    def bodies(self) -> tuple[DrawnBody, ...]:
        """All bodies: body 1, body 2, and those between them."""
        beside = np.array([self.center_distance_mm, 0.0])
        one = (1, self.outline_1, self.teeth_1, self.angle_1, self.bore_radius_1_mm)
        two = (2, self.outline_2, self.teeth_2, self.angle_2, self.bore_radius_2_mm)
        return (DrawnBody(*one, 0.0 * beside), DrawnBody(*two, beside), *self.between)

    def extent_mm(self, positions: Iterable[int]) -> tuple[Floats, Floats]:
        """Two corners (2,) of the rectangle around both bodies at all of these positions."""
        found = []
        for body in self.bodies:
            radius = np.hypot(*body.outline.T)
            # a tip is within half a pitch of each direction
            outer = body.outline[radius >= np.cos(np.pi / body.teeth) * radius.max()]
            turned = (all_around(outer, body.teeth, body.angle[p]) for p in positions)
            found += [body.center_mm + outline for outline in turned]
            found.append(body.center_mm + np.outer([-1.0, 1.0], [body.hole_mm or 0.0] * 2))
        every = np.concatenate(found)
        return every.min(axis=0), every.max(axis=0)

    @property
    def is_around(self) -> bool:
        """Whether body 2 surrounds body 1: it is fixed outside its teeth."""
        radius = self.bore_radius_2_mm
        return radius is not None and bool(radius > np.hypot(*self.outline_2.T).max())
