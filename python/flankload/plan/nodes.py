"""What forces at nodes change: by a law, from how far apart the nodes of a run stand.

Forces at nodes are another way to the same states, a hundred times as dear as pressure modes: none
are solved for. What they are off by goes with the distance of the nodes over the half-width of the
contact. Against pressure modes, mean and largest of the rotation, largest of the load share:

    FZG type C pair   0.20 half-widths apart    -0.1 %   0.7 %   1.0 points
                      0.38                      -0.7 %   2.0 %   1.6
                      0.76                      -1.2 %   4.9 %   6.9
    internal pair     0.15                      -0.4 %   1.4 %   1.5
                      0.20                      -0.5 %   1.2 %   1.1
                      0.44                      -1.3 %   3.1 %   2.5
    spline, conforming flanks                   -0.6 %   0.6 %
    pair from meshes  3.5 and 3.6               +2.3 %  31.5 %  26.8
      wheel alone     0.20 and 3.6              -5.2 %   6.1 %   1.3
      pinion alone    3.5 and 0.20             +12.1 %  37.8 %  26.9
    toothed sector    0.20 and 3.8              -3.9 %   5.6 %   2.6
                      0.20 and 7.6              -5.1 %   6.1 %   2.6
                      0.20 and 14.7             -6.6 %   7.6 %   0.8
                      0.54 and 7.6              -5.3 %   6.4 %   4.8
                      1.61 and 7.6              -6.0 %   8.1 %   3.9

Nodes of one body alone that stand far apart shift all pairs alike, which changes the share little:
the law has it from what the rotation at a position misses beyond its mean. The pinion's mesh alone
does not keep to it.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from flankload.elasticity.nodal_loads import nodes_of
from flankload.pairing.node_spacing import half_widths_apart
from flankload.plan.sizes import Size

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from flankload.bodies import Body
    from flankload.plan.coarse import Coarse
    from flankload.plan.sizes import States
    from flankload.scene import Scene

#: Parts of the wind-up for each half-width between two nodes: largest at a position, and mean.
LARGEST, MEAN = 0.06, 0.02
#: Of nodes much further apart than the contact is wide, whatever their distance: of both bodies;
#: of one beyond what the other misses, too; of one in the mean.
MOST_LARGEST, MOST_BEYOND, MOST_MEAN = 0.22, 0.056, 0.1
#: Load share over what the largest amount exceeds the mean by.
SHARE = 1.5


def nodal_size(
    scene: Scene, coarse: Coarse, base: list[States], unloaded_rad: NDArray[np.float64]
) -> Size | None:
    """Size of forces at nodes in a scene that has them.

    Parameters
    ----------
    scene : Scene
    coarse : Coarse
    base : list of States
        The least torque first: the narrowest contact is missed most.
    unloaded_rad : (P,) array
        Rotation without torque.

    Returns
    -------
    Size or None
        None without torque, or where neither body has elements.
    """
    pair, states = coarse.fine_pair(scene), base[0]
    bodies = pair.body_1, pair.body_2
    spacings = [_spacing_mm(body) for body in bodies if body.mesh is not None and not body.rigid]
    if not spacings or states.torque_Nm <= 0.0:
        return None
    least = half_widths_apart(bodies, min(spacings), states.torque_Nm, scene.pair.face_width_mm)
    if least is None:
        return None
    parts = np.array(spacings) * least / min(spacings)
    both, beyond = parts.min(), parts.max() - parts.min()
    largest = min(LARGEST * both, MOST_LARGEST) + min(0.5 * LARGEST * beyond, MOST_BEYOND)
    mean = float(np.minimum(MEAN * parts, MOST_MEAN).mean())
    size = part_of_wind_up(float(largest), states, unloaded_rad, coarse)
    share = SHARE * (size.load_share - mean) if size.load_share else 0.0
    return replace(size, rotation_mean=-mean, load_share=share)


def part_of_wind_up(
    part: float, states: States, unloaded_rad: NDArray[np.float64], coarse: Coarse
) -> Size:
    """Size of what takes a part of the wind-up, and as much of the load share.

    Parameters
    ----------
    part : float
    states : States
        Of the torque at which it is so.
    unloaded_rad : (P,) array
        Rotation without torque.
    coarse : Coarse

    Returns
    -------
    Size
    """
    wind_up = float(np.max(states.rotation_rad - unloaded_rad))
    return Size(
        rotation_mean=-part,
        rotation_largest=part,
        rotation_um=1000.0 * coarse.reference_radius_mm * part * wind_up,
        load_share=part if states.load_share.shape[1] > 1 else 0.0,
        torque_Nm=states.torque_Nm,
    )


def _spacing_mm(body: Body) -> float:
    """Largest distance of the nodes that carry forces."""
    assert body.mesh is not None
    return float(np.diff(nodes_of(body.mesh)).max())
