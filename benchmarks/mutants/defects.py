"""A planted defect: a file of the repository with one small change."""

from __future__ import annotations

import random
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class Mutant:
    """One change.

    Attributes
    ----------
    path
        From the repository's root.
    line
        Of the change, from 1.
    kind
        What was done, such as ``< to <=``.
    text
        The whole file with the change.
    before, after
        The changed line without its indentation.
    """

    path: str
    line: int
    kind: str
    text: str
    before: str
    after: str

    @property
    def key(self) -> tuple[str, str, str]:
        """What it is known by, wherever the line stands."""
        return self.path, self.before, self.after


def changed(path: str, kind: str, old: str, new: str) -> Mutant | None:
    """The mutant that makes `new` of a file's `old` text; None where no line differs or more than one does."""
    first, second = old.splitlines(), new.splitlines()
    if len(first) != len(second):
        return None
    places = [i for i, (a, b) in enumerate(zip(first, second, strict=True)) if a != b]
    if len(places) != 1:
        return None
    (at,) = places
    return Mutant(path, at + 1, kind, new, first[at].strip(), second[at].strip())


def known(root: Path, path: str, line: int, before: str, after: str) -> Mutant | None:
    """A mutant that was told of before; None where its line now reads otherwise."""
    text = (root / path).read_text(encoding="utf-8")
    lines = text.splitlines(keepends=True)
    if line > len(lines) or lines[line - 1].strip() != before:
        return None
    lines[line - 1] = lines[line - 1].replace(before, after)
    return changed(path, "again", text, "".join(lines))


def drawn(makers: Sequence[Callable[[], Mutant | None]], count: int, seed: int) -> list[Mutant]:
    """Draw without repetition, at most two of one line; the same for the same seed and sources."""
    order = list(makers)
    random.Random(seed).shuffle(order)
    seen: Counter[int] = Counter()
    chosen: list[Mutant] = []
    for make in order:
        if len(chosen) == count:
            break
        mutant = make()
        if mutant is not None and seen[mutant.line] < 2:
            seen[mutant.line] += 1
            chosen.append(mutant)
    return chosen
