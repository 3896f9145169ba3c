"""All effects by name: the catalogue's, those of installed packages, and those that a program registers itself."""

from __future__ import annotations

import importlib
import pkgutil
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from functools import cache
from importlib.metadata import entry_points
from types import MappingProxyType

from gen.errors import InputError
from gen.model.effects.base import Effect

GROUP = "gen.effects"
"""Entry points of this group in a package's metadata name subclasses of :class:`Effect`."""

_CATALOGUE = "gen.model.effects.catalogue"

_registered: dict[str, Effect] = {}
_catalogue_only: list[bool] = []


def registry() -> Mapping[str, Effect]:
    """All effects by name: the catalogue in alphabetical order of its files, packages, then registered ones.

    Raises
    ------
    InputError
        If an installed package's effect cannot be loaded.
    """
    known = _catalogue()
    return MappingProxyType(known if _catalogue_only else known | _installed() | _registered)


def register(effect: type[Effect]) -> type[Effect]:
    """Make an effect known to this process; also a decorator of its class.

    Parameters
    ----------
    effect
        The class.

    Raises
    ------
    ValueError
        If another effect has its name.
    """
    _added(_registered, effect, registry())
    return effect


def unregister(name: str) -> None:
    """Forget an effect that was registered.

    Raises
    ------
    KeyError
        If none of this name was.
    """
    del _registered[name]


@contextmanager
def catalogue_only() -> Iterator[None]:
    """Within it the registry is the catalogue: what is stored with gen must not depend on what else is installed."""
    _catalogue_only.append(True)
    try:
        yield
    finally:
        _catalogue_only.pop()


@cache
def _catalogue() -> dict[str, Effect]:
    known: dict[str, Effect] = {}
    folder = importlib.import_module(_CATALOGUE).__path__
    for module in sorted(info.name for info in pkgutil.iter_modules(folder)):
        found = importlib.import_module(f"{_CATALOGUE}.{module}")
        for entry in vars(found).values():
            if isinstance(entry, type) and issubclass(entry, Effect) and entry.__module__ == found.__name__:
                _added(known, entry, known)
    return known


@cache
def _installed() -> dict[str, Effect]:
    known: dict[str, Effect] = {}
    for entry in sorted(entry_points(group=GROUP), key=lambda point: point.name):
        try:
            _added(known, entry.load(), _catalogue() | known)
        except Exception as error:
            raise InputError(f"cannot be loaded as an effect: {error}", file=f"entry point {entry.value}") from error
    return known


def _added(known: dict[str, Effect], effect: type[Effect], others: Mapping[str, Effect]) -> None:
    if effect.name in others:
        raise ValueError(f'an effect with the name "{effect.name}" is there already')
    known[effect.name] = effect()


def calibration() -> Effect:
    """The effect that a sensor's tolerated error is written down as."""
    return next(effect for effect in registry().values() if effect.tolerance_K is not None)


def tolerance_K() -> float:
    """How far a sensor may be off by its nature, K."""
    return calibration().tolerance_K or 0.0
