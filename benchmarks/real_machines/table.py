"""The scoreboard as text."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from benchmarks.real_machines.judge import AUTO, HELD, NETWORK, PARTS, REFERENCES, REFINED, Answer, Judged

WORSE = 1.05
"""A model may err by so much more than the best reference."""
SAME = 1.05
"""Errors within this factor are the same."""
COLUMNS = (HELD, *REFERENCES, PARTS, NETWORK, AUTO, REFINED)


def text(results: Sequence[Judged], *, sentences: bool = True) -> str:
    """Give the table, and what `gen` said of each case."""
    columns = [name for name in COLUMNS if any(name in one.answers for one in results)]
    lines = [f"| machine | tested on | {' | '.join(columns)} | network / best | s |", "|---" * (len(columns) + 4) + "|"]
    for one in results:
        cells = [_cell(one.answers.get(name)) for name in columns]
        seconds = f"{one.answers[NETWORK].seconds:.1f}"
        for name in (AUTO, REFINED):
            if name in one.answers:
                seconds += f" + {one.answers[name].seconds:.1f}"
        lines.append(f"| {one.machine} | {one.what} | {' | '.join(cells)} | {one.ratio:.2f} | {seconds} |")
    lines += ["", *goals(results)]
    if sentences:
        for one in results:
            lines += ["", f"{one.machine}, {one.what}"]
            for name in (AUTO, NETWORK, REFINED, PARTS):
                if name in one.answers:
                    answer = one.answers[name]
                    named = f" ({', '.join(answer.names)})" if answer.names else ""
                    lines.append(f"  {name}: {answer.said}{named}")
                    if name == NETWORK:
                        lines += [f"    {warning}" for warning in answer.warnings]
    return "\n".join(lines)


def goals(results: Sequence[Judged]) -> list[str]:
    """Say how many cases keep to the goals."""
    lines = [_goal(results, name) for name in (NETWORK, AUTO) if all(name in one.answers for one in results)]
    return lines + _choices(results)


def _goal(results: Sequence[Judged], name: str) -> str:
    ratios = np.array([one.over_best(name) for one in results])
    refused = [one for one in results if one.answers[name].status != "ok"]
    return (
        f"{name} against the best reference, {len(results)} cases: at most {WORSE - 1.0:.0%} worse in "
        f"{np.count_nonzero(ratios <= WORSE)}, better in {np.count_nonzero(ratios < 1.0)}, refused in {len(refused)}; "
        f"median ratio {np.median(ratios):.2f}, worst {np.max(ratios):.2f}"
    )


def _choices(results: Sequence[Judged]) -> list[str]:
    """How often the choice took what errs less on the runs that took no part."""
    both = [one for one in results if {PARTS, AUTO} <= set(one.answers) and one.answers[AUTO].status == "ok"]
    if not both:
        return []
    errors = [(_error(one.answers[PARTS]), _error(one.answers[NETWORK])) for one in both]
    taken = [_error(one.answers[one.answers[AUTO].names[0]]) for one in both]
    right = sum(own <= SAME * min(pair) for own, pair in zip(taken, errors, strict=True))
    parts = sum(one.answers[AUTO].names == [PARTS] for one in both)
    only = sum(np.isinf(pair).any() for pair in errors)
    least = sum(p <= SAME * n for p, n in errors), sum(n <= SAME * p for p, n in errors)
    longer = [one.answers[AUTO].seconds / (one.answers[PARTS].seconds + one.answers[NETWORK].seconds) for one in both]
    return [
        f"the choice took the better of parts and network, or one within {SAME - 1.0:.0%} of it, in {right} of "
        f"{len(both)} cases (parts in {parts}; in {only} there was only one of them); always parts would have been "
        f"right in {least[0]}, always the network in {least[1]}",
        f"the choice took {np.median(longer):.1f} times as long as one fit of both in the median, "
        f"{max(longer):.1f} at most",
    ]


def _error(answer: Answer) -> float:
    return answer.rmse_K if answer.status == "ok" else float("inf")


def _cell(answer: Answer | None) -> str:
    if answer is None:
        return ""
    return f"{answer.rmse_K:.2f}" if answer.status == "ok" else answer.status
