"""Result of one torque or of a list of torques at all positions, and derived quantities."""

from __future__ import annotations

from collections.abc import Mapping
from copy import copy
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Any

import numpy as np

from flankload.errors import InputError
from flankload.result.forms import ResultForms
from flankload.result.harmonics import over_positions
from flankload.result.loaded_positions import PairPositions
from flankload.result.optional_results import EffectResults
from flankload.result.summary import key_figures, summary
from flankload.result.torque_axis import per_torque
from flankload.result.torque_list import joined

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

#: Key figures of the short form, with the names of their estimates.
FIGURES = {
    "transmission_error_mean_um": "transmission_error_mean",
    "transmission_error_peak_to_peak_um": "transmission_error_peak_to_peak",
    "contact_ratio_under_load": "",
    "peak_pressure_MPa": "largest_pressure",
}


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class Result(EffectResults, ResultForms):
    """Load distribution at P positions on S sites (flank pairs), for one torque or a list.

    The result of a scene with a list of T torques follows these rules:

    - An array (P,) or (P, S) of one torque becomes (T, P) or (T, P, S), a number (T,). `sites` are
      those of all torques; a pair that a torque never loads has the values of an open pair there.
    - `position_rad`, the dimensions of the bodies and all else that no torque changes remain as
      they are.
    - `summary`, `key_figures` and `estimate` have the keys of one torque, with a tuple of T values
      each (None: no value).
    - `friction`, `slices`, `shafts`, `coast`, `drive`, `root_stress` and `pair_tables` are tuples
      of T objects, or None if there are none.
    - `warnings` are those of all torques without repetition; a warning that does not concern all of
      them names its torques. `cost` is that of the run, `outside_limits` are those of any torque.
    - `at(torque_Nm)` is the result of one torque. Its arrays are views of those of all torques
      if its pairs are consecutive ones of theirs.

    Attributes
    ----------
    name : str
        Name of the scene.
    torque_Nm : float
        Torque on body 1.
    sites : (S,) array
        Pair numbers: pair 0 is at the pitch point at position 0, greater numbers are further into
        recess.
    position_rad, rotation_rad : (P,) arrays
        Angle of body 1 (with a cam: of the cam) from position zero; additional rotation of body 1
        under load.
    reference_radius_mm, face_width_mm : float
        Radius that converts rotation into transmission error; face width.
    pitch_rad, period_rad : float
        One tooth pitch of body 1 (a turn of the cam); rotation of body 1 after which everything
        repeats.
    closed : bool
        Whether the ascending positions cover the period once from the first on: the last position
        is followed by the first, a period later.
    whole_circle : bool
        Whether the sites are all teeth of the bodies (splines), including unloaded ones.
    follower_angle_rad : (P,) array or None
        Angle of a follower on its cam without load, counter-clockwise from the line between both
        axes to the line through its axis and its roller's centre (along its flat). None for other
        pairs.
    site_force_N, peak_pressure_MPa : (P, S) arrays
        Force of each flank pair, 0 if open; largest pressure of each flank pair, 0 if open.
    stiffness_tangent_Nm_per_rad : (P,) array
        Derivative of the torque with respect to the rotation.
    status : (P,) array
        0 solved, 1 ill-conditioned, 2 degenerate, 3 uniqueness not certain.
    pair_tables : sequence of PairTable, one per position
    corner_contact : (P, S) array of bool
        Contact on a sharp corner, where no finite peak pressure exists.
    estimate : dict or None
        Estimated relative errors.
    cost : dict
        Seconds by stage and counters.
    unloaded_rotation_rad : (P,) array or None
        Rotation without torque, caused by deviations, offset, expansion and preload. None if no
        such state exists, and for chains and belts.
    accuracy : dict or None
        Report on a tolerance named by the scene: values of the discretization and their reasons.
    warnings : tuple of str
    slices : SliceLoads or None
        Loads of the slices of the face width; None in a plane scene.
    shafts : ShaftLoads or None
        Tilt of the teeth by shafts, forces on their bearings; None without shafts.
    outside_limits : tuple of str
        Premises of the model that the scene violates, with `effects.beyond_limits = true`; the
        error estimate, which also lists them, does not include the consequences.
    drawing : PairDrawing
    friction : FrictionResult or None
        Friction forces, losses, torque on body 2; None without friction.
    geometry : PairGeometry or None
        Positions and motion of the bodies; without it sliding and coast flanks are unknown.
    drive : ChainDrive, BeltDrive, StageLoads or None
        Tensions, places and margins of a chain or a belt; its sites are rollers, or teeth of the
        belt, with circumferential forces; pressures are 0. Of a planetary stage, also `stage`:
        load sharing, forces and orbits; its sites are the planets.
    root_readings : two RootReading or None
        Conversion of forces into stress in the tooth roots, if requested.
    coast : CoastContact or None
        Contact on the coast flanks, if they can carry load; everything else refers to working
        flanks.
    """

    estimate: Mapping[str, Any] | None
    cost: Mapping[str, Any]
    warnings: tuple[str, ...]
    accuracy: Mapping[str, Any] | None = None
    outside_limits: tuple[str, ...] = ()

    @classmethod
    def of_torques(cls, results: Sequence[Result]) -> Result:
        """Join the results of the torques of a list, even of a single one.

        Parameters
        ----------
        results : sequence of Result
            One per torque, at the same positions.

        Raises
        ------
        ValueError
            If there is no result, or the positions differ.
        """
        if not results:
            raise ValueError("results: expected one per torque, found none")
        for one in results:
            if not np.array_equal(one.position_rad, results[0].position_rad):
                raise ValueError("results: expected the same positions for all torques")
        results = tuple(copy(one) for one in results)  # their arrays become views
        found = object.__new__(cls)
        common = {field.name: getattr(results[0], field.name) for field in fields(PairPositions)}
        vars(found).update(common, _by_torque=results)
        for field in fields(cls):
            if field.name not in common:
                vars(found)[field.name] = found._over_torques(field.name)
        return found

    def _over_torques(self, name: str) -> Any:
        """An attribute of single torques over all torques; for the properties of this class."""
        return joined(self.by_torque, name)

    def mesh(self, planet: int, kind: str) -> Result:
        """Return the result of one mesh of a planetary stage.

        Parameters
        ----------
        planet : int
            Number of the planet, from 1.
        kind : {"sun", "ring"}
            The mesh with the sun, whose body 1 is the sun, or that with the ring, whose body 1 is
            the planet, in a mirror image in which it turns counter-clockwise.

        Returns
        -------
        Result
            Its positions are rotations of body 1 relative to the carrier from pair 0 at the pitch
            point. Its torque is that of equal planets; its transmission error is the approach of
            the flanks.

        Raises
        ------
        InputError
            If the result has no such mesh.
        """
        found = []
        for one in self.by_torque:
            if one.stage is None:
                expected = "mesh: expected the result of a planetary stage"
                raise InputError(f"{expected}, found that of a pair")
            found.append(one.stage.mesh(planet, kind))
        return type(self).of_torques(found) if self.has_torque_list else found[0]

    @per_torque
    def load_sharing_factor(self) -> float | None:
        """Largest load share of a pair times the mean number of loaded pairs.

        None if the positions do not cover the period. This is not the transverse load factor of ISO
        6336-1, which compares the largest load share with that of a pair without pitch errors.
        """
        over = over_positions(self)
        if not over.covers_period:
            return None
        return float(self.load_share.max() * over.mean_of_steps(self.loaded_pairs))

    @per_torque
    def key_figures(self) -> dict[str, Any]:
        """Part of the summary that follows from few curves: its entries up to the pressures."""
        return key_figures(self)

    @per_torque
    def summary(self) -> dict[str, Any]:
        """Summary of a report.

        `transmission_error_mean_um` (over the period; for uneven positions the integral of the
        curve through them), `transmission_error_by_load_mean_um` (the same minus the state without
        torque), `transmission_error_peak_to_peak_um` (of the positions);
        `transmission_error_harmonics_um` (amplitudes of the first five of the period),
        `transmission_error_mesh_harmonics_um` (the same of a tooth pitch: waves that pass once,
        twice, ... in a pitch) and `contact_ratio_under_load` (mean number of loaded pairs), None if
        the positions do not cover the period; `loaded_pairs_min`, `loaded_pairs_max`,
        `load_share_max` (largest load share of a pair);
        `peak_pressure_MPa` with `peak_pressure_position_rad`, `peak_pressure_pair` (the largest
        pressure off sharp corners; None if all contact is on sharp corners);
        `corner_pressure_MPa` with `corner_pressure_position_rad`, `corner_pressure_pair` (the
        largest on a sharp corner, which grows without limit on finer cells; None without such
        contact). In addition `contact_ratio_geometric` (path of contact divided by base
        pitch; None if unknown), `contact_ratio_usable` (the same between form circles and tip
        roundings or chamfers), `overlap_ratio` (0 of straight teeth) and `contact_ratio_total` (the
        sum of the geometric one and the overlap ratio), the means of both stiffnesses over the
        period,
        `peak_line_load_N_per_mm` with its position and pair, `largest_sliding_mm_per_rad`
        (magnitude) and `coast_flank_gap_min_um`; if requested, `root_stress_1` and `root_stress_2`
        with largest `tension` and `compression`; if coast flanks can carry load,
        `coast_flanks_loaded_min`, `coast_flanks_loaded_max` (numbers of them at once) and the
        largest `coast_force_N`, `coast_peak_pressure_MPa` and `coast_corner_pressure_MPa` with
        their positions and pairs. In three dimensions `face_load_factor`, `line_load_factor`,
        `line_load_length_mm` (over which these and the largest line load are means),
        `peak_line_load_z_mm` and the largest magnitudes `axial_force_N` and `tilting_moment_Nm`;
        with shafts `tilt_mean_um_per_mm` and the largest force on each bearing, and `k_h_beta_iso`
        for comparison if one bends under the
        teeth. With `effects.speed_rpm` `power_W` of the torque on body 1 and, with friction,
        `power_loss_W`, the mean over the period.
        """
        return summary(self)

    def _card_title(self) -> str:
        return f"Result {self.name!r}"

    def _card_lines(self) -> Iterator[tuple[str, str]]:
        """Torques, positions, key figures with their estimated errors."""
        every = self.by_torque
        yield "torque_Nm", ", ".join(f"{torque:.6g}" for torque in self.torques_Nm)
        yield "positions", _positions(every[0])
        yield "pairs", ", ".join(str(site) for site in sorted({s for r in every for s in r.sites}))
        for key, source in FIGURES.items():
            yield key, _figure(every, key, source)
        yield "warnings", f"{len(self.warnings)}{': see result.warnings' * bool(self.warnings)}"


def _positions(result: Result) -> str:
    """Number and range of the positions of body 1."""
    place = result.position_deg
    covered = ", over the whole period" if result.closed else ""
    where = f" from {place.min():.6g} to {place.max():.6g} deg{covered}" if place.size > 1 else ""
    return f"{place.size}{where}"


def _figure(results: Sequence[Result], key: str, source: str) -> str:
    """A key figure of each torque with its estimated error."""
    texts = []
    for one in results:
        value, error = one.key_figures[key], (one.estimate or {}).get(source)
        text = "unknown" if value is None else f"{value:.5g}"
        texts.append(text if error is None or value is None else f"{text} (+- {error:.1%})")
    return ", ".join(texts)
