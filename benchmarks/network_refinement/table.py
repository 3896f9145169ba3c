"""The tables of many trials: by effect, what was named instead, and the goals."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from benchmarks.network_refinement.judge import Judged
from benchmarks.plants.planted.draw import LIBRARY
from benchmarks.plants.planted.kinds import FAULTS, OUTSIDE

WORSE = 1.05
"""Error after over error before, from which on refinement made a model worse."""
EXPLAINED = 1.5
"""Noise floors up to which what is outside of the library may be called explained."""
NEAR = 1.3
"""Noise floors up to which a refined model is as good as it can be."""
TOLD = 0.1
"""By how much the error that refinement tells may be off, as a share."""


def group(result: Judged) -> str:
    """Which kind of trial it is: `single`, `pair`, `nothing`, `outside` or `fault`."""
    if not result.planted:
        return "nothing"
    if len(result.planted) > 1:
        return "pair"
    (name,) = result.planted
    return "outside" if name in OUTSIDE else "fault" if name in FAULTS else "single"


@dataclass(frozen=True)
class Row:
    """All trials of one kind with as many fit runs.

    Parameters
    ----------
    planted, fit_runs
        Which.
    trials, without
        How many, and how many of them without a result.
    first, among, false, flagged
        Shares of all trials with the right name first, with it among the names and their lookalikes, with a false name,
        and with the motor called faulty.
    placed
        Of those with the right name first that have a sensed place, the share that has it right.
    before, before_high, after, after_high
        Medians and 90 % of the errors in noise floors.
    seconds
        Median of refinement.
    """

    planted: str
    fit_runs: int
    trials: int
    without: int
    first: float
    among: float
    false: float
    flagged: float
    placed: float
    before: float
    before_high: float
    after: float
    after_high: float
    seconds: float


def seen(results: Sequence[Judged]) -> list[Judged]:
    """Trials in which there was something to find and a model to refine."""
    return [result for result in results if result.status not in ("unseen", "no model")]


def label(result: Judged) -> str:
    """The row of a trial."""
    return "pairs" if group(result) == "pair" else "+".join(result.planted) or "nothing"


def rows(results: Sequence[Judged]) -> list[Row]:
    """All kinds that have a trial, in the library's order."""
    order = [*LIBRARY, "nothing", "pairs", *OUTSIDE, *FAULTS]
    cells: dict[tuple[int, str], list[Judged]] = {}
    for result in seen(results):
        cells.setdefault((result.fit_runs, label(result)), []).append(result)
    keys = sorted(cells, key=lambda key: (key[0], order.index(key[1])))
    return [_row(name, runs, cells[runs, name]) for runs, name in keys]


def _row(name: str, runs: int, mine: Sequence[Judged]) -> Row:
    made = [result for result in mine if result.status == "ok"]
    before, after = [result.before for result in mine], [result.after for result in made]
    return Row(
        planted=name,
        fit_runs=runs,
        trials=len(mine),
        without=len(mine) - len(made),
        first=_mean([result.first for result in mine]),
        among=_mean([result.among for result in mine]),
        false=_mean([bool(result.false) for result in mine]),
        flagged=_mean([result.flagged for result in mine]),
        placed=_mean([result.placed for result in mine if result.placed is not None]),
        before=_percentile(before, 50),
        before_high=_percentile(before, 90),
        after=_percentile(after, 50),
        after_high=_percentile(after, 90),
        seconds=_percentile([result.seconds for result in mine], 50),
    )


def _mean(values: Sequence[bool]) -> float:
    return float(np.mean(values)) if values else float("nan")


def _percentile(values: Sequence[float], share: float) -> float:
    known = [value for value in values if value == value]
    return float(np.percentile(known, share)) if known else float("nan")


@dataclass(frozen=True)
class Goal:
    """A goal and what was reached.

    Parameters
    ----------
    text
        What it asks of a trial; one without a result does not do it.
    reached
        Share of the trials that do it.
    of
        How many trials.
    least
        The share that is asked for.
    """

    text: str
    reached: float
    of: int
    least: float

    @property
    def met(self) -> bool | None:
        """Whether it is; None where there is no trial."""
        return self.reached >= self.least if self.of else None


