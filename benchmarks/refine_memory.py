"""Memory and time of `gen refine` and `gen identify` on long logs.

    python benchmarks/refine_memory.py --rows 10000000

Writes run files with time, PWM, ambient and four temperatures (and one with two rows in three of them missing), runs
both commands on them, and prints the peak resident memory of each process and its time. The rows are at 4 Hz.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

ROOT = Path(__file__).parent.parent
sys.path.insert(0, str(ROOT))

from gen.coefficients import load  # noqa: E402
from gen.model import ExactSolution  # noqa: E402

COEFFICIENTS = ROOT / "examples" / "my1016" / "coeffs.json"
SPEEDS = (0, 51, 102, 153, 204, 255)
EVERY = 100
"""The model is solved at every so many rows and drawn straight between: this is about memory, not accuracy."""


def write(path: Path, rows: int, seed: int, every_row: bool = False) -> None:
    """Write a log at 4 Hz in which the casing is 8 % too warm; speeds change each three hours, or in every row."""
    random = np.random.default_rng(seed)
    model = load(COEFFICIENTS).model
    coarse = np.arange(0, rows + EVERY, EVERY) * 0.25
    hold = min(10800.0, rows * 0.25 / 6.0)
    held = random.choice(SPEEDS, int(coarse[-1] // hold) + 1)[(coarse // hold).astype(int)]
    rises = ExactSolution(model).simulate_times(coarse, held)
    rises["casing"] = rises["casing"] * 1.08
    with path.open("w", encoding="utf-8") as stream:
        stream.write("time_s,pwm," + ",".join(f"{name}_degC" for name in rises) + ",ambient_degC\n")
        for first in range(0, rows, 100_000):
            t = np.arange(first, min(first + 100_000, rows)) * 0.25
            pwm = held[(t / (EVERY * 0.25)).astype(int)]
            if every_row:
                pwm = np.clip(pwm + random.integers(-5, 6, t.size), 0, 255)
            columns = [
                np.round((30 + np.interp(t, coarse, r) + random.normal(0, 0.2, t.size)) * 4) / 4 for r in rises.values()
            ]
            room = np.round((30 + random.normal(0, 0.1, t.size)) * 4) / 4
            lines = (
                ",".join(map(repr, row))
                for row in zip(t.tolist(), pwm.tolist(), *(c.tolist() for c in columns), room.tolist(), strict=True)
            )
            stream.write("\n".join(lines) + "\n")


def measured(*arguments: str) -> tuple[float, float]:
    """Run `gen` in a process of its own; give its peak resident memory in MB and its time in s."""
    started = time.perf_counter()
    process = subprocess.Popen([sys.executable, "-m", "gen", *arguments], cwd=ROOT, stdout=subprocess.DEVNULL)
    _, status, usage = os.wait4(process.pid, 0)
    if status:
        raise SystemExit(f"gen {' '.join(arguments)}: exit status {os.waitstatus_to_exitcode(status)}")
    return usage.ru_maxrss / 1024.0, time.perf_counter() - started


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rows", type=int, default=1_000_000, help="in all run files of a command together")
    parser.add_argument("--files", type=int, default=1, help="files to fit that the rows are spread over")
    parser.add_argument("--pwm-every-row", action="store_true", help="PWM changes with every row, as under control")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        fit = [folder / f"fit{i}.csv" for i in range(options.files)]
        for i, path in enumerate(fit):
            write(path, options.rows // options.files, i, options.pwm_every_row)
        write(folder / "test.csv", 40_000, 99)
        size = sum(path.stat().st_size for path in fit) / 1e6
        print(f"{options.rows} rows in {options.files} file(s), {size:.0f} MB")
        files = [str(path) for path in fit]
        test, out = str(folder / "test.csv"), str(folder / "out.json")
        for command in (
            ["refine", str(COEFFICIENTS), "--fit", *files, "--test", test, "--out", out, "--report", f"{out}.html"],
            ["identify", *files, "--model", "parts", "--out", out],
        ):
            memory, seconds = measured(*command)
            print(f"gen {command[0]:9s} peak {memory:6.0f} MB, {seconds:6.1f} s", flush=True)


if __name__ == "__main__":
    main()
