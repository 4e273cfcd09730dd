"""Assembly of both bodies of a scene: all data known before finite elements are solved."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial
from math import radians
from typing import TYPE_CHECKING, Any

import numpy as np
from msgspec import structs

from flankload.bodies import Body, build_body
from flankload.bodies.imported.given import ModalCompliance
from flankload.bodies.profile_deviation import profile_deviation
from flankload.bodies.root_fillet import RootFillets, root_fillets
from flankload.errors import SceneError
from flankload.mechanisms.parts import made_once
from flankload.mechanisms.registry import require_flanks
from flankload.mechanisms.toggles import without_modifications
from flankload.pairing.body_pair import BodyPair
from flankload.pairing.common_height import common_height, tilt_notes
from flankload.pairing.expansion import growth_notes, growth_of
from flankload.pairing.friction import (
    coefficients_by_tooth,
    friction_notes,
    friction_of,
)
from flankload.pairing.node_spacing import spacing_for_loads, spacing_notes
from flankload.pairing.pairing import Pairing, pair_bodies
from flankload.pairing.period import Period, period_of
from flankload.pairing.slices import Slices, gap_by_misalignment, reached_positions, slices_of
from flankload.scene.axial import check_hands
from flankload.scene.discretization import (
    DEFAULT,
    Discretization,
    choose_discretization,
    elements_for_modes,
)
from flankload.scene.effects import Effects, effects_of
from flankload.scene.effects.rules import check_coast_kinds
from flankload.scene.usual import question_notes

#: Largest product of positions and flank pairs (each pitch adds a flank pair): the number of
#: entries that an array of the result may have.
MOST_NUMBERS = 1e7
#: Flanks from files that deviate from their involute by at most this amount are unmodified.
LEAST_DEVIATION_UM = 1e-3

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from flankload.bodies.axial_shape import AxialShape
    from flankload.mechanisms.parts import Parts
    from flankload.scene import BodySpec, Scene
    from flankload.scene.pair import Positions


def bodies_of(
    scene: Scene,
    discretization: Discretization,
    which: tuple[int, ...] = (0, 1),
    *,
    alike: tuple[Body, Body] | None = None,
    parts: Parts | None = None,
) -> tuple[Body, ...]:
    """Bodies of a scene, not yet paired.

    Parameters
    ----------
    which : tuple of int
        0 is body 1, 1 is body 2.
    alike : two Body, optional
        The same bodies at any discretization, if available: the spacing of the nodes that carry
        forces follows from their curves.
    parts : Parts, optional
        Of earlier runs.

    Raises
    ------
    SceneError
        If a body cannot be made; names file, key, expected and found.
    """
    require_flanks(scene)
    element_mm, nodes_mm = scene.accuracy.flank_element_mm, None
    try:
        if effects_of(scene).nodal_near_field:
            element_mm, nodes_mm = None, _nodes_mm(scene, discretization, alike, parts)
        bodies = tuple(
            _body(scene, discretization, z, (element_mm, nodes_mm), parts) for z in which
        )
        if effects_of(scene).nodal_near_field:
            for z, body in zip(which, bodies, strict=True):
                _check_nodes(body, f"body_{z + 1}")
        elif element_mm is None and (scene.accuracy.modes or 0) > DEFAULT.modes:
            bodies = tuple(
                _bearing(body, scene, discretization, z, parts)
                for z, body in zip(which, bodies, strict=True)
            )
        return bodies
    except SceneError as error:
        raise _with_file(error, scene) from None


def build_bodies(
    scene: Scene,
    discretization: Discretization | None = None,
    *,
    bodies: tuple[Body, Body] | None = None,
    groups: tuple[int, int] = (1, 1),
    parts: Parts | None = None,
) -> BodyPair:
    """Pair the bodies of a scene; no finite elements are solved.

    Parameters
    ----------
    discretization : Discretization, optional
        By default that of the scene.
    bodies : two Body, optional
        From `bodies_of`, if available.
    groups : (int, int)
        Number of teeth after which the compliance of each body repeats, if known.
    parts : Parts, optional
        Of earlier runs.

    Raises
    ------
    SceneError
        If a body cannot be made or the bodies cannot mesh; names file, key, expected and found.
    """
    discretization, effects = discretization or choose_discretization(scene), effects_of(scene)
    body_1, body_2 = bodies or bodies_of(scene, discretization, parts=parts)
    try:
        if effects.coast_flanks:
            check_coast_kinds(body_1.kind, body_2.kind)
        if not effects.tip_contact:
            body_1, body_2 = without_ends(body_1), without_ends(body_2)
        window = _window(scene, (body_1, body_2), groups)
        pairing = pair_bodies(
            body_1,
            body_2,
            center_distance_mm=scene.pair.axes_apart_mm,
            position_rad=reached_positions(window.position_rad, body_1),
            coast_flanks=effects.coast_flanks,
        )
        # coefficients may differ from tooth to tooth
        pairing = replace(pairing, period=window.period)
        friction = friction_of(scene, body_1, pairing)
        fillets = (_fillets(body_1, "body_1", effects), _fillets(body_2, "body_2", effects))
    except SceneError as error:
        raise _with_file(error, scene) from None
    several = window.position_rad.size > 1
    pair = BodyPair(
        body_1=body_1,
        body_2=body_2,
        pairing=pairing,
        discretization=discretization,
        effects=_with_effects_of_files(effects, (body_1, body_2)),
        position_rad=window.position_rad,
        pitches=window.pitches,
        closed=window.closed and several,
        adaptive=scene.positions.adaptive and several,
        notes=(),
        friction=friction,
        fillets=fillets,
        growth=growth_of(scene, pairing),
        slices=_slices(scene, (body_1, body_2), pairing),
    )
    return replace(pair, notes=_notes(scene, pair, window, groups))


def _with_effects_of_files(effects: Effects, bodies: tuple[Body, Body]) -> Effects:
    """Effects including those of compliance files: pitch errors and modified flanks."""
    return replace(
        effects,
        pitch_errors=any(bodies[0].pitch_errors_um) or any(bodies[1].pitch_errors_um),
        flank_modifications=effects.flank_modifications
        or any(_is_modified_file(body) for body in bodies),
    )


@dataclass(frozen=True)
class _Window:
    """Positions (P,) of a scene and the periods that they cover.

    `pitches` is None for single angles; `period` is that of the curves, `geometric` that of the
    geometry, `whole` that of geometry and compliance; `closed`: they cover whole periods.
    """

    position_rad: NDArray[np.float64]
    pitches: int | None
    period: Period
    geometric: Period
    whole: Period
    closed: bool
    notes: tuple[str, ...]


def _window(scene: Scene, bodies: tuple[Body, Body], groups: tuple[int, int]) -> _Window:
    """Positions of a scene."""
    geometric = period_of(*bodies, by_tooth=coefficients_by_tooth(scene, bodies[0]))
    whole = geometric.with_compliance(groups)
    pitches = _pitches(scene.positions, _reached(geometric, groups, bodies))
    period = geometric if _stands_for_all(scene.positions, pitches, geometric) else whole
    closed = pitches is not None and pitches % period.pitches == 0
    position_rad = _positions(scene.positions, period.pitch_rad, pitches, closed=closed)
    position_rad, notes = _without_copies(scene, position_rad)
    return _Window(position_rad, pitches, period, geometric, whole, closed, notes)


def _notes(
    scene: Scene, pair: BodyPair, window: _Window, groups: tuple[int, int]
) -> tuple[str, ...]:
    """Remarks on the bodies and the pair for the user."""
    bodies = (pair.body_1, pair.body_2)
    # in concentric splines the same teeth meet at every position: a window omits none
    pitches = None if scene.is_concentric else window.pitches
    return (
        *question_notes(scene),
        *(f"body_1: {note}" for note in pair.body_1.notes),
        *(f"body_2: {note}" for note in pair.body_2.notes),
        *spacing_notes(bodies, scene.torques_Nm, scene.pair.face_width_mm),
        *pair.pairing.warnings,
        *(
            []
            if pair.slices is None
            else tilt_notes(
                pair.pairing.fit, pair.slices.conforming, float(pair.slices.width_mm.sum())
            )
        ),
        *window.notes,
        *_beyond_window(pitches, window.geometric),
        *_beyond_teeth(pitches, window.whole, groups, bodies),
        *friction_notes(pair.friction, pair.pairing),
        *growth_notes(scene),
        *(
            f"body_{z}: rigid, so there is no stress in its roots"
            for z, body in enumerate(bodies, start=1)
            if pair.effects.root_stress and body.rigid
        ),
    )


def _slices(scene: Scene, bodies: tuple[Body, Body], pairing: Pairing) -> Slices | None:
    """Slices of the common face width; None in a plane scene."""
    one, two = (body.axial for body in bodies)
    if one is None or two is None:
        return None
    check_hands(one.hand_sign, two.hand_sign, inward=bodies[1].outward < 0)
    if pairing.fit is not None:
        return _coupling_slices(scene, bodies, (one, two))
    angles = scene.pair.inclination_um_per_mm, scene.pair.deviation_um_per_mm
    misalignment = 0.0
    if any(angles):
        if pairing.mesh is None:
            raise SceneError(
                key="pair.inclination_um_per_mm" if angles[0] else "pair.deviation_um_per_mm",
                expected="nothing, since a body without a profile has no pressure angle",
                found=angles[0] or angles[1],
            )
        misalignment = gap_by_misalignment(*angles, pairing.mesh.pressure_angle_rad)
    graded = scene.effects.contact == "pairs"
    return slices_of((one, two), scene.accuracy.slices, misalignment, graded=graded)


def _coupling_slices(
    scene: Scene, bodies: tuple[Body, Body], shapes: tuple[AxialShape, AxialShape]
) -> Slices:
    """Slices of a spline, with the tilt of its hub about the middle of the common width."""
    slices = slices_of(shapes, scene.accuracy.slices, 0.0)
    height = common_height(
        *bodies,
        offset_mm=scene.pair.axes_apart_mm,
        misalignment_rad=scene.pair.misalignment_mrad / 1000.0,
        direction_rad=radians(scene.pair.misalignment_direction_deg),
        middle_z_mm=0.5 * float(slices.edges_mm[0] + slices.edges_mm[-1]),
    )
    return replace(slices, conforming=height)


def _with_file(error: SceneError, scene: Scene) -> SceneError:
    """Add the scene's file to an error that names no file."""
    if error.file is not None or scene.file is None:
        return error
    return error.with_file(scene.file)


