"""Loads of the slices of the common face width, and the factors derived from them."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from flankload.base.card import Card
from flankload.base.read_only import KeepsReadOnly, frozen
from flankload.base.rounding import TIE
from flankload.base.torque import in_newton_metres

if TYPE_CHECKING:
    from flankload.base.arrays import Floats, Numbers


#: Part of the load below which a flank hardly touches: shares are known to half of that.
HARDLY_TOUCHES = 0.01


@dataclass(frozen=True, eq=False, repr=False)
class SliceLoads(KeepsReadOnly, Card):
    """Loads of J slices at P positions on S sites.

    Attributes
    ----------
    z_mm, width_mm : (J,) arrays
        Axial position of the middle of each slice, and its width.
    force_N : (P, S, J) array
        Force normal to the flank.
    peak_pressure_MPa : (P, S, J) array
    tangent_helix_base : float
        Tangent of the helix angle on the base cylinder of body 1, positive for a right hand.
    cosine_helix_base : float
        Part of a force normal to the flank that lies in the transverse section.
    line_load_length_mm : float
        Length over which mean line loads are means; slices that are longer count themselves.
    weights : (P,) array
        Parts of the positions in means over the period; their sum is 1.
    directions : (P, S, 2) array or None
        Transverse normals out of body 1 of the flanks of a spline, which carry all around the
        axis; None if all flanks push in nearly the same direction.
    coast_force_N : (P,) array or None
        Sum of the forces on the coast flanks, if they can carry load.
    """

    z_mm: Floats
    width_mm: Floats
    force_N: Floats
    peak_pressure_MPa: Floats
    tangent_helix_base: float
    cosine_helix_base: float
    line_load_length_mm: float
    weights: Floats
    directions: Floats | None = None
    coast_force_N: Floats | None = None
    #: Pictures over the width of teeth in mesh, of root stress, and of teeth all around.
    pictures: ClassVar[tuple[str, ...]] = ("line_load", "line_load_map", "contact_pattern")
    root_pictures: ClassVar[tuple[str, ...]] = ("root_stress", "root_stress_over_width")
    picture_all_around = "line_load_map"

    @property
    def enter_in_turn(self) -> bool:
        """Whether contact lines end in the flank, so that slices enter and leave contact in turn.

        Quantities of single contacts then jump from position to position.
        """
        return bool(self.tangent_helix_base) and self.z_mm.size > 1

    @cached_property
    def line_load_N_per_mm(self) -> Floats:
        """(P, S, J) Force per mm of face width, mean over each slice."""
        return frozen(self.force_N / self.width_mm)

    @cached_property
    def mean_line_load_N_per_mm(self) -> Floats:
        """(P, S, J) The larger mean over `line_load_length_mm` that begins or ends with the slice.

        It has a limit for narrower slices also at sharp ends, where line loads have none.
        """
        return frozen(mean_line_loads(self.force_N, self.width_mm, self.line_load_length_mm))

    @cached_property
    def relative_line_load(self) -> Floats:
        """(P, J) Mean line load summed over all flanks, divided by its mean over the face width.

        For a spline (P, S, J): line load of each tooth, divided by the mean of all teeth. 1 at
        positions without load.
        """
        return frozen(
            relative_line_loads(
                self.force_N, self.width_mm, self.line_load_length_mm, each=self._each
            )
        )

    @cached_property
    def relative_mean_line_load(self) -> Floats:
        """(J,) The same for the mean over the period; of a spline `relative_line_load`.

        If the positions do not cover the period, the mean is that over their range, or over single
        positions with equal weights. The teeth of a spline remain at their places, so that nothing
        passes along their flanks over which a mean could be taken.
        """
        if self._each:
            return self.relative_line_load
        return frozen(
            relative_mean_line_loads(
                self.force_N, self.width_mm, self.line_load_length_mm, self.weights
            )
        )

    @property
    def line_load_factor(self) -> float:
        """Largest of all positions and slices of `relative_line_load`."""
        return float(self.relative_line_load.max())

    @property
    def face_load_factor(self) -> float:
        """K_Hbeta (ISO 6336-1): largest of `relative_mean_line_load`."""
        return float(self.relative_mean_line_load.max())

    @property
    def _each(self) -> bool:
        """Whether line loads are those of single flanks: of splines."""
        return self.directions is not None

    @cached_property
    def flank_face_load_factor(self) -> Floats:
        """(P, S) Largest line load of a flank divided by its mean; 1 for an unloaded flank.

        NaN for a flank that hardly touches, whose contact line is only about to begin or end.
        """
        force = self.force_N.sum(axis=2)
        touches = force > HARDLY_TOUCHES * force.sum(axis=1, keepdims=True)
        factors = np.where(force > 0, np.nan, 1.0)
        largest = self.mean_line_load_N_per_mm.max(axis=2)
        np.divide(largest * self.width_mm.sum(), force, out=factors, where=touches)
        return frozen(factors)

    @cached_property
    def axial_force_N(self) -> Floats:
        """(P,) Axial component of the forces on body 1, positive along z."""
        # the normal out of body 1 leans by the base helix angle, on coast flanks the other way
        sine = self.tangent_helix_base * self.cosine_helix_base
        coast = 0.0 if self.coast_force_N is None else self.coast_force_N
        return frozen(sine * (self.force_N.sum(axis=(1, 2)) - coast))

    @cached_property
    def tilting_moment_Nm(self) -> Floats:
        """(P,) Moment of the transverse forces on working flanks about the middle of the width.

        Their lever arm is the axial distance; positive if more load is at larger z. Of a spline the
        magnitude of `tilting_moments_Nm`.
        """
        moments = self.tilting_moments_Nm
        if moments is not None:
            return frozen(np.hypot(*moments.T))
        middle = 0.5 * (self.z_mm[0] + self.z_mm[-1])
        transverse = self.cosine_helix_base * self.force_N.sum(axis=1)
        return frozen(in_newton_metres(transverse @ (self.z_mm - middle)))

    @cached_property
    def tilting_moments_Nm(self) -> Floats | None:
        """(P, 2) Moment on the hub of a spline about x and y, by the forces of the shaft.

        About the middle of the face width; None if the bodies are no spline.
        """
        if self.directions is None:
            return None
        middle = 0.5 * (self.z_mm[0] + self.z_mm[-1])
        along = in_newton_metres(self.force_N @ (self.z_mm - middle))
        normal_x, normal_y = np.moveaxis(self.directions, -1, 0)
        # (x, y, z) x F n, in the plane of x and y
        return frozen(np.stack([-(along * normal_y).sum(1), (along * normal_x).sum(1)], axis=1))

    def summary(self) -> dict[str, float]:
        """Entries of the summary of a result."""
        _, _, j = np.unravel_index(self.mean_line_load_N_per_mm.argmax(), self.force_N.shape)
        return {
            "face_load_factor": self.face_load_factor,
            "line_load_factor": self.line_load_factor,
            "line_load_length_mm": self.line_load_length_mm,
            "peak_line_load_z_mm": float(self.z_mm[j]),
            "axial_force_N": float(np.abs(self.axial_force_N).max()),
            "tilting_moment_Nm": float(np.abs(self.tilting_moment_Nm).max()),
        }

    def factor_of(self, which: slice) -> float | None:
        """K_Hbeta of some positions, which have equal parts in the mean; None in the plane."""
        force = self.force_N[which]
        return replace(self, force_N=force, weights=np.ones(len(force))).face_load_factor

    @property
    def per_width(self) -> Floats:
        """Line loads in the shape of results: (P, S, J), (P, S) in the plane."""
        return self.line_load_N_per_mm

    def at_sites(self, sites: Numbers) -> SliceLoads:
        """The same for some of the sites."""
        return replace(
            self,
            force_N=self.force_N[:, sites],
            peak_pressure_MPa=self.peak_pressure_MPa[:, sites],
            directions=None if self.directions is None else self.directions[:, sites],
        )


class PlaneLoads(SliceLoads):
    """Loads of the only slice of a plane result, over whose width nothing varies."""

    pictures = ()
    root_pictures = ("root_stress",)
    picture_all_around = "flank_pressure"

    @classmethod
    def of(cls, force_N: Floats, peak_pressure_MPa: Floats, face_width_mm: float) -> PlaneLoads:
        """Loads from those of the sites (P, S)."""
        return cls(
            z_mm=np.zeros(1),
            width_mm=np.full(1, face_width_mm),
            force_N=force_N[..., np.newaxis],
            peak_pressure_MPa=peak_pressure_MPa[..., np.newaxis],
            tangent_helix_base=0.0,
            cosine_helix_base=1.0,
            line_load_length_mm=face_width_mm,
            weights=np.full(len(force_N), 1.0 / len(force_N)),
        )

    def summary(self) -> dict[str, float]:
        """No entries."""
        return {}

    def factor_of(self, which: slice) -> None:
        """None."""

    @property
    def per_width(self) -> Floats:
        """(P, S) The line load."""
        return self.line_load_N_per_mm[..., 0]

    @cached_property
    def mean_line_load_N_per_mm(self) -> Floats:
        """(P, S, 1) The line load."""
        return self.line_load_N_per_mm

    @cached_property
    def relative_line_load(self) -> Floats:
        """(P, 1) Ones."""
        return frozen(np.ones((len(self.force_N), 1)))

    @cached_property
    def relative_mean_line_load(self) -> Floats:
        """(1,) One."""
        return frozen(np.ones(1))

    @cached_property
    def flank_face_load_factor(self) -> Floats:
        """(P, S) Ones."""
        return frozen(np.ones(self.force_N.shape[:2]))


def mean_line_loads(force_N: Floats, width_mm: Floats, length_mm: float) -> Floats:
    """Means (…, J) of the line load over a length, from forces (…, J) of slices of (J,) widths.

    The larger of the two means over the length that begins, and that ends, with a slice, both
    within the face width, and over the slice itself if that is longer: the largest one of all
    slices is then that of any place up to the change of the line load within a slice.
    """
    edges = np.concatenate([[0.0], np.cumsum(width_mm)])
    length = np.minimum(np.maximum(length_mm, width_mm), edges[-1])

    def beginning_at(low: Floats) -> Floats:
        low = np.clip(low, 0.0, edges[-1] - length)
        inside = np.minimum.outer(low + length, edges[1:]) - np.maximum.outer(low, edges[:-1])
        inside[inside < TIE * edges[-1]] = 0.0
        return np.asarray(force_N @ (inside / np.multiply.outer(length, width_mm)).T)

    return np.maximum(beginning_at(edges[:-1]), beginning_at(edges[1:] - length))


def relative_line_loads(
    force_N: Floats, width_mm: Floats, length_mm: float, *, each: bool = False
) -> Floats:
    """Mean line load divided by its mean over the face width at each position.

    Parameters
    ----------
    force_N : (P, S, J) array
    width_mm : (J,) array
        Widths of the slices.
    length_mm : float
        Length over which line loads are means.
    each : bool
        Line loads of single flanks, divided by the mean of all, instead of sums over the flanks.

    Returns
    -------
    (P, J) array, or (P, S, J) of single flanks
        1 at positions without load.
    """
    force = force_N if each else force_N.sum(axis=1)
    axes = tuple(range(1, force.ndim))
    total = force.sum(axis=axes, keepdims=True)
    flanks = force_N.shape[1] if each else 1
    relative = np.ones_like(force)
    loads = mean_line_loads(force, width_mm, length_mm)
    np.divide(flanks * width_mm.sum() * loads, total, out=relative, where=total > 0)
    return relative


def relative_mean_line_loads(
    force_N: Floats, width_mm: Floats, length_mm: float, weights: Floats
) -> Floats:
    """(J,) The same for the mean over positions with weights (P,); sums over the flanks."""
    mean = np.tensordot(weights, force_N, axes=1)
    return np.asarray(relative_line_loads(mean[np.newaxis], width_mm, length_mm)[0])
