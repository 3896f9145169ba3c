"""What the templates are told of the channels: values that the board is told beside the PWM."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import TypedDict

from gen.lowering.effects.program import Channel
from gen.lowering.fixed.component import FixedComponent
from gen.lowering.fixed.start import start_scale
from gen.lowering.float32.start import start_factor
from gen.lowering.program import AnyComponent, Program


class ChannelContext(TypedDict):
    """A channel: its name in the C++ enumeration, and its range in thousandths."""

    id: str
    column: str
    low: int
    high: int
    neutral: int


class AmbientContext(TypedDict):
    """The ambient whose changes pass the parts' own dynamics, in thousandths of a degree Celsius.

    `reference` is what rises of the state count from, and `factors` what turns thousandths into words, by shape.
    """

    reference: int
    low: int
    high: int
    factors: dict[str, str]


def ambient_context(program: Program) -> AmbientContext | None:
    """The ambient of a program; None where its changes act at once, or through a network's paths."""
    ambient = program.ambient
    if ambient is None:
        return None
    factors = {shape.identifier: word_factors(program.components[shape.members[0]]) for shape in program.shapes}
    return {"reference": ambient.neutral, "low": ambient.low, "high": ambient.high, "factors": factors}


def word_factors(component: AnyComponent) -> str:
    """Literals that turn thousandths of a kelvin into words of a component's rise."""
    if isinstance(component, FixedComponent):
        scale = start_scale(component.layout.output_bits)
        return f"{scale.whole}L, {scale.upper}u, {scale.lower}u"
    return component.literal(float(start_factor(component.fraction_bits[0])))


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


def told_channels(program: Program) -> dict[str, str]:
    """Names in the C++ of the columns that the model is told."""
    columns = [channel.column for channel in program.channels]
    return dict(zip(columns, channel_names(program.channels), strict=True))
