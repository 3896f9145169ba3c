"""How well the motor meets the study, as tables."""

from __future__ import annotations

import numpy as np
from rich.console import Console
from rich.table import Table

from gen.arrays import FloatArray
from gen.rig.calibrate.fit import BROKEN, compare, settled
from gen.rig.calibrate.targets import Targets, time_to_63
from gen.rig.losses import heat
from gen.rig.parameters import MEASURED, MotorParameters
from gen.rig.response import held, network, no_load


def print_tables(parameters: MotorParameters, targets: Targets) -> None:
    """Print steady temperatures, time constants, fault signatures and what makes the brush cool above 60 %."""
    console = Console(width=120)
    healthy = compare(parameters, targets)
    console.print(_table("Motor minus Table 4.1 at 10 800 s, K", targets.speeds, healthy.end_K, "+.2f"))
    console.print(_table("Settled motor minus Table 4.1, K", targets.speeds, healthy.settled_K, "+.2f"))
    times = {name: np.array([time_to_63(targets.time_s, curve) for curve in healthy.curves[name]]) for name in MEASURED}
    console.print(_table("Time to 63 % of the rise at 10 800 s, s", targets.speeds, times, ".0f"))
    percent = {name: 100.0 * values for name, values in healthy.time_63.items()}
    console.print(_table("The same against the Table 4.3 transfer functions, %", targets.speeds, percent, "+.1f"))
    console.print(_table("No-load current, A", targets.speeds, {"motor": healthy.current_A}, ".2f"))
    well = settled(parameters, targets.fault_speeds)
    for kind, condition in BROKEN.items():
        broken = settled(parameters, targets.fault_speeds, condition)
        rows = {f"{name} over healthy": broken[name] - well[name] for name in ("brush", "casing")}
        rows["casing, degC"] = broken["casing"]
        console.print(_table(f"{kind} fault, settled", targets.fault_speeds, rows, "+.1f"))
    console.print(explain_fall(parameters))


def explain_fall(parameters: MotorParameters) -> str:
    """Say how much of the brush's fall from 60 to 100 % speed is due to convection and how much to heat."""
    net = network(parameters)
    low, high = (held(parameters, no_load(s), net=net) for s in (0.6, 1.0))
    # Heat of full speed, heat paths as at 60 %: what is left of the fall is not convection's.
    still = np.array(heat(parameters, no_load(1.0)).nodes)
    still[0] += high.copper_W
    flows = net.flows(net.conductances(0.6))
    frozen = np.linalg.solve(-flows[:, :-1], still + flows[:, -1] * 30.0)
    total = low.settled[1] - high.settled[1]
    heat_part = low.settled[1] - frozen[1]
    watts = [sum(point.heat.nodes) + point.copper_W for point in (low, high)]
    return (
        f"Brush from 60 to 100 % speed: {-total:+.1f} K, of which {-heat_part:+.1f} K because the heat goes from "
        f"{watts[0]:.1f} to {watts[1]:.1f} W and {heat_part - total:+.1f} K because convection rises."
    )


def _table(title: str, speeds: FloatArray, rows: dict[str, FloatArray], form: str) -> Table:
    table = Table(title=title, title_justify="left")
    table.add_column("")
    for speed in speeds:
        table.add_column(f"{100 * speed:.0f} %", justify="right")
    for name, values in rows.items():
        table.add_row(name, *(format(value, form) for value in values))
    return table
