"""Public logs of which somebody wrote down that something was not as usual, and what the tools make of it.

    python -m benchmarks.real_machines.anomalies --data FOLDER

FOLDER/tass_bldc_stall is a large motor close to standstill (docs/real_machines.md). Beside the run whose name says
`fanon`, its author notes that a thermocouple outside of the phases was disturbed by the motor while it ran (`Ext-above-
PHA` in Run10A to Run10D); in the last of them a second one is beside it.

* **Disturbed sensor**: how many readings identification and refinement believe, of it and of all sensors that were not.
* **Fan**: a network from three runs without it, by how much it declares itself to be off, its error on one more of
  these, on the run with the fan and on one with less voltage, and after how long these are further off than the first
  ever was.
"""

from __future__ import annotations

import argparse
import json
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

import gen
from benchmarks.real_machines.logs.case import FloatArray
from benchmarks.real_machines.logs.motors import stalled_runs
from gen.identification.logs.believed import believed
from gen.runs import Run, write_run

LOG = "tass_bldc_stall"
DISTURBED, BESIDE = "Ext-above-PHA", "Ext-above-PHA-tc2"
NO_READING_DEGC = -200.0
"""Below it the logger wrote that there was none."""
OFF_K = 5.0
HEALTHY, FRESH, FAN, WEAKER = ("Run1", "Run2", "Run3"), "Run5", "Run4", "Run14"


@dataclass(frozen=True)
class Believed:
    """What is believed of one sensor in one run.

    Attributes
    ----------
    run, sensor
        Which.
    readings, kept
        How many there are, and are believed.
    off
        How many are off by more than `OFF_K` from a sensor beside it; -1 where there is none.
    """

    run: str
    sensor: str
    readings: int
    kept: int
    off: int = -1


def sensors(folder: Path) -> Iterator[Believed]:
    """Judge every sensor of every run."""
    table = pd.read_csv(folder / "thermocouples_long.csv.gz")
    for run, rows in table.groupby("run"):
        at = {str(name): own.sort_values("t_s") for name, own in rows.groupby("sensor")}
        for name, own in at.items():
            time, shown = own.t_s.to_numpy(dtype=np.float64), own.T_C.to_numpy(dtype=np.float64)
            shown = np.where(shown > NO_READING_DEGC, shown, np.nan)
            off = -1
            if name == DISTURBED and BESIDE in at:
                true = np.interp(time, at[BESIDE].t_s.to_numpy(), at[BESIDE].T_C.to_numpy())
                off = int(np.count_nonzero(np.abs(shown - true) > OFF_K))
            yield Believed(str(run), name, int(np.isfinite(shown).sum()), int(believed(time, shown).sum()), off)


def residuals(folder: Path) -> tuple[gen.Model, dict[str, tuple[FloatArray, dict[str, FloatArray]]]]:
    """Predict the runs that took no part.

    Returns
    -------
    model, dict
        The network; and by run: times, shape (N,), s, and by part measured minus modelled, shape (N,), K.
    """
    runs = stalled_runs(folder, (*HEALTHY, FRESH, FAN, WEAKER))
    with tempfile.TemporaryDirectory(prefix="real-") as scratch:
        paths = {name: Path(scratch) / f"{name}.csv" for name in runs}
        for name, run in runs.items():
            write_run(paths[name], run)
        model = gen.identify([paths[name] for name in HEALTHY], name="stalled", model="network").model
        tested = (FRESH, FAN, WEAKER)
        return model, {name: (runs[name].time_s, _residual(model, runs[name], paths[name])) for name in tested}


def _residual(model: gen.Model, run: Run, path: Path) -> dict[str, FloatArray]:
    shown = gen.simulate(model, path)
    return {name: read - shown[f"{name}_degC"].to_numpy(dtype=np.float64) for name, read in run.temps.items()}


def main() -> None:
    """Print both."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", type=Path, required=True, help="folder of the logs")
    folder = parser.parse_args().data / LOG
    found = list(sensors(folder))
    for one in found:
        if one.sensor == DISTURBED:
            off = "" if one.off < 0 else f"; {one.off} are off by more than {OFF_K:g} K from the one beside it"
            print(f"{one.run}, {one.sensor}: {one.kept} of {one.readings} readings believed{off}")
    sound = [one for one in found if one.sensor != DISTURBED]
    lost = [f"{one.run}, {one.sensor}: {one.readings - one.kept}" for one in sound if one.kept < one.readings]
    print(f"of {len(sound)} others {sum(one.readings for one in sound)} readings; not believed: {'; '.join(lost)}")
    model, judged = residuals(folder)
    for entry in json.loads(model.text)["provenance"]["error"]:
        (low, high), (slow, fast) = entry["model_minus_measured_K"], entry["pwm"]
        print(f"{entry['component']} at PWM {slow} to {fast}: declared {low:+.0f} .. {high:+.0f} K")
    worst = {part: float(np.nanmax(np.abs(error))) for part, error in judged[FRESH][1].items()}
    for run, (time, by_part) in judged.items():
        for part, error in by_part.items():
            beyond = time[np.abs(error) > worst[part]]
            after = f"; beyond {worst[part]:.1f} K after {beyond[0]:.0f} s" if beyond.size else ""
            rms, mean = float(np.sqrt(np.nanmean(error**2))), float(np.nanmean(error))
            print(f"{run}, {part}: {rms:.1f} K root mean square, mean {mean:+.1f} K{after}")


if __name__ == "__main__":
    main()
