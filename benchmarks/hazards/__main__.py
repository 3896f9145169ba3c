"""The command: hazards or a healthy motor, and the table."""

from __future__ import annotations

import argparse
import json
import sys
from dataclasses import asdict
from pathlib import Path

from rich.console import Console

from benchmarks import hazards
from benchmarks.hazards.bits import CAMPAIGNS
from benchmarks.hazards.noise import moved_per_hour, obeyed_per_hour
from benchmarks.hazards.nuisance import run_healthy
from benchmarks.hazards.running import Line, lines, names
from benchmarks.hazards.table import finite, table


def main() -> int:
    """Run, print, and give the exit status."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.hazards",
        description=hazards.__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument(
        "--only", nargs="+", metavar="NAME", help="hazards by name; a name that ends in - means all that begin so"
    )
    parser.add_argument("--list", action="store_true", help="print the names, and what each is")
    parser.add_argument("--jobs", type=int, default=2, help="processes")
    parser.add_argument("--every", action="store_true", help="flip a bit of each of the EEPROM's 4096 bytes")
    parser.add_argument("--flash-bits", type=int, default=30, metavar="N")
    parser.add_argument("--ram-bits", type=int, default=30, metavar="N")
    parser.add_argument(
        "--nuisance", type=float, metavar="HOURS", help="a healthy motor for so long, in place of hazards"
    )
    parser.add_argument("--seed", type=int, default=1, help="of the healthy motor's commands")
    parser.add_argument("--json", type=Path, help="write the answers here")
    options = parser.parse_args()
    if options.nuisance is not None:
        return healthy(options.nuisance, options.seed, options.jobs)
    wanted = chosen(options.only, parser)
    if options.list:
        print("\n".join(wanted))
        return 0
    counts = {"eeprom-bits": 0 if options.every else 10, "flash-bits": options.flash_bits, "ram-bits": options.ram_bits}
    done: list[Line] = []
    with Console(stderr=True).status("") as status:
        for line in lines(wanted, counts, options.jobs):
            done.append(line)
            if options.json is not None:
                write(done, options.json)
            status.update(f"{len(done)} of {len(wanted)}: {line.name}")
    Console(width=400).print(table(done))
    print_summary(done)
    return 0 if all(line.passes for line in done if line.faults == 1) else 1


def write(done: list[Line], path: Path) -> None:
    """Write what there is so far."""
    path.write_text(json.dumps([finite(asdict(line)) for line in done], indent=1) + "\n", encoding="utf-8")


def chosen(only: list[str] | None, parser: argparse.ArgumentParser) -> list[str]:
    """The names that are meant."""
    known = names()
    if only is None:
        return known
    found = [
        name for name in known if any(name == part or (part.endswith("-") and name.startswith(part)) for part in only)
    ]
    unknown = [part for part in only if part not in known and not any(name.startswith(part) for name in found)]
    if unknown:
        parser.error(f'unknown hazard "{unknown[0]}"; --list prints them')
    return found


def print_summary(done: list[Line]) -> None:
    """How many pass, and what random bytes do in a thousand hours."""
    single = [line for line in done if line.faults == 1]
    passed = sum(line.passes for line in single)
    print(f"\n{passed} of {len(single)} single faults pass, {sum(line.runs for line in done)} runs.")
    for line in done:
        if line.name in CAMPAIGNS and line.failed:
            print(f"{line.name}: {len(line.failed)} of {line.runs} fail, (address, bit) {list(line.failed)}")
    print(
        f"Random bytes at 115200 baud: {obeyed_per_hour():.0f} lines an hour are a PWM or a question by chance, "
        f"{1000.0 * moved_per_hour():.1g} times in 1000 h they arm the board and then command a PWM."
    )


def healthy(hours: float, seed: int, jobs: int) -> int:
    """Run a healthy motor, and say what stopped it."""
    found = run_healthy(hours, seed, jobs)
    print(f"{found.hours:.1f} h of a healthy motor, {found.commands} commands: {len(found.stops)} stops by the board")
    for stop in found.stops:
        print(f"  {stop}")
    return 1 if found.stops else 0


if __name__ == "__main__":
    sys.exit(main())
