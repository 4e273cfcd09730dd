"""The effects that a scene can request: one record per effect, and queries of the records.

A record lists the keys that switch an effect on and the keys with which it is refused, the work it
adds to a run, the counters that show this work, and the method that estimates its size before the
run (`Effect`). Other modules read one Boolean per effect (`Effects`) or the deciding key
(`Switch`).
"""

from flankload.scene.effects.record import Effect, SizeBy, Switch, Work
from flankload.scene.effects.records import (
    EFFECTS,
    Effects,
    effects_of,
    excluded_by,
    known_effects,
    switches_of,
    work_in,
)
from flankload.scene.effects.switches import MODIFICATIONS, RELIEF_PLACES, is_spatial

__all__ = [
    "EFFECTS",
    "MODIFICATIONS",
    "RELIEF_PLACES",
    "Effect",
    "Effects",
    "SizeBy",
    "Switch",
    "Work",
    "effects_of",
    "excluded_by",
    "is_spatial",
    "known_effects",
    "switches_of",
    "work_in",
]
