"""Mutants that once passed, each with the tests that have to see it now: ``named.json``."""

from __future__ import annotations

import json
from pathlib import Path

from benchmarks.mutants.defects import Mutant

NAMED = Path(__file__).parent / "named.json"


def named(root: Path, only: tuple[str, ...] = ()) -> tuple[list[tuple[Mutant, list[str]]], list[str]]:
    """Make them, and say which cannot be: their place is not there any more, or there more than once.

    Parameters
    ----------
    root
        The repository.
    only
        Beginnings of paths; empty: all.
    """
    made, gone = [], []
    for each in json.loads(NAMED.read_text(encoding="utf-8")):
        path, before, after = each["path"], each["before"], each["after"]
        if only and not path.startswith(only):
            continue
        text = (root / path).read_text(encoding="utf-8")
        if text.count(before) != 1:
            gone.append(f"{path}: found {before!r} {text.count(before)} times, expected it once")
            continue
        line = text[: text.index(before)].count("\n") + 1
        mutant = Mutant(path, line, "named", text.replace(before, after), before.strip(), after.strip())
        made.append((mutant, list(each["tests"])))
    return made, gone
