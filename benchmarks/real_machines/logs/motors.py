"""Logs of motors."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from pathlib import Path

import numpy as np
import pandas as pd

from benchmarks.real_machines.logs.case import Case, FloatArray, between, driven_by, each_left_out, files
from gen.runs import Run


def gimbalbot(folder: Path) -> Iterator[Case]:
    """A brushless motor that runs for two minutes and cools for ten; each run once left out."""
    runs = files(sorted(folder.glob("*.csv")))
    yield from each_left_out("gimbalbot", runs, ("motor",), lambda name: f"run {name.split('-')[1]}")


def ur3(folder: Path) -> Iterator[Case]:
    """Joints of a robot arm, one morning in three parts, the room not measured. Each part once left out."""
    for joint in (3, 4, 5):
        runs = files(sorted(folder.glob(f"joint{joint}_*.csv")))
        yield from each_left_out(f"ur3 joint {joint}", runs, (f"joint{joint}",), lambda name: name.split("_")[1])


def paderborn(folder: Path) -> Iterator[Case]:
    """A PMSM of which speed is the input, on a drive cycle in six stretches, and on another one."""

    def run(rows: pd.DataFrame, step: float) -> Run:
        return Run(
            time_s=np.arange(len(rows), dtype=np.float64) * step,
            pwm=np.clip(np.rint(rows.motor_speed.to_numpy() / 6000.0 * 255.0), 0, 255).astype(np.int64),
            temps={"winding": rows.stator_winding.to_numpy(), "rotor": rows.pm.to_numpy()},
            ambient=rows.ambient.to_numpy(),
            extras={
                "current_A": np.hypot(rows.i_d.to_numpy(), rows.i_q.to_numpy()),
                "voltage_V": np.hypot(rows.u_d.to_numpy(), rows.u_q.to_numpy()),
                "torque_Nm": rows.torque.to_numpy(),
            },
        )

    a = pd.read_csv(folder / "group_A.csv.gz")
    stretches = {f"A{i}": run(a.iloc[i * 500 : (i + 1) * 500], 2.5) for i in range(6)}
    test = {name: stretches.pop(name) for name in ("A3", "A5")}
    b = run(pd.read_csv(folder / "group_B.csv.gz"), 5.0)
    parts = ("winding", "rotor")
    yield Case("paderborn", "stretches of the same cycle", parts, stretches, test)
    yield Case("paderborn", "another cycle", parts, stretches, {"B": b})


WATTS_PER_COUNT = 5.0
STALLED = ("Run1", "Run2", "Run3", "Run5", "Run13", "Run14")
"""Runs with a thermocouple in the winding and one on the stator's body, without the fan of Run4."""


def tass_bldc_stall(folder: Path) -> Iterator[Case]:
    """A large brushless motor close to standstill, heated by its power for minutes."""
    runs = stalled_runs(folder, STALLED)
    test = {name: runs.pop(name) for name in ("Run5", "Run14")}
    yield Case("tass bldc", "Run5 and Run14", ("winding", "stator"), runs, test)


def stalled_runs(folder: Path, names: Collection[str]) -> dict[str, Run]:
    """Runs of the motor close to standstill, by what their names begin with."""
    sensors = pd.read_csv(folder / "thermocouples_long.csv.gz")
    controller = pd.read_csv(folder / "esc_10hz.csv.gz")
    return {
        short: _stalled(sensors[sensors.run == name], controller[controller.run == name])
        for name in sorted(set(sensors.run))
        if (short := name.split("-")[0]) in names
    }


def _stalled(sensors: pd.DataFrame, controller: pd.DataFrame) -> Run:
    """A run on one clock: the thermocouples' is moved so that the winding begins to warm when power comes on."""
    at = {name: rows.dropna() for name, rows in sensors.groupby("sensor")}
    clock, winding = at["Winding Temp"].t_s.to_numpy(), at["Winding Temp"].T_C.to_numpy()
    first = clock[np.argmax(winding > np.median(winding[:20]) + 1.0)]
    on = float(controller.t_s[controller.P_W > 50.0].iloc[0])
    time = np.asarray(np.arange(max(on - 2.0, 0.0), float(controller.t_s.max()), 0.5), dtype=np.float64)
    held = controller.iloc[np.clip(np.searchsorted(controller.t_s, time, side="right") - 1, 0, None)]
    shown = {
        key: np.interp(time, rows.t_s.to_numpy() - (first - on), rows.T_C.to_numpy(), right=np.nan)
        for key, rows in at.items()
    }
    run = Run(
        time_s=time - time[0],
        pwm=np.clip(np.rint(held.P_W.to_numpy() / WATTS_PER_COUNT), 0, 255).astype(np.int64),
        temps={"winding": shown["Winding Temp"], "stator": shown["Stator Body"]},
        ambient=np.full(time.size, float(at["Ambient"].T_C.median())),
        extras={"current_A": held.I_A.to_numpy()},
    )
    return driven_by(run, f"P_W, 255 = {255.0 * WATTS_PER_COUNT:g} W")


