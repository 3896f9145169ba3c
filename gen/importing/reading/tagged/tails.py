"""Names that say where a reading comes from, as paths: what all begin with, and `state` at the end, says nothing."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Sequence

CARRIERS = {"state", "value", "val", "reading", "values", "status", "get"}
"""Ends of paths that say nothing where most have the same."""
_LEAST_SHARED = 0.5


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
    ends = Counter(path[-1] for path in kept.values() if len(path) > 1 and path[-1].casefold() in CARRIERS)
    often = {end for end, count in ends.items() if count > 1 and count >= _LEAST_SHARED * len(kept)}
    kept = {name: path[:-1] if len(path) > 1 and path[-1] in often else path for name, path in kept.items()}
    return {name: "".join(path).rstrip(marks) or name for name, path in kept.items()}
