"""What the board said while it ran: a run file's comments ``# event: TIME TEXT``, of which there may be many."""

from __future__ import annotations

import re
from pathlib import Path

from gen.runs.head import decoded, naming, opened

_EVENT = re.compile(r"#\s*event:\s*(\d+(?:\.\d+)?) (.+)")


def events(path: Path | str) -> list[tuple[float, str]]:
    """Give the events of a run file in its order: time of the run in s, and text.

    Raises
    ------
    InputError
        When the file cannot be read.
    """
    found = []
    with naming(path), opened(Path(path)) as stream:
        for number, raw in enumerate(stream, start=1):
            line = decoded(raw.removeprefix(b"\xef\xbb\xbf"), number).strip()
            if line and not line.startswith("#"):
                break
            if match := _EVENT.fullmatch(line):
                found.append((float(match[1]), match[2]))
    return found
