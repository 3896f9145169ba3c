"""The motor beside the study, as a picture."""

from __future__ import annotations

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from gen.arrays import FloatArray
from gen.rig.calibrate.fit import BROKEN, compare, settled
from gen.rig.calibrate.targets import Targets, load
from gen.rig.parameters import MEASURED, MotorParameters, my1016

_COLOURS = ("#4c78a8", "#54a24b", "#e45756", "#b279a2", "#f58518")
_TITLES = {"brush": "Brush", "bearing": "Bearing", "magnet": "Magnet", "casing": "Casing"}


def figure() -> Figure:
    """Settled temperatures over speed, steps from cold, and both faults."""
    parameters, targets = my1016(), load()
    with matplotlib.rc_context({"font.size": 8, "axes.grid": True, "grid.alpha": 0.3}):
        drawn = Figure(figsize=(12, 9), layout="constrained")
        axes = drawn.subplots(3, 4)
        healthy = compare(parameters, targets)
        fine = np.linspace(0.0, 1.0, 101)
        over_speed = settled(parameters, fine)
        for column, name in enumerate(MEASURED):
            _settled(axes[0, column], name, fine, over_speed[name], targets)
            _steps(axes[1, column], name, healthy.curves[name], targets)
        _inside(axes[2, 0], fine, over_speed)
        well = settled(parameters, targets.fault_speeds)
        for column, kind in enumerate(BROKEN, start=1):
            _fault(axes[2, column], kind, parameters, well, targets)
        _errors(axes[2, 3], healthy.end_K, targets)
    return drawn


def _settled(axes: Axes, name: str, fine: FloatArray, values: FloatArray, targets: Targets) -> None:
    axes.plot(100 * fine, values, color="black", label="rig, settled")
    axes.errorbar(
        100 * targets.speeds,
        targets.end_degC[name],
        yerr=2.0,
        fmt="o",
        color="#e45756",
        capsize=3,
        label="Table 4.1 ± 2 K",
    )
    axes.set(title=f"{_TITLES[name]}, settled", xlabel="speed, %", ylabel="°C", ylim=(28, 90))
    axes.legend(loc="lower center")


def _steps(axes: Axes, name: str, curves: FloatArray, targets: Targets) -> None:
    hours = targets.time_s[::12] / 3600.0
    for k, speed in enumerate(targets.speeds):
        axes.plot(hours, curves[k, ::12], color=_COLOURS[k], label=f"{100 * speed:.0f} %")
        axes.plot(hours, targets.curves[name][k, ::12], color=_COLOURS[k], linestyle="--", linewidth=1)
    axes.set(title=f"{_TITLES[name]}, step (dashed: Table 4.3)", xlabel="time, h", ylabel="rise, K", ylim=(0, 58))
    axes.legend(loc="lower right", ncols=2)


def _inside(axes: Axes, fine: FloatArray, over_speed: dict[str, FloatArray]) -> None:
    for name, colour in zip(("winding", "brush", "air", "casing"), _COLOURS, strict=False):
        axes.plot(100 * fine, over_speed[name], color=colour, label=name)
    axes.set(title="Inside, settled", xlabel="speed, %", ylabel="°C", ylim=(28, 90))
    axes.legend(loc="lower center", ncols=2)


def _fault(axes: Axes, kind: str, parameters: MotorParameters, well: dict[str, FloatArray], targets: Targets) -> None:
    broken = settled(parameters, targets.fault_speeds, BROKEN[kind])
    percent = 100 * targets.fault_speeds
    for name, colour in (("brush", "#4c78a8"), ("casing", "#f58518")):
        axes.plot(percent, broken[name] - well[name], color=colour, marker=".", label=f"{name}, rig")
    axes.plot(
        percent, targets.faults[kind].brush, "o", color="#4c78a8", fillstyle="none", label="brush, reading of the study"
    )
    axes.plot(percent, targets.faults[kind].casing_at_least, color="#f58518", linestyle=":", label="casing at least")
    axes.set(title=f"{kind.capitalize()} fault over healthy, settled", xlabel="speed, %", ylabel="K", ylim=(-6, 18))
    axes.legend(loc="upper left")


def _errors(axes: Axes, end_K: dict[str, FloatArray], targets: Targets) -> None:
    for k, name in enumerate(MEASURED):
        axes.bar(100 * targets.speeds + 3.5 * (k - 1.5), end_K[name], width=3.2, color=_COLOURS[k], label=name)
    axes.axhspan(-2, 2, color="black", alpha=0.06)
    axes.set(title="Rig minus Table 4.1 at 10 800 s", xlabel="speed, %", ylabel="K", ylim=(-2.4, 4))
    axes.legend(loc="upper right", ncols=2)
