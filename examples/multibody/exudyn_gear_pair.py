"""Two gears that turn slowly under torque in Exudyn: the table takes the place of a mesh stiffness.

Coordinates are the angles of both gears, each positive in its own sense of rotation. The torque
between them is that at which the table has, at this angle, the present rotation of gear 1 beyond
gear 2. At low speed the gears follow the static transmission error of the table.

    pip install exudyn  # run with 1.13
    python exudyn_gear_pair.py
"""

import exudyn as exu
import numpy as np
from pair_table import solved_table

TORQUE_NM = 302.0
RATIO = 24 / 16
#: Moments of inertia of steel discs of 14 mm width with the pitch diameters, kg m².
INERTIA = (0.28e-3, 1.4e-3)
SPEED_RAD_PER_S = 1.0
DAMPING = 0.1  # of the critical damping


def simulate(periods: float = 2.0, step_s: float = 2e-4) -> tuple[np.ndarray, np.ndarray]:
    """Angle of gear 1, rad, and rotation of gear 1 beyond gear 2, um on the base circle."""
    table = solved_table()
    radius_um = 1e3 * table.reference_radius_mm
    rotation = table.values["transmission_error_um"] / radius_um
    stiffness = table.values["stiffness_tangent_Nm_per_rad"].mean()
    reduced = 1.0 / (1.0 / INERTIA[0] + RATIO**2 / INERTIA[1])
    damping = 2 * DAMPING * np.sqrt(stiffness * reduced)

    def torque_between(angle: float, beyond: float) -> float:
        place = angle % table.period_rad
        at = [np.interp(place, table.angle_rad, column) for column in rotation.T]
        slope = np.diff(table.torques_Nm) / np.diff(at)
        k = min(max(int(np.searchsorted(at, beyond)) - 1, 0), slope.size - 1)
        return float(max(0.0, table.torques_Nm[k] + slope[k] * (beyond - at[k])))

    def forces(mbs: object, t: float, item: int, q: list, q_t: list) -> list:
        between = torque_between(RATIO * q[1], q[0] - RATIO * q[1])
        between += damping * (q_t[0] - RATIO * q_t[1])
        return [TORQUE_NM - between, RATIO * (between - TORQUE_NM)]

    container = exu.SystemContainer()
    mbs = container.AddSystem()
    start = float(np.interp(TORQUE_NM, table.torques_Nm, rotation[0]))
    node = mbs.AddNode(
        exu.itemInterface.NodeGenericODE2(
            referenceCoordinates=[0.0, 0.0],
            initialCoordinates=[start, 0.0],
            initialCoordinates_t=[SPEED_RAD_PER_S, SPEED_RAD_PER_S / RATIO],
            numberOfODE2Coordinates=2,
        )
    )
    mbs.AddObject(
        exu.itemInterface.ObjectGenericODE2(
            nodeNumbers=[node], massMatrix=np.diag(INERTIA), forceUserFunction=forces
        )
    )
    sensor = mbs.AddSensor(
        exu.itemInterface.SensorNode(
            nodeNumber=node,
            storeInternal=True,
            outputVariableType=exu.OutputVariableType.Coordinates,
        )
    )
    mbs.Assemble()
    settings = exu.SimulationSettings()
    settings.timeIntegration.endTime = periods * table.period_rad / SPEED_RAD_PER_S
    settings.timeIntegration.numberOfSteps = round(settings.timeIntegration.endTime / step_s)
    settings.timeIntegration.verboseMode = 0
    settings.solution.file.write = False
    settings.solution.sensors.writePeriod = step_s
    mbs.SolveDynamic(settings)
    _, one, two = mbs.GetSensorStoredData(sensor).T
    return one, radius_um * (one - RATIO * two)


def main() -> None:
    """Compare the simulated transmission error with the static table."""
    angle, found = simulate()
    table = solved_table()
    static = table.values["transmission_error_um"][:, 1]
    wanted = np.interp(angle % table.period_rad, table.angle_rad, static)
    late = angle > table.period_rad  # the first period starts from rest in the deflection
    print(f"peak to peak, static      {np.ptp(static):.2f} um")
    print(f"peak to peak, simulated   {np.ptp(found[late]):.2f} um")
    print(f"root mean square between  {np.sqrt(np.mean((found - wanted)[late] ** 2)):.2f} um")


if __name__ == "__main__":
    main()
