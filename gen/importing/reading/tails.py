"""Names that say where a reading comes from, as paths: what all of them begin with says nothing."""

from __future__ import annotations

import re
from collections.abc import Sequence

_CARRIERS = {"state", "value", "val", "reading", "values", "status", "get"}
"""Ends of paths that say nothing where all have the same."""


def without_shared(names: Sequence[str], marks: str) -> dict[str, str]:
    """Each name without the parts that all of them begin with; the last part stays.

    Parameters
    ----------
    names
        Paths.
    marks
        What parts them.
    """
    paths = {
        name: re.findall(rf"[^{re.escape(marks)}]+[{re.escape(marks)}]*|^[{re.escape(marks)}]+", name) for name in names
    }
    several = list(paths.values())
    shared = 0
    while several and all(len(path) > shared + 1 and path[shared] == several[0][shared] for path in several):
        shared += 1
    kept = {name: path[shared:] for name, path in paths.items()}
    ends = {path[-1] for path in kept.values() if path}
    if ends and len(ends) == 1 and ends <= _CARRIERS and all(len(path) > 1 for path in kept.values()):
        kept = {name: path[:-1] for name, path in kept.items()}
    return {name: "".join(path).rstrip(marks) or name for name, path in kept.items()}
