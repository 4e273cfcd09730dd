"""Both bodies of a scene, built and put together: all that is known before elements are solved."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from flankload.bodies import Body, build_body
from flankload.bodies.profile_deviation import profile_deviation
from flankload.effects import Effects, effects_of
from flankload.errors import SceneError
from flankload.node_spacing import spacing_notes
from flankload.pairing import Pairing, pair_bodies
from flankload.resolution import Resolution, choose_resolution

#: Flanks in files that stay within this of their involute are not modified.
LEAST_DEVIATION_UM = 1e-3

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from flankload.scene import Scene


@dataclass(frozen=True)
class BodyPair:
    """Both bodies and how they stand to each other.

    Attributes
    ----------
    body_1, body_2 : Body
    pairing : Pairing
    resolution : Resolution
    effects : Effects
    position_rad : (P,) array
        Angles of body 1 from position zero.
    closed : bool
        The positions divide evenly a period after which all repeats (with pitch errors one tooth
        pitch is none).
    notes : tuple of str
        What a user must know of bodies and pair.
    """

    body_1: Body
    body_2: Body
    pairing: Pairing
    resolution: Resolution
    effects: Effects
    position_rad: NDArray[np.float64]
    closed: bool
    notes: tuple[str, ...]

    @property
    def turn_1(self) -> float:
        """Turn of body 1's frame at position zero, rad."""
        return self.pairing.turns_at_zero_rad[0]

    @property
    def turn_2(self) -> float:
        """Turn of body 2's frame at position zero, rad."""
        return self.pairing.turns_at_zero_rad[1]


def build_bodies(scene: Scene) -> BodyPair:
    """Bodies of a scene and their pairing; no finite elements are solved.

    Parameters
    ----------
    scene : Scene

    Returns
    -------
    BodyPair

    Raises
    ------
    SceneError
        If a body cannot be made or the pair cannot mesh; names file, key, expected and found.
    """
    resolution, effects = choose_resolution(scene), effects_of(scene)
    try:
        body_1, body_2 = (
            build_body(
                spec,
                key,
                folder=scene.folder,
                flank_element_mm=scene.accuracy.flank_element_mm,
                flank_element_parts=resolution.flank_element_parts,
            )
            for spec, key in ((scene.body_1, "body_1"), (scene.body_2, "body_2"))
        )
        position_rad, even = _positions(scene, 2 * np.pi / body_1.teeth)
        position_rad, alike = _without_copies(scene, position_rad)
        pairing = pair_bodies(
            body_1,
            body_2,
            center_distance_mm=scene.pair.axes_apart_mm,
            position_rad=position_rad,
        )
    except SceneError as error:
        if error.file is not None or scene.file is None:
            raise
        raise error.with_file(scene.file) from None
    # a compliance file may bring pitch errors and modified flanks along
    errors = (*body_1.pitch_errors_um, *body_2.pitch_errors_um)
    effects = replace(
        effects,
        pitch_errors=any(errors),
        flank_modifications=effects.flank_modifications
        or any(_is_modified_file(body) for body in (body_1, body_2)),
    )
    uneven = effects.pitch_errors or any((*body_1.flank_turns_rad, *body_2.flank_turns_rad))
    notes = (
        *(f"body_1: {note}" for note in body_1.notes),
        *(f"body_2: {note}" for note in body_2.notes),
        *spacing_notes((body_1, body_2), scene.torques_Nm, scene.pair.face_width_mm),
        *pairing.warnings,
        *alike,
    )
    return BodyPair(
        body_1=body_1,
        body_2=body_2,
        pairing=pairing,
        resolution=resolution,
        effects=effects,
        position_rad=position_rad,
        closed=even and position_rad.size > 1 and not uneven,
        notes=notes,
    )


def _is_modified_file(body: Body) -> bool:
    """Whether the flank in a compliance file departs from its involute."""
    profile = profile_deviation(body) if body.kind == "compliance" else None
    return profile is not None and (
        len(profile.marks) > 2 or float(np.abs(profile.deviation_um).max()) > LEAST_DEVIATION_UM
    )


def _positions(scene: Scene, period_rad: float) -> tuple[NDArray[np.float64], bool]:
    """Angles of body 1 (P,), and whether they divide one tooth pitch evenly."""
    wanted = scene.positions
    if wanted.angles_deg is not None:
        return np.radians(np.asarray(wanted.angles_deg, dtype=float)), False
    return period_rad * np.arange(wanted.count) / wanted.count, True


def _without_copies(
    scene: Scene, position_rad: NDArray[np.float64]
) -> tuple[NDArray[np.float64], tuple[str, ...]]:
    """Concentric splines stand the same at every position: of a count the first one suffices."""
    concentric = scene.body_1.kind == "spline_shaft" and scene.pair.axes_apart_mm == 0.0
    if not concentric or scene.positions.angles_deg is not None or position_rad.size == 1:
        return position_rad, ()
    note = (
        f"on common axes all positions are alike: one is computed, not {position_rad.size} "
        "(pair.center_offset_mm parts the axes)"
    )
    return position_rad[:1], (note,)
