"""Logs of heaters that are switched: every few rows of them, and beside them the times of every change.

Rows that are further apart than the heater's changes do not say for how long it was on, so the input is written anew
at each second from the times in ``*switches*.csv``; temperatures stay in the rows that there are.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd

from benchmarks.real_machines.logs.case import Case, FloatArray, between
from gen.runs import Run

KETTLE_BEGIN_S, KETTLE_CUT_S = 1382907449.0, 1382908054.0
"""In the rows before, the probe cools from what it was in."""
PRBS_CUT_S = 600.5


def kettle_brautomat(folder: Path) -> Iterator[Case]:
    """Water in a kettle that is on for some 20 s at once: the last two of six times are tested."""
    table, changes = _read(folder / "efbe_schott_wasserkocher.csv"), _read(folder / "heater_switches.csv")
    run = _each_second(table.second, {"water": table.Isttemperatur}, changes.time, changes.Status_Heizung)
    yield _cut("kettle", "water", run, KETTLE_BEGIN_S, KETTLE_CUT_S)


def sbhs_prbs(folder: Path) -> Iterator[Case]:
    """A plate with a coil and a fan under random binary steps, from warm: the last 400 of 1 000 s are tested."""
    table, changes = _read(folder / "prbs_29Apr2014.csv"), _read(folder / "heater_switches.csv")
    run = _each_second(table.iteration, {"plate": table.temp}, changes.iteration, changes.heater / 100.0)
    yield _cut("sbhs", "plate", run, 0.0, PRBS_CUT_S)


def incubator_intocps(folder: Path) -> Iterator[Case]:
    """A box of foam with a fan, heated at random for five minutes and left to cool: the second run is tested."""
    runs = {}
    for name, number in (("first", ""), ("second", "_2")):
        table, changes = (
            _read(folder / f"random_on_off_sequences{number}.csv"),
            _read(folder / f"heater_switches{number}.csv"),
        )
        temperatures = {"box": table.t2, "corner": table.t3, "ambient": table.t1}
        runs[name] = _each_second(table.time, temperatures, changes.time, changes.heater_on)
    yield Case("foam box", "second run", ("box", "corner"), {"first": runs["first"]}, {"second": runs["second"]})


HOTEND_CUT_S = 722.0
HOTEND_SWITCHES = "switches.csv"


def hotend_onion(folder: Path) -> Iterator[Case]:
    """A printer's nozzle, heated at full power to 218 degC and left to cool, without its fan, and with it.

    Of each a run is fitted and another one, of another day, is tested. The author noted the room, 21.4 degC.
    """
    changes = _read(folder / HOTEND_SWITCHES)
    runs = {}
    for file in ("heattest", "heattest_200", "heattest_fan_200_2"):
        table, own = _read(folder / f"{file}.csv"), changes[changes.file == f"{file}.csv"]
        run = _each_second(table.time_s, {"nozzle": table.T_C}, own.time_s, own.pwm)
        runs[file] = replace(run, ambient=np.full(run.time_s.size, 21.4))
    still, moved = between(runs["heattest_200"], 0.0, HOTEND_CUT_S), between(runs["heattest_200"], HOTEND_CUT_S, np.inf)
    yield Case("hotend", "without fan", ("nozzle",), {"A": runs["heattest"]}, {"B1": still})
    yield Case("hotend", "with fan", ("nozzle",), {"B2": moved}, {"C": runs["heattest_fan_200_2"]})


BENCH_CUT = "2021-09-04 10:19:47"


def unb_bench(folder: Path) -> Iterator[Case]:
    """A closed box with a resistor, and a fan that is on while that is off; three of five times are tested."""
    table, changes = (_dated(_read(folder / file)) for file in ("on-off.csv", "switches_on-off.csv"))
    heater = changes["Atuadores"].str.rstrip("%").astype(float).clip(lower=0.0) / 100.0
    temperatures = {"box": table["Internal Temperature"], "ambient": table["External Temperature"]}
    run = _each_second(table.time, temperatures, changes.time, heater)
    cut = float(pd.Timestamp(BENCH_CUT).timestamp())
    yield Case(
        "resistor box", "later", ("box",), {"before": between(run, 0.0, cut)}, {"later": between(run, cut, np.inf)}
    )


def uconsole_cm5(folder: Path) -> Iterator[Case]:
    """A computer in a closed case, idle and under full load; its cooling is tested. The author noted the room."""
    runs = {}
    for phase, load in (("idle", 0), ("stress", 255), ("cooldown", 0)):
        table = _read(folder / f"{phase}.csv")
        time = table.t_s.to_numpy(dtype=np.float64)
        chip = table.temp_c.to_numpy(dtype=np.float64)
        runs[phase] = Run(time, np.full(time.size, load), {"chip": chip}, np.full(time.size, 26.0))
    test = {"cooldown": runs.pop("cooldown")}
    yield Case("computer", "cooling", ("chip",), runs, test)


def _dated(table: pd.DataFrame) -> pd.DataFrame:
    """Times of day as seconds."""
    named = table.rename(columns=str.strip)
    at = pd.to_datetime(named.Timestamp, format="%d/%m/%Y %H:%M:%S")
    return named.assign(time=(at - pd.Timestamp(0)).dt.total_seconds())


def _read(path: Path) -> pd.DataFrame:
    return pd.read_csv(path)


def _each_second(time: pd.Series, temperatures: Mapping[str, pd.Series], at: pd.Series, share: pd.Series) -> Run:
    """A run with one row each second; the heater is off before its first change."""
    seconds = np.arange(np.ceil(time.iloc[0]), np.floor(time.iloc[-1]) + 1.0)
    held = np.append(0.0, share.to_numpy(dtype=np.float64))
    pwm = np.rint(held[np.searchsorted(at.to_numpy(dtype=np.float64), seconds, side="right")] * 255.0).astype(np.int64)
    rows = np.rint(time.to_numpy(dtype=np.float64) - seconds[0]).astype(np.int64)
    inside = (rows >= 0) & (rows < seconds.size)
    shown: dict[str, FloatArray] = {}
    for name, values in temperatures.items():
        shown[name] = np.full(seconds.size, np.nan)
        shown[name][rows[inside]] = values.to_numpy(dtype=np.float64)[inside]
    return Run(seconds, pwm, shown, shown.pop("ambient", None))


def _cut(machine: str, part: str, run: Run, begin: float, cut: float) -> Case:
    """The first part of a run fitted, the rest tested."""
    return Case(machine, "later", (part,), {"before": between(run, begin, cut)}, {"later": between(run, cut, np.inf)})
