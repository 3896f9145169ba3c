"""The command: cases until enough are ambiguous, in one process or two."""

from __future__ import annotations

import argparse
import os
import sys
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import asdict
from functools import partial
from itertools import islice
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

from benchmarks import plan
from benchmarks.campaign import in_order, json_text
from benchmarks.plan.judge import Case, Judged, judge
from benchmarks.plants.planted.draw import LIBRARY

MOST_TRIED = 20
"""Cases that are tried for each ambiguous one that is asked for."""


def options_of(arguments: Sequence[str] | None = None) -> argparse.Namespace:
    """Read the command line."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.plan",
        description=plan.__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--cases", type=int, default=2, help="how many ambiguous ones")
    parser.add_argument("--seed", type=int, default=0, help="of the first motor; the others follow")
    parser.add_argument("--fit-hours", type=float, default=1.5, help="of the first run")
    parser.add_argument("--hours", type=float, default=3.0, help="of the planned and of the random run")
    parser.add_argument("--jobs", type=int, choices=(1, 2), default=1, help="processes")
    parser.add_argument("--json", type=Path, help="write every case here, after each anew")
    parser.add_argument("--models", type=Path, help="keep identified networks here, and take those that are there")
    return parser.parse_args(arguments)


def cases(options: argparse.Namespace) -> Iterator[Case]:
    """Motor by motor, each with another effect first: any beginning has many motors and many effects."""
    effects = tuple(LIBRARY)
    for number in range(MOST_TRIED * options.cases):
        # A motor has two effects, the next motor the two after these.
        seed, effect = options.seed + number // 2, effects[number % len(effects)]
        yield Case(seed, effect, options.fit_hours, options.hours)


def in_a_folder(case: Case, models: Path) -> Judged:
    """Judge a case in a folder of its own."""
    with tempfile.TemporaryDirectory(prefix="plan-") as name:
        return judge(case, models, Path(name))


def _lost(case: Case, error: Exception) -> Judged:
    return Judged(str(case), status="failed", message=f"{type(error).__name__}: {error}")


def judged(options: argparse.Namespace, models: Path) -> Iterator[Judged]:
    """Judge until enough are ambiguous."""
    every, enough = cases(options), 0
    while enough < options.cases:
        batch = list(islice(every, options.jobs))
        if not batch:
            return
        for result in in_order(batch, partial(in_a_folder, models=models), _lost, options.jobs):
            enough += result.status == "ok"
            yield result


def told(result: Judged) -> str:
    """One line on a case."""
    if result.planned is None or result.random is None:
        return f"{result.case}: {result.status} {result.message}"
    after = [" + ".join(one.names) or "none" for one in (result.planned, result.random)]
    tied = [f" ({', '.join(one.lookalikes)})" if one.lookalikes else "" for one in (result.planned, result.random)]
    return (
        f"{result.case}: {' / '.join(result.hypotheses)} -> planned {after[0]}{tied[0]}; random {after[1]}{tied[1]}; "
        f"expected {result.planned_floors:.2f} against {result.plain_floors:.2f} floors"
    )


def text(results: Sequence[Judged]) -> str:
    """The table of all ambiguous cases, and what was left out of it."""
    open_ = [one for one in results if one.planned is not None and one.random is not None]
    lines = [
        "| planted | one run | and the planned one | and a random one as long | expected floors: planned, plain |",
        "|---|---|---|---|---|",
    ]
    for one in open_:
        assert one.planned is not None
        assert one.random is not None
        shown = [", ".join([" + ".join(n.names) or "none", *n.lookalikes]) for n in (one.planned, one.random)]
        marks = ["**" if n.right else "" for n in (one.planned, one.random)]
        after = [f"{mark}{words}{mark}" for mark, words in zip(marks, shown, strict=True)]
        floors = f"{one.planned_floors:.2f}, {one.plain_floors:.2f}"
        lines.append(f"| {one.case} | {', '.join(one.hypotheses)} | {after[0]} | {after[1]} | {floors} |")
    count = len(open_)
    shares = {
        "right name first after one run": sum(one.right for one in open_),
        "right name among what is left open": sum(one.among for one in open_),
        "right name first after the planned run": sum(bool(one.planned and one.planned.right) for one in open_),
        "the same, and none tied with it": sum(bool(one.planned and one.planned.alone) for one in open_),
        "right name first after a random run": sum(bool(one.random and one.random.right) for one in open_),
        "the same, and none tied with it ": sum(bool(one.random and one.random.alone) for one in open_),
    }
    clear = sum(one.status == "clear" for one in results)
    failed = [one for one in results if one.status == "failed"]
    lines += ["", *(f"{words.strip()}: {number} of {count}" for words, number in shares.items())]
    lines += [f"not ambiguous after one run: {clear}; without a result: {len(failed)}"]
    return "\n".join([*lines, *(f"  {one.case}: {one.message}" for one in failed)])


def main() -> None:
    """Judge, and print the table."""
    options = options_of()
    results: list[Judged] = []
    with tempfile.TemporaryDirectory(prefix="models-") as name:
        models = options.models or Path(name)
        models.mkdir(parents=True, exist_ok=True)
        for result in judged(options, models):
            results.append(result)
            print(f"{len(results)} {told(result)}", file=sys.stderr, flush=True)
            if options.json:
                options.json.parent.mkdir(parents=True, exist_ok=True)
                options.json.write_text(json_text([asdict(one) for one in results]), encoding="utf-8")
    print(text(results))


if __name__ == "__main__":
    main()
