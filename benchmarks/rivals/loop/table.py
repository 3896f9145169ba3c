"""The tables of identification and tracing."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from rich.box import MARKDOWN
from rich.markup import escape
from rich.table import Table

from benchmarks.rivals.loop.identification import OURS, Identified
from benchmarks.rivals.loop.tracing import Traced


def identified_table(found: Sequence[Identified], what: str) -> Table:
    """Errors of each identifier; times are multiples of the first row's.

    Parameters
    ----------
    found
        The rows; the first is ours.
    what
        Plants or motors, in the plural.
    """
    count, first = max(len(one.error_K) for one in found), found[0]
    table = Table("identification", f"error on fresh runs, median of {count} {what}", "worst", "time", box=MARKDOWN)
    for one in found:
        if one.missing is not None:
            table.add_row(one.title, "", "", escape(one.missing))
            continue
        worst = max(one.error_K)
        table.add_row(
            f"**{one.title}**" if one.title.startswith(OURS) else one.title,
            f"{np.median(one.error_K):.2f} K",
            f"{worst:.2f} K" if np.isfinite(worst) else "diverged",
            f"x {one.seconds / first.seconds:.2f}" if one.seconds else "",
        )
    return table


def traced_table(found: Sequence[Traced]) -> Table:
    """What each named; times are multiples of those of `gen refine`."""
    table = Table(
        "planted", "way", "named first", "right", "other effects", "error on test runs, before", "after", "time",
        box=MARKDOWN,
    )  # fmt: skip
    ours = {one.planted: one.seconds for one in found if one.title == "gen refine"}
    for one in found:
        title = f"**{one.title}**" if one.title == "gen refine" else one.title
        if one.missing is not None:
            table.add_row(one.planted, title, *[""] * 5, escape(one.missing))
            continue
        table.add_row(
            one.planted,
            title,
            one.named or "nothing",
            "yes" if one.named == one.planted else "no",
            str(one.others),
            f"{one.before_K:.2f} K",
            f"{one.after_K:.2f} K",
            f"x {one.seconds / ours[one.planted]:.3f}",
        )
    return table
