"""Tables of what was heard."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from rich.box import MARKDOWN
from rich.table import Table

from benchmarks.alarm_hours.judged import Heard, coefficients_of
from benchmarks.alarm_hours.lives import HOUR_S, RUN_S
from gen.lowering.alarms import lower_alarms


def _is_heat(path: Path) -> dict[str, bool]:
    return {rule.name: rule.heat is not None for rule in lower_alarms(coefficients_of(path))}


def healthy_table(path: Path, heard: Sequence[Heard]) -> Table:
    """False alarms per kind of life."""
    heat = _is_heat(path)
    table = Table("healthy motor", "hours", "level rules: runs with an alarm", "missing heat: runs with an alarm",
                  "a verdict among them", box=MARKDOWN)  # fmt: skip
    for kind in dict.fromkeys(item.life for item in heard):
        own = [item for item in heard if item.life == kind]
        levels = sum(any(not heat[name] for name in item.first_s) for item in own)
        heats = sum(any(heat[name] for name in item.first_s) for item in own)
        verdicts = sum(any(name.endswith("_fault") for name in item.first_s) for item in own)
        table.add_row(kind, f"{len(own) * RUN_S / HOUR_S:.0f}", str(levels), str(heats), str(verdicts))
    return table


def _delays(own: Sequence[Heard], names: Sequence[str]) -> tuple[list[float], int]:
    """Delays of the first of these rules' alarms, s, of the runs without one before the fault; and how many had one."""
    delays, early = [], 0
    for item in own:
        times = [item.first_s[name] for name in names if name in item.first_s]
        assert item.fault_s is not None
        if times and min(times) < item.fault_s:
            early += 1
        elif times:
            delays.append(min(times) - item.fault_s)
    return delays, early


def fault_table(path: Path, heard: Sequence[Heard], title: str) -> Table:
    """Delays and verdicts by kind of fault."""
    heat = _is_heat(path)
    table = Table(title, "runs", "level rules: heard", "after (s): median, worst", "missing heat: heard",
                  "after (s): median, worst", "early", "told right", box=MARKDOWN)  # fmt: skip
    for kind in dict.fromkeys(item.life for item in heard):
        own = [item for item in heard if item.life == kind]
        cells = [kind, str(len(own))]
        for wanted in (False, True):
            delays, early = _delays(own, [name for name, is_heat in heat.items() if is_heat == wanted])
            spread = f"{np.median(delays):.0f}, {max(delays):.0f}" if delays else ""
            cells += [str(len(delays)), spread]
        table.add_row(*cells, str(early), str(_told(own)))
    return table


def load_table(path: Path, heard: Sequence[Heard]) -> Table:
    """Whether a load is told from a fault: what any rule raised, by the largest load."""
    heat = _is_heat(path)
    table = Table("motor", "runs", "level rules: alarm", "missing heat: alarm", "of faults: early",
                  "after (s): median, worst", "told right", box=MARKDOWN)  # fmt: skip
    for kind in dict.fromkeys(item.life for item in heard):
        own = [item for item in heard if item.life == kind]
        counts = [
            str(sum(any(heat[name] == wanted for name in item.first_s) for item in own)) for wanted in (False, True)
        ]
        if own[0].fault_s is None:
            table.add_row(kind, str(len(own)), *counts, "", "", "")
            continue
        delays, early = _delays(own, list(heat))
        spread = f"{np.median(delays):.0f}, {max(delays):.0f}" if delays else ""
        table.add_row(kind, str(len(own)), *counts, str(early), spread, str(_told(own)))
    return table


def _told(own: Sequence[Heard]) -> int:
    """In how many the verdict names the fault, and no other was named before."""
    fault = own[0].life.split()[0].rstrip(",")
    right, wrong = f"{fault}_fault", {"bearing": "brush_fault", "brush": "bearing_fault"}[fault]
    return sum(right in item.first_s and not item.first_s.get(wrong, np.inf) <= item.first_s[right] for item in own)
