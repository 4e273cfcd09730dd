"""Pictures of effects: contact on the coast flanks, stress in the roots."""

from __future__ import annotations

import numpy as np
import pytest

from flankload.plot import pictures_of, plot_flank_forces, plot_loaded_pair, plot_root_stress
from tests.support.pair_scenes import EXTERNAL, solved

#: 10 um nearer than FZG type C: both flanks of a tooth touch.
TIGHT = {**EXTERNAL, "pair": {**EXTERNAL["pair"], "center_distance_mm": 91.49}}


def test_pictures_show_both_sides() -> None:
    tight = solved(TIGHT, 60.0, count=8, effects={"coast_flank": True})
    (axes,) = plot_flank_forces(tight).axes
    dashed = [line for line in axes.get_lines() if line.get_linestyle() == "--"]
    carries = np.flatnonzero((tight.coast_force_N > 0).any(axis=0))
    assert len(dashed) == carries.size > 0
    for line, s in zip(dashed, carries, strict=True):
        drawn = np.asarray(line.get_ydata())[:8]
        force = tight.coast_force_N[:, s] / 1e3
        np.testing.assert_array_equal(drawn[force > 0], force[force > 0])
    names = [text.get_text() for text in plot_loaded_pair(tight, 4).axes[0].texts]
    assert any("coast" in name for name in names)
    with pytest.raises(ValueError, match="contact on coast flanks"):
        plot_flank_forces(solved(EXTERNAL, 0.0, count=1, rigid=True))


def test_stress_is_drawn_as_one_tooth_sees_it() -> None:
    result = solved(EXTERNAL, 302.0, count=4, effects={"root_stress": True})
    assert "root_stress" in pictures_of(result)
    axes = plot_root_stress(result).axes[0]
    stress = result.root_stress[1]
    assert stress is not None
    label = f"body 2, tension up to {stress.tension.stress_MPa.max():.0f} MPa"
    first = next(line for line in axes.lines if line.get_label() == label)
    x, y = (np.asarray(values) for values in first.get_data())
    np.testing.assert_array_equal(y[:4], stress.tension.stress_MPa[:, 0])
    # one pitch later the pair is where the next one was
    assert x[4] - x[0] == pytest.approx(1.0)
    assert y[4] == stress.tension.stress_MPa[0, 1]
