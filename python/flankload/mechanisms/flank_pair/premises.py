"""What a result rests on: a scene that breaks a premise is refused, or its result says so.

The model knows small deformations of bodies that touch on their working flanks. Each premise is one
record here, with the number up to which it holds. What geometry breaks is known before elements are
solved, what a load breaks after the sweep.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from flankload.errors import ContactError, NoContactState, PremiseError
from flankload.mechanisms.flank_pair.backlash import ROUNDING_UM, coast_overlap_um, key_of_backlash
from flankload.result.accuracy_lines import OUTSIDE
from flankload.scene.usual import questions

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence

    from numpy.typing import NDArray

    from flankload.contact.sweep import Sweep
    from flankload.pairing.body_pair import BodyPair
    from flankload.pairing.gear_pair import Mesh
    from flankload.result import Result
    from flankload.result.geometry import PairGeometry
    from flankload.scene import Scene

    Floats = NDArray[np.float64]

#: Parts of a torque without an answer that are tried, until one of them has one.
PARTS = tuple(0.25**k for k in range(1, 9))
#: A contact ratio less by that is 1.
ROUNDING = 1e-9


@dataclass(frozen=True)
class Premise:
    """What must hold.

    Attributes
    ----------
    name : str
        As `result.outside_limits` lists it.
    limit : float
    expected : str
        What is expected, with the limit.
    """

    name: str
    limit: float
    expected: str


#: With less there are positions at which a tip corner alone carries, whose pressure has no limit.
CONTACT_RATIO = Premise("contact_ratio", 1.0, "a contact ratio of at least 1")
#: Coast flanks that overlap carry, too.
BACKLASH = Premise(
    "backlash",
    0.0,
    "coast flanks that stay apart, since they carry nothing without effects.coast_flank = true",
)
#: Finite elements that follow the deformed shape differ by 1.1 % at 0.031 of a pitch, 0.1 of a
#: module, and by 1.9 % at twice as much.
DEFLECTION = Premise("deflection", 0.1, "flanks that give way by at most 0.1 of a module")
#: Where there is no module; of a cam's follower parts of a radian.
ROTATION = Premise(
    "rotation", 0.1, "body 1 to turn under load by at most 0.1 of a pitch, or of a radian"
)
#: Far beyond it strains are not small; metals yield at a hundredth, polymers at a tenth.
PRESSURE = Premise(
    "pressure", 0.5, "pressures of at most 0.5 of Young's modulus, that of the softer body"
)


@dataclass(frozen=True)
class Broken:
    """A premise that does not hold.

    Attributes
    ----------
    premise : Premise
    key : str
        To blame.
    found : str
        The number, in words.
    """

    premise: Premise
    key: str
    found: str

    def error(self, scene: Scene) -> PremiseError:
        """The refusal."""
        return PremiseError(
            file=scene.file,
            key=self.key,
            expected=f"{self.premise.expected} (or effects.beyond_limits = true)",
            found=self.found,
        )

    @property
    def note(self) -> str:
        """What the result says."""
        return f"{OUTSIDE}: {self.key}: expected {self.premise.expected}, found {self.found}"


def held(scene: Scene, broken: Sequence[Broken]) -> tuple[Broken, ...]:
    """Refuse what is broken, unless the scene wants to go on without.

    Parameters
    ----------
    scene : Scene
    broken : sequence of Broken

    Returns
    -------
    tuple of Broken

    Raises
    ------
    PremiseError
        Names the first of them.
    """
    if broken and not scene.effects.beyond_limits:
        raise broken[0].error(scene)
    return tuple(broken)


def marked(result: Result, broken: Sequence[Broken]) -> Result:
    """A result that says which premises it breaks: first of its warnings, and in its estimate.

    Parameters
    ----------
    result : Result
    broken : sequence of Broken

    Returns
    -------
    Result
    """
    if not broken:
        return result
    names, estimate = tuple(one.premise.name for one in broken), result.estimate
    if estimate is not None:
        estimate = {**estimate, "outside_limits": names}
    return replace(
        result,
        outside_limits=names,
        estimate=estimate,
        warnings=(*(one.note for one in broken), *result.warnings),
    )


# --- before elements are solved -------------------------------------------------------------------
def broken_by_geometry(pair: BodyPair) -> Iterator[Broken]:
    """What is broken whatever the load is.

    Parameters
    ----------
    pair : BodyPair

    Yields
    ------
    Broken
    """
    mesh = pair.pairing.mesh
    if mesh is None or _contact_ratio(mesh) >= CONTACT_RATIO.limit - ROUNDING:
        return
    yield Broken(
        CONTACT_RATIO,
        "pair.center_distance_mm",
        f"{_contact_ratio(mesh):.4g} on {pair.pairing.center_distance_mm:g} mm with these tip "
        "diameters",
    )


def _contact_ratio(mesh: Mesh) -> float:
    """The contact ratio that counts."""
    return mesh.contact_ratio


# --- after the sweep ------------------------------------------------------------------------------
def broken_by_load(
    scene: Scene,
    pair: BodyPair,
    geometry: PairGeometry,
    found: Sweep,
    number: int,
    *,
    part: float = 1.0,
) -> Iterator[Broken]:
    """What a torque breaks.

    Parameters
    ----------
    scene : Scene
    pair : BodyPair
        As its bodies have grown.
    geometry : PairGeometry
        At the positions of the sweep.
    found : Sweep
    number : int
        Of the torque.
    part : float
        Part of that torque of which the sweep is.

    Yields
    ------
    Broken
    """
    torque = Torque(scene, number, part)
    turned_rad = _finite(found.torque_Nmm * found.tangent_rad_per_Nmm)
    deflection_mm = turned_rad * pair.body_1.reference_radius_mm
    involute = pair.body_1.involute
    if involute is not None:
        module = 2.0 * involute.reference_radius_mm / pair.body_1.teeth
        if deflection_mm > DEFLECTION.limit * module:
            amount = f"{deflection_mm / module:.3g} of a module ({deflection_mm:.3g} mm)"
            yield torque.broken(DEFLECTION, amount)
    yield from broken_by_turn(turned_rad, pair.pairing.pitch_rad, torque)
    elastic = (body for body in (pair.body_1, pair.body_2) if not body.rigid)
    softer = [body.material.young_modulus_MPa for body in elastic]
    pressure = _peak_off_corners(found) / scene.pair.face_width_mm
    if softer and pressure > PRESSURE.limit * min(softer):
        amount = f"{pressure / min(softer):.3g} of {min(softer):g} MPa"
        yield torque.broken(PRESSURE, amount)
    # without torque nothing carries: the rotation is that of the working flanks by definition
    overlap_um = coast_overlap_um(pair, geometry, found) if found.torque_Nmm > 0.0 else 0.0
    if overlap_um > ROUNDING_UM:
        yield Broken(
            BACKLASH,
            key_of_backlash(scene),
            f"about {overlap_um:.3g} um of overlap {torque.under}",
        )


def blame_load(
    scene: Scene,
    pair: BodyPair,
    geometry: PairGeometry,
    error: ContactError,
    run: Callable[[float], tuple[Sweep, ...]],
) -> None:
    """Refuse a scene whose torque has no answer where a part of it breaks a premise already.

    Parameters
    ----------
    scene, pair, geometry
        As of `broken_by_load`.
    error : ContactError
        Why there is none; a proof that there is no state has another reason.
    run : callable
        Sweeps under one torque, N mm.

    Raises
    ------
    PremiseError
    """
    if isinstance(error, NoContactState) and error.proven:
        return
    torque_Nm = max(scene.torques_Nm)
    number = scene.torques_Nm.index(torque_Nm)
    for part in PARTS:
        try:
            (found,) = run(1000.0 * part * torque_Nm)
        except ContactError:
            continue
        held(scene, tuple(broken_by_load(scene, pair, geometry, found, number, part=part)))
        return


def broken_by_drive(scene: Scene, result: Result, number: int) -> Iterator[Broken]:
    """What a torque breaks on a chain or a belt, whose displacements are small ones.

    Parameters
    ----------
    scene : Scene
    result : Result
    number : int
        Of the torque.

    Yields
    ------
    Broken
    """
    if not scene.effects.large_displacement:
        stiffness = result.stiffness_tangent_Nm_per_rad
        with np.errstate(divide="ignore", invalid="ignore"):
            turned_rad = _finite(result.torque_Nm / stiffness)
        yield from broken_by_turn(turned_rad, result.pitch_rad, Torque(scene, number))


def broken_by_turn(turned_rad: float, pitch_rad: float, torque: Torque) -> Iterator[Broken]:
    """A body 1 that turns too far under load.

    Parameters
    ----------
    turned_rad, pitch_rad : float
    torque : Torque

    Yields
    ------
    Broken
    """
    unit = min(pitch_rad, 1.0)
    if turned_rad > ROTATION.limit * unit:
        of = "a pitch" if unit < 1.0 else "a radian"
        yield torque.broken(ROTATION, f"{turned_rad / unit:.3g} of {of}")


class Torque:
    """A torque of a scene, as a message names it."""

    def __init__(self, scene: Scene, number: int, part: float = 1.0) -> None:
        self._scene, self._number = scene, number
        whole = scene.torques_Nm[number]
        self.under = f"under {whole:g} N m"
        if part < 1.0:
            self.under = f"already under {part * whole:.3g} N m, a part of {whole:g} N m"

    def broken(self, premise: Premise, found: str) -> Broken:
        """Blame a modulus that is unusual, else the torque."""
        asked = questions(self._scene)
        for key in ("body_1.young_modulus_MPa", "body_2.young_modulus_MPa"):
            if key in asked:
                return Broken(premise, key, f"{found} {self.under}, with {asked[key]}")
        listed = f"[{self._number}]" if self._scene.has_torque_list else ""
        return Broken(premise, f"load.torque_Nm{listed}", f"{found} {self.under}")


def _finite(turned_rad: Floats) -> float:
    """The largest by which a torque turns body 1, at least: contacts get stiffer as it grows."""
    return float(np.max(turned_rad, where=np.isfinite(turned_rad), initial=0.0))


def _peak_off_corners(found: Sweep) -> float:
    """Largest pressure times face width, N/mm; on sharp corners it means nothing."""
    sites = [(found.site_peak_N_per_mm, found.site_corner)]
    if found.coast is not None:
        sites.append((found.coast.site_peak_N_per_mm, found.coast.site_corner))
    return max(float(np.max(peak, where=corner <= 0, initial=0.0)) for peak, corner in sites)
