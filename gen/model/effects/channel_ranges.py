"""Which channels effects read, and in which range each may lie: of a board's arithmetic, and of what is proven."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from gen.model.dynamics import ROOM_degC, ThermalModel
from gen.model.effects.base import Applied, Input

#: By the unit at the end of a column's name, where the file says nothing else.
_RANGES = {"_a": (-50.0, 50.0), "_v": (0.0, 100.0), "_degc": (-50.0, 400.0), "_percent": (0.0, 100.0)}
_RANGES |= {"_pct": (0.0, 100.0), "_w": (0.0, 1000.0)}
_OTHER = (0.0, 20.0)


@dataclass(frozen=True)
class ChannelRange:
    """A channel in its own unit.

    Parameters
    ----------
    column
        Name in run files.
    low, high
        Values beyond them are held to them.
    neutral
        Before the first value.
    """

    column: str
    low: float
    high: float
    neutral: float


def columns(model: ThermalModel, effects: Sequence[Applied]) -> list[str]:
    """Extra columns that the effects need, each once."""
    names: dict[str, None] = {}
    for applied in effects:
        names |= dict.fromkeys(applied.columns(model.component_names))
    return list(names)


def channel_ranges(
    model: ThermalModel, effects: Sequence[Applied], declared: Mapping[str, tuple[float, float]]
) -> tuple[ChannelRange, ...]:
    """The ambient first, then all columns.

    Parameters
    ----------
    model, effects
        What needs them.
    declared
        Ranges from the coefficient file, by column.
    """
    fixed = model.ambient_fixed if model.ambient_fixed is not None else ROOM_degC
    found = [ChannelRange("ambient_degC", *model.ambient_told, fixed)]
    for column in columns(model, effects):
        read = [(a, source) for a in effects for source, name in a.effect.reads(a.values) if name == column]
        neutral = next((value for a, source in read if (value := _neutral(a, source)) is not None), None)
        if neutral is None:
            neutral = fixed if column.lower().endswith("_degc") else 0.0
        low, high = next((source.limits for _, source in read if source.limits is not None), _by_unit(column))
        ends = declared.get(column, (min(low, neutral), max(high, 2.0 * neutral)))
        found.append(ChannelRange(column, *ends, neutral))
    return tuple(found)


def _neutral(applied: Applied, source: Input) -> float | None:
    """The value at which an effect does nothing, None where it states none."""
    value = applied.values.get(source.neutral) if isinstance(source.neutral, str) else source.neutral
    return None if value is None else float(value)


def _by_unit(column: str) -> tuple[float, float]:
    return next((limits for end, limits in _RANGES.items() if column.lower().endswith(end)), _OTHER)
