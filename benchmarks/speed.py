"""How fast this computer works, as ratios within one run: no test asserts a time, this script prints them.

    python benchmarks/speed.py

Every row is processor time: what one unit of the work costs, in milliseconds here and as a multiple of a reference
workload (a loop of a million additions of Python's own floats, the best of five) that is timed in the same run. The
multiple is what to compare between computers and versions. A multiple of a few tenths of simulated time is noise.
"""

from __future__ import annotations

import argparse
import os
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np

ROOT = Path(__file__).parent.parent
sys.path.insert(0, str(ROOT))

from gen.coefficients import load  # noqa: E402
from gen.emulate.board import Board  # noqa: E402
from gen.emulate.firmware import build_firmware  # noqa: E402
from gen.emulate.plants.plant import BenchPlant  # noqa: E402
from gen.emulate.session import run_session  # noqa: E402
from gen.model import ExactSolution  # noqa: E402
from gen.runs import Run, read_run, write_run  # noqa: E402

COEFFICIENTS = ROOT / "examples" / "my1016" / "coeffs.json"
NAMES = ("brush", "bearing", "magnet", "casing")
SAMPLES = 43_200
PULSES_PER_S = 22_083.0


@dataclass(frozen=True)
class Row:
    """One kind of work: what it is, the unit of what was done, how many units, and the processor time, s."""

    what: str
    unit: str
    units: float
    seconds: float


def reference() -> float:
    """Processor time of the reference workload, s."""

    def additions() -> None:
        total = 0.0
        for i in range(1_000_000):
            total += i * 0.5

    return min(taken(additions) for _ in range(5))


def taken(work: Callable[[], object], *, children: bool = False) -> float:
    """Processor time of this process, or of those that it starts, s."""
    who = resource.RUSAGE_CHILDREN if children else resource.RUSAGE_SELF
    before = resource.getrusage(who)
    work()
    after = resource.getrusage(who)
    return (after.ru_utime + after.ru_stime) - (before.ru_utime + before.ru_stime)


def emulation(folder: Path) -> list[Row]:
    """The firmware on the emulated Mega, standing still and at full speed."""
    coefficients = load(COEFFICIENTS)
    wiring = coefficients.document.wiring
    assert wiring is not None
    built = build_firmware(coefficients, "fixed", "table", "coeffs.json", folder)
    rows = []
    for what, pulses, seconds in (("no pulses", 0.0, 60.0), ("full speed", PULSES_PER_S, 60.0)):
        plant = BenchPlant(dict.fromkeys((*NAMES, "ambient"), 30.0), pulses)
        board = Board(built.elf, built.cache, wiring, plant)
        rows.append(
            Row(
                f"emulated firmware, {what}",
                "simulated s",
                seconds,
                taken(lambda board=board, seconds=seconds: run_session(board, seconds, profile=((0.0, 255),))),  # type: ignore[misc]
            )
        )
        board.close()
    return rows


def solving() -> Row:
    """The exact solution of three hours at 4 Hz, another PWM in every sample."""
    solution = ExactSolution(load(COEFFICIENTS).model)
    pwm = np.random.default_rng(7).integers(-255, 256, SAMPLES)
    solution.simulate(pwm)  # the exponentials are made
    return Row(
        "exact solution, four components", "1000 samples", SAMPLES / 1000.0, taken(lambda: solution.simulate(pwm))
    )


def runs(folder: Path) -> list[Path]:
    """Three hours at 4 Hz, four components, five speeds; sensors with noise and 0.25 degC."""
    random = np.random.default_rng(1)
    solution = ExactSolution(load(COEFFICIENTS).model)
    clock = np.arange(SAMPLES, dtype=np.float64) * 0.25
    paths = []
    for pwm in (51, 102, 153, 204, 255):
        counts = np.where(clock < 8000.0, pwm, 0)
        rise = solution.simulate(counts)
        temps = {n: np.round((30.0 + rise[n][:-1] + random.normal(0.0, 0.15, SAMPLES)) * 4) / 4 for n in NAMES}
        paths.append(folder / f"pwm_{pwm}.csv")
        write_run(paths[-1], Run(clock, counts, temps, np.full(SAMPLES, 30.0)))
    return paths


def command(*arguments: str | Path) -> float:
    """Processor time of one `gen` command, s."""

    def run() -> None:
        subprocess.run([sys.executable, "-m", "gen", *map(str, arguments)], capture_output=True, check=False, cwd=ROOT)

    return taken(run, children=True)


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        unit = reference()
        rows = [*emulation(folder), solving()]
        paths = runs(folder)
        rows.append(Row("reading a run file", "1000 rows", SAMPLES / 1000.0, taken(lambda: read_run(paths[0]))))
        out = folder / "coeffs.json"
        identify = ("identify", "--model", "parts", "--out", out)
        rows.append(Row("gen identify, five runs of 3 h", "command", 1.0, command(*identify, *paths)))
        rows.append(Row("gen --help", "command", 1.0, command("--help")))
        rows.append(Row("gen build of a missing file", "command", 1.0, command("build", folder / "missing.json")))
        rows.append(Row("gen identify of a missing file", "command", 1.0, command("identify", "x.csv", "--out", out)))
        unit = min(unit, reference())
    print(f"reference workload: {unit * 1000.0:.0f} ms, at {time.strftime('%Y-%m-%d')}")
    print("| work | unit | ms of processor a unit | reference workloads a unit |")
    print("|---|---|---|---|")
    for row in rows:
        cost = row.seconds / row.units
        print(f"| {row.what} | {row.unit} | {cost * 1000.0:.3g} | {cost / unit:.3g} |")
    for row in rows:
        if row.unit == "simulated s":
            ratio = row.units / row.seconds
            print(f"{row.what}: {ratio:.0f} simulated seconds in one, 3 h in {10_800.0 / ratio:.0f} s")


if __name__ == "__main__":
    main()