Steps = tuple[tuple[float, float], ...]
"""From when, s, and how much, A."""
HELD_CURRENTS: dict[str, tuple[float, Steps]] = {
    "ak109Run1": (22.8, ((0.0, 16.37), (40.0, 0.0))),
    "ak109Run2": (21.3, ((0.0, 11.7), (60.0, 0.0))),
    "ak109Run3": (21.3, ((0.0, 14.0), (40.0, 0.0), (80.0, 14.0), (120.0, 0.0))),
    "ak109Run4": (21.4, ((0.0, 16.37), (90.0, 0.0), (180.0, 14.0), (270.0, 0.0), (360.0, 11.7), (450.0, 0.0))),
    "ak606Run1": (20.4, ((0.0, 3.6), (90.0, 0.0), (180.0, 2.95), (270.0, 0.0), (360.0, 2.0), (450.0, 0.0))),
    "ak606Run2": (20.6, ((0.0, 4.4), (90.0, 0.0), (180.0, 2.95), (270.0, 0.0), (360.0, 3.6), (450.0, 0.0))),
    "ak809Run1": (21.4, ((0.0, 9.75), (60.0, 0.0), (150.0, 8.52), (270.0, 0.0), (360.0, 7.31), (450.0, 0.0))),
}
"""The room, degC, and the currents of each run: they are in the author's program, not in the logs."""
FULL_CURRENTS = {"ak109": 20.0, "ak606": 5.0, "ak809": 10.0}
AK809_CUT_S = 360.0


def tmotor(folder: Path) -> Iterator[Case]:
    """Three actuators held at a current for a minute or so, and cooling: two with each run once left out.

    Of the third there is one run: its third heating is tested.
    """
    for motor in ("ak109", "ak606"):
        runs = {name: _held_current(folder, name) for name in HELD_CURRENTS if name.startswith(motor)}
        yield from each_left_out(f"tmotor {motor}", runs, ("motor",), lambda name: f"run {name[-1]}")
    run = _held_current(folder, "ak809Run1")
    fit, test = between(run, 0.0, AK809_CUT_S), between(run, AK809_CUT_S, np.inf)
    yield Case("tmotor ak809", "third heating", ("motor",), {"first two": fit}, {"third": test})


def _held_current(folder: Path, name: str) -> Run:
    table = pd.read_csv(folder / f"{name}Data.csv")
    time = table.time.to_numpy(dtype=np.float64)
    motor = table.temperature.astype(str).str.strip().to_numpy(dtype=np.float64)
    room, steps = HELD_CURRENTS[name]
    since = np.searchsorted([at for at, _ in steps], time, side="right") - 1
    current = np.array([level for _, level in steps])[since]
    pwm = np.rint(current / FULL_CURRENTS[name[:5]] * 255.0).astype(np.int64)
    run = Run(time, pwm, {"motor": motor}, np.full(time.size, room))
    return driven_by(run, f"current, 255 = {FULL_CURRENTS[name[:5]]:g} A")


REST_US, FULL_US = 1000.0, 2000.0
"""A speed controller's pulses at rest and at full throttle."""


def kde_motor(folder: Path) -> Iterator[Case]:
    """A drone's motor with its propeller, held at a throttle until it is hot, then off. Each run once left out."""
    runs = {}
    for path in sorted(folder.glob("Level-KDE-*.csv")):
        table = pd.read_csv(path)
        time = table["Time (s)"].to_numpy(dtype=np.float64)
        throttle = np.clip((table["ESC (µs)"].to_numpy(dtype=np.float64) - REST_US) / (FULL_US - REST_US), 0.0, 1.0)
        runs[path.stem.split("_")[0].removeprefix("Level-KDE-")] = Run(
            time_s=time - time[0],
            pwm=np.rint(throttle * 255.0).astype(np.int64),
            temps={"motor": _celsius(table["4LHE Temp (ºF)"])},
            ambient=_celsius(table["66NA Temp (ºF)"]),
            extras={"current_A": table["Current (A)"].to_numpy(dtype=np.float64)},
        )
    yield from each_left_out("kde motor", runs, ("motor",), lambda name: f"{name} us")


def _celsius(fahrenheit: pd.Series) -> FloatArray:
    return np.asarray((fahrenheit.to_numpy(dtype=np.float64) - 32.0) / 1.8)
