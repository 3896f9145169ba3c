"""The command: every log that the folder holds, one process."""

from __future__ import annotations

import argparse
import os
import sys
from dataclasses import asdict
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

from benchmarks import real_machines
from benchmarks.campaign import json_text
from benchmarks.real_machines.judge import AUTO, PARTS, REFINED, Judged, judge
from benchmarks.real_machines.logs import cases
from benchmarks.real_machines.table import text
from gen.runs.drive import MACHINES


def main() -> None:
    """Judge, and print the table."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.real_machines",
        description=real_machines.__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--data", type=Path, required=True, help="the folder with the logs")
    parser.add_argument("--only", default="", help="cases whose name begins with this")
    parser.add_argument("--models", default=f"{REFINED},{PARTS},{AUTO}", help="beside the network; may be empty")
    parser.add_argument("--heat", action="append", default=[], help="a column that heats, told to `gen identify` alone")
    parser.add_argument("--drives", choices=("", *MACHINES), default="", help="what the input drives, told likewise")
    parser.add_argument("--json", type=Path, help="write all answers here, after each case anew")
    options = parser.parse_args()
    results: list[Judged] = []
    for case in cases(options.data):
        if not str(case).startswith(options.only):
            continue
        one = judge(case, options.models.split(","), options.heat, options.drives)
        results.append(one)
        print(f"{case}: {one.ratio:.2f} of the best reference", file=sys.stderr, flush=True)
        if options.json:
            options.json.write_text(json_text([asdict(result) for result in results]), encoding="utf-8")
    if not results:
        sys.exit(f"{options.data}: no log of {options.only or 'any machine'} is there")
    print(text(results))


if __name__ == "__main__":
    main()
