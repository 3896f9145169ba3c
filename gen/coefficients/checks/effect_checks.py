"""What a file's effects must satisfy before anything is computed with them."""

from __future__ import annotations

from collections.abc import Sequence

from gen.coefficients.document import Document
from gen.errors import InputError
from gen.model.dynamics import ThermalModel
from gen.model.effects import Applied
from gen.model.effects.runaway import domain_of, runaway
from gen.model.extended import fold

GROWS = "temperatures might grow without end (docs/effects.md)"


def declared_ranges(document: Document) -> dict[str, tuple[float, float]]:
    """Ranges of channels that the wiring declares, by column."""
    wired = document.wiring.channels if document.wiring is not None else ()
    return {channel.column: channel.limits for channel in wired}


def check_runaway(document: Document, model: ThermalModel, effects: tuple[Applied, ...]) -> None:
    """Refuse effects with which temperatures grow without end while everything is held.

    Parameters
    ----------
    document
        The document.
    model, effects
        Made of it: the model with what folds into it, and the other effects.

    Raises
    ------
    InputError
        With the JSON path of the effect that adds most to it.
    """
    found = runaway(model, effects, domain_of(model, effects, declared_ranges(document)))
    if found is None:
        return
    raise InputError(f"{found.message}: {GROWS}", place=place_of(document, found.applied))


def runs_away(document: Document, model: ThermalModel, effects: Sequence[Applied], more: Sequence[Applied]) -> bool:
    """Whether temperatures grow without end with more effects beside those that a file has.

    Parameters
    ----------
    document, model, effects
        As :func:`check_runaway` takes them.
    more
        Further effects, at components of the model.
    """
    model, rest = fold(model, more)
    every = (*effects, *rest)
    return runaway(model, every, domain_of(model, every, declared_ranges(document))) is not None


def place_of(document: Document, applied: Applied) -> str:
    """JSON path of an effect."""
    number = next(i for i, entry in enumerate(document.effects) if entry.applied() == applied)
    return f"$.effects[{number}]"
