"""The plots of a result as methods: `result.plot.transmission_error(axes)`.

The package with the plots is imported at first use: it depends on this one.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from flankload.result.quantities import torques_of

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from flankload.result.forms import ResultForms
    from flankload.result.result import Result


class Plots:
    """Methods that draw the plots of results of one scene, one per torque.

    Each method has the name of the file that `flankload run --plot` writes. It draws on the given
    `matplotlib.axes.Axes`, without a title, or on those of a new figure with title and margins, and
    returns the Axes. The state of `matplotlib.pyplot` is neither used nor changed. A new figure can
    be written by `axes.figure.savefig`. Plots of one torque show the largest one.

    Parameters
    ----------
    results : Result, or sequence of Result of single torques
    """

    def __init__(self, results: ResultForms | Sequence[Result]) -> None:
        self._results = torques_of(results)

    def names(self) -> tuple[str, ...]:
        """Names of the plots that suit the results."""
        return tuple(_plot().pictures_of(self._results))

    def all(self, folder: str | Path, **options: Any) -> tuple[Path, ...]:
        """Write all plots that suit the results, as `flankload run --plot`.

        Parameters
        ----------
        folder : path
            Created if it does not exist.
        **options
            `formats` (sequence of "png", "svg", "pdf"), `dpi`, `size_mm` (width, height).

        Returns
        -------
        tuple of Path
        """
        return tuple(_plot().plot_all(self._results, folder, **options))

    def _draw(self, name: str, ax: Any, **options: Any) -> Any:
        named = {key: value for key, value in options.items() if value is not None}
        return _plot().draw_on(name, self._results, ax, **named)

    def transmission_error(self, ax: Any = None) -> Any:
        """Transmission error over the positions."""
        return self._draw("transmission_error", ax)

    def transmission_error_spectrum(self, ax: Any = None) -> Any:
        """Amplitudes of the transmission error over the mesh orders."""
        return self._draw("transmission_error_spectrum", ax)

    def load_sharing(self, ax: Any = None) -> Any:
        """Load share of each pair over the positions."""
        return self._draw("load_sharing", ax)

    def peak_pressure(self, ax: Any = None) -> Any:
        """Peak pressure of each pair over the positions."""
        return self._draw("peak_pressure", ax)

    def pressure_over_diameter(self, ax: Any = None, *, body: int | None = None) -> Any:
        """Peak pressure over the diameter of a body, with points A to E."""
        return self._draw("pressure_over_diameter", ax, body=body)

    def load_map(self, ax: Any = None) -> Any:
        """Force of each pair at each position."""
        return self._draw("load_map", ax)

    def loaded_pair(
        self, ax: Any = None, *, position: int | None = None, body: int | None = None
    ) -> Any:
        """Teeth in mesh at a position, with pressures and forces; in three dimensions of a body."""
        return self._draw("loaded_pair", ax, position=position, body=body)

    def flank_forces(self, ax: Any = None) -> Any:
        """Forces on working and coast flanks over the positions."""
        return self._draw("flank_forces", ax)

    def stiffness(self, ax: Any = None) -> Any:
        """Stiffness over the positions."""
        return self._draw("stiffness", ax)

    def torque_sweep(self, ax: Any = None, *, quantity: str | None = None) -> Any:
        """A key figure over the torque."""
        return self._draw("torque_sweep", ax, quantity=quantity)

    def profile_deviation(self, ax: Any = None, *, body: int | None = None) -> Any:
        """Deviation of a body from its involute."""
        return self._draw("profile_deviation", ax, body=body)

    def follower_motion(self, ax: Any = None) -> Any:
        """Angle of a follower on its cam, and the contact force."""
        return self._draw("follower_motion", ax)

    def load_per_tooth(self, ax: Any = None, *, position: int | None = None) -> Any:
        """Force on each tooth of a spline."""
        return self._draw("load_per_tooth", ax, position=position)

    def flank_pressure(self, ax: Any = None, *, position: int | None = None) -> Any:
        """Pressure on the most loaded flank of a spline."""
        return self._draw("flank_pressure", ax, position=position)

    def root_stress(self, ax: Any = None) -> Any:
        """Stress in the tooth roots on the way of a tooth."""
        return self._draw("root_stress", ax)

    def root_stress_over_width(self, ax: Any = None) -> Any:
        """Stress in the most stressed tooth roots over the face width."""
        return self._draw("root_stress_over_width", ax)

    def line_load(self, ax: Any = None, *, position: int | None = None) -> Any:
        """Line load over the face width."""
        return self._draw("line_load", ax, position=position)

    def line_load_map(self, ax: Any = None) -> Any:
        """Line load of a tooth over its way and the face width."""
        return self._draw("line_load_map", ax)

    def contact_pattern(self, ax: Any = None, *, body: int | None = None) -> Any:
        """Largest pressure at each place of a flank."""
        return self._draw("contact_pattern", ax, body=body)

    def belt_on_pulley(self, ax: Any = None, *, position: int | None = None) -> Any:
        """Belt, pulley and the forces on the teeth."""
        return self._draw("belt_on_pulley", ax, position=position)

    def load_around_wrap(self, ax: Any = None, *, position: int | None = None) -> Any:
        """Forces of the teeth of a belt around the wrap."""
        return self._draw("load_around_wrap", ax, position=position)

    def force_through_wrap(self, ax: Any = None) -> Any:
        """Force of a tooth of a belt on its way through the wrap."""
        return self._draw("force_through_wrap", ax)

    def chain_on_sprocket(self, ax: Any = None, *, position: int | None = None) -> Any:
        """Chain, sprocket and the forces on the rollers."""
        return self._draw("chain_on_sprocket", ax, position=position)

    def tensions(self, ax: Any = None) -> Any:
        """Tension of the links of a chain around the wrap."""
        return self._draw("tensions", ax)

    def gear_train(self, ax: Any = None, *, position: int | None = None) -> Any:
        """Gears of a train with the forces of their meshes and on their bearings."""
        return self._draw("gear_train", ax, position=position)

    def planetary_stage(self, ax: Any = None, *, position: int | None = None) -> Any:
        """Sun, planets and ring at a position, with the forces on planets and pins."""
        return self._draw("planetary_stage", ax, position=position)

    def planet_load_share(self, ax: Any = None) -> Any:
        """Share of each planet over the positions."""
        return self._draw("planet_load_share", ax)

    def sun_orbit(self, ax: Any = None) -> Any:
        """Path of the axis of the sun."""
        return self._draw("sun_orbit", ax)

    def stage_patterns(self, ax: Any = None) -> Any:
        """Largest pressure on the flanks of all planets in both meshes; of one on given axes."""
        return self._draw("stage_patterns", ax)

    def mesh_load_factor(self, ax: Any = None) -> Any:
        """K_gamma over the torque."""
        return self._draw("mesh_load_factor", ax)


def _plot() -> Any:
    return import_module("flankload.plot")
