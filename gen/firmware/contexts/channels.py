"""What the templates are told of the channels: values that the board is told beside the PWM."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import TypedDict

from gen.lowering.effects.program import Channel


class ChannelContext(TypedDict):
    """A channel: its name in the C++ enumeration, and its range in thousandths."""

    id: str
    column: str
    low: int
    high: int
    neutral: int


def channel_names(channels: Sequence[Channel]) -> list[str]:
    """Each channel's name in the C++ enumeration; columns that differ in case or other signs alone are numbered."""
    names = ["AMBIENT"][: len(channels)]
    for number, channel in enumerate(channels[1:], start=1):
        name = re.sub(r"[^A-Z0-9]+", "_", channel.column.upper()).strip("_") or "COLUMN"
        names.append(f"{name}_{number}" if name in names else name)
    return names


def channel_contexts(channels: Sequence[Channel]) -> list[ChannelContext]:
    """The channels in their order; the first is the ambient."""
    return [
        {
            "id": name,
            "column": channel.column,
            "low": channel.low,
            "high": channel.high,
            "neutral": channel.neutral,
        }
        for name, channel in zip(channel_names(channels), channels, strict=True)
    ]
