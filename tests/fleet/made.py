"""Small fleets for tests: one sensed part, runs of some minutes, on a network that is integrated here."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from gen.fleet.folder.store import Store
from gen.runs import Run

ROW_S = 10.0


def run_of(seed: int, *, heat: float = 1.0, capacity: float = 1.0, offset: float = 0.0, hours: float = 1.5) -> Run:
    """A motor of two capacities, casing measured, holds of some minutes; Euler's method by hand."""
    rng = np.random.default_rng(seed)
    rows = int(hours * 3600.0 / ROW_S)
    pwm = np.repeat(rng.choice([0, 80, 130, 180, 250], rows // 60 + 1, p=[0.2, 0.2, 0.2, 0.2, 0.2]), 60)[:rows]
    pwm[:60] = 180
    inner, outer = 22.0, 22.0
    seen = np.empty((rows, 2))
    for row in range(rows):
        seen[row] = inner, outer
        for _ in range(5):
            w = pwm[row] / 255.0
            flow = 0.8 * (inner - outer)
            inner += ROW_S / 5 * (18.0 * heat * w - flow) / (60.0 * capacity)
            outer += ROW_S / 5 * (flow - (0.25 + 0.25 * w) * (outer - 22.0)) / (150.0 * capacity)
    noisy = seen + rng.normal(0.0, 0.1, seen.shape)
    temps = {"brush": noisy[:, 0], "casing": noisy[:, 1] + offset}
    return Run(ROW_S * np.arange(rows, dtype=np.float64), pwm.astype(np.int64), temps, np.full(rows, 22.0))


def store_of(folder: Path, motors: int, *, runs: int = 1) -> Store:
    """A store with motors that differ by some percent."""
    store = Store(str(folder))
    for number in range(motors):
        rng = np.random.default_rng(1000 + number)
        heat, capacity = np.exp(rng.normal(0.0, 0.08, 2)).tolist()
        for k in range(runs):
            store.add(f"m{number}", f"2026-01-0{k + 1}", "run", run_of(10 * number + k, heat=heat, capacity=capacity))
    return store
