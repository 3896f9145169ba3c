"""Lines that each name one number, round after round, as a sketch prints them with `println`: to tagged records."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

from gen.importing.reading.lines import Lines
from gen.importing.reading.pairs import LONGEST, is_timed, names_in, record_of, share_left
from gen.importing.reading.stamps import AROUND, is_stamp
from gen.importing.reading.tagged.tagged_records import Record

_SAMPLE = 400
_LEAST = 0.5
"""Of the lines: rules and empty words stand between them."""
_LEAST_ROUNDS = 3
_ALIKE = 0.8
"""How often a name comes, of how often another one does."""
_OF_TIMES = 0.1
"""Of the lines, how many fewer than half may be readings, where a time stands before each."""
_MOST_LEFT = 0.3
UNTIMED = "print millis() in a line of each round"
"""How to record with times."""


def is_rounds(texts: Sequence[str]) -> bool:
    """Whether lines name one number each, the same names again and again.

    Parameters
    ----------
    texts
        The lines.
    """
    sample = [text[:LONGEST] for text in texts[:_SAMPLE]]
    stamps = sum(map(is_stamp, sample))
    found = [(text, names) for text in sample if len(names := names_in(text)) > 0 and not is_stamp(text)]
    if any(len(names) > 1 or is_timed(text) for text, names in found):
        return False
    counts = Counter(names[0] for text, names in found if share_left(text) < _MOST_LEFT)
    often = [count for count in counts.values() if count >= _LEAST_ROUNDS]
    by_turns = stamps >= _LEAST_ROUNDS and abs(stamps - max(often, default=0)) <= 1  # one number below each time
    if len(often) < 2 - by_turns or sum(often) < (_LEAST - by_turns * _OF_TIMES) * len(sample):
        return False
    return min(often) >= _ALIKE * max(often) - 1


def rounds(lines: Lines, times: Sequence[str]) -> tuple[list[Record], list[int], list[int]]:
    """Records of rounds, each from the name that came first, or from one that comes again.

    Parameters
    ----------
    lines
        For which :func:`is_rounds`.
    times
        Of each line, where something else told it.

    Returns
    -------
    records, places, bad
        And the numbers of lines that are none.
    """
    made: list[dict[str, str]] = []
    stamps: list[str] = []
    places, bad = [], []
    first, at, begun = "", "", True
    for i, (text, number) in enumerate(zip(lines.texts, lines.numbers, strict=True)):
        stamp = text.strip(AROUND)
        names = names_in(text[:LONGEST])
        if is_stamp(text):
            at, begun = stamp, True
        elif len(names) != 1:
            bad.append(number)
        else:
            first = first or names[0]
            if begun or names[0] == first or names[0] in made[-1]:
                made.append({})
                stamps.append(times[i] if times else at)
                places.append(number)
                begun = False
            made[-1] |= record_of(text, frozenset())
    return (
        [
            {"fields": fields, "tags": {}} | ({"time": stamp} if stamp else {})
            for fields, stamp in zip(made, stamps, strict=True)
        ],
        places,
        bad,
    )
