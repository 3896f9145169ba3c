"""Objects by their times, or by keys that mean nothing, as Firebase exports them: to an array of objects."""

from __future__ import annotations

from gen.importing.reading.stamps import is_stamp

_LEAST = 5
_LEAST_ALIKE = 20
"""Of keys that are no times: fewer objects with the same names are parts, and no rows."""


def entries_of(tree: object) -> object:
    """An array of the objects within one whose keys are times, or which have all the same names; else as it is.

    Parameters
    ----------
    tree
        A JSON text; what is looked for may be the only object within others.
    """
    if not isinstance(tree, dict):
        return tree
    if len(tree) == 1:
        (within,) = tree.values()
        found = entries_of(within)
        return found if found is not within else tree
    entries = list(tree.values())
    if len(entries) < _LEAST or not all(isinstance(entry, dict) and entry for entry in entries):
        return tree
    if all(map(is_stamp, tree)):
        return [{"time": key, **entry} for key, entry in tree.items()]
    alike = {tuple(sorted(entry)) for entry in entries}
    return entries if len(entries) >= _LEAST_ALIKE and len(alike) == 1 else tree
