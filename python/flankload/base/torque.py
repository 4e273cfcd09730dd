"""Torques are in N m in scenes and results, and in N mm between them."""

N_MM_PER_N_M = 1000.0


def in_newton_metres(torque_Nmm: float) -> float:
    """A torque in N m, for results and texts; `Scene.torques_Nmm` is the other direction."""
    return torque_Nmm / N_MM_PER_N_M
