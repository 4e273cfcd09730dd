"""Positions of a pair without estimates or results."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

import flankload as fl
from flankload.contact.flank_contact import FlankContact, Level
from flankload.contact.sweep import Sweep, sweep
from flankload.elasticity.compliance import BodyCompliance
from flankload.mechanisms.elements import compliance_of
from flankload.mechanisms.flank_pair.assembly import build_bodies
from flankload.pairing.body_pair import BodyPair
from flankload.scene.discretization import Grid


@dataclass(frozen=True)
class Job:
    """A scene, whose bodies and compliances are made once."""

    scene: fl.Scene

    @cached_property
    def bodies(self) -> BodyPair:
        """Both bodies put together."""
        return build_bodies(self.scene)

    @cached_property
    def compliances(self) -> tuple[BodyCompliance, BodyCompliance]:
        """Compliances of both bodies."""
        pair = self.bodies
        return compliance_of(pair.body_1, self.scene), compliance_of(pair.body_2, self.scene)

    def positions(self, count: int) -> NDArray[np.float64]:
        """Evenly over a period, rad."""
        return np.linspace(0.0, self.bodies.pairing.period_rad, count, endpoint=False)

    def sweep(
        self, count: int, torques_Nmm: Sequence[float], *, level: Level = "pairs"
    ) -> tuple[Sweep, ...]:
        """Positions of a period under torques."""
        contact = self.contact(self.bodies.discretization.grid, level)
        return sweep(contact, self.positions(count), torques_Nmm)

    def contact(self, grid: Grid, level: Level = "pairs") -> FlankContact:
        """Contact of both bodies, without friction."""
        return FlankContact(self.bodies, self.compliances, grid, level)
