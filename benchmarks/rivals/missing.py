"""Rivals whose library is not installed."""

from __future__ import annotations

import importlib
from types import ModuleType


class LibraryMissing(Exception):
    """A rival's library is not installed; the message says which and how to get it."""


def library(name: str) -> ModuleType:
    """Import a rival's library, or one of its modules.

    Raises
    ------
    LibraryMissing
        When it is not there.
    """
    try:
        return importlib.import_module(name)
    except ImportError as error:
        package = name.split(".")[0]
        raise LibraryMissing(f"{package} is not installed: pip install '.[rivals]'") from error
