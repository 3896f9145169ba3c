"""`gen refine` on logs of real machines that nobody planted anything in.

    python benchmarks/refine_real.py FOLDER

FOLDER holds ``tclab/tclab_apm_runs.csv`` (Temperature Control Lab, Apache-2.0), ``tass_bldc_stall`` (a brushless motor
at standstill, MIT) and ``paderborn_mini/group_A.csv.gz`` and ``group_B.csv.gz`` (PMSM of Paderborn University, CC BY-SA
4.0, not shipped with this project). What is missing is left out. A deliberately poor baseline is fitted first: the lab
with one of its two heaters, the motor at standstill by its power, the PMSM by its speed alone. Then `gen refine` says
what it misses, and errors are printed on runs or stretches that took no part.
"""

from __future__ import annotations

import json
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from scipy.optimize import least_squares

ROOT = Path(__file__).parent.parent
sys.path.insert(0, str(ROOT))

from gen.coefficients import parse  # noqa: E402
from gen.refinement.refine import refine  # noqa: E402
from gen.runs import Run, write_run  # noqa: E402


def baseline(name: str, runs: list[Run], components: list[str], second: str | None = None) -> str:
    """A coefficient file with two poles a component and a gain proportional to PWM.

    With `second`, a column that heats as well is fitted beside, and then left out of the file: what remains is
    the model that a test of the first input alone would have given.
    """
    entries = []
    for component in components:

        def residual(u: np.ndarray, component: str = component) -> np.ndarray:
            gain, tau, lag, other = np.exp(u)
            parts = []
            for run in runs:
                beside = other * run.extras[second] if second else np.zeros(run.time_s.size)
                room = run.ambient if run.ambient is not None else np.full(run.time_s.size, 25.0)
                rise = np.empty(run.time_s.size)
                source = rise[0] = run.temps[component][0] - room[0]
                for k, h in enumerate(np.diff(run.time_s)):
                    target = gain * abs(run.pwm[k]) + beside[k]
                    source = target + (source - target) * np.exp(-h / tau)
                    rise[k + 1] = source + (rise[k] - source) * np.exp(-h / lag)
                off = run.temps[component] - room - rise
                parts.append(off[np.isfinite(off)])
            return np.concatenate(parts)

        limits = (np.log([0.005, 10.0, 3.0, 1e-4]), np.log([8.0, 3600.0, 600.0, 2.0]))
        found = least_squares(residual, np.log([0.3, 300.0, 15.0, 0.1]), bounds=limits)
        gain, tau, lag, beside = np.exp(found.x)
        entries.append(
            {
                "name": component,
                "order": 2,
                "gain": {"poly": [gain / tau / lag]},
                "poles": [{"real": {"poly": [-1.0 / tau]}}, {"real": {"poly": [-1.0 / lag]}}],
            }
        )
        left_out = f"; {second}: {beside:.3f} K per unit, left out" if second else ""
        print(f"  baseline, {component}: {gain:.3f} K per count, {tau:.0f} s and {lag:.0f} s{left_out}")
    return json.dumps(
        {
            "format": "gen-coefficients",
            "version": 1,
            "name": name,
            "sample_time_s": 0.25,
            "input": {"name": "pwm", "full_scale": 255, "nominal_speed_rpm": 6000},
            "ambient": {"channel": "ambient_degC"},
            "validity": {"pwm": [0, 255], "outside": "hold"},
            "domain": {"pwm": [0, 255], "ambient_degC": [-10, 100], "temperature_degC": [-10, 200]},
            "components": entries,
        }
    )


