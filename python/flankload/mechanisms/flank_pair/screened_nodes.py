"""Size of the effect of nodal forces, from a law in the node spacing of a run.

Nodal forces lead to the same states as pressure modes at a hundred times the cost, so none are
solved for. Their error depends on the node spacing divided by the half-width of the contact;
docs/guide/effects.md compares the law with runs.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flankload.elasticity.nodal_loads import nodes_of
from flankload.mechanisms.effect_size import Size
from flankload.pairing.node_spacing import half_widths_apart, spacing_for_loads

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from flankload.mechanisms.effect_size import States
    from flankload.pairing.body_pair import BodyPair
    from flankload.scene import Scene

#: Part of the wind-up per half-width of node spacing: largest at a position, and mean.
LARGEST, MEAN = 0.06, 0.02
#: Limits for nodes much further apart than the contact width, independent of their spacing: for
#: both bodies; for one body in addition to the error of the other; for one body in the mean.
MOST_LARGEST, MOST_BEYOND, MOST_MEAN = 0.22, 0.056, 0.1
#: Load share divided by the difference between largest and mean amount.
SHARE = 1.5


def node_spacings(scene: Scene, pair: BodyPair) -> list[float | None]:
    """Node spacing of each body, mm, if the scene had nodal forces; None without elements.

    `pair` is that of the scene, with or without nodal forces.
    """
    bodies = pair.body_1, pair.body_2
    wanted = scene.accuracy.flank_element_mm
    if wanted is None:
        wanted = spacing_for_loads(bodies, scene.torques_Nm, scene.pair.face_width_mm)
    spacings: list[float | None] = []
    for z, body in enumerate(bodies):
        if body.mesh is None or body.rigid:
            spacings.append(None)
        elif pair.effects.nodal_near_field or f"body_{z + 1}.file" in scene.files:
            spacings.append(float(np.diff(nodes_of(body.mesh)).max()))
        else:
            spacings.append(wanted)
    return spacings


def nodal_size(
    scene: Scene, pair: BodyPair, states: States, unloaded_rad: NDArray[np.float64]
) -> Size | None:
    """Size of the effect of nodal forces; None without torque, or if neither body has elements.

    `scene` has nodal forces; `states` are those of the least torque: the narrowest contact has the
    largest error. `unloaded_rad` (P,) is the rotation without torque.
    """
    spacings = [each for each in node_spacings(scene, pair) if each is not None]
    if not spacings or states.torque_Nm <= 0.0:
        return None
    bodies = pair.body_1, pair.body_2
    least = half_widths_apart(bodies, min(spacings), states.torque_Nm, scene.pair.face_width_mm)
    if least is None:
        return None
    parts = np.array(spacings) * least / min(spacings)
    both, beyond = parts.min(), parts.max() - parts.min()
    largest = min(LARGEST * both, MOST_LARGEST) + min(0.5 * LARGEST * beyond, MOST_BEYOND)
    mean = float(np.minimum(MEAN * parts, MOST_MEAN).mean())
    wind_up = float(np.max(states.rotation_rad - unloaded_rad))
    return Size(
        rotation_mean=-mean,
        rotation_largest=float(largest),
        rotation_um=1000.0 * pair.body_1.reference_radius_mm * float(largest) * wind_up,
        load_share=SHARE * (float(largest) - mean) if states.load_share.shape[1] > 1 else 0.0,
        torque_Nm=states.torque_Nm,
    )
