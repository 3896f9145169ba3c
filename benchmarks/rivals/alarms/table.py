"""The table of the ways to hear of a fault."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from rich.box import MARKDOWN
from rich.table import Table

from benchmarks.rivals.alarms.judge import Heard


def alarm_table(found: Sequence[Heard]) -> Table:
    """Make the table, a row for each way; faults by severity."""
    faults = [item for item in found if item.fault_s is not None]
    severities = list(dict.fromkeys(item.kind.split()[1] for item in faults))
    columns = [text for name in severities for text in (f"found, severity {name}", "after (s): median, worst")]
    hours = sum(item.hours for item in found)
    table = Table("way", *columns, f"false alarms per 1 000 h (of {hours:.0f} h)", box=MARKDOWN)
    for way in found[0].first_s:
        cells = []
        for name in severities:
            own = [item for item in faults if item.kind.split()[1] == name]
            delays = delays_s(own, way)
            cells.append(f"{len(delays)} of {len(own)}")
            cells.append(f"{np.median(delays):.0f}, {max(delays):.0f}" if delays else "")
        table.add_row(way, *cells, f"{1000.0 * false_alarms(found, way) / hours:.0f}")
    return table


def delays_s(faults: Sequence[Heard], way: str) -> list[float]:
    """Delays of one way's alarms since the fault began, s, of the runs without one before it."""
    delays = []
    for item in faults:
        first = item.first_s[way]
        assert item.fault_s is not None
        if first is not None and first >= item.fault_s:
            delays.append(first - item.fault_s)
    return delays


def false_alarms(found: Sequence[Heard], way: str) -> int:
    """Runs in which one way alarms though nothing has happened yet; such an alarm is held, so each counts once."""
    firsts = [(item.first_s[way], item.fault_s) for item in found]
    return sum(first is not None and (fault is None or first < fault) for first, fault in firsts)
