"""Scenes solved with the bodies and elements of other tests: those that are alike are made once.

For tests of results. A run with parts of earlier ones has the bits of a single run (proved by
`unit/mechanisms/test_prepared.py`), except in its cost: tests of the cost call `flankload.solve`.
"""

from __future__ import annotations

import flankload as fl
from flankload.mechanisms import Earlier, Parts, run_once
from flankload.scene.discretization import Discretization

#: More than a study holds: files of tests that share bodies are far apart.
PARTS = Parts(256)


def solve(
    scene: fl.Scene, *, discretization: Discretization | None = None
) -> fl.Result | tuple[fl.Result, ...]:
    """Results of a scene; alone if it leaves discretization or effects to the program.

    Parameters
    ----------
    scene : Scene
    discretization : Discretization, optional
        Replaces that of the scene.

    Returns
    -------
    Result, or a tuple of Results if the scene has a list of torques
    """
    if scene.names_tolerance or scene.effects.choose is not None:
        assert discretization is None
        results = fl.solve(scene).by_torque
    else:
        results = run_once(scene, discretization=discretization, earlier=Earlier(parts=PARTS))
    return results if scene.has_torque_list else results[0]
