"""Load distribution of a gear pair: how much the teeth carry, and what a rigid wheel changes.

The pair is type C of the FZG test rig. Body 1 (the pinion) is free to turn and carries the torque,
body 2 stands at its kinematic angle; at each position of a mesh period

    F >= 0,  gap >= 0,  F * gap = 0,  sum of lever * F = torque

decides which flanks touch and how much each carries.
"""

import tomllib
from pathlib import Path

import flankload as fl

SCENE = Path(__file__).parent / "scenes" / "external_gear.toml"


def main() -> None:
    """Solve the pair, print what a report quotes, then vary it."""
    result = fl.solve(fl.read_scene(SCENE))
    summary = result.summary
    print(f"{result.name}, {result.torque_Nm:g} N m")
    print(f"  transmission error   mean {summary['transmission_error_mean_um']:.2f} um,")
    print(f"    peak to peak       {summary['transmission_error_peak_to_peak_um']:.2f} um")
    print(f"  contact ratio        {summary['contact_ratio_under_load']:.3f} under load")
    print(f"  largest pressure     {summary['peak_pressure_MPa']:.0f} MPa")

    # Which teeth carry at the position a quarter of a pitch after the pitch point?
    p = len(result.position_rad) // 4
    for site, share, force in zip(
        result.sites, result.load_share[p], result.site_force_N[p], strict=True
    ):
        print(f"  pair {site:2d} at 1/4 pitch  {100 * share:5.1f} %, {force:.0f} N")

    # A scene is a dictionary, too: the same pair with a rigid wheel.
    table = tomllib.loads(SCENE.read_text(encoding="utf-8"))
    table["name"] = "the same with a rigid wheel"
    table["body_2"]["rigid"] = True
    stiff = fl.solve(fl.Scene.from_dict(table))
    print(f"{stiff.name}")
    print(f"  transmission error   mean {stiff.summary['transmission_error_mean_um']:.2f} um")
    print(f"  FE jobs              {stiff.cost['fe_factorisations']}")


if __name__ == "__main__":
    main()
