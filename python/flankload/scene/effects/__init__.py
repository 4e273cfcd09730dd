"""The effects that a scene can call for: a record for each, and what follows from the records.

A record says which keys call for an effect and which it is refused with, what it adds to a run, in
which counters that shows and how its size is found before the run (`Effect`). Other modules read
one truth value an effect (`Effects`), and on request because of which key it is so (`Switch`).
"""

from flankload.scene.effects.record import Effect, SizeBy, Switch, Work
from flankload.scene.effects.records import EFFECTS, Effects, effects_of, switches_of, work_in
from flankload.scene.effects.switches import MODIFICATIONS

__all__ = [
    "EFFECTS",
    "MODIFICATIONS",
    "Effect",
    "Effects",
    "SizeBy",
    "Switch",
    "Work",
    "effects_of",
    "switches_of",
    "work_in",
]
