"""Assembly of both bodies of a scene: all data known before finite elements are solved."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from math import cos, radians, sin
from typing import TYPE_CHECKING

import numpy as np

from flankload.bodies import Body
from flankload.bodies.free_corner import forces_turn
from flankload.bodies.profile_deviation import profile_deviation
from flankload.bodies.root_fillet import RootFillets, root_fillets
from flankload.contact.flank_contact import FlankContact
from flankload.contact.sweep import sweep
from flankload.elasticity.compliance import no_compliance
from flankload.errors import SceneError
from flankload.mechanisms.flank_pair.mistakes import explained
from flankload.mechanisms.flank_pair.positions import positions_of
from flankload.mechanisms.flank_pair.rims import rim_notes
from flankload.mechanisms.scene_bodies import bodies_of, with_file_of
from flankload.pairing.body_pair import BodyJob, BodyPair
from flankload.pairing.common_height import common_height
from flankload.pairing.expansion import body_load_notes, body_loads_of
from flankload.pairing.friction import friction_notes, friction_of
from flankload.pairing.gear_mesh import GearMesh
from flankload.pairing.node_spacing import spacing_notes
from flankload.pairing.pairing import Pairing, pair_bodies
from flankload.pairing.slices import (
    Slices,
    gap_by_misalignment,
    plane_slice,
    reached_positions,
    slices_of,
)
from flankload.pairing.spline_fit import tilt_notes
from flankload.scene import MeshBody
from flankload.scene.axial import check_hands
from flankload.scene.discretization import Discretization, choose_discretization
from flankload.scene.effects import Effects, effects_of
from flankload.scene.effects.rules import check_coast_kinds
from flankload.scene.usual import question_notes

#: Largest distance between flanks with angles from files, relative to the pitch; a larger distance
#: indicates another tooth or centre distance.
LARGEST_FLANK_DISTANCE = 0.25
#: Largest relative difference of the leads per tooth of bodies from files: that of helix angles
#: that differ by 1e-6 degrees.
LEAD = 1e-6
#: Least deviation from the involute of a modified flank from a file, um.
LEAST_DEVIATION_UM = 1e-3

if TYPE_CHECKING:
    from flankload.bodies.axial_shape import AxialShape
    from flankload.cost import Account
    from flankload.mechanisms.reuse import Parts
    from flankload.scene import Scene


def build_bodies(
    scene: Scene,
    discretization: Discretization | None = None,
    *,
    bodies: tuple[Body, Body] | None = None,
    groups: tuple[int, int] = (1, 1),
    parts: Parts | None = None,
    modified_elements: bool = False,
) -> BodyPair:
    """Pair the bodies of a scene; no finite elements are solved.

    Parameters
    ----------
    discretization, bodies, parts : optional
        By default that of the scene; from `bodies_of`; of earlier runs.
    groups : (int, int)
        Number of teeth after which the compliance of each body repeats, if known.
    modified_elements : bool
        Whether elements follow the modified flanks, for another program.

    Raises
    ------
    SceneError
        If a body cannot be made or the bodies cannot mesh; names file, key, expected and found.
    """
    discretization = discretization or choose_discretization(scene)
    made = partial(bodies_of, parts=parts, modified_elements=modified_elements)

    def paired(scene: Scene) -> BodyPair:
        one, two = made(scene, discretization)
        return _paired(scene, discretization, (one, two), groups)

    try:
        return _paired(scene, discretization, bodies, groups) if bodies else paired(scene)
    except SceneError as error:
        raise explained(error, scene, paired) from None


def _paired(
    scene: Scene, discretization: Discretization, bodies: tuple[Body, Body], groups: tuple[int, int]
) -> BodyPair:
    """As `build_bodies`, without a search for the mistake in an impossible scene."""
    effects, (one, two) = effects_of(scene), bodies
    try:
        if effects.coast_flanks:
            check_coast_kinds(one.kind, two.kind)
        if not effects.tip_contact:
            one, two = without_ends(one), without_ends(two)
        window = positions_of(scene, (one, two), groups)
        pairing = pair_bodies(
            one,
            two,
            center_distance_mm=scene.pair.axes_apart_mm,
            position_rad=reached_positions(window.position_rad, one),
            coast_flanks=effects.coast_flanks or (scene.effects.beyond_limits and one.conforms),
        )
        # influence coefficients may differ between teeth
        coast = pairing.coast if effects.coast_flanks else None
        pairing = replace(pairing, period=window.period, coast=coast)
        friction = friction_of(scene, one, pairing)
        fillets = (fillets_of(one, "body_1", effects), fillets_of(two, "body_2", effects))
    except SceneError as error:
        raise with_file_of(scene, error) from None
    loads = body_loads_of(scene, pairing)
    turns = forces_turn((one, two))
    pair = BodyPair(
        bodies=(one, two),
        pairing=pairing,
        slices=_slices(scene, (one, two), pairing),
        friction=friction,
        jobs=(
            BodyJob(effects.elastic_body_1, fillets[0], loads[0], turns=turns),
            BodyJob(effects.elastic_body_2, fillets[1], loads[1], turns=turns),
        ),
        discretization=discretization,
        effects=_with_effects_of_files(effects, (one, two)),
        position_rad=window.position_rad,
        pitches=window.pitches,
        closed=window.closed,
        adaptive=scene.positions.adaptive and window.position_rad.size > 1,
        notes=(),
    )
    return replace(pair, notes=_notes(scene, pair, window.notes))


def _with_effects_of_files(effects: Effects, bodies: tuple[Body, Body]) -> Effects:
    """Effects including those of compliance files: pitch errors and modified flanks."""
    return replace(
        effects,
        pitch_errors=any(any(body.pitch_errors_um) for body in bodies),
        flank_modifications=effects.flank_modifications or any(map(_is_modified_file, bodies)),
    )


def _notes(scene: Scene, pair: BodyPair, window_notes: tuple[str, ...]) -> tuple[str, ...]:
    """Remarks on the bodies and the pair for the user."""
    return (
        *question_notes(scene),
        *(f"body_1: {note}" for note in pair.body_1.notes),
        *(f"body_2: {note}" for note in pair.body_2.notes),
        *rim_notes(pair.names, pair.bodies),
        *spacing_notes(pair.bodies, scene.torques_Nmm, pair.face_width_mm),
        *pair.pairing.warnings,
        *(() if pair.pairing.coast else tilt_notes(pair.pairing.fit, pair.slices)),
        *window_notes,
        *friction_notes(pair.friction, pair.pairing, pair.slices),
        *body_load_notes(scene),
        *(
            f"body_{z}: rigid, so there is no stress in its roots"
            for z, body in enumerate(pair.bodies, start=1)
            if pair.effects.root_stress and body.rigid
        ),
    )


def _slices(scene: Scene, bodies: tuple[Body, Body], pairing: Pairing) -> Slices:
    """Slices of the common face width; the only one of a plane scene."""
    one, two = (body.axial for body in bodies)
    if one.plane:
        return plane_slice(scene.pair.face_width_mm)
    _check_lead(scene, bodies)
    try:
        check_hands(one.hand_sign, two.hand_sign, inward=bodies[1].outward < 0)
    except SceneError as error:
        raise with_file_of(scene, error) from None
    if pairing.fit is not None:
        return _coupling_slices(scene, bodies, (one, two))
    angles = scene.pair.inclination_um_per_mm, scene.pair.deviation_um_per_mm
    misalignment = (0.0, 0.0)
    if any(angles):
        if pairing.gear_geometry is None:
            raise SceneError(
                key="pair.inclination_um_per_mm" if angles[0] else "pair.deviation_um_per_mm",
                expected="nothing, since a body without a profile has no pressure angle",
                found=angles[0] or angles[1],
            )
        pressure_angle = pairing.gear_geometry.pressure_angle_rad
        # in the mirror image about the line of centres, axis 2 deviates to the other side
        misalignment = (
            gap_by_misalignment(*angles, pressure_angle),
            gap_by_misalignment(angles[0], -angles[1], pressure_angle),
        )
    return slices_of_mesh(scene, (one, two), misalignment)


def _check_lead(scene: Scene, bodies: tuple[Body, Body]) -> None:
    """Check that helices from compliance files have the same lead per tooth."""
    one, two = bodies
    expected = -two.outward * one.axial.twist_rad_per_mm * one.teeth / two.teeth
    found = two.axial.twist_rad_per_mm
    for name in ("body_2", "body_1"):
        if getattr(scene, name).brings_compliance and abs(found - expected) > LEAD * abs(expected):
            raise SceneError(
                file=scene.file,
                key=f"{name}.file",
                expected=f"a pair of helices that turn body_2 by {expected:.8g} rad/mm (parallel "
                "axes)",
                found=f"{found:.8g}",
            )


def slices_of_mesh(
    scene: Scene, shapes: tuple[AxialShape, AxialShape], misalignment: tuple[float, float] = (0, 0)
) -> Slices:
    """Slices of a gear mesh of a scene; the only one of plane bodies."""
    if shapes[0].plane:
        return plane_slice(scene.pair.face_width_mm)
    return slices_of(
        shapes,
        scene.accuracy.slices,
        misalignment,
        graded=scene.effects.contact == "pairs",
        line_load_mm=scene.accuracy.line_load_length_mm,
    )


def _coupling_slices(
    scene: Scene, bodies: tuple[Body, Body], shapes: tuple[AxialShape, AxialShape]
) -> Slices:
    """Slices of a spline, with the tilt of its hub about the middle of the common width."""
    slices = slices_of(
        shapes, scene.accuracy.slices, line_load_mm=scene.accuracy.line_load_length_mm
    )
    direction = radians(scene.pair.misalignment_direction_deg)
    height = common_height(
        *bodies,
        tilt=scene.pair.misalignment_mrad / 1000.0 * np.array([cos(direction), sin(direction)]),
        middle_z_mm=0.5 * float(slices.edges_mm[0] + slices.edges_mm[-1]),
    )
    return replace(slices, conforming=height)


def without_ends(body: Body) -> Body:
    """A body with contact on its active flanks only, not on tips and in fillets."""
    return replace(body, active_range_mm=body.curve.active_range)


def fillets_of(body: Body, key: str, effects: Effects) -> RootFillets | None:
    """Root fillets of an elastic body, if their stress is requested."""
    if not effects.root_stress or body.rigid:
        return None
    return root_fillets(body.unmodified, key)


def _is_modified_file(body: Body) -> bool:
    """Whether the flank in a compliance file deviates from its involute."""
    profile = profile_deviation(body) if body.kind == "compliance" else None
    return profile is not None and (
        len(profile.marks) > 2 or float(np.abs(profile.deviation_um).max()) > LEAST_DEVIATION_UM
    )


# --- flanks with positions from files -------------------------------------------------------------
def with_flank_distance(scene: Scene, pair: BodyPair, account: Account) -> BodyPair:
    """Add a note on the distance between flanks whose positions come from files.

    The unloaded state is counted in the account. Raises SceneError if the flanks are too far apart.
    """
    if pair.body_1.flank_angle_known and pair.body_2.flank_angle_known:
        return pair
    rigid = (no_compliance(pair.body_1), no_compliance(pair.body_2))
    section = GearMesh(pair.bodies, pair.pairing, plane_slice(pair.face_width_mm))
    contact = FlankContact(section, rigid, pair.discretization.grid)
    (unloaded,) = sweep(contact, pair.position_rad[:1], [0.0], account=account)
    radius = pair.body_1.reference_radius_mm
    gap_mm = float(unloaded.rotation_rad[0]) * radius
    apart = "overlap by" if gap_mm < 0 else "stand apart by"
    if abs(gap_mm) > LARGEST_FLANK_DISTANCE * pair.pairing.pitch_rad * radius:
        _blame_flank(scene, pair, f"{apart} {abs(gap_mm):.3f} mm")
        raise SceneError(
            file=scene.file,
            key="pair.center_distance_mm",
            expected="bodies whose flanks nearly touch (within a quarter pitch) at the angles of "
            "their files",
            found=f"{scene.pair.axes_apart_mm:g} mm, where they {apart} {abs(gap_mm):.3f} mm",
        )
    note = (
        f"at the angles of the files, the flanks {apart} {1000 * abs(gap_mm):.3g} um at the first "
        "position; rotation and transmission error are measured from there"
    )
    return replace(pair, flank_distance_note=note)


def _blame_flank(scene: Scene, pair: BodyPair, distance: str) -> None:
    """Refuse a mesh flank that faces clockwise if that of its mate faces counter-clockwise."""
    if pair.body_1.mirrored == pair.body_2.mirrored:
        return
    key, spec = ("body_1", scene.body_1) if pair.body_1.mirrored else ("body_2", scene.body_2)
    assert isinstance(spec, MeshBody)
    sets = spec.flank_sets
    name = "flank_set" if sets is None else "flank_sets"
    raise SceneError(
        file=scene.file,
        key=f"{key}.{name}",
        expected="the other flank of the tooth: one that faces counter-clockwise about the axis of "
        "its body, as that of the mate does",
        found=f"{(sets or (spec.flank_set,))[0]!r}, which faces clockwise: in their "
        f"mirror image the flanks {distance}",
    )
