"""The command."""

from __future__ import annotations

import argparse
import json
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

from rich.console import Console
from rich.table import Table

from benchmarks import alarm_hours
from benchmarks.alarm_hours import oracle
from benchmarks.alarm_hours.judged import DEFAULT, TABLES, Campaign, judge
from benchmarks.alarm_hours.lives import HEALTHY
from benchmarks.alarm_hours.tables import fault_table, healthy_table, load_table

ORACLE = "oracle"


def oracle_table(campaign: Campaign, pool: ProcessPoolExecutor) -> Table:
    """Thresholds by healthy hours, then every fault."""
    factors = oracle.thresholds(campaign, campaign.lives("healthy"))
    numbers = range(len(campaign.lives("faults")))
    jobs = [campaign] * len(numbers), numbers, [factors] * len(numbers)
    return oracle.oracle_table(list(pool.map(oracle.delays, *jobs, chunksize=4)))


def main() -> None:
    """Run the campaign and print its tables."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.alarm_hours",
        description=alarm_hours.__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("coefficients", type=Path, nargs="?", default=DEFAULT)
    parser.add_argument("--hours", type=float, default=1000.0)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--each", type=int, default=10, help="runs of each life with a fault, and of each load")
    parser.add_argument("--only", nargs="+", choices=(*TABLES, ORACLE), default=(*TABLES, ORACLE))
    parser.add_argument("--zeroed", action="store_true", help="the board has learnt its sensors' offsets before")
    parser.add_argument("--kinds", nargs="+", choices=[*HEALTHY], default=[], help="of healthy hours; without it all")
    parser.add_argument("--json", type=Path)
    options = parser.parse_args()
    kinds = tuple(options.kinds)
    campaign = Campaign(options.coefficients, options.hours, options.seed, options.each, options.zeroed, kinds)
    console, found = Console(width=250), {}
    with ProcessPoolExecutor(options.jobs) as pool:
        for name in options.only:
            if name == ORACLE:
                console.print(oracle_table(campaign, pool), highlight=False)
                continue
            numbers = range(len(campaign.lives(name)))
            heard = list(pool.map(judge, [campaign] * len(numbers), [name] * len(numbers), numbers, chunksize=4))
            found[name] = [{"kind": item.life, "fault_s": item.fault_s, "first_s": item.first_s} for item in heard]
            if name == "healthy":
                table = healthy_table(options.coefficients, heard)
            elif name == "loads":
                table = load_table(options.coefficients, heard)
            else:
                table = fault_table(options.coefficients, heard, "fault")
            console.print(table, highlight=False)
    if options.json is not None:
        options.json.write_text(json.dumps(found, indent=1) + "\n")


if __name__ == "__main__":
    main()
