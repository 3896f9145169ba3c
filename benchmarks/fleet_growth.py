"""What a fleet costs as it grows: the form, the models, the watching, memory, a motor.

A made fleet (`benchmarks.fleet`) of each size in turn, on two workers. Time on the clock is with what else runs; that
of processors is the commands' own, their workers' included.

    python -m benchmarks.fleet_growth --sizes 10 30 100 300 1000
"""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import argparse
import tempfile
import time
from pathlib import Path

from benchmarks.fleet import UNTIL, filled, gen, largest_MB, scouting_s, tally
from benchmarks.made_fleet.draw import Made, fleet

TITLES = ("motors", "form (s)", "models (s)", "watch (s)", "processors a motor (s): models, watch", "largest (MB)")


def grown(made: Made) -> None:
    """Identify and watch one fleet, and print its row."""
    motors = fleet(made)
    with tempfile.TemporaryDirectory() as folder:
        store = filled(Path(folder), motors)
        began = time.time()
        models = gen("identify", store.url, "--until", UNTIL, "--jobs", "2")
        form_s = scouting_s(store, began)
        watching = gen("watch", store.url, "--jobs", "2")
        each = f"{models.processor_s / made.motors:.2f}, {watching.processor_s / made.motors:.2f}"
        times = (form_s, models.clock_s - form_s, watching.clock_s)
        cells = [str(made.motors), *(f"{value:.0f}" for value in times), each, f"{largest_MB():.0f}"]
        print("  ".join(cell.ljust(len(title)) for cell, title in zip(cells, TITLES, strict=True)).rstrip(), flush=True)
        print(f"    found: {tally(store, motors)} healthy motors", flush=True)


def main() -> None:
    """Grow the fleet, print."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.fleet_growth",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--sizes", type=int, nargs="+", default=[10, 30, 100], metavar="MOTORS")
    parser.add_argument("--seed", type=int, default=3, help="of the series")
    parser.add_argument("--faulty", type=float, default=0.05, help="share of motors")
    options = parser.parse_args()
    print("  ".join(TITLES), flush=True)
    for size in sorted(options.sizes):
        grown(Made(size, options.seed, options.faulty, 1.0))


if __name__ == "__main__":
    main()
