"""The command line: ``record`` the nearest tests once, then ``run``; see docs/mutants.md."""

from __future__ import annotations

import argparse
import json
import os
import random
import signal
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

from benchmarks.mutants import of_python, of_templates
from benchmarks.mutants.defects import Mutant, drawn, known
from benchmarks.mutants.named import named
from benchmarks.mutants.nearest import nearest, recorded
from benchmarks.mutants.recording import Limits
from benchmarks.mutants.trials import Verdict, run

ROOT = Path(__file__).parents[2]
RECORDINGS = ROOT / "build" / "mutants"
EQUIVALENT = Path(__file__).parent / "equivalent.json"
RECORDED = (
    "model lowering effects reference coefficients firmware identification refinement verification emulate runs replay "
    "record thresholds rig certificate live fleet importing planning proposal drawing interface cli study avr device"
)
CAUGHT = "caught"


def record(rooms: Sequence[str], limits: Limits, jobs: int) -> None:
    """Run the quick tests of these rooms once, `jobs` rooms at a time, and note which lines each test runs."""

    def one(room: str) -> int:
        plugin = ["-p", "benchmarks.mutants.recording", "--mutants-map", str(RECORDINGS / f"{room}.json")]
        for name, value in (("test", limits.test_s), ("file", limits.file_s), ("cases", limits.cases)):
            plugin += [f"--mutants-{name}", str(value)]
        command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", *plugin, f"tests/{room}"]
        return subprocess.run(command, cwd=ROOT, check=False, stdout=subprocess.DEVNULL).returncode

    with ThreadPoolExecutor(jobs) as pool:
        began = time.perf_counter()
        for room, status in zip(rooms, pool.map(one, rooms), strict=True):
            print(
                f"{time.perf_counter() - began:6.0f} s  {room}" + (f": pytest says {status}" if status else ""),
                flush=True,
            )


def sample(count: int, seed: int, only: list[str]) -> list[Mutant]:
    """Draw mutants: four of ``gen/`` to one of the templates, files by their number of lines.

    Parameters
    ----------
    count, seed
        How many, and the draw's.
    only
        Files (or beginnings of their paths) to take instead of all.
    """
    chosen: list[Mutant] = []
    sources = (
        (of_python.modules(ROOT), of_python.mutants_of, 0.8),
        (of_templates.templates(ROOT), of_templates.mutants_of, 0.2),
    )
    for files, mutants_of, share in sources:
        taken = [f for f in files if not only or f.relative_to(ROOT).as_posix().startswith(tuple(only))]
        if not taken:
            continue
        weights = [len(file.read_text(encoding="utf-8").splitlines()) for file in taken]
        wanted = count if only and len(chosen) == 0 else round(count * share)
        picks = Counter(random.Random(seed).choices(range(len(taken)), weights, k=wanted))
        for place, number in sorted(picks.items()):
            chosen += drawn(mutants_of(taken[place], ROOT), number, seed)
    return chosen


def said_in(verdicts: Path) -> list[dict[str, Any]]:
    """What a run wrote about each mutant; nothing where it has not begun."""
    return [json.loads(line) for line in verdicts.read_text("utf-8").splitlines()] if verdicts.exists() else []


def not_caught(verdicts: Path) -> list[Mutant]:
    """What survived an earlier run, was too slow for it or met no test."""
    said = said_in(verdicts)
    open_ = [each for each in said if each["outcome"] not in (CAUGHT, "no program")]
    found = (known(ROOT, each["path"], each["line"], each["before"], each["after"]) for each in open_)
    return [mutant for mutant in found if mutant is not None]


def told(verdict: Verdict) -> str:
    """One verdict in a line or three."""
    mutant = verdict.mutant
    head = f"{verdict.outcome:10} {verdict.seconds:5.1f} s  {mutant.path}:{mutant.line}  {verdict.by}"
    if verdict.outcome == CAUGHT or verdict.outcome == "no program":
        return head
    return f"{head} ({verdict.tests} tests)\n    - {mutant.before}\n    + {mutant.after}"


def reasons() -> dict[tuple[str, str, str], str]:
    """Why some mutants cannot be caught: they compute the same."""
    return {(e["path"], e["before"], e["after"]): e["reason"] for e in json.loads(EQUIVALENT.read_text("utf-8"))}