def show(text: str, fit: dict[str, Run], test: dict[str, Run]) -> None:
    """Refine and print."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for key, run in {**fit, **test}.items():
            write_run(folder / f"{key}.csv", run)
        found = refine(
            parse(text.encode()), text, [folder / f"{k}.csv" for k in fit], [folder / f"{k}.csv" for k in test]
        )
    for component, candidates in found.tracing.considered.items():
        for c in candidates[:3]:
            why = "; ".join(c.judgement.reasons) or "passes"
            print(f"    considered, {component}: {c.label}, left-out RMSE {c.judgement.after_K:.2f} K: {why}")
    print(f"  verdict: {found.verdict} ({found.tracing.tried} hypotheses)")
    for effect in found.effects:
        numbers = {k: v for k, v in effect["parameters"].items() if v is not None}
        others = [other["name"] for other in effect["evidence"]["lookalikes"]]
        print(f"  {effect['component']}: {effect['name']} {numbers}; look-alikes: {', '.join(others) or 'none'}")
    before, after = found.before.summary(), found.after.summary()
    for kind in ("fit", "test"):
        print(f"  {kind}: RMSE {before[kind]['rmse_K']:.2f} -> {after[kind]['rmse_K']:.2f} K")
    for path, parts in after["per_run"].items():
        if Path(path).stem in test:
            cells = ", ".join(
                f"{n} {before['per_run'][path][n]['rmse_K']:.2f} -> {e['rmse_K']:.2f}" for n, e in parts.items()
            )
            print(f"    {Path(path).stem}: {cells}")
    for component, left in found.remains.items():
        most = ", ".join(f"{k} {v:.0%}" for k, v in list(left.shares.items())[:3])
        print(f"  {component}: {left.rms_K:.2f} K left (noise {left.noise_K:.2f} K), goes with {most}")


def tclab(folder: Path) -> None:
    """Two heaters, one of them modelled, either way round."""
    table = pd.read_csv(folder / "tclab" / "tclab_apm_runs.csv")
    for own, other in ((1, 2), (2, 1)):
        runs = {}
        for name, rows in table.groupby("run"):
            temps = rows[f"T{own}_C"].to_numpy()
            runs[str(name)] = Run(
                time_s=rows.t_s.to_numpy(),
                pwm=np.rint(rows[f"Q{own}"].to_numpy() * 2.55).astype(np.int64),
                temps={f"heater{own}": temps},
                ambient=np.full(len(rows), float(temps[0])),
                extras={
                    f"Q{other}_percent": rows[f"Q{other}"].to_numpy(),
                    f"T{other}_degC": rows[f"T{other}_C"].to_numpy(),
                },
            )
        print(f"Temperature Control Lab, only heater {own} modelled")
        test = {k: v for k, v in runs.items() if k == "apm_hybrid_mimo"}
        fit = {k: v for k, v in runs.items() if k not in test}
        show(baseline("tclab", list(fit.values()), [f"heater{own}"], second=f"Q{other}_percent"), fit, test)
        told(runs, f"heater{own}", f"T{other}_degC")


def told(runs: dict[str, Run], component: str, other: str) -> None:
    """What these runs tell of the other heater: its heat fitted together with all else, at several ambients."""
    print(f"  heat exchanged with {other}, in 1/s, when gain, both time constants and it are fitted together:")
    for names in ([*runs], *([name] for name in runs)):
        cells = []
        for room in (-2.0, 0.0, 2.0, 4.0):

            def residual(u: np.ndarray, names: list[str] = names, room: float = room) -> np.ndarray:
                gain, tau, lag = np.exp(u[:3])
                parts = []
                for name in names:
                    run = runs[name]
                    around = run.temps[component][0] + room
                    shown = np.empty(run.time_s.size)
                    part = shown[0] = run.temps[component][0]
                    for k, h in enumerate(np.diff(run.time_s)):
                        rate = 1.0 / tau + u[3]
                        target = ((around + gain * abs(run.pwm[k])) / tau + u[3] * run.extras[other][k]) / rate
                        part = target + (part - target) * np.exp(-rate * h)
                        shown[k + 1] = part + (shown[k] - part) * np.exp(-h / lag)
                    parts.append((run.temps[component] - shown) / np.sqrt(run.time_s.size))
                return np.concatenate(parts)

            limits = (
                [np.log(0.02), np.log(30.0), np.log(3.0), -2e-3],
                [np.log(2.0), np.log(2000.0), np.log(120.0), 3e-2],
            )
            found = least_squares(residual, [np.log(0.22), np.log(190.0), np.log(15.0), 1e-3], bounds=limits)
            rms = np.sqrt(2.0 * found.cost / len(names))
            cells.append(f"ambient {room:+.0f} K: {found.x[3]:+.4f} ({rms:.2f} K left)")
        print(f"    {'all runs' if len(names) > 1 else names[0]:16s} {'; '.join(cells)}")


def paderborn(folder: Path) -> None:
    """A PMSM by its speed alone."""

    def run(rows: pd.DataFrame, step: float) -> Run:
        return Run(
            time_s=np.arange(len(rows)) * step,
            pwm=np.clip(np.rint(rows.motor_speed.to_numpy() / 6000.0 * 255.0), 0, 255).astype(np.int64),
            temps={"winding": rows.stator_winding.to_numpy(), "rotor": rows.pm.to_numpy()},
            ambient=rows.ambient.to_numpy(),
            extras={
                "current_A": np.hypot(rows.i_d.to_numpy(), rows.i_q.to_numpy()),
                "voltage_V": np.hypot(rows.u_d.to_numpy(), rows.u_q.to_numpy()),
                "torque_Nm": rows.torque.to_numpy(),
                "coolant_degC": rows.coolant.to_numpy(),
            },
        )

    a = pd.read_csv(folder / "paderborn_mini" / "group_A.csv.gz")
    parts = {f"A{i}": run(a.iloc[i * 500 : (i + 1) * 500], 2.5) for i in range(6)}
    test = {k: parts[k] for k in ("A3", "A5")}
    b = folder / "paderborn_mini" / "group_B.csv.gz"
    if b.exists():
        test["B"] = run(pd.read_csv(b), 5.0)
    fit = {k: parts[k] for k in ("A0", "A1", "A2", "A4")}
    print(
        "PMSM, speed alone (profile A in six stretches; tested on two of them, and on profile B, another drive cycle)"
    )
    show(baseline("pmsm", list(fit.values()), ["winding", "rotor"]), fit, test)


WATTS_PER_COUNT = 5.0
STALLED = ("Run1", "Run2", "Run3", "Run4", "Run5", "Run13", "Run14")
"""Runs with a thermocouple in the winding and one on the stator's body; a fan blew in Run4 only."""


