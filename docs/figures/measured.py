"""Real machines: measured and predicted temperatures of the runs that were not used."""

from __future__ import annotations

from matplotlib.figure import Figure

from benchmarks.real_machines.shipped import CASES, predict


def figure() -> Figure:
    """A panel for each part that was predicted."""
    predictions = [prediction for case in CASES for prediction in predict(case)[0]]
    drawn = Figure(figsize=(3.6 * len(predictions), 3.0), layout="constrained")
    panels = drawn.subplots(1, len(predictions), squeeze=False)[0]
    for axes, p in zip(panels, predictions, strict=True):
        axes.plot(p.time, p.measured, ".", markersize=2, color="#c4520a", label="measured, not used")
        axes.plot(p.time, p.model, color="#0b62a8", linewidth=1.4, label="free run of the model")
        axes.set_title(f"{p.case}: {p.component}", fontsize=8)
        axes.set_xlabel("time (s)")
        axes.set_ylabel("temperature (°C)")
        axes.grid(True, color="#d5d9dd", linewidth=0.6)
        axes.legend(fontsize=7, frameon=False)
    return drawn