def _check_nodes(body: Body, key: str) -> None:
    """Refuse nodal forces for a body with imported pressure modes: its file has no nodal tables."""
    if isinstance(body.given, ModalCompliance):
        raise SceneError(
            key="effects.near_field",
            expected=f"'analytic', since {key}.file holds pressure modes: nodes that carry forces "
            f"come from elements, or from a matrix between nodes in {key}.file",
            found="'nodes'",
        )


def _nodes_mm(
    scene: Scene,
    discretization: Discretization,
    alike: tuple[Body, Body] | None,
    parts: Parts | None,
) -> float | None:
    """Spacing of the nodes that carry forces: named, or from the contact width of the curves."""
    if scene.accuracy.flank_element_mm is not None:
        return scene.accuracy.flank_element_mm
    if alike is None:
        alike = (
            _body(scene, discretization, 0, (None, None), parts),
            _body(scene, discretization, 1, (None, None), parts),
        )
    return spacing_for_loads(alike, scene.torques_Nm, scene.pair.face_width_mm)


def _bearing(
    body: Body, scene: Scene, discretization: Discretization, z: int, parts: Parts | None
) -> Body:
    """The body with flank elements fine enough for the named number of modes."""
    assert scene.accuracy.modes is not None
    wanted = elements_for_modes(scene.accuracy.modes)
    parametric = hasattr((scene.body_1, scene.body_2)[z], "module_mm")
    if not parametric or body.mesh is None or body.mesh.flank_elements >= wanted:
        return body
    low, high = body.mode_range_mm
    return _body(scene, discretization, z, (None, (high - low) / wanted), parts)


