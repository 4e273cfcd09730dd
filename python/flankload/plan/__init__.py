"""Before a run: which effects it will have, because of which key, what they cost and change."""

from flankload.plan.choice import choose_effects
from flankload.plan.effect_size import Size
from flankload.plan.planned import Chosen, Plan, PlannedEffect
from flankload.plan.planning import plan

__all__ = ["Chosen", "Plan", "PlannedEffect", "Size", "choose_effects", "plan"]
