"""JSON texts one behind the other, each over several lines, as `sensors -j` and `jq` print them: one a line."""

from __future__ import annotations

import json
from json.decoder import JSONDecoder

from gen.importing.reading.lines import Lines
from gen.importing.reading.stamps import AROUND, is_stamp

_LEAST = 3


def one_a_line(text: str) -> Lines | None:
    """Each document in a line of its own, with the time that stands before it; None where a text is none of them.

    Parameters
    ----------
    text
        Objects, with nothing or a line of the time between them.
    """
    decoder = JSONDecoder()
    texts, numbers = [], []
    at, line, stamped = 0, 1, ""
    while at < len(text):
        if text[at].isspace() or text[at] == ",":
            line += text[at] == "\n"
            at += 1
            continue
        if text[at] != "{":
            end = text.find("\n", at)
            between = text[at : end if end >= 0 else len(text)]
            if not is_stamp(between) or end < 0:
                return None
            stamped, at = between.strip(AROUND), end
            continue
        try:
            tree, end = decoder.raw_decode(text, at)
        except (ValueError, RecursionError):
            return None
        texts.append(json.dumps({"time": stamped, **tree} if stamped else tree))
        numbers.append(line)
        line += text.count("\n", at, end)
        at, stamped = end, ""
    return Lines(texts, numbers, []) if len(texts) >= _LEAST else None