def _body(
    scene: Scene,
    discretization: Discretization,
    z: int,
    lengths_mm: tuple[float | None, float | None],
    parts: Parts | None,
) -> Body:
    """A body; lengths: of the flank's elements, and the distance of its nodes."""
    spec, key = (scene.body_1, scene.body_2)[z], f"body_{z + 1}"
    element_mm, nodes_mm = lengths_mm

    def built(spec: BodySpec) -> Body:
        call = partial(
            _built,
            _stamps(scene, key),
            spec,
            key,
            folder=scene.folder,
            flank_element_mm=element_mm,
            flank_element_parts=discretization.flank_element_parts,
            flank_nodes_mm=nodes_mm,
            pair_width_mm=scene.pair.face_width_mm if effects_of(scene).three_dimensions else None,
        )
        return made_once(call, parts)

    errors_um = () if spec.from_file else spec.pitch_errors_um
    if errors_um:  # they place the teeth of a body and change nothing else: others share it
        spec = structs.replace(spec, pitch_errors_um=())
    plain = without_modifications(spec) if scene.accuracy.unmodified_elements else spec
    if plain == spec or spec.rigid:
        own = built(spec)
    else:  # the flank alone: a rigid body has no mesh
        own, elements = built(structs.replace(spec, rigid=True)), built(plain)
        own = replace(own, rigid=False, mesh=elements.mesh, elements=elements)
    return replace(own, pitch_errors_um=tuple(errors_um)) if errors_um else own


def _built(stamps: tuple[tuple[int, int], ...], spec: BodySpec, key: str, **keys: Any) -> Body:
    """A body from its keys and from files with these stamps."""
    return build_body(spec, key, **keys)


def _stamps(scene: Scene, key: str) -> tuple[tuple[int, int], ...]:
    """Time of change and size of the files of a body, as far as they exist."""
    stamps = []
    for name, path in scene.files.items():
        if name.startswith(f"{key}."):
            with suppress(OSError, ValueError):  # whoever reads the file says what is wrong
                stat = path.stat()
                stamps.append((stat.st_mtime_ns, stat.st_size))
    return tuple(stamps)


