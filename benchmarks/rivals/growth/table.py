"""The tables of how cost grows."""

from __future__ import annotations

from collections.abc import Sequence

from rich.box import MARKDOWN
from rich.table import Table

from benchmarks.rivals.growth.boards import BOARDS, held
from benchmarks.rivals.growth.measure import Grown

BY_SIZE = ("components", "nodes")
"""Series whose size a board may run out of."""


def growth_table(found: Sequence[Grown]) -> Table:
    """Make the table of all sizes; times are multiples of the first row's verify."""
    table = Table(
        "what grows", "size", "cycles, PWM held", "with a change", "flash", "RAM", "build", "verify",
        "every word equal", box=MARKDOWN,
    )  # fmt: skip
    first = found[0]
    for one in found:
        if one.refused is not None:
            table.add_row(one.series, str(one.size), *[""] * 6, f"refused: {one.refused.split(';')[0]}")
            continue
        table.add_row(
            one.series,
            str(one.size),
            str(one.cycles_held),
            str(one.cycles_change),
            f"{one.flash_bytes} B",
            f"{one.ram_bytes} B",
            f"x {one.build_s / first.verify_s:.2f}",
            f"x {one.verify_s / first.verify_s:.2f}",
            "yes" if one.equal else "no",
        )
    return table


def boards_table(found: Sequence[Grown]) -> Table:
    """Make the table of the largest models, by series and board."""
    table = Table("largest model", *(board.name for board in BOARDS), box=MARKDOWN)
    for name in dict.fromkeys(one.series for one in found):
        series = [one for one in found if one.series == name]
        if name.startswith(BY_SIZE):
            ends = (held(board, series) for board in BOARDS)
            table.add_row(name, *(f"{size} ({short})" for size, short in ends))
    return table
