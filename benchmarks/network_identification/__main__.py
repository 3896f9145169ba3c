"""The command: cases by plants, data and rooms, judged in one process or two."""

from __future__ import annotations

import argparse
import json
import os
import sys
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import asdict
from functools import partial
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

from benchmarks import network_identification
from benchmarks.campaign import in_order, json_text
from benchmarks.network_identification.judge import Judged, judge
from benchmarks.network_identification.table import rows, text
from benchmarks.plants.cases import Case, bench, matrix, write_case
from benchmarks.plants.profiles import DataKind
from benchmarks.plants.rooms import RoomKind

MODELS = {
    "parts": ("parts",),
    "network": ("network",),
    "both": ("parts", "network"),
    "auto": ("auto",),
    "all": ("parts", "network", "auto"),
}


def options_of(arguments: Sequence[str] | None = None) -> argparse.Namespace:
    """Read the command line."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.network_identification",
        description=network_identification.__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--plants", type=int, default=100, help="how many")
    parser.add_argument("--seed", type=int, default=0, help="of the first plant; the others follow")
    parser.add_argument("--model", choices=MODELS, default="parts")
    parser.add_argument("--data", type=partial(_kinds, DataKind), default=tuple(DataKind), help="steps,mixed,...")
    parser.add_argument("--room", type=partial(_kinds, RoomKind), default=tuple(RoomKind), help="held,moving,...")
    parser.add_argument(
        "--disturbed", type=float, default=0.0, help="K by which what no log holds moves the parts slowly"
    )
    parser.add_argument("--first", type=int, help="only as many cases of the matrix")
    parser.add_argument("--jobs", type=int, choices=(1, 2), default=1, help="processes")
    parser.add_argument("--json", type=Path, help="write every case and the table here, after each case anew")
    parser.add_argument("--case", type=Case.parse, help="SEED:DATA:ROOM: this one only")
    parser.add_argument("--keep", type=Path, help="with --case: write its files here and leave them")
    options = parser.parse_args(arguments)
    if options.keep and not options.case:
        parser.error("--keep needs --case")
    return options


def _kinds(kind: type[DataKind] | type[RoomKind], text: str) -> tuple[DataKind | RoomKind, ...]:
    return tuple(kind(word) for word in text.split(","))


def in_a_folder(case: Case, models: Sequence[str], keep: Path | None = None, disturbed_K: float = 0.0) -> list[Judged]:
    """Judge a case in a folder of its own; its files are written once for all models."""
    with tempfile.TemporaryDirectory(prefix="plants-") as name:
        folder = keep or Path(name)
        folder.mkdir(parents=True, exist_ok=True)
        try:
            written = write_case(case, folder, disturbed_K)
        except Exception as error:  # the plant's own fault; the case still counts
            return _raised(models, case, error)
        return [judge(written, model, folder) for model in models]


def judged(cases: Sequence[Case], models: Sequence[str], jobs: int, disturbed_K: float = 0.0) -> Iterator[list[Judged]]:
    """Judge cases, in their order; those whose process dies are told as raised."""
    one = partial(in_a_folder, models=models, disturbed_K=disturbed_K)
    return in_order(cases, one, partial(_raised, models), jobs)


def _raised(models: Sequence[str], case: Case, error: Exception) -> list[Judged]:
    return [Judged(str(case), model, "raised", f"{type(error).__name__}: {error}") for model in models]


def as_json(results: Sequence[Judged]) -> str:
    """Every case and the table; what is no number is null."""
    made = {"cases": [asdict(r) for r in results], "table": [asdict(row) for row in rows(results)]}
    return json_text(made)


def main() -> None:
    """Judge, and print the table."""
    options = options_of()
    models = MODELS[options.model]
    if options.case:
        found = in_a_folder(options.case, models, options.keep, options.disturbed)
        made = as_json(found)
        if options.keep:
            (options.keep / "judged.json").write_text(made, encoding="utf-8")
            drawn = json.dumps(asdict(bench(options.case.seed)), indent=1)
            (options.keep / "plant.json").write_text(drawn + "\n", encoding="utf-8")
        print(made + text(found))
        return
    cases = matrix(range(options.seed, options.seed + options.plants), options.data, options.room)[: options.first]
    results: list[Judged] = []
    for number, found in enumerate(judged(cases, models, options.jobs, options.disturbed), start=1):
        results += found
        for one in found:
            print(
                f"{number}/{len(cases)} {one.case} {one.model}: {one.status}, {one.floors:.2f} floors, "
                f"{one.seconds:.1f} s{', left out: ' + ', '.join(one.left_out) if one.left_out else ''}"
                f"{'; ' + one.chosen[1] if one.chosen[1] else ''}",
                file=sys.stderr,
                flush=True,
            )
        if options.json:
            options.json.parent.mkdir(parents=True, exist_ok=True)
            options.json.write_text(as_json(results), encoding="utf-8")
    print(text(results))


if __name__ == "__main__":
    main()
