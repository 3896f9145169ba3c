"""The channels that the effects need, as the board holds them: in thousandths."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from gen.lowering.effects.program import Channel
from gen.model import ThermalModel
from gen.model.effects import Applied
from gen.model.effects.channel_ranges import ChannelRange, channel_ranges


def channels(
    model: ThermalModel, effects: Sequence[Applied], declared: Mapping[str, tuple[float, float]]
) -> tuple[Channel, ...]:
    """The ambient and all columns.

    Parameters
    ----------
    model, effects
        What needs them.
    declared
        Ranges from the coefficient file, by column.
    """
    return tuple(_channel(found) for found in channel_ranges(model, effects, declared))


def _channel(found: ChannelRange) -> Channel:
    low, high, neutral = (round(value * 1000.0) for value in (found.low, found.high, found.neutral))
    return Channel(found.column, low, high, min(max(neutral, low), high))
