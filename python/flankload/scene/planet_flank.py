"""The table of the flanks of planets in mesh with the ring (`[stage.planet_ring_flank]`)."""

from flankload.scene import axial
from flankload.scene.refusal import refuse, refuse_absent
from flankload.scene.table import Table


class PlanetFlank(Table, frozen=True, kw_only=True):
    """Modifications along the axis of one side of the planets, instead of those of [planet]."""

    lead_crowning_um: axial.LeadCrowning = None
    helix_slope_um: axial.HelixSlope = None
    end_relief_um: axial.EndRelief = None
    end_relief_length_mm: axial.EndReliefLength = None
    end_relief_shape: axial.EndReliefShape = "linear"

    def check(self, width_mm: float, key: str) -> None:
        """Check end relief and its lengths, which are within the face width."""
        reliefs = ("end_relief_um", "end_relief_length_mm")
        for missing, there in (reliefs, reliefs[::-1]):
            if getattr(self, missing) is None and getattr(self, there) is not None:
                refuse_absent(key, missing, "a list of 2 numbers", there)
        for k, length in enumerate(self.end_relief_length_mm or ()):
            if length > width_mm:
                expected = f"at most the face width of the planets, {width_mm:g}"
                refuse(f"{key}.end_relief_length_mm[{k}]", expected, length)