def goals(results: Sequence[Judged], fit_runs: int) -> list[Goal]:
    """What was asked of refinement with some number of fit runs, and what came out."""
    mine = [result for result in seen(results) if result.fit_runs == fit_runs]
    by = {name: [r for r in mine if group(r) == name] for name in ("single", "pair", "nothing", "outside", "fault")}
    healthy = [result for result in mine if group(result) != "fault"]

    def goal(text: str, trials: Sequence[Judged], asked: Callable[[Judged], bool], least: float) -> Goal:
        return Goal(text, _mean([r.status == "ok" and asked(r) for r in trials]), len(trials), least)

    return [
        goal("single: right name first", by["single"], lambda r: r.first, 0.9 if fit_runs >= 6 else 0.8),
        goal("single: no false name", by["single"], lambda r: not r.false, 0.95),
        goal("single: error after at most 1.3 floors", by["single"], lambda r: r.after <= NEAR, 0.9),
        goal("nothing: nothing named", by["nothing"], lambda r: not r.named, 0.95),
        goal("pairs: both named", by["pair"], lambda r: set(r.planted) <= set(r.named), 0.8),
        goal("pairs: no false name", by["pair"], lambda r: not r.false, 0.95),
        goal('outside: not "explained" above 1.5 floors', by["outside"], honest, 1.0),
        goal("all: not worse than before by over 5 %", mine, lambda r: r.after_K <= WORSE * r.before_K, 1.0),
        goal("all: error told is right to 10 %", mine, lambda r: abs(r.told_K - r.after_K) <= TOLD * r.after_K, 1.0),
        goal("faults: flagged", by["fault"], lambda r: r.flagged, 1.0),
        goal("faults: not learnt without a word", by["fault"], lambda r: r.flagged or not r.named, 1.0),
        goal("no fault: not flagged", healthy, lambda r: not r.flagged, 0.95),
    ]


def honest(result: Judged) -> bool:
    """Whether nothing is called explained that is not."""
    return result.verdict != "explained" or result.after <= EXPLAINED


HEAD = (
    "fit                                              right   right   in look- false  called | error in noise floors   "
    "  |\n"
    "runs planted                      trials  without first   place   alikes   name   faulty | before  90 %   after   "
    "90 % |     s"
)


def text(results: Sequence[Judged]) -> str:
    """By effect, what was named first, the goals, and every trial without a result."""
    lines = [HEAD]
    for row in rows(results):
        shares = " ".join(
            f"{_percent(share):>7}" for share in (row.first, row.placed, row.among, row.false, row.flagged)
        )
        floors = " ".join(f"{value:6.2f}" for value in (row.before, row.before_high, row.after, row.after_high))
        lines.append(
            f"{row.fit_runs:<4d} {row.planted:<28} {row.trials:6d} {row.without:8d} {shares} | {floors} | "
            f"{row.seconds:7.1f}"
        )
    lines += ["", *confusion(results)]
    if told := patterns(results):
        lines += ["", *told]
    for runs in sorted({result.fit_runs for result in results}):
        lines += ["", f"{runs} fit runs", *(_line(goal) for goal in goals(results, runs) if goal.of)]
    return "\n".join([*lines, "", *_without(results)])


def _line(goal: Goal) -> str:
    met = "met" if goal.met else "NOT met"
    return f"  {goal.text:<44} {_percent(goal.reached):>6} of {goal.of:<4d} at least {_percent(goal.least):>5}: {met}"


def confusion(results: Sequence[Judged]) -> list[str]:
    """What was named first, by what was planted: rows are planted, columns are named."""
    first: dict[str, Counter[str]] = {}
    for result in seen(results):
        named = (result.named or ["-"])[0] if result.status == "ok" else result.status
        first.setdefault(label(result), Counter())[named] += 1
    columns = [*(name for name in LIBRARY if any(name in counts for counts in first.values())), "-"]
    columns += sorted({name for counts in first.values() for name in counts} - set(columns))
    order = [*LIBRARY, "nothing", "pairs", *OUTSIDE, *FAULTS]
    heads = [f"{number}" for number in range(1, len(columns) + 1)]
    lines = [f"{'planted, and what was named first':<34}" + "".join(f"{head:>4}" for head in heads)]
    for name in sorted(first, key=order.index):
        cells = "".join(f"{first[name][column] or '.':>4}" for column in columns)
        lines.append(f"  {name:<32}{cells}")
    named = ", ".join(f"{head} {column}" for head, column in zip(heads, columns, strict=True))
    return [*lines, f"  {named}"]


def patterns(results: Sequence[Judged]) -> list[str]:
    """How what is left goes over time, as told of each kind that the library does not have, where anything was."""
    told: dict[str, Counter[str]] = {}
    for result in seen(results):
        if group(result) in ("outside", "fault"):
            told.setdefault(label(result), Counter())[result.pattern or "-"] += 1
    if not any(set(counts) - {"-"} for counts in told.values()):
        return []
    columns = [*sorted({name for counts in told.values() for name in counts} - {"-"}), "-"]
    lines = [f"{'planted, and how it goes over time':<34}" + "".join(f"{name:>16}" for name in columns)]
    for name in (name for name in (*OUTSIDE, *FAULTS) if name in told):
        lines.append(f"  {name:<32}" + "".join(f"{told[name][column] or '.':>16}" for column in columns))
    return lines


def _percent(share: float) -> str:
    return f"{100.0 * share:.0f} %" if share == share else "-"


def _without(results: Sequence[Judged]) -> list[str]:
    return [f"{r.status}: {r.trial}: {r.message[:200]}" for r in results if r.status != "ok"]
