"""Logs of rooms and boxes with a heater."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pandas as pd

from benchmarks.real_machines.logs.case import Case, between, driven_by, each_left_out
from gen.runs import Run

HOUSE_KILOWATTS = 6.0
HOUSE_CUT_H = 28.8


def house(folder: Path) -> Iterator[Case]:
    """A small house in winter, heated by switched electric heaters: each half of 58 h once left out.

    The sun shines in, which the input does not say.
    """
    table = pd.read_csv(folder / "inputPRBS1.csv")
    halves = {}
    for name, rows in (("first half", table.t < HOUSE_CUT_H), ("second half", table.t >= HOUSE_CUT_H)):
        half = table[rows]
        run = Run(
            time_s=np.rint((half.t - half.t.iloc[0]).to_numpy() * 3600.0),
            pwm=np.rint(half.Ph.to_numpy() / HOUSE_KILOWATTS * 255.0).astype(np.int64),
            temps={"inside": half.yTi.to_numpy(dtype=np.float64)},
            ambient=half.Ta.to_numpy(dtype=np.float64),
            extras={"sun_kW_m2": half.Ps.to_numpy(dtype=np.float64)},
        )
        halves[name] = driven_by(run, f"Ph, 255 = {HOUSE_KILOWATTS:g} kW")
    yield from each_left_out("house", halves, ("inside",), str)


STRETCHES = {
    "warming": ("202603031510.csv", "00:00:30", "00:30:40"),
    "approach": ("202602111639.csv", "00:00:30", "00:31:01"),
    "regulated": ("202603031806.csv", "00:01:20", "00:31:00"),
}
"""From which log, and from when to when: between the times at which the logger hung."""


def incubator(folder: Path) -> Iterator[Case]:
    """A box with a heater that is on or off, from 25 degC, from 52 degC and kept at 60 degC. Each once left out.

    The room was not measured.
    """
    runs = {}
    for name, (file, first, last) in STRETCHES.items():
        table = pd.read_csv(folder / file)
        rows = table[(table.TimeElapsed >= first) & (table.TimeElapsed <= last)]
        time = pd.to_timedelta(rows.TimeElapsed).dt.total_seconds().to_numpy(dtype=np.float64)
        pwm = np.where(rows.Heater.to_numpy() == "ON", 255, 0).astype(np.int64)
        box = rows.Temperature.to_numpy(dtype=np.float64)
        runs[name] = Run(time - time[0], pwm, {"box": box})
    yield from each_left_out("incubator", runs, ("box",), str)


BOX_WATTS = 2220.0
BOX_CUT_S = 126900.0
BOX_LAST_S = 415800.0
"""The author's own examples drop the row behind, in which the room jumps."""


def armadillo_box(folder: Path) -> Iterator[Case]:
    """A prototype of a small house under an electric heater: each half of 4.8 days once left out.

    The sun shines in, which the input does not say.
    """
    table = pd.read_csv(folder / "armadillo_data_H2.csv")
    time = table.Time.to_numpy(dtype=np.float64)
    run = Run(
        time_s=time,
        pwm=np.rint(table.P_hea.to_numpy() / BOX_WATTS * 255.0).astype(np.int64),
        temps={"inside": table.T_int.to_numpy(dtype=np.float64)},
        ambient=table.T_ext.to_numpy(dtype=np.float64),
    )
    run = driven_by(run, f"P_hea, 255 = {BOX_WATTS:g} W")
    halves = {
        "first half": between(run, 0.0, BOX_CUT_S),
        "second half": between(run, BOX_CUT_S, BOX_LAST_S + 1.0),
    }
    yield from each_left_out("armadillo box", halves, ("inside",), str)
