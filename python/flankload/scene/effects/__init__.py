"""The effects that a scene can call for, as one table; what it does not call for is not computed.

A row of the table says which keys call for an effect, what it adds to a run, in which counters that
shows and how its size is found before the run (`Effect`). What other rooms read is one truth value
a row (`Effects`), and on request because of which key it is so (`Switch`).
"""

from flankload.scene.effects.called_for import Effects, effects_of, switches_of, work_in
from flankload.scene.effects.effect import Effect, SizeBy, Switch, Work
from flankload.scene.effects.switches import MODIFICATIONS
from flankload.scene.effects.table import EFFECTS

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
