"""Attack the guaranteed error: search starts and PWM sequences for one that breaks a bound, against an exact solution.

Run:  python -m benchmarks.attack                       (the examples, and 500 random coefficient files: hours)
      python -m benchmarks.attack --no-examples --files 20 --seed 7
      python -m benchmarks.attack FILE..                (these files alone, thoroughly)

Every file is built in all four forms.  It is refused in one clear line, or every bound holds against what was found;
no build ends in a traceback or takes more than ten seconds.  Exit status 1 if anything of this is not so.
"""

from __future__ import annotations

import argparse
import os
import sys
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # the matrices are small

from benchmarks.attack.campaign import attack_file, attack_random
from benchmarks.attack.report import Report
from benchmarks.attack.search import QUICK, THOROUGH

_ROOT = Path(__file__).parent.parent.parent
_EXAMPLES = ("my1016", "my1016_averaged", "my1016_rig", "two_mass")


def main(arguments: list[str] | None = None) -> int:
    """Attack what the arguments name; the exit status."""
    given = _parser().parse_args(arguments)
    report, drawn = Report.empty(), Report.empty()
    effort = QUICK if given.quick else THOROUGH
    for path in given.paths:
        attack_file(path, str(path), effort, given.seed, report, _say)
    if not given.paths and given.examples:
        for name in _EXAMPLES:
            path = _ROOT / "examples" / name / "coeffs.json"
            attack_file(path, name, effort, given.seed, report, _say)
    if report.attacked:
        print(f"\n{report.table()}\n\n{report.summary()}\n")
    if not given.paths:
        attack_random(range(given.first, given.first + given.files), QUICK, given.seed, drawn, _say)
        last = given.first + given.files - 1
        print(f"\nrandom files {given.first}..{last} of seed {given.seed}:\n\n{drawn.summary()}\n")
    faults = report.faults() + drawn.faults()
    for fault in faults:
        print(f"FAULT  {fault}")
    print(f"{len(faults)} faults, seed {given.seed}")
    return 1 if faults else 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("paths", nargs="*", type=Path, metavar="FILE", help="coefficient files to attack")
    parser.add_argument("--files", type=int, default=500, help="how many random files (default: 500)")
    parser.add_argument("--first", type=int, default=0, help="the number of the first random file (default: 0)")
    parser.add_argument("--seed", type=int, default=1, help="of random files and of the search (default: 1)")
    parser.add_argument("--no-examples", dest="examples", action="store_false", help="random files only")
    parser.add_argument("--quick", action="store_true", help="spend no more on a file or example than on a random file")
    return parser


def _say(line: str) -> None:
    print(line, flush=True)


if __name__ == "__main__":
    sys.exit(main())