def without_ends(body: Body) -> Body:
    """A body with contact on its active flanks only, not on tips and in fillets."""
    return replace(body, active_range_mm=body.curve.active_range)


def _fillets(body: Body, key: str, effects: Effects) -> RootFillets | None:
    """Root fillets of an elastic body, if their stress is requested."""
    if not effects.root_stress or body.rigid:
        return None
    return root_fillets(body.elements or body, key)


def _is_modified_file(body: Body) -> bool:
    """Whether the flank in a compliance file deviates from its involute."""
    profile = profile_deviation(body) if body.kind == "compliance" else None
    return profile is not None and (
        len(profile.marks) > 2 or float(np.abs(profile.deviation_um).max()) > LEAST_DEVIATION_UM
    )


def _pitches(wanted: Positions, period: Period) -> int | None:
    """Tooth pitches covered by the positions; None for single angles."""
    if wanted.angles_deg is not None:
        return None
    pitches = period.pitches if wanted.pitches == "hunting" else wanted.pitches
    per_pitch = wanted.count if not wanted.adaptive else wanted.most_per_pitch
    if per_pitch * pitches**2 > MOST_NUMBERS and pitches > 1:
        raise SceneError(
            key="positions.pitches",
            expected="so few pitches that positions times flank pairs, of which each pitch brings "
            f"a new one, stay below {MOST_NUMBERS:g}",
            found=f"{pitches} pitches of {per_pitch} positions",
        )
    return pitches


def _positions(
    wanted: Positions, pitch_rad: float, pitches: int | None, *, closed: bool
) -> NDArray[np.float64]:
    """Angles of body 1 (P,); adaptive ones include the end of a window that is not periodic."""
    if pitches is None:
        return np.radians(np.asarray(wanted.angles_deg, dtype=float))
    last = 1 if wanted.adaptive and not closed else 0
    return pitch_rad * np.arange(wanted.count * pitches + last) / wanted.count


def _stands_for_all(wanted: Positions, pitches: int | None, period: Period) -> bool:
    """Whether teeth that differ only in compliance count as equal.

    This holds for positions within one period of the geometry; more positions are only needed to
    resolve the differences.
    """
    if pitches is not None:
        return pitches == period.pitches
    angles = np.radians(np.asarray(wanted.angles_deg, dtype=float))
    return bool(np.ptp(angles) < period.rad * (1.0 + 1e-9))


def _reached(period: Period, groups: tuple[int, int], bodies: tuple[Body, Body]) -> Period:
    """Period that positions can cover: teeth without a flank in their file never carry load."""
    one, two = (
        1 if body.named_teeth else group for body, group in zip(bodies, groups, strict=True)
    )
    return period.with_compliance((one, two))


def _beyond_window(pitches: int | None, period: Period) -> tuple[str, ...]:
    """Note on the part of the period outside the window."""
    if pitches is None or pitches % period.pitches == 0:
        return ()
    pitch = "pitch" if pitches == 1 else "pitches"
    note = (
        f"teeth stand beside their place: the curves repeat after {period.pitches} pitches, these "
        f"positions run over {pitches} {pitch} (positions.pitches = 'hunting' for all)"
    )
    return (note,)


def _beyond_teeth(
    pitches: int | None, whole: Period, groups: tuple[int, int], bodies: tuple[Body, Body]
) -> tuple[str, ...]:
    """Note on teeth of different compliance outside the window."""
    if groups == (1, 1) or pitches is None or pitches % whole.pitches == 0:
        return ()
    unlike = [z for z in (0, 1) if groups[z] > 1]
    yielding = " and ".join(
        f"that of body_{z + 1} after {groups[z]} of {bodies[z].teeth} teeth" for z in unlike
    )
    cure = "positions.pitches = 'hunting' for all"
    for z in unlike:
        if bodies[z].named_teeth:
            cure = f"name the flanks of all teeth of body_{z + 1}, then {cure}"
    window = "one" if pitches == 1 else f"{pitches}"
    note = (
        f"the compliance does not repeat with the tooth, {yielding}: the curves repeat after "
        f"{whole.pitches} pitches, these positions run over {window}; their mean, peak to peak "
        f"and harmonics are not those of all teeth ({cure})"
    )
    return (note,)


def _without_copies(
    scene: Scene, position_rad: NDArray[np.float64]
) -> tuple[NDArray[np.float64], tuple[str, ...]]:
    """Positions without duplicates: concentric splines have the same state at every position."""
    if not scene.is_concentric or scene.positions.angles_deg is not None or position_rad.size == 1:
        return position_rad, ()
    note = (
        f"on common axes all positions are alike: one is computed, not {position_rad.size} "
        "(pair.center_offset_mm parts the axes)"
    )
    return position_rad[:1], (note,)
