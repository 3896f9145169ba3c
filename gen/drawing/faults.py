"""Faults that a run file's comments declare, as bars; ``motor_fault: brush from 9 s`` says from when on."""

from __future__ import annotations

import re
from collections.abc import Mapping

from gen.drawing.section import Bar, shown
from gen.runs.faults import called_unhealthy, declared_faults

_FROM = re.compile(r"(.+?) from (\d+(?:\.\d+)?(?:e[+-]?\d+)?) s", re.ASCII)
_POWER_ON = re.compile(r"(-?\d+(?:\.\d+)?) s", re.ASCII)


def declared(comments: Mapping[str, str], start_s: float, end_s: float) -> list[Bar]:
    """Give the faults that a run's comments name.

    Parameters
    ----------
    comments
        By key. A fault may say from when on, in seconds since power-on; ``power_on`` tells when that was.
    start_s, end_s
        Of the run. A fault lasts to its end.
    """
    bars = []
    for fault in declared_faults(comments):
        named, since = fault, start_s
        if found := _FROM.fullmatch(fault):
            named, since = found[1], float(found[2]) + _power_on_s(comments)
        bars.append(Bar(shown(f"fault: {named}"), "fault", min(max(since, start_s), end_s), end_s))
    if not bars and called_unhealthy(comments):
        bars.append(Bar("fault: not healthy", "fault", start_s, end_s))
    return bars


def _power_on_s(comments: Mapping[str, str]) -> float:
    found = _POWER_ON.fullmatch(comments.get("power_on", "").strip())
    return float(found[1]) if found else 0.0
