"""The scoreboard as text."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from benchmarks.real_machines.judge import HELD, NETWORK, PARTS, REFERENCES, REFINED, Answer, Judged

WORSE = 1.05
"""The network may err by so much more than the best reference."""
COLUMNS = (HELD, *REFERENCES, PARTS, NETWORK, REFINED)


def text(results: Sequence[Judged], *, sentences: bool = True) -> str:
    """Give the table, and what `gen` said of each case."""
    columns = [name for name in COLUMNS if any(name in one.answers for one in results)]
    lines = [f"| machine | tested on | {' | '.join(columns)} | network / best | s |", "|---" * (len(columns) + 4) + "|"]
    for one in results:
        cells = [_cell(one.answers.get(name)) for name in columns]
        seconds = f"{one.answers[NETWORK].seconds:.1f}"
        if REFINED in one.answers:
            seconds += f" + {one.answers[REFINED].seconds:.1f}"
        lines.append(f"| {one.machine} | {one.what} | {' | '.join(cells)} | {one.ratio:.2f} | {seconds} |")
    lines += ["", *goals(results)]
    if sentences:
        for one in results:
            lines += ["", f"{one.machine}, {one.what}"]
            for name in (NETWORK, REFINED, PARTS):
                if name in one.answers:
                    answer = one.answers[name]
                    named = f" ({', '.join(answer.names)})" if answer.names else ""
                    lines.append(f"  {name}: {answer.said}{named}")
                    if name == NETWORK:
                        lines += [f"    {warning}" for warning in answer.warnings]
    return "\n".join(lines)


def goals(results: Sequence[Judged]) -> list[str]:
    """Say how many cases keep to the goals."""
    ratios = np.array([one.ratio for one in results])
    refused = [one for one in results if one.answers[NETWORK].status != "ok"]
    return [
        f"network against the best reference, {len(results)} cases: at most {WORSE - 1.0:.0%} worse in "
        f"{np.count_nonzero(ratios <= WORSE)}, better in {np.count_nonzero(ratios < 1.0)}, refused in {len(refused)}; "
        f"median ratio {np.median(ratios):.2f}, worst {np.max(ratios):.2f}"
    ]


def _cell(answer: Answer | None) -> str:
    if answer is None:
        return ""
    return f"{answer.rmse_K:.2f}" if answer.status == "ok" else answer.status
