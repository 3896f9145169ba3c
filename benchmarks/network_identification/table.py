"""The table of many cases."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np

from benchmarks.network_identification.judge import Held, Judged
from benchmarks.plants.cases import Case, bench, profile_chance
from benchmarks.plants.profiles import DataKind, fitted
from benchmarks.plants.rooms import RoomKind

GOOD = 1.3
"""Noise floors up to which a model counts as good."""
WORSE = 0.1
"""Noise floors by which a model may be worse with more data before it is named."""


@dataclass(frozen=True)
class Row:
    """A cell of the table: all plants with one kind of data, room and model.

    Parameters
    ----------
    model, data, room
        Which.
    cases, refused, raised
        How many, and how many without a model.
    left_out
        Share of the sensed nodes of the models that exist which they lack.
    median, high
        Median and 90 % of the error in noise floors, of the models that exist.
    turning, stopping
        Medians by test run, in noise floors.
    good
        Share of all cases, refused and raised ones too, whose model has every sensed node and errs by at most 1.3.
    declared, true_rise, read_rise
        Shares of declared errors and of intervals that hold.
    undeclared
        Means for which nothing was declared.
    seconds
        Median of identification.
    """

    model: str
    data: str
    room: str
    cases: int
    refused: int
    raised: int
    left_out: float
    median: float
    high: float
    turning: float
    stopping: float
    good: float
    declared: float
    undeclared: int
    true_rise: float
    read_rise: float
    seconds: float


def rows(results: Sequence[Judged]) -> list[Row]:
    """All cells that have a case."""
    models = list(dict.fromkeys(result.model for result in results))
    cells = {cell: list[Judged]() for cell in product(models, DataKind, RoomKind)}
    for result in results:
        case = Case.parse(result.case)
        cells[result.model, case.data, case.room].append(result)
    return [_row(model, data, room, mine) for (model, data, room), mine in cells.items() if mine]


def _row(model: str, data: str, room: str, mine: Sequence[Judged]) -> Row:
    made = [result for result in mine if result.status == "ok"]
    floors = [result.floors for result in made]
    nodes = sum(result.nodes for result in made)
    return Row(
        model=model,
        data=str(data),
        room=str(room),
        cases=len(mine),
        refused=sum(result.status == "refused" for result in mine),
        raised=sum(result.status == "raised" for result in mine),
        left_out=sum(len(result.left_out) for result in made) / nodes if nodes else float("nan"),
        median=_percentile(floors, 50),
        high=_percentile(floors, 90),
        turning=_percentile([result.by_run["test_turning"] / result.floor_K for result in made], 50),
        stopping=_percentile([result.by_run["test_stopping"] / result.floor_K for result in made], 50),
        good=float(np.mean([result.whole and result.floors <= GOOD for result in mine])),
        declared=_share([result.declared for result in made]),
        undeclared=sum(result.undeclared for result in made),
        true_rise=_share([result.true_rise for result in made]),
        read_rise=_share([result.read_rise for result in made]),
        seconds=_percentile([result.seconds for result in mine], 50),
    )


def _percentile(values: Sequence[float], share: float) -> float:
    return float(np.percentile(values, share)) if values else float("nan")


def _share(held: Sequence[Held]) -> float:
    of = sum(one.of for one in held)
    return sum(one.inside for one in held) / of if of else float("nan")


HEAD = (
    "model    data       room        cases  refused raised  left out | error in noise floors           good  | "
    "declared   intervals     s\n"
    "                                                                 median   90 %  turning stopping       | "
    "hold       true   read"
)


def text(results: Sequence[Judged]) -> str:
    """The table, what more data did, and every case without a model."""
    lines = [HEAD]
    for row in rows(results):
        lines.append(
            f"{row.model:<8} {row.data:<10} {row.room:<10} {row.cases:6d} {row.refused:8d} {row.raised:6d} "
            f"{_percent(row.left_out):>9} | {row.median:6.2f} {row.high:6.2f} {row.turning:8.2f} {row.stopping:8.2f} "
            f"{_percent(row.good):>6} | {_percent(row.declared):>8} {_percent(row.true_rise):>6} "
            f"{_percent(row.read_rise):>6} {row.seconds:5.1f}"
        )
    lines += ["", *by_rest(results), *more_data(results), *choices(results), *_without(results)]
    return "\n".join(lines)


def _percent(share: float) -> str:
    return f"{100.0 * share:.0f} %" if share == share else "-"


def by_rest(results: Sequence[Judged]) -> list[str]:
    """What models err by whose motors rested in the runs, and the others', in cells that have both."""
    cells: dict[tuple[str, str, str], dict[bool, list[Judged]]] = {}
    for result in results:
        case = Case.parse(result.case)
        cell = cells.setdefault((result.model, str(case.data), str(case.room)), {True: [], False: []})
        cell[rested(case)].append(result)
    return [
        f"{', '.join(cell)}: median {_errors(of[False])} whose runs never rest; {_errors(of[True])} others"
        for cell, of in cells.items()
        if of[True] and of[False]
    ]


