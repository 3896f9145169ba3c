"""Convert published logs of real machines to run files.

Run:  python examples/measured/convert.py SOURCE examples/measured

SOURCE holds `tclab/tclab_apm_runs.csv` and `tass_bldc_stall/`, see examples/measured/README.md. Their inputs are no PWM
of a motor: heater power in percent and electrical power in watts are written as counts, and the files say so.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pandas as pd

from gen.runs import Run, write_run

WATTS_PER_COUNT = 5.0
#: How much later the thermocouples' clock reads than the controller's, s: the author's own alignment of these runs,
#: found by laying his aligned series over both logs.
CLOCK_S = {"Run2-Throttle100": 8.2, "Run3-Throttle48": 7.6, "Run13-Throttle8": 7.0, "Run14-Throttle9": 11.5}
SENSORS = {"winding": "Winding Temp", "stator": "Stator Body"}
BLDC_ROW_S = 0.5


def tclab(source: Path, target: Path) -> None:
    """Two heaters, two sensors: one set of runs for each heater with its own sensor."""
    log = pd.read_csv(source / "tclab" / "tclab_apm_runs.csv")
    for name, rows in log.groupby("run"):
        for own, other in ((1, 2), (2, 1)):
            measured = rows[f"T{own}_C"].to_numpy(dtype=np.float64)
            counts = np.round(rows[f"Q{own}"].to_numpy(dtype=np.float64) * 2.55).astype(np.int64)
            run = Run(
                rows["t_s"].to_numpy(dtype=np.float64),
                counts,
                {f"sensor{own}": measured},
                np.full(len(measured), measured[0]),
                extras={f"heater{other}_percent": rows[f"Q{other}"].to_numpy(dtype=np.float64)},
                comments={
                    "source": "Temperature Control Lab, github.com/APMonitor/arduino @ f36e65a, Apache-2.0",
                    "pwm": f"heater {own} in percent times 2.55, rounded; heater {other} is not part of it",
                    "ambient": "not measured: the sensor's first reading, held",
                },
            )
            write_run(target / "tclab" / f"{name}_heater{own}.csv", run)


def bldc(source: Path, target: Path) -> None:
    """A brushless motor close to standstill: electrical power heats it, so power takes the input's place."""
    folder = source / "tass_bldc_stall"
    sensors, controller = pd.read_csv(folder / "thermocouples_long.csv.gz"), pd.read_csv(folder / "esc_10hz.csv.gz")
    for name, shift in CLOCK_S.items():
        power = controller[controller["run"] == name]
        time = np.arange(0.0, float(power["t_s"].max()), BLDC_ROW_S)
        at = np.floor(power["t_s"].to_numpy(dtype=np.float64) / BLDC_ROW_S).astype(np.int64)
        watts = pd.Series(power["P_W"].to_numpy(dtype=np.float64)).groupby(at).mean().reindex(range(len(time)))
        watts = watts.ffill().fillna(0.0)
        mine = sensors[sensors["run"] == name]
        run = Run(
            time,
            np.clip(np.round(watts.to_numpy() / WATTS_PER_COUNT), 0, 255).astype(np.int64),
            {part: _nearest(mine, sensor, time + shift) for part, sensor in SENSORS.items()},
            _nearest(mine, "Ambient", time + shift),
            {"power_W": np.round(watts.to_numpy(dtype=np.float64), 1)},
            {
                "source": "github.com/TasS-RV/Motor-Thermal-Modelling-Tool @ e94b107, MIT",
                "pwm": f"electrical power over {WATTS_PER_COUNT:g} W, rounded; mean over {BLDC_ROW_S} s",
                "input": f"power_W, 255 = {255.0 * WATTS_PER_COUNT:g} W",
            },
        )
        write_run(target / "bldc" / f"{name.split('-')[0].lower()}.csv", run)


def _nearest(mine: pd.DataFrame, sensor: str, time: np.ndarray) -> np.ndarray:  # type: ignore[type-arg]
    """Give each row the sample nearest to it, within half a row; the rest stays missing: nothing is interpolated."""
    rows = mine[mine["sensor"] == sensor].dropna()
    clock, values = rows["t_s"].to_numpy(dtype=np.float64), rows["T_C"].to_numpy(dtype=np.float64)
    index = np.clip(np.searchsorted(clock, time), 1, len(clock) - 1)
    index -= time - clock[index - 1] < clock[index] - time
    return np.where(np.abs(clock[index] - time) <= BLDC_ROW_S / 2.0, values[index], np.nan)


if __name__ == "__main__":
    source, target = Path(sys.argv[1]), Path(sys.argv[2])
    for folder in ("tclab", "bldc"):
        (target / folder).mkdir(exist_ok=True)
    tclab(source, target)
    bldc(source, target)
