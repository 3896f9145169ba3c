"""The public logs, as runs, and what is fitted and tested of each.

A log becomes run files as a person would write them: its temperatures under their names, its input as PWM (a current,
a speed or a power over its full scale), all else as extra columns. Nothing is smoothed, shifted or left out, but that
two clocks of one log are put on one.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Collection, Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from gen.interface import import_runs
from gen.runs import Run, read_run

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Case:
    """What is fitted, and what is tested.

    Attributes
    ----------
    machine
        Short name of the log.
    what
        Which of its runs are tested, and what is special.
    parts
        The temperatures that are judged; others are neighbours.
    fit, test
        Runs by name.
    """

    machine: str
    what: str
    parts: tuple[str, ...]
    fit: dict[str, Run]
    test: dict[str, Run]

    def __str__(self) -> str:
        return f"{self.machine}, {self.what}"


def cases(folder: Path) -> Iterator[Case]:
    """Give the cases of every log that the folder holds, the small ones first."""
    for name, made in READERS.items():
        if (folder / name).is_dir():
            yield from made(folder / name)


def gimbalbot(folder: Path) -> Iterator[Case]:
    """A brushless motor that runs for two minutes and cools for ten; each run once left out."""
    runs = _files(sorted(folder.glob("*.csv")))
    yield from _each_left_out("gimbalbot", runs, ("motor",), lambda name: f"run {name.split('-')[1]}")


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
        yield from _each_left_out(f"tclab heater {own}", runs, (f"heater{own}",), lambda name: name.split("_")[1])


def battery_cell(folder: Path) -> Iterator[Case]:
    """A cell under random current: tested on other random runs, and on discharges at 1 and 2 C."""
    files = _read(sorted(folder.glob("cell1_*.csv")))
    runs = {path.stem.removeprefix("cell1_"): _driven_by(run, "current, 255 = 6 A") for path, run in files}
    test = {name: runs[name] for name in ("random05", "random15", "random25", "random35", "random45")}
    fit = {name: runs[name] for name in ("random00", "random10", "random20", "random30", "random40")}
    surface = ("surface",)
    yield Case("battery cell", "from five random runs", surface, fit, test)
    yield Case("battery cell", "from one random run", surface, {"random00": runs["random00"]}, test)
    held = {name: runs[name] for name in ("ref_1C", "two_C")}
    yield Case("battery cell", "random runs, tested on held currents", surface, fit, held)


def ur3(folder: Path) -> Iterator[Case]:
    """Joints of a robot arm, one morning in three parts, the room not measured. Each part once left out."""
    for joint in (3, 4, 5):
        runs = _files(sorted(folder.glob(f"joint{joint}_*.csv")))
        yield from _each_left_out(f"ur3 joint {joint}", runs, (f"joint{joint}",), lambda name: name.split("_")[1])


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
    return _driven_by(run, f"P_W, 255 = {255.0 * WATTS_PER_COUNT:g} W")


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
    yield from _each_left_out("reflow oven", runs, ("oven",), str)


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
    yield from _each_left_out("heating plate", halves, ("plate",), str)


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
        yield from _each_left_out(f"tmotor {motor}", runs, ("motor",), lambda name: f"run {name[-1]}")
    run = _held_current(folder, "ak809Run1")
    fit, test = _between(run, 0.0, AK809_CUT_S), _between(run, AK809_CUT_S, np.inf)
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
    return _driven_by(run, f"current, 255 = {FULL_CURRENTS[name[:5]]:g} A")


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
        halves[name] = _driven_by(run, f"Ph, 255 = {HOUSE_KILOWATTS:g} kW")
    yield from _each_left_out("house", halves, ("inside",), str)


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
    yield from _each_left_out("incubator", runs, ("box",), str)


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
    yield from _each_left_out("kde motor", runs, ("motor",), lambda name: f"{name} us")


def _celsius(fahrenheit: pd.Series) -> FloatArray:
    return np.asarray((fahrenheit.to_numpy(dtype=np.float64) - 32.0) / 1.8)


def _driven_by(run: Run, said: str) -> Run:
    """A run that says what its input is, as `gen import --input COLUMN --full-scale X` writes it."""
    return replace(run, comments={**run.comments, "input": said})


def _between(run: Run, first: float, until: float) -> Run:
    rows = (run.time_s >= first) & (run.time_s < until)
    ambient = None if run.ambient is None else run.ambient[rows]
    temps = {name: values[rows] for name, values in run.temps.items()}
    return Run(run.time_s[rows] - run.time_s[rows][0], run.pwm[rows], temps, ambient, comments=run.comments)


def _read(paths: list[Path]) -> Iterator[tuple[Path, Run]]:
    for path in paths:
        yield path, read_run(path)


def _files(paths: list[Path]) -> dict[str, Run]:
    return {path.stem: run for path, run in _read(paths)}


def _each_left_out(
    machine: str, runs: dict[str, Run], parts: tuple[str, ...], short: Callable[[str], str]
) -> Iterator[Case]:
    for left in runs:
        fit = {name: run for name, run in runs.items() if name != left}
        yield Case(machine, short(left), parts, fit, {left: runs[left]})


READERS: dict[str, Callable[[Path], Iterator[Case]]] = {
    "gimbalbot": gimbalbot,
    "tclab": tclab,
    "ur3": ur3,
    "battery_cell": battery_cell,
    "tass_bldc_stall": tass_bldc_stall,
    "paderborn_mini": paderborn,
    "reflow_oven": reflow_oven,
    "heating_plate": heating_plate,
    "tmotor": tmotor,
    "house": house,
    "incubator": incubator,
    "kde_motor": kde_motor,
}
"""By the folder that holds the log."""
