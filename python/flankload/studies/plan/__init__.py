"""Plan of a run: its effects with the keys that cause them, their cost and their size."""

from flankload.mechanisms.effect_size import Size
from flankload.studies.plan.choice import choose_effects
from flankload.studies.plan.planned import Chosen, Plan, PlannedEffect
from flankload.studies.plan.planning import plan

__all__ = ["Chosen", "Plan", "PlannedEffect", "Size", "choose_effects", "plan"]
