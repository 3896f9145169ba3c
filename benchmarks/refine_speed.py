"""Time of a refinement: 20 runs of 3 h with four components, whole library.

    python benchmarks/refine_speed.py [--kinds hidden_node sensor_gain]

Prints the time on the wall and of the processor, reading and judging included. The planted runs are drawn straight
between their rows to one row a second.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
from dataclasses import replace
from pathlib import Path

import numpy as np

ROOT = Path(__file__).parent.parent
sys.path.insert(0, str(ROOT))

from gen.coefficients import load  # noqa: E402
from gen.refinement.parts.refine import refine  # noqa: E402
from gen.runs import read_run, write_run  # noqa: E402
from tests.refinement import plant_effects  # noqa: E402
from tests.refinement.plant import COEFFICIENTS, NAMES  # noqa: E402


def every_second(path: Path) -> None:
    """Write a run again with a row each second."""
    run = read_run(path, NAMES)
    assert run.ambient is not None
    time_s = np.arange(0.0, run.time_s[-1] + 0.5)
    held = np.searchsorted(run.time_s, time_s, side="right") - 1
    columns = {key: values[held] for key, values in run.extras.items()}
    temps = {key: np.round(np.interp(time_s, run.time_s, values) * 4) / 4 for key, values in run.temps.items()}
    again = replace(run, time_s=time_s, pwm=run.pwm[held], temps=temps, ambient=run.ambient[held], extras=columns)
    write_run(path, again)


def main() -> None:
    """Print the times."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--kinds", nargs="+", default=["hidden_node", "sensor_gain"])
    options = parser.parse_args()
    plant_effects.RUNS, plant_effects.FIT, plant_effects.HOURS = 22, 20, 3.0
    with tempfile.TemporaryDirectory() as name:
        fit, test, _ = plant_effects.make(Path(name), tuple(options.kinds), 1)
        for path in (*fit, *test):
            every_second(path)
        wall, processor = time.perf_counter(), time.process_time()
        found = refine(load(COEFFICIENTS), COEFFICIENTS.read_text(encoding="utf-8"), fit, test)
        wall, processor = time.perf_counter() - wall, time.process_time() - processor
    print(
        f"{len(fit)} runs of 3 h to fit: {wall:.0f} s, of the processor {processor:.0f} s; {found.verdict}, "
        f"{', '.join(effect['name'] for effect in found.effects)}"
    )


if __name__ == "__main__":
    main()
