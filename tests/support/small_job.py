"""A scene file with a short run time."""

from __future__ import annotations

SCENE = """
name = "small job"
[body_1]
kind = "gear"
teeth = 16
module_mm = 4.5
profile_shift = 0.182
tip_diameter_mm = 82.46
bore_diameter_mm = 30
[body_2]
kind = "gear"
teeth = 24
module_mm = 4.5
profile_shift = 0.171
tip_diameter_mm = 118.36
bore_diameter_mm = 40
[pair]
center_distance_mm = 91.5
face_width_mm = 14
[load]
torque_Nm = 302
[positions]
count = 2
[accuracy]
tolerance = 0.1
estimate = false
flank_element_mm = 2
"""
