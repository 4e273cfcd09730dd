"""How the bodies of a result touch: words, tables and pictures that depend on the kind of pair.

`engagement_of` is the only decision by kind; tables, plots and the report use the properties of the
engagement.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from math import atan2, degrees, hypot
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from flankload.base.text_table import MARK, NONE, number, text_table
from flankload.result.harmonics import over_positions

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator

    from flankload.base.arrays import Flags, Floats
    from flankload.result.optional_results import EffectResults
    from flankload.result.result import Result

#: Columns of a position and their units.
HEAD = ("position", "transm. error", "tangent stiffness", "secant stiffness")
UNITS = ("deg", "um", "N/um", "N/um")
FORMS = (".3f", ".3f", ".2f", ".2f")
#: Largest number of pairs with a column each; with more pairs a row lists the loaded ones.
MOST_COLUMNS = 8


class Engagement(ABC):
    """How two bodies touch, as far as the description, tables and plots of results depend on it."""

    #: Word for a site, and for several.
    words_for_sites: ClassVar[tuple[str, str]] = ("pair", "pairs")
    #: Name of the angle that the positions are, and of the body that has it, with sliding speeds.
    position_angle: ClassVar[str] = "angle of body 1"
    sliding_body: ClassVar[str] = "body 1"
    #: Whether a pair is at the place of the next one a pitch later; a cam has one pair.
    pairs_advance: ClassVar[bool] = True
    #: Whether a site has the same number at all positions, and its word in the names of columns.
    sites_stay: ClassVar[bool] = False
    site_word: ClassVar[str] = "pair"
    #: Label of the axis of a load map along which the pairs advance.
    way: ClassVar[str] = "place of the pair in mesh pitches from the pitch point"
    #: Whether the sites are all flanks there are, so that the first follows the last.
    cyclic_sites: ClassVar[bool] = False
    #: Whether the mesh excites vibration in multiples of its frequency.
    has_mesh_orders: ClassVar[bool] = False
    #: Whether contacts have a pressure, not only a force.
    has_pressures: ClassVar[bool] = True
    #: Whether a picture of the bodies shows the pressure on each flank, otherwise its force.
    draws_pressures: ClassVar[bool] = True
    #: Whether such a picture shows whole bodies, otherwise the surroundings of the contacts.
    draws_whole_bodies: ClassVar[bool] = True
    #: Number of bodies that it shows as outlines; None: all.
    drawn_bodies: ClassVar[int | None] = None
    #: Names of the plots that suit the results of several torques.
    over_torque: ClassVar[tuple[str, ...]] = ("torque_sweep",)

    @abstractmethod
    def rows(self, result: Result) -> Iterable[str]:
        """A table with a row per position; a further one of the sites if there are many."""

    @abstractmethod
    def own_pictures(self, result: Result) -> tuple[str, ...]:
        """Names of the plots that not every kind of pair has."""

    def pictures(self, result: Result) -> tuple[str, ...]:
        """Names of the plots that suit a result of one torque.

        Parameters
        ----------
        result : Result
            Result with this engagement; so are those of the other methods.

        Returns
        -------
        tuple of str
            Names in `flankload.plot.PICTURES`.
        """
        several, over = result.position_rad.size > 1, over_positions(result)
        spectrum = self.has_mesh_orders and over.covers_period and over.position_rad.size > 2
        own = self.own_pictures(result)
        stressed = any(stress is not None for stress in result.root_stress)
        return (
            *own,
            *["transmission_error_spectrum"] * (spectrum and "transmission_error" in own),
            *["load_map"] * (several and self.pairs_advance),
            *result.width_loads.root_pictures * stressed,
        )

    @property
    def marked_orders(self) -> range:
        """Orders of the mesh frequency that a spectrum marks."""
        return range(0)

    def drawn_force(self, result: Result, p: int, s: int) -> tuple[float, float, float]:
        """Polar angle, radius and direction of a force on body 2, for a drawing.

        Parameters
        ----------
        result : Result
        p, s : int
            Indices of the position and of the site, which carries load.

        Returns
        -------
        angle_rad, radius_mm, direction_rad : float
            The direction is an angle, too.
        """
        table = result.pairs(p)
        force = np.where(table.site == result.sites[s], table.force_N, 0.0)
        x, y = force @ table.point_mm / force.sum()
        across, up = force @ table.normal
        return atan2(y, x), hypot(x, y), atan2(up, across)

    def period_in_words(self, result: Result) -> str:
        """Range of positions that cover the period."""
        pitches = result.period_pitches
        number = "one pitch" if pitches == 1 else f"{pitches} pitches"
        return f"{number} of {result.pitch_deg:g} deg"

    def out_of_all(self, result: Result) -> str:
        """Number of sites, behind that of the loaded ones, if they are all that the bodies have."""
        return ""


class TeethInMesh(Engagement):
    """Teeth that pass through the mesh and carry load one after the other."""

    has_mesh_orders = True
    draws_whole_bodies = False

    def rows(self, result: Result) -> list[str]:
        """A row per position, with a column per pair or, if there are many, the loaded ones."""
        if result.sites.size > MOST_COLUMNS:
            return _rows_of_loaded(result)
        sites = range(result.sites.size)
        return rows_of_positions(
            result,
            [text for s in sites for text in (f"pair {result.sites[s]}", "")],
            ("share %", "MPa") * result.sites.size,
            lambda p: [text for s in sites for text in _share_and_pressure(result, p, s)],
        )

    def own_pictures(self, result: Result) -> tuple[str, ...]:
        several, loaded = result.position_rad.size > 1, result.torque_Nm > 0
        profiles = any(profile is not None for profile in result.drawing.profiles)
        return (
            "transmission_error",
            "load_sharing",
            "peak_pressure",
            *["pressure_over_diameter"] * (several and loaded and result.has_involute_path),
            "loaded_pair",
            *["flank_forces"] * (result.coast is not None),
            *["stiffness"] * loaded,
            *["profile_deviation"] * profiles,
            *result.width_loads.pictures * loaded,
        )


class TeethAllAround(Engagement):
    """Teeth that are all in contact with a fixed mate: splines and couplings."""

    words_for_sites = ("tooth", "teeth")
    way = "place of the tooth in pitches around the axis"
    cyclic_sites = True
    draws_pressures = False

    def rows(self, result: Result) -> list[str]:
        """A row per position, then one per tooth at the position of the largest force."""

        def cells(p: int) -> tuple[str, str, str]:
            s, loaded = int(np.argmax(result.site_force_N[p])), result.loaded_pairs[p]
            share = f"{100 * result.load_share[p, s]:.2f}"
            return f"{loaded}", share, f"{result.sites[s]}" if loaded else NONE

        heads, units = ("teeth loaded", "most on one", "at tooth"), ("", "share %", "")
        p = int(np.argmax(result.site_force_N.max(axis=1)))
        title = f"load per tooth at {degrees(result.position_rad[p]):.3f} deg"
        return [
            *rows_of_positions(result, heads, units, cells),
            "",
            title,
            *_rows_of_teeth(result, p),
        ]

    def own_pictures(self, result: Result) -> tuple[str, ...]:
        along, several = result.width_loads.picture_all_around, result.position_rad.size > 1
        return ("load_per_tooth", along, "loaded_pair", *["transmission_error"] * several)

    def out_of_all(self, result: Result) -> str:
        return f" of {result.sites.size} teeth carry load"


class FollowerOnCam(Engagement):
    """A follower with a single contact, which moves around the cam."""

    position_angle = "cam angle"
    sliding_body = "the cam, for a roller that does not rotate"
    pairs_advance = False
    cyclic_sites = True

    def rows(self, result: Result) -> list[str]:
        """A row per position."""
        follower = result.follower_angle_deg
        assert follower is not None
        return rows_of_positions(
            result,
            ("follower", "force", "pressure"),
            ("deg", "kN", "MPa"),
            lambda p: (f"{follower[p]:.3f}", *_of_site(result, p, 0)),
        )

    def own_pictures(self, result: Result) -> tuple[str, ...]:
        loaded = result.torque_Nm > 0
        names = ("transmission_error", "follower_motion", "peak_pressure", "loaded_pair")
        return (*names, *["stiffness"] * loaded)

    def period_in_words(self, result: Result) -> str:
        return "one turn of the cam"


_IN_MESH, _ALL_AROUND, _ON_CAM = TeethInMesh(), TeethAllAround(), FollowerOnCam()


def engagement_of(result: EffectResults) -> Engagement:
    """How the bodies of a result touch."""
    if result.drive is not None:
        return result.drive
    if result.has_cam:
        return _ON_CAM
    return _ALL_AROUND if result.whole_circle else _IN_MESH


def rows_of_positions(
    result: Result,
    heads: Iterable[str],
    units: Iterable[str],
    cells: Callable[[int], Iterable[str]],
) -> list[str]:
    """A row per position: transmission error and stiffnesses, then further cells."""
    numbers = zip(
        np.degrees(result.position_rad),
        result.transmission_error_um,
        result.stiffness_tangent_N_per_um,
        result.stiffness_secant_N_per_um,
        strict=True,
    )
    rows = [
        (*(number(*both) for both in zip(row, FORMS, strict=True)), *cells(p))
        for p, row in enumerate(numbers)
    ]
    return text_table([(*HEAD, *heads), (*UNITS, *units), *rows])


def _rows_of_loaded(result: Result) -> list[str]:
    """A row per position with the pairs that carry load there, out of many."""
    most = int(result.loaded_pairs.max())

    def cells(p: int) -> Iterator[str]:
        for s in np.flatnonzero(result.site_force_N[p] > 0).tolist():
            yield f"{result.sites[s]}"
            yield from _share_and_pressure(result, p, s)

    heads, units = ("pair that", "carries", ""), ("pair", "share %", "MPa")
    return rows_of_positions(result, heads * most, units * most, cells)


def _rows_of_teeth(result: Result, p: int) -> list[str]:
    """A row per tooth at a position."""
    coast = result.coast
    heads = ("", "coast", "pressure") if coast is not None else ()
    units = ("", "kN", "MPa") if coast is not None else ()
    rows: list[tuple[str, ...]] = [
        ("tooth", "force", "share", "pressure", *heads),
        ("", "kN", "%", "MPa", *units),
    ]
    for s, site in enumerate(result.sites):
        force, pressure = _of_site(result, p, s)
        share = _share_and_pressure(result, p, s)[0]
        beside: tuple[str, ...] = ()
        if coast is not None:
            values = coast.force_N, coast.peak_pressure_MPa, coast.corner_contact
            beside = ("", *_force_and_pressure(*values, p, s))
        rows.append((f"{site}", force, share, pressure, *beside))
    return text_table(rows)


def _share_and_pressure(result: Result, p: int, s: int) -> tuple[str, str]:
    pressure = _of_site(result, p, s)[1]
    return (NONE if pressure == NONE else f"{100 * result.load_share[p, s]:.2f}"), pressure


def _of_site(result: Result, p: int, s: int) -> tuple[str, str]:
    values = result.site_force_N, result.peak_pressure_MPa, result.corner_contact
    return _force_and_pressure(*values, p, s)


def _force_and_pressure(
    force_N: Floats, pressure_MPa: Floats, corner: Flags, p: int, s: int
) -> tuple[str, str]:
    """Force in kN and pressure in MPa, marked on a sharp corner; empty if unloaded."""
    if force_N[p, s] <= 0:
        return NONE, NONE
    mark = MARK * bool(corner[p, s])
    return f"{force_N[p, s] / 1e3:.3f}", f"{pressure_MPa[p, s]:.0f}{mark}"
