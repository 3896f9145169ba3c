"""The command line: ``record`` the nearest tests once, then ``run``; see docs/mutants.md."""

from __future__ import annotations

import argparse
import json
import os
import random
import signal
import subprocess
import sys
from collections import Counter
from collections.abc import Iterable
from pathlib import Path

from benchmarks.mutants import of_python, of_templates
from benchmarks.mutants.defects import Mutant, drawn, known
from benchmarks.mutants.nearest import nearest, recorded
from benchmarks.mutants.trials import Verdict, run

ROOT = Path(__file__).parents[2]
RECORDINGS = ROOT / "build" / "mutants"
EQUIVALENT = Path(__file__).parent / "equivalent.json"
RECORDED = (
    "model lowering effects reference coefficients firmware runs replay record thresholds rig identification "
    "refinement verification interface cli emulate study avr"
)
CAUGHT = "caught"


def record(rooms: Iterable[str]) -> None:
    """Run the tests of these rooms once and note which lines each runs."""
    for room in rooms:
        plugin = ["-p", "benchmarks.mutants.recording", "--mutants-map", str(RECORDINGS / f"{room}.json")]
        subprocess.run([sys.executable, "-m", "pytest", "-q", *plugin, f"tests/{room}"], cwd=ROOT, check=True)


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


def not_caught(verdicts: Path) -> list[Mutant]:
    """What survived an earlier run, was too slow for it or met no test."""
    said = [json.loads(line) for line in verdicts.read_text(encoding="utf-8").splitlines()]
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


def main() -> int:
    """Run the command line."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.mutants", description=__doc__)
    commands = parser.add_subparsers(dest="command", required=True)
    recording = commands.add_parser("record", help="note which test runs which line")
    recording.add_argument("rooms", nargs="*", default=RECORDED.split())
    trial = commands.add_parser("run", help="plant, test, print the score and the survivors")
    trial.add_argument("--count", type=int, default=300)
    trial.add_argument("--seed", type=int, default=11)
    trial.add_argument("--only", nargs="*", default=[], help="files, or beginnings of their paths")
    trial.add_argument("--tests", nargs="*", default=[], help="run these for every mutant, not the nearest recorded")
    trial.add_argument("--again", type=Path, help="instead of drawing: what an earlier run's file has as not caught")
    trial.add_argument("--jobs", type=int, default=1)
    trial.add_argument("--budget", type=float, default=40.0, help="recorded seconds of tests for one mutant")
    trial.add_argument("--limit", type=float, default=240.0, help="seconds for one mutant")
    trial.add_argument("--json", type=Path, default=RECORDINGS / "verdicts.jsonl")
    options = parser.parse_args()
    if options.command == "record":
        record(options.rooms)
        return 0
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))  # the copies are removed then, too
    notes = recorded(RECORDINGS)
    mutants = not_caught(options.again) if options.again else sample(options.count, options.seed, options.only)
    random.Random(options.seed).shuffle(mutants)
    same = reasons()
    equivalent = [mutant for mutant in mutants if mutant.key in same]
    planned = [
        (mutant, options.tests or nearest(mutant, notes, ROOT, options.budget))
        for mutant in mutants
        if mutant.key not in same
    ]
    counts: Counter[str] = Counter()
    options.json.parent.mkdir(parents=True, exist_ok=True)
    with options.json.open("w", encoding="utf-8") as file:
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
    print(f"{caught} of {judged} caught; beside these {apart}, {len(equivalent)} compute the same")
    return 0 if caught == judged else 1


if __name__ == "__main__":
    raise SystemExit(main())
