"""Which of the temperatures is the ambient's."""

from __future__ import annotations

import re
from collections.abc import Sequence

from gen.importing.guessing import names
from gen.importing.guessing.evidence import Facts

_OUTRIGHT, _ROOM, _AIR = range(3)


def ambient_of(temperatures: Sequence[Facts]) -> tuple[str, bool]:
    """The column that says most plainly that it is the ambient; and whether that has to be asked for.

    Asked for is one that only speaks of air, or of outside, beside a word that nobody knows (`air inlet`), and one of
    two rooms.

    Parameters
    ----------
    temperatures
        The columns that are temperatures.

    Returns
    -------
    name, doubtful
        No name where none says so.
    """
    ranked = [(rank, facts.name) for facts in temperatures if (rank := _rank(names.apart(facts.named[0]))) is not None]
    if not ranked:
        return "", False
    rank, name = min(ranked, key=lambda entry: entry[0])
    level, others = rank
    several = level != _OUTRIGHT and sum(1 for other, _ in ranked if other == rank) > 1
    return name, several or (level == _AIR and others > 0)


def _rank(base: str) -> tuple[int, int] | None:
    """How plainly a name says the ambient, least first: by which words, and how many others stand there."""
    level = next((level for level, words in enumerate(names.AMBIENTS) if words.search(base)), None)
    if level is None and names.HALL.search(base):  # all columns here are in degrees
        level = _ROOM
    if level is None or (level != _OUTRIGHT and names.PARTS.search(base)):
        return None
    plain = names.HALL.sub(" ", base) if level == _ROOM else base
    rest = names.AMBIENT.sub(" ", names.AMBIENT.sub(" ", plain))  # of two side by side, the first takes what parts them
    return level, sum(1 for word in re.split(r"[\W_]+", rest) if not names.NEUTRAL.fullmatch(word))
