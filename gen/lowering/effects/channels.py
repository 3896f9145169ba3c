"""The channels that the effects need, as the board holds them: in thousandths."""

from __future__ import annotations

from collections.abc import Iterable

from gen.lowering.effects.program import Channel
from gen.model.effects.channel_ranges import ChannelRange


def channels(ranges: Iterable[ChannelRange]) -> tuple[Channel, ...]:
    """Channels in thousandths of their unit, each neutral value within its range."""
    return tuple(_channel(found) for found in ranges)


def _channel(found: ChannelRange) -> Channel:
    low, high, neutral = (round(value * 1000.0) for value in (found.low, found.high, found.neutral))
    return Channel(found.column, low, high, min(max(neutral, low), high))