def parsed() -> argparse.Namespace:
    """Read the command line."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.mutants", description=__doc__)
    commands = parser.add_subparsers(dest="command", required=True)
    recording = commands.add_parser("record", help="note which test runs which line")
    usual = Limits()
    recording.add_argument("rooms", nargs="*", default=RECORDED.split())
    recording.add_argument("--jobs", type=int, default=1, help="rooms at a time")
    recording.add_argument("--test", type=float, default=usual.test_s, help="seconds after which a test is left out")
    recording.add_argument("--file", type=float, default=usual.file_s, help="seconds that a file of tests may take")
    recording.add_argument("--cases", type=int, default=usual.cases, help="cases of one test function")
    trial = commands.add_parser("run", help="plant, test, print the score and the survivors")
    trial.add_argument("--count", type=int, default=300)
    trial.add_argument("--seed", type=int, default=11)
    trial.add_argument("--tests", nargs="*", default=[], help="run these for every mutant, not the nearest recorded")
    trial.add_argument("--again", type=Path, help="instead of drawing: what an earlier run's file has as not caught")
    trial.add_argument("--resume", action="store_true", help="go on with a run that was ended: keep what --json holds")
    trial.add_argument("--budget", type=float, default=40.0, help="recorded seconds of tests for one mutant")
    by_name = commands.add_parser("named", help="plant those of named.json, each with the tests named there")
    for each, file in ((trial, "verdicts.jsonl"), (by_name, "named.jsonl")):
        each.add_argument("--only", nargs="*", default=[], help="files, or beginnings of their paths")
        each.add_argument("--jobs", type=int, default=1)
        each.add_argument("--limit", type=float, default=240.0, help="seconds for one mutant")
        each.add_argument("--json", type=Path, default=RECORDINGS / file)
    return parser.parse_args()


Planned = list[tuple[Mutant, list[str]]]


def planned_of(options: argparse.Namespace) -> tuple[Planned, Counter[str], int]:
    """What `run` has to try, what an earlier run said of the others, and how many compute the same."""
    notes = recorded(RECORDINGS)
    mutants = sample(options.count, options.seed, options.only) if options.again is None else not_caught(options.again)
    mutants = [mutant for mutant in mutants if not options.only or mutant.path.startswith(tuple(options.only))]
    random.Random(options.seed).shuffle(mutants)
    same = reasons()
    told_before = said_in(options.json) if options.resume else []
    earlier = {(each["path"], each["before"], each["after"]): each["outcome"] for each in told_before}
    different = [mutant for mutant in mutants if mutant.key not in same]
    planned = [
        (mutant, options.tests or nearest(mutant, notes, ROOT, options.budget))
        for mutant in different
        if mutant.key not in earlier
    ]
    counts = Counter(earlier[mutant.key] for mutant in different if mutant.key in earlier)
    return planned, counts, len(mutants) - len(different)


def main() -> int:
    """Run the command line."""
    options = parsed()
    if options.command == "record":
        record(options.rooms, Limits(options.test, options.file, options.cases), options.jobs)
        return 0
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))  # the copies are removed then, too
    goes_on = options.command == "run" and options.resume
    if options.command == "run":
        planned, counts, equivalent = planned_of(options)
    else:
        planned, gone = named(ROOT, tuple(options.only))
        counts, equivalent = Counter(), 0
        print("\n".join(gone), end="\n" if gone else "")
    options.json.parent.mkdir(parents=True, exist_ok=True)
    with options.json.open("a" if goes_on else "w", encoding="utf-8") as file:
        for verdict in run(planned, ROOT, options.jobs, options.limit):
            counts[verdict.outcome] += 1
            print(told(verdict), flush=True)
            mutant = verdict.mutant
            said = {"path": mutant.path, "line": mutant.line, "before": mutant.before, "after": mutant.after}
            said |= {"outcome": verdict.outcome, "by": verdict.by, "seconds": round(verdict.seconds, 1)}
            file.write(json.dumps(said) + "\n")
            file.flush()
    caught = counts[CAUGHT]
    judged = sum(counts.values()) - counts["no program"] - counts["too slow"]
    apart = ", ".join(f"{counts[name]} {name}" for name in ("no program", "too slow"))
    print(f"{caught} of {judged} caught; beside these {apart}, {equivalent} compute the same")
    return 0 if caught == judged else 1


if __name__ == "__main__":
    raise SystemExit(main())
