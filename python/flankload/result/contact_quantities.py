"""Quantities derived from the contact pairs of a result: contact width, sliding, coast side."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from flankload.base.read_only import KeepsReadOnly
from flankload.base.rounding import round_down, round_up
from flankload.result.flank_contact import FlankContacts, flank_contacts

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flankload.result.geometry import PairGeometry
    from flankload.result.pairs import PairTable
    from flankload.result.slices import SliceLoads

Floats = NDArray[np.float64]


class ContactQuantities(KeepsReadOnly):
    """Quantities of a `Result` that follow from its pair tables and the pair's geometry.

    They are computed on first use.
    """

    if TYPE_CHECKING:
        # fields of the result

        @property
        def sites(self) -> NDArray[np.int64]: ...
        @property
        def position_rad(self) -> Floats: ...
        @property
        def rotation_rad(self) -> Floats: ...
        @property
        def pitch_rad(self) -> float: ...
        @property
        def face_width_mm(self) -> float: ...
        @property
        def site_force_N(self) -> Floats: ...
        @property
        def pair_tables(self) -> Sequence[PairTable]: ...
        @property
        def geometry(self) -> PairGeometry | None: ...
        @property
        def slices(self) -> SliceLoads | None: ...

    @cached_property
    def potential_pairs(self) -> NDArray[np.int64]:
        """(P,) Number of pairs that could carry load.

        Those between the ends of the geometric path of contact, and those whose flanks would touch
        if they were rigid (their gap without load is less than the rotation, so that the core
        places cells on them).
        """
        path = None if self.geometry is None else self.geometry.path_pitches
        counts = []
        for place, table in zip(self.position_rad / self.pitch_rad, self.pair_tables, strict=True):
            could = set(table.site.tolist())
            if path is not None:
                # pair j is j pitches further along
                could |= set(range(round_up(path[0] - place), round_down(path[1] - place) + 1))
            counts.append(len(could))
        return frozen(np.array(counts))

    @cached_property
    def line_load_N_per_mm(self) -> Floats:
        """(P, S) Force of each pair per mm of face width; (P, S, J) in three dimensions."""
        if self.slices is not None:
            return self.slices.line_load_N_per_mm
        return frozen(self.site_force_N / self.face_width_mm)

    @cached_property
    def flank_contacts(self) -> FlankContacts:
        """Contact width of each pair, and motion of both bodies there."""
        return flank_contacts(self.pair_tables, self.sites, self.geometry)

    @property
    def contact_half_width_mm(self) -> Floats:
        """(P, S) Half the length of flank in contact, more accurate than one cell; NaN if open.

        A Hertz contact has b = sqrt(2 rho F c) with the line load F, the reduced radius rho and the
        sum c of 2 (1 - nu²)/(pi E) of both bodies (plane strain). In three dimensions the largest
        of all slices.
        """
        return self.flank_contacts.half_width_mm

    @property
    def sliding_mm_per_rad(self) -> Floats:
        """(P, S) Sliding (v_2 - v_1)·t_1, mean over each contact weighted by force; NaN if open.

        t_1 points to the tip of body 1. The value is per rad of body 1 in the sense of its torque:
        multiplied by its speed in rad/s it is in mm/s; if body 2 drives, that speed is negative.
        """
        return frozen(self.flank_contacts.velocity_2 - self.flank_contacts.velocity_1)

    @property
    def specific_sliding_1(self) -> Floats:
        """(P, S) 1 - v_2/v_1 (DIN 3960), v along the flank; NaN if open, or if v_1 is 0."""
        return _specific(self.flank_contacts.velocity_1, self.flank_contacts.velocity_2)

    @property
    def specific_sliding_2(self) -> Floats:
        """(P, S) 1 - v_1/v_2 (DIN 3960), v along the flank; NaN if open, or if v_2 is 0."""
        return _specific(self.flank_contacts.velocity_2, self.flank_contacts.velocity_1)

    @cached_property
    def coast_flank_gap_um(self) -> Floats | None:
        """(P,) Distance of the coast flanks along the line of action, um; None if not known.

        From geometry: body 1 has turned by the rotation, and flanks have their shape without load.
        Loaded teeth bend back by part of the rotation, so at least this distance minus the
        transmission error remains. The angle by which body 1 turns back when its torque reverses is
        this distance divided by its base radius.
        """
        if self.geometry is None or self.geometry.coast is None:
            return None
        coast = self.geometry.coast
        return frozen(1000.0 * coast.base_radius_mm * (coast.gap_rad + self.rotation_rad))


def frozen(array: NDArray[Any]) -> NDArray[Any]:
    """Make an array read-only and return it."""
    array.setflags(write=False)
    return array


def _specific(own: Floats, other: Floats) -> Floats:
    found = np.full_like(own, np.nan)
    np.divide(own - other, own, out=found, where=own != 0)
    return frozen(found)
