"""The table of the ways to have the model on the board."""

from __future__ import annotations

from collections.abc import Sequence

from rich.box import MARKDOWN
from rich.markup import escape
from rich.table import Table

from benchmarks.rivals.code.profiles import NAMES
from benchmarks.rivals.code.row import Row

LOST_K = 10.0
"""From this error on the part is lost, and what the others do is said too."""


def code_table(rows: Sequence[Row]) -> Table:
    """Make the table, a row for each."""
    table = Table(
        "way", *(f"error, {name}" for name in NAMES), "proven", "cycles, PWM held", "with a change", "flash", "RAM",
        "bit for bit", "lacks", box=MARKDOWN,
    )  # fmt: skip
    for row in rows:
        if row.missing is not None:
            table.add_row(row.title, *[""] * 9, escape(row.missing))
            continue
        table.add_row(
            row.title,
            *(error_text(row.error_K[name]) for name in NAMES),
            "no" if row.proven_K is None else f"{row.proven_K:.1e} K",
            str(row.cycles_held),
            str(row.cycles_change),
            f"{row.flash_bytes} B",
            f"{row.ram_bytes} B",
            "yes" if row.equal else "no",
            row.lacks,
        )
    return table


def error_text(of_parts: dict[str, float]) -> str:
    """The worst part's error; of a lost part its name, and the others' error."""
    lost = [name for name, error in of_parts.items() if error > LOST_K]
    if not lost:
        return f"{max(of_parts.values()):.1e} K"
    others = [error for name, error in of_parts.items() if name not in lost]
    worst = max(of_parts.values())
    said = f"{worst:.0f} K" if worst < 1e4 else "diverges"
    rest = f", others {max(others):.1e} K" if others else ""
    return f"{' '.join(lost)} {said}{rest}"
