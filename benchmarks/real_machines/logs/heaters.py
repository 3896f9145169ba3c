"""Logs of what is heated by a current, a lamp or a coil."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pandas as pd

from benchmarks.real_machines.logs.case import Case, driven_by, each_left_out, files
from gen.interface import import_runs
from gen.runs import Run, read_run


def tclab(folder: Path) -> Iterator[Case]:
    """Two heaters, each of which also warms the other's sensor; one of them is the input. Each run once left out.

    The room was not measured: as in the examples, it is where the run begins.
    """
    table = pd.read_csv(folder / "tclab_apm_runs.csv")
    for own, other in ((1, 2), (2, 1)):
        runs = {}
        for name, rows in table.groupby("run"):
            runs[str(name)] = Run(
                time_s=rows.t_s.to_numpy(dtype=np.float64),
                pwm=np.rint(rows[f"Q{own}"].to_numpy() * 2.55).astype(np.int64),
                temps={
                    f"heater{own}": rows[f"T{own}_C"].to_numpy(dtype=np.float64),
                    f"beside{other}": rows[f"T{other}_C"].to_numpy(dtype=np.float64),
                },
                ambient=np.full(len(rows), float(rows[f"T{own}_C"].iloc[0])),
                extras={f"Q{other}_percent": rows[f"Q{other}"].to_numpy(dtype=np.float64)},
            )
        yield from each_left_out(f"tclab heater {own}", runs, (f"heater{own}",), lambda name: name.split("_")[1])


def battery_cell(folder: Path) -> Iterator[Case]:
    """A cell under random current: tested on other random runs, and on discharges at 1 and 2 C."""
    found = files(sorted(folder.glob("cell1_*.csv")))
    runs = {name.removeprefix("cell1_"): driven_by(run, "current, 255 = 6 A") for name, run in found.items()}
    test = {name: runs[name] for name in ("random05", "random15", "random25", "random35", "random45")}
    fit = {name: runs[name] for name in ("random00", "random10", "random20", "random30", "random40")}
    surface = ("surface",)
    yield Case("battery cell", "from five random runs", surface, fit, test)
    yield Case("battery cell", "from one random run", surface, {"random00": runs["random00"]}, test)
    held = {name: runs[name] for name in ("ref_1C", "two_C")}
    yield Case("battery cell", "random runs, tested on held currents", surface, fit, held)


OVEN = {
    "to 100 degC": "signals_step_100_percent_until_100_degC_cooling_down_door_closed.log",
    "to 200 degC": "signals_step_100_percent_until_200_degC_cooling_down_door_closed.log",
    "half power": "signals_step_50_percent.log",
}
"""By what was run; as the oven's author names them."""


def reflow_oven(folder: Path) -> Iterator[Case]:
    """A pizza oven with a thermocouple, heated by a relay, as `gen import` reads its logs. Each run once left out.

    In one of them the first reading is what the sensor had before its first conversion, and the room was not measured:
    the row is left out, and the room is where the run begins.
    """
    runs = {}
    for name, file in OVEN.items():
        with tempfile.TemporaryDirectory() as made:
            columns = {"Temperature (C)": "oven_degC"} if name == "half power" else {}
            run = read_run(import_runs([folder / file], Path(made) / "runs", columns=columns).runs[0])
        if run.ambient is None:
            oven = run.temps["oven"][1:]
            run = Run(run.time_s[1:] - run.time_s[1], run.pwm[1:], {"oven": oven}, np.full(oven.size, oven[0]))
        runs[name] = run
    yield from each_left_out("reflow oven", runs, ("oven",), str)


PLATE_VOLTS = 10.0
PLATE_CUT_S = 800.0


def heating_plate(folder: Path) -> Iterator[Case]:
    """A steel plate below a lamp: one run, cut where the voltage steps up for the first time. Each half once left out.

    The room was not measured.
    """
    t, volts, plate = np.loadtxt(folder / "heating_system.dat", unpack=True)
    halves = {}
    for name, rows in (("first half", t < PLATE_CUT_S), ("second half", t >= PLATE_CUT_S)):
        pwm = np.rint(volts[rows] / PLATE_VOLTS * 255.0).astype(np.int64)
        halves[name] = Run(t[rows] - t[rows][0], pwm, {"plate": plate[rows]})
    yield from each_left_out("heating plate", halves, ("plate",), str)


def unthermal(folder: Path) -> Iterator[Case]:
    """A transistor heated by a source of current, on three days: a model of two of them has to follow a whole profile.

    The room was not measured; the other two runs begin warm and move by 10 K.
    """
    runs = {}
    for path in sorted(folder.glob("*.csv")):
        table = pd.read_csv(path)
        time = table.t.to_numpy(dtype=np.float64)
        pwm = np.rint(table.u.to_numpy() / 100.0 * 255.0).astype(np.int64)
        runs[path.stem] = Run(time - time[0], pwm, {"transistor": table.y.to_numpy(dtype=np.float64)})
    test = {"profile_closed": runs.pop("profile_closed")}
    yield Case("unthermal", "profile", ("transistor",), runs, test)
