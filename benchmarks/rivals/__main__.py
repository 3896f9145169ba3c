"""Side by side with what people use today, on the same machine and the same emulated Mega.

    python -m benchmarks.rivals [--only code] [--quick] [--json FILE]

`code`: ways to have the MY1016's model on the board. Errors are the board's own words against the exact solution, over
a step to 60 %, a staircase of ten minutes a level and a toggling every two seconds, three hours each (`--quick`:
eighteen minutes); cycles are the worst of these runs; flash and RAM the model's alone, compiled with PlatformIO's
flags; bit for bit: every word of the board's equals its reference's, which for a rival is its own C++ compiled by g++.

`loop`: identification of random plants from steps at five speeds, judged by a free run over a fresh profile, and of
motors of independent physics (`benchmarks.plants`) from steps and mixed runs; and one planted effect a trial, traced by
`gen refine` and by general tools that get the residual and a library of the same terms, on the MY1016's parts and on a
motor of independent physics. Times are processor time as multiples of this tool's.

`alarms`: ways to hear of a fault of the simulated motor, on the runs of `benchmarks.alarm_hours`. All get their
thresholds from the healthy runs that `examples/my1016_rig` has its own from; the rivals' are 1.2 times the worst that
they show. An alarm in a healthy run, or before its fault, is a false one.

`cost`: what the emitted fixed-point model costs as it grows. Build (lowering, proof, text) and verify (compiling,
running and comparing here and on the emulated Mega, over the same samples) are processor time as multiples of the
first row's verify. The largest models are what a file holds, or less by the straight line through a series' two
largest, within 4 000 000 cycles a tick: on the Mega beside the MY1016's sketch; on the Uno alone.

`host`: what a sample takes in the simulators, what the commands take to start, and what `gen identify` and
`gen refine` take over the length and the number of runs, for parts and for a network: processor time as multiples
within each table, and the most memory of the process.

A rival whose library is not installed (`pip install '.[rivals]'` installs all) has a row that says so, and the exit
status is 1.
"""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Callable, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

from rich.console import Console
from rich.table import Table

from benchmarks.campaign import json_text
from benchmarks.rivals.alarms.judge import judged
from benchmarks.rivals.alarms.table import alarm_table
from benchmarks.rivals.code.measure import rows as code_rows
from benchmarks.rivals.code.profiles import LENGTH
from benchmarks.rivals.code.table import code_table
from benchmarks.rivals.growth.measure import grown
from benchmarks.rivals.growth.table import boards_table, growth_table
from benchmarks.rivals.host.commands import COMMANDS, starts
from benchmarks.rivals.host.simulators import rates
from benchmarks.rivals.host.table import rates_table, starts_table, work_table
from benchmarks.rivals.host.work import KINDS as MODELS
from benchmarks.rivals.host.work import QUICK_SIZES, SIZES, worked
from benchmarks.rivals.loop.identification import identified
from benchmarks.rivals.loop.motors import identified_motors, traced_motors
from benchmarks.rivals.loop.table import identified_table, traced_table
from benchmarks.rivals.loop.tracing import KINDS, traced
from gen.coefficients import load

ROOT = Path(__file__).parents[2]
MY1016 = ROOT / "examples" / "my1016" / "coeffs.json"
QUICK_LENGTH = LENGTH // 10
MOTOR = 10_100
"""Seed of the motor whose changes are traced."""
Part = Callable[[bool, Callable[[str], None]], tuple[list[Table], Sequence[Any]]]


def _code(quick: bool, tell: Callable[[str], None]) -> tuple[list[Table], Sequence[Any]]:
    rows = code_rows(load(MY1016), QUICK_LENGTH if quick else LENGTH, tell)
    return [code_table(rows)], rows


def _alarms(quick: bool, tell: Callable[[str], None]) -> tuple[list[Table], Sequence[Any]]:
    found = judged(quick, tell)
    return [alarm_table(found)], found


def _cost(quick: bool, tell: Callable[[str], None]) -> tuple[list[Table], Sequence[Any]]:
    found = grown(quick, tell)
    return [growth_table(found), boards_table(found)], found


def _loop(quick: bool, tell: Callable[[str], None]) -> tuple[list[Table], Sequence[Any]]:
    plants, motors = identified(1 if quick else 3, tell), identified_motors(1 if quick else 6, tell)
    kinds = KINDS[: 1 if quick else 3]
    effects, changes = traced(kinds, tell), traced_motors(kinds, MOTOR, tell)
    tables = [identified_table(plants, "plants"), identified_table(motors, "motors")]
    tables += [traced_table(effects), traced_table(changes)]
    return tables, [*plants, *motors, *effects, *changes]


def _host(quick: bool, tell: Callable[[str], None]) -> tuple[list[Table], Sequence[Any]]:
    tell("steps")
    simulators = rates(500 if quick else 4000)
    commands = starts(COMMANDS[:3] if quick else COMMANDS, tell)
    work = worked(QUICK_SIZES if quick else SIZES, MODELS, tell)
    return [rates_table(simulators), starts_table(commands), work_table(work)], [*simulators, *commands, *work]


PARTS: dict[str, Part] = {"code": _code, "loop": _loop, "alarms": _alarms, "cost": _cost, "host": _host}


def main(arguments: Sequence[str] | None = None) -> int:
    """Print the tables that are asked for; 1 where a rival's library is missing."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", nargs="+", choices=PARTS, default=list(PARTS))
    parser.add_argument("--quick", action="store_true", help="shorter and fewer runs")
    parser.add_argument("--json", type=Path)
    options = parser.parse_args(arguments)
    console, found, missing = Console(width=300), {}, set()
    for name in options.only:
        with Console(stderr=True).status("") as status:
            tables, rows = PARTS[name](options.quick, status.update)
        for table in tables:
            console.print(table, highlight=False)
        found[name] = [asdict(row) for row in rows]
        missing |= {row.missing for row in rows if getattr(row, "missing", None) is not None}
    if options.json is not None:
        options.json.write_text(json_text(found), encoding="utf-8")
    for reason in sorted(missing):
        print(reason, file=sys.stderr)
    return 1 if missing else 0


if __name__ == "__main__":
    sys.exit(main())