def bldc(folder: Path) -> None:
    """A brushless motor close to standstill: electrical power heats it, so power takes the input's place."""
    sensors = pd.read_csv(folder / "tass_bldc_stall" / "thermocouples_long.csv.gz")
    controller = pd.read_csv(folder / "tass_bldc_stall" / "esc_10hz.csv.gz")
    runs = {}
    for name in sorted(set(sensors.run)):
        short = name.split("-")[0]
        if short in STALLED:
            runs[short] = _stalled(sensors[sensors.run == name], controller[controller.run == name], short == "Run4")
    test = {key: runs.pop(key) for key in ("Run5", "Run14")}
    calm = [run for key, run in runs.items() if key != "Run4"]
    print("Brushless motor at standstill, by its power alone; Run4 with a fan; tested on Run5 and Run14")
    show(baseline("bldc", calm, ["winding", "stator"]), runs, test)


def _stalled(sensors: pd.DataFrame, controller: pd.DataFrame, fan: bool) -> Run:
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
    return Run(
        time_s=time - time[0],
        pwm=np.clip(np.rint(held.P_W.to_numpy() / WATTS_PER_COUNT), 0, 255).astype(np.int64),
        temps={"winding": shown["Winding Temp"], "stator": shown["Stator Body"]},
        ambient=np.full(time.size, float(at["Ambient"].T_C.median())),
        extras={"current_A": held.I_A.to_numpy(), "fan_contact": np.full(time.size, float(fan))},
    )


def main() -> None:
    """Do what the folder has data for."""
    folder = Path(sys.argv[1])
    sets: dict[str, Callable[[Path], Any]] = {"tclab": tclab, "tass_bldc_stall": bldc, "paderborn_mini": paderborn}
    for name, work in sets.items():
        if (folder / name).is_dir():
            work(folder)
            print()


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    main()
