"""All effects by name."""

from __future__ import annotations

import importlib
import pkgutil
from collections.abc import Mapping
from functools import cache

from gen.model.effects import catalogue
from gen.model.effects.base import Effect

REGISTRY: dict[str, Effect] = {}


@cache
def registry() -> Mapping[str, Effect]:
    """All effects by name, in alphabetical order of their files."""
    for module in sorted(info.name for info in pkgutil.iter_modules(catalogue.__path__)):
        found = importlib.import_module(f"{catalogue.__name__}.{module}")
        for entry in vars(found).values():
            if isinstance(entry, type) and issubclass(entry, Effect) and entry.__module__ == found.__name__:
                REGISTRY[entry.name] = entry()
    return REGISTRY
