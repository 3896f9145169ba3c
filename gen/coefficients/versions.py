"""The versions of the coefficient file: a file of an older one is brought to the newest before it is checked.

A file of any version loads for ever. A new version adds one function to :data:`MIGRATIONS`, which makes a file of it
from one of the version before; that function is never changed or removed. ``docs/format.md`` says what changed.
"""

from __future__ import annotations

import copy
from collections.abc import Callable
from typing import Any, Final

from gen.coefficients.messages import described
from gen.errors import InputError

FORMAT: Final = "gen-coefficients"
VERSION: Final = 2
"""The newest version, which is the one that is written."""

Tree = dict[str, Any]
"""A file's JSON, not yet checked."""
Migration = Callable[[Tree], Tree]
"""From a file of one version to the same of the next; it gets a copy of its own, and need not set the version."""


def _with_networks(tree: Tree) -> Tree:
    """Version 2 may hold a network in the place of components; what version 1 holds means the same in it."""
    if "network" in tree:
        raise InputError('found "network" in a file of version 1; a network needs "version": 2', place="$.network")
    return tree


MIGRATIONS: tuple[Migration, ...] = (_with_networks,)
"""The first makes version 2 of version 1, and so on."""


def version_of(tree: Tree) -> int:
    """Give the version of a file; one that does not say is taken for the first, and is refused later for the gap.

    Raises
    ------
    InputError
        When this is another format, or a version that this tool does not know: every other message would mislead.
    """
    if tree.get("format", FORMAT) != FORMAT:
        raise InputError(f'found {described(tree["format"])}, expected "{FORMAT}"', place="$.format")
    found, newest = tree.get("version", 1), len(MIGRATIONS) + 1
    expected = "1" if newest == 1 else f"1 to {newest}"
    if isinstance(found, bool) or not isinstance(found, (int, float)) or found < 1 or found != int(found):
        raise InputError(f"found {described(found)}, expected {expected}; see docs/format.md", place="$.version")
    if found > newest:
        raise InputError(
            f"found {described(found)}, expected {expected}: a newer gen wrote this file; install a newer gen "
            "(docs/format.md)",
            place="$.version",
        )
    return int(found)


def migrated(tree: Tree) -> Tree:
    """Bring a file to the newest version; one of the newest, or that does not say its version, stays as it is.

    Parameters
    ----------
    tree
        The file's JSON, which stays as it is.

    Raises
    ------
    InputError
        As :func:`version_of`; when the file is so far from valid that it cannot be brought to the next version; for a
        key of a later version where an unknown one would mislead.
    """
    first = version_of(tree)
    if "version" not in tree:
        return tree  # the checks that follow say so, or name the key that was meant
    for version, migration in enumerate(MIGRATIONS[first - 1 :], start=first):
        try:
            tree = migration(copy.deepcopy(tree)) | {"version": version + 1}
        except (LookupError, TypeError, ValueError, AttributeError) as error:
            raise InputError(
                f"cannot be brought from version {version} to {version + 1} ({type(error).__name__}: {error}); "
                f"expected a valid file of version {version}",
                place="$",
            ) from error
    return tree
