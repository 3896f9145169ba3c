"""The public logs, as runs, and what is fitted and tested of each.

A log becomes run files as a person would write them: its temperatures under their names, its input as PWM (a current,
a speed or a power over its full scale), all else as extra columns. Nothing is smoothed, shifted or left out, but that
two clocks of one log are put on one.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

from benchmarks.real_machines.logs.case import Case as Case
from benchmarks.real_machines.logs.case import FloatArray as FloatArray
from benchmarks.real_machines.logs.heaters import battery_cell, heating_plate, reflow_oven, tclab, unthermal
from benchmarks.real_machines.logs.motors import gimbalbot, kde_motor, paderborn, tass_bldc_stall, tmotor, ur3
from benchmarks.real_machines.logs.rooms import armadillo_box, house, incubator
from benchmarks.real_machines.logs.switched import (
    hotend_onion,
    incubator_intocps,
    kettle_brautomat,
    sbhs_prbs,
    uconsole_cm5,
    unb_bench,
)

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
    "unthermal": unthermal,
    "armadillo_box": armadillo_box,
    "kettle_brautomat": kettle_brautomat,
    "sbhs_prbs": sbhs_prbs,
    "incubator_intocps": incubator_intocps,
    "hotend_onion": hotend_onion,
    "unb_bench": unb_bench,
    "uconsole_cm5": uconsole_cm5,
}
"""By the folder that holds the log."""


def cases(folder: Path) -> Iterator[Case]:
    """Give the cases of every log that the folder holds, the small ones first."""
    for name, made in READERS.items():
        if (folder / name).is_dir():
            yield from made(folder / name)