def rested(case: Case) -> bool:
    """Whether a case's runs hold PWM 0."""
    profiles = fitted(case.data, profile_chance(bench(case.seed)))
    return any(pwm == 0 for profile in profiles for pwm, _ in profile.holds)


def _errors(results: Sequence[Judged]) -> str:
    floors = [result.floors for result in results if result.status == "ok"]
    good = float(np.mean([result.whole and result.floors <= GOOD for result in results]))
    of = f"{_percentile(floors, 50):.2f}, 90 % {_percentile(floors, 90):.2f}, within {GOOD} {_percent(good)}"
    return f"{of} in {len(results)}"


def more_data(results: Sequence[Judged]) -> list[str]:
    """By model and room: how many plants two mixed runs beside the same five steps made worse."""
    by_case = {(result.model, result.case): result for result in results}
    lines = []
    for model, room in product(dict.fromkeys(result.model for result in results), RoomKind):
        changes: list[tuple[float, int]] = []
        for (kind, name), steps in by_case.items():
            case = Case.parse(name)
            mixed = by_case.get((model, str(Case(case.seed, DataKind.MIXED, room))))
            mine = kind == model and case.data is DataKind.STEPS and case.room is room and steps.whole
            if mine and mixed is not None:
                changes.append((mixed.floors - steps.floors if mixed.whole else float("inf"), case.seed))
        if changes:
            worse = [seed for change, seed in sorted(changes, reverse=True) if change > WORSE]
            seeds = f": plants {', '.join(map(str, worse[:5]))}" if worse else ""
            lines.append(
                f"{model}, {room}: mixed runs beside the steps make {len(worse)} of {len(changes)} models "
                f"worse by over {WORSE} floors, or lose a node{seeds}"
            )
    return lines


SAME = 1.05
"""Errors within this factor are the same."""


def choices(results: Sequence[Judged]) -> list[str]:
    """How often `auto` took the kind that errs less on the test runs, and where it did not."""
    by_case = {(result.model, result.case): result for result in results}
    kinds = ("parts", "network")
    right = taken = 0
    lines = []
    for result in results:
        both = [by_case.get((kind, result.case)) for kind in kinds]
        known = [one for one in both if one is not None and one.status == "ok"]
        if result.model != "auto" or result.status != "ok" or len(known) < len(kinds):
            continue
        best = min(known, key=lambda one: one.floors)
        taken += 1
        right += result.floors <= SAME * best.floors
        if result.floors > SAME * best.floors:
            lines.append(
                f"not the better one: {result.case}: {result.floors:.2f} floors, {best.model} {best.floors:.2f}"
            )
    if not taken:
        return []
    return [f"auto took the better of both kinds, or one within {SAME - 1.0:.0%} of it, in {right} of {taken}", *lines]


def _without(results: Sequence[Judged]) -> list[str]:
    return [f"{r.status}: {r.case} {r.model}: {r.message[:200]}" for r in results if r.status != "ok"]
