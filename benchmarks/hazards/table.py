"""The table of hazards."""

from __future__ import annotations

import math
from typing import Any

from rich.box import MARKDOWN
from rich.table import Table

from benchmarks.hazards.running import Line


def table(lines: list[Line]) -> Table:
    """One line each."""
    made = Table(
        "hazard", "cause", "the board", "after (s)", "beyond, driven (K)", "beyond at all (K)", "driven blind (s)",
        "ends", "goal", box=MARKDOWN,
    )  # fmt: skip
    for line in lines:
        outcome = line.outcome
        made.add_row(
            line.name,
            line.cause,
            outcome.did,
            "never" if outcome.after_s is None else f"{outcome.after_s:.2f}",
            kelvins(outcome.beyond_driven_K),
            kelvins(outcome.beyond_K),
            f"{outcome.blind_s:.2f}",
            outcome.end,
            verdict(line),
        )
    return made


def kelvins(beyond_K: float) -> str:
    """How far beyond; nothing below the limit."""
    return f"{beyond_K:.1f}" if beyond_K > 0.0 else "0"


def verdict(line: Line) -> str:
    """Whether the goal holds; in brackets for more than one fault, for which there is none."""
    said = "PASS" if line.passes else f"FAIL {len(line.failed)} of {line.runs}" if line.runs > 1 else "FAIL"
    return said if line.faults == 1 else f"({said})"


def finite(answer: dict[str, Any]) -> dict[str, Any]:
    """The same without infinities, which JSON does not have."""
    outcome = answer["outcome"]
    return answer | {
        "outcome": {
            key: None if isinstance(value, float) and not math.isfinite(value) else value
            for key, value in outcome.items()
        }
    }
