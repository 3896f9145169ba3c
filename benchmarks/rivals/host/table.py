"""The tables of what the tools cost on this computer."""

from __future__ import annotations

from collections.abc import Sequence

from rich.box import MARKDOWN
from rich.table import Table

from benchmarks.rivals.host.commands import Start
from benchmarks.rivals.host.simulators import Rate
from benchmarks.rivals.host.work import Work


def rates_table(found: Sequence[Rate]) -> Table:
    """Make the table of the simulators."""
    table = Table("simulator", "time of a sample", box=MARKDOWN)
    for one in found:
        table.add_row(one.title, f"x {one.multiple:.3g}")
    return table


def starts_table(found: Sequence[Start]) -> Table:
    """Make the table of the commands' starts."""
    table = Table("command", "processor time", "most memory", box=MARKDOWN)
    for one in found:
        table.add_row(f"`{one.title}`", f"x {one.multiple:.0f}", f"{one.memory_MB:.0f} MB")
    return table


def work_table(found: Sequence[Work]) -> Table:
    """Make the table of identification and refinement; times are multiples of the first row's."""
    table = Table("command", "runs", "of", "processor time", "for each hour of runs", "most memory", box=MARKDOWN)
    first = found[0]
    for one in found:
        multiple = one.seconds / first.seconds
        hourly = multiple / (one.runs * one.hours) * (first.runs * first.hours)
        table.add_row(
            f"`gen {one.command}`, {one.kind}",
            str(one.runs),
            f"{one.hours:g} h",
            f"x {multiple:.2f}",
            f"x {hourly:.2f}",
            f"{one.memory_MB:.0f} MB",
        )
    return table
