"""The command: trials by kinds and benches, judged in one process or two."""

from __future__ import annotations

import argparse
import json
import os
import re
import sys
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import asdict, fields
from functools import partial
from pathlib import Path
from typing import Any

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np

from benchmarks import network_refinement
from benchmarks.campaign import in_order, json_text
from benchmarks.network_refinement.judge import Judged, Kind, judge
from benchmarks.network_refinement.table import goals, rows, text
from benchmarks.plants.planted.draw import LIBRARY, NotVisible
from benchmarks.plants.planted.kinds import FAULTS, KINDS, OUTSIDE
from benchmarks.plants.planted.later import FIT_NAMES
from benchmarks.plants.planted.trial import NOTHING, Trial, setting, write_trial

GROUPS = {"single": tuple(LIBRARY), "outside": tuple(OUTSIDE), "faults": tuple(FAULTS)}


def options_of(arguments: Sequence[str] | None = None) -> argparse.Namespace:
    """Read the command line."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.network_refinement",
        description=network_refinement.__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--cases", nargs="+", default=["singlex1", "nothingx2"], help="KINDxN: 16x3 nothingx10 ...")
    parser.add_argument("--seed", type=int, default=0, help="of the first motor; the others follow")
    parser.add_argument("--fit-runs", type=_runs, default=(2,), help="2, 6 or 2,6")
    parser.add_argument("--only", help="of the trials, those in which this was planted")
    parser.add_argument("--first", type=int, help="only as many of the trials")
    parser.add_argument("--skip", type=int, default=0, help="leave out as many of the trials first")
    parser.add_argument("--jobs", type=int, choices=(1, 2), default=1, help="processes")
    parser.add_argument("--json", type=Path, help="write every trial and the tables here, after each trial anew")
    parser.add_argument("--go-on", action="store_true", help="take the trials that --json has as judged")
    parser.add_argument("--models", type=Path, help="keep identified networks here, and take those that are there")
    parser.add_argument(
        "--model", choices=("network", "parts"), default="network", help="what the motor is identified as"
    )
    parser.add_argument("--accept-change", action="store_true", help="refine with it")
    parser.add_argument("--case", type=Trial.parse, help="SEED:EFFECT:FIT: this one only")
    parser.add_argument("--keep", type=Path, help="with --case: write its files here and leave them")
    options = parser.parse_args(arguments)
    if options.go_on and not options.json:
        parser.error("--go-on needs --json")
    if options.keep and not options.case:
        parser.error("--keep needs --case")
    if options.only and options.only not in (*KINDS, NOTHING):
        parser.error(f"--only: nothing is called {options.only}")
    try:
        options.trials = [options.case] if options.case else chosen(options)
    except ValueError as error:
        parser.error(f"--cases: {error}")
    return options


def _runs(text: str) -> tuple[int, ...]:
    found = tuple(int(word) for word in text.split(","))
    if not all(1 <= runs <= len(FIT_NAMES) for runs in found):
        raise ValueError(text)
    return found


def chosen(options: argparse.Namespace) -> list[Trial]:
    """The trials, motor by motor."""
    cells = [cell for words in options.cases for cell in cells_of(words)]
    found = [Trial(options.seed + number, names, runs) for number, names in cells for runs in options.fit_runs]
    if options.only:
        found = [trial for trial in found if options.only in (trial.names or (NOTHING,))]
    return sorted(dict.fromkeys(found), key=lambda trial: trial.seed)[options.skip :][: options.first]


def cells_of(words: str) -> list[tuple[int, tuple[str, ...]]]:
    """Numbers of motors, and what is planted on each, of one KINDxN.

    Raises
    ------
    ValueError
        If it is none.
    """
    matched = re.fullmatch(r"(\w+?)x(\d+)", words)
    if not matched:
        raise ValueError(f"{words}: not KINDxN")
    kind, count = matched[1], int(matched[2])
    if kind == "pairs":
        return [(number, _pair(number)) for number in range(count)]
    if kind == NOTHING:
        return [(number, ()) for number in range(count)]
    names = GROUPS.get(kind) or ((kind,) if kind in KINDS else tuple(LIBRARY)[: int(kind)])
    return [(number, (name,)) for number in range(count) for name in names]


def _pair(number: int) -> tuple[str, ...]:
    """Two effects of the library."""
    rng = np.random.default_rng([20274, number])
    return tuple(str(name) for name in rng.choice(list(LIBRARY), 2, replace=False))


def in_a_folder(
    trial: Trial, models: Path, keep: Path | None = None, kind: Kind = "network", *, accept_change: bool = False
) -> Judged:
    """Judge a trial in a folder of its own."""
    with tempfile.TemporaryDirectory(prefix="refinement-") as name:
        folder = keep or Path(name)
        folder.mkdir(parents=True, exist_ok=True)
        try:
            written = write_trial(trial, folder)
        except NotVisible as error:
            return Judged(str(trial), planted=list(trial.names), status="unseen", message=str(error))
        except Exception as error:  # the plant's own fault; the trial still counts
            return _raised(trial, error)
        return judge(written, folder, models, kind, accept_change=accept_change)


def judged(
    trials: Sequence[Trial], models: Path, jobs: int, kind: Kind = "network", *, accept_change: bool = False
) -> Iterator[Judged]:
    """Judge trials, in their order; those whose process dies are told as raised."""
    one = partial(in_a_folder, models=models, kind=kind, accept_change=accept_change)
    return in_order(trials, one, _raised, jobs)


def _raised(trial: Trial, error: Exception) -> Judged:
    return Judged(str(trial), planted=list(trial.names), status="raised", message=f"{type(error).__name__}: {error}")


def as_json(results: Sequence[Judged]) -> str:
    """Every trial and the tables; what is no number is null."""
    trials = [
        {**asdict(r), "named": r.named, "first": r.first, "among": r.among, "false": r.false, "flagged": r.flagged}
        for r in results
    ]
    asked = {str(n): [asdict(g) for g in goals(results, n)] for n in sorted({r.fit_runs for r in results})}
    made = {"trials": trials, "table": [asdict(row) for row in rows(results)], "goals": asked}
    return json_text(made)


def judged_before(path: Path) -> list[Judged]:
    """The trials that a file of :func:`as_json` has."""
    numbers = {"floor_K", "before_K", "after_K", "told_K"}
    own = [entry.name for entry in fields(Judged)]
    found = []
    for trial in json.loads(path.read_text(encoding="utf-8"))["trials"]:
        values: dict[str, Any] = {key: trial[key] for key in own}
        values |= {key: float("nan") for key in numbers if values[key] is None}
        found.append(Judged(**values))
    return found


def told(result: Judged) -> str:
    """One line on a trial."""
    named = ", ".join(result.named) or "nothing"
    said = f"named {named}, {result.verdict}" if result.status == "ok" else f"{result.status}: {result.message[:80]}"
    return (
        f"{result.trial}{f' on {result.bench}' if not result.trial.startswith(f'{result.bench}:') else ''}: {said}; "
        f"{f'{result.became}, ' if result.became else ''}{result.before:.2f} -> {result.after:.2f} floors, "
        f"{result.seconds:.1f} s"
    )


def main() -> None:
    """Judge, and print the tables."""
    options = options_of()
    with tempfile.TemporaryDirectory(prefix="models-") as name:
        models = options.models or Path(name)
        models.mkdir(parents=True, exist_ok=True)
        if options.keep:
            result = in_a_folder(options.case, models, options.keep, options.model, accept_change=options.accept_change)
            (options.keep / "judged.json").write_text(as_json([result]), encoding="utf-8")
            _leave_truth(options.case, options.keep)
            print(as_json([result]) + text([result]))
            return
        results = judged_before(options.json) if options.go_on and options.json.exists() else []
        done = {result.trial for result in results}
        left = [trial for trial in options.trials if str(trial) not in done]
        for result in judged(left, models, options.jobs, options.model, accept_change=options.accept_change):
            results.append(result)
            print(f"{len(results)}/{len(options.trials)} {told(result)}", file=sys.stderr, flush=True)
            if options.json:
                options.json.parent.mkdir(parents=True, exist_ok=True)
                options.json.write_text(as_json(results), encoding="utf-8")
    print(text(results))


def _leave_truth(trial: Trial, folder: Path) -> None:
    """Write down what is truly there."""
    try:
        made = asdict(setting(trial.seed, trial.names))
    except NotVisible as error:
        made = {"unseen": str(error)}
    (folder / "truth.json").write_text(json.dumps(made, indent=1, default=float) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
