"""The coefficient file with what was found."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from gen.coefficients import Coefficients, parse, with_network
from gen.coefficients.messages import building
from gen.coefficients.network import NetworkEntry
from gen.coefficients.network_curves import six_digits
from gen.errors import InputError
from gen.model.network_past import network_start_weights
from gen.refinement.gains import LEAST_GAIN, LEVEL
from gen.refinement.network.ambient import MovingAmbient
from gen.refinement.network.changing.writer import MARGIN, NetworkWriter
from gen.refinement.network.effects import NetworkEffect
from gen.refinement.network.effects.warm_inside import NAME as INITIAL_STATE
from gen.refinement.network.tracing.judged import p_better
from gen.refinement.network.tracing.trace import Traced
from gen.refinement.network.tracing.warm_start import WarmStart
from gen.refinement.verdict import NOTHING

NOT_ALONE = (
    "ambient: found, but the file follows a room that moves only once its numbers are fitted to it, and they are not "
    "written without what was found beside it"
)
HELD = (
    "{}: the file holds it to {:g} .. {:g}, where the runs had {:g} .. {:g}: with all of that, for as long as you "
    "like, no board could be built ({})"
)
ROUNDED = 1e-3
"""Of what a channel was within: what six digits may cut off."""
MARGINS = (MARGIN, 0.0, -0.1, -0.2, -0.3)
"""How far channels may be beyond what they were in the runs: less where no board could be built otherwise."""


@dataclass(frozen=True)
class Written:
    """A file.

    Attributes
    ----------
    text
        Its text.
    refitted
        Whether its numbers were fitted anew.
    refused
        Why it does not hold all that was found; empty if it does.
    """

    text: str
    refitted: bool = False
    refused: str = ""


def written(
    coefficients: Coefficients,
    raw: str,
    traced: Traced,
    kept: Sequence[NetworkEffect],
    room: MovingAmbient | None,
    start: WarmStart,
    *,
    accept_change: bool = False,
) -> Written:
    """Write what was found into a file.

    Numbers that were fitted beside an effect are right beside that effect only: without it the file stays as it is.

    Parameters
    ----------
    coefficients, raw
        The file, and its text.
    traced
        All that was found.
    kept
        Effects of it that are to be written.
    room
        That the measured ambient is to be read from now on, or None.
    start
        What hidden nodes start at from now on.
    accept_change
        Write the file's own numbers, fitted anew, although they leave more than noise.
    """
    network, channel = coefficients.document.network, None if room is None else room.channel
    assert network is not None
    document = coefficients.document
    ranges = traced.data.offered.ranges

    def begun(margin: float = MARGIN) -> NetworkWriter:
        made = NetworkWriter(network, document.input.full_scale, ranges, document.sample_time_s, margin)
        for name, factor in start.factors.items():
            made.start_factor(name, factor)
        return made

    # Some files follow a room that moves only with numbers that were fitted to it.
    alone = channel if room is None or room.as_it_is else None
    begins = [INITIAL_STATE if start.named else "starts"] if start.factors else []
    outside = [*begins, *([] if alone is None else ["ambient"])]
    unchanged = Written(raw, refused="" if alone == channel else NOT_ALONE)
    if outside:
        text = with_network(raw, begun().entry, f"refined: {', '.join(outside)}", alone)
        unchanged = replace(unchanged, text=text)
    sound = room is not None or accept_change or traced.null.floors <= NOTHING
    if not kept and (traced.added or not sound or not _file_is_worse(traced)):
        return unchanged
    named = [f"{effect.name} at {effect.component}" for effect in kept] + ([] if room is None else ["ambient"])
    said = ", ".join(named) or "no effect"
    fitted = traced.final.fitted
    refusals: list[InputError] = []
    for margin in MARGINS:
        writer = begun(margin)
        try:
            with building():
                fitted.shape.write(writer, fitted.vector, kept)
                text = with_network(raw, writer.entry, f"refined: {said}", channel)
            entry = _begun_anew(network, writer.entry, parse(text.encode()), start.factors)
            text = with_network(raw, entry, f"refined: {said}", channel)
            parse(text.encode())
        except InputError as error:
            refusals.append(error)
            if writer.entry.channels == network.channels:
                break  # no channel is read that could be held to less
            continue
        less = _held(network, writer.entry, ranges, refusals[0]) if refusals else []
        return Written(text, refitted=True, refused="; ".join(less))
    why = f"{said}: found, but a file with it is none that can be built ({refusals[0]})"
    return Written(unchanged.text, refused=why)


def _begun_anew(
    before: NetworkEntry, entry: NetworkEntry, made: Coefficients, factors: Mapping[str, float]
) -> NetworkEntry:
    """Let hidden nodes begin where the network, as it is now, lets expect them.

    Not those that began otherwise, or begin at factors that were found for what the file says.
    """
    assert made.model.network is not None
    shares = network_start_weights(made.model.network, *made.document.validity.pwm)
    if shares is None:
        return entry
    otherwise = {node.name for node in before.nodes if node.start_from is None or node.start_factor != 1.0} | {*factors}
    sensed = [node.name for node in made.model.network.sensed]
    likely = dict(zip((node.name for node in made.model.network.hidden), shares.tolist(), strict=True))
    nodes = []
    for node in entry.nodes:
        if node.name in likely and node.name not in otherwise:
            each = {name: six_digits(share) for name, share in zip(sensed, likely[node.name], strict=True)}
            nodes.append(node.model_copy(update={"start_from": each}))
        else:
            nodes.append(node)
    return entry.model_copy(update={"nodes": tuple(nodes)})


def _held(
    before: NetworkEntry, after: NetworkEntry, ranges: Mapping[str, tuple[float, float]], why: InputError
) -> list[str]:
    """Say which new channels a file reads in less than they were in the runs, and why it could not read all."""
    held = []
    for channel in after.channels[len(before.channels) :]:
        (low, high), (least, most) = channel.range, ranges.get(channel.column, channel.range)
        if max(low - least, most - high) > ROUNDED * (most - least):
            held.append(HELD.format(channel.column, low, high, least, most, why))
    return held


def offered_anew(traced: Traced, *, declared: bool) -> str:
    """Say what the file's own numbers, fitted anew, would bring where nothing was named and they are not written.

    Parameters
    ----------
    traced
        All that was found.
    declared
        Whether the file misses the runs by no more than it declares: then they need be no other motor's.

    Returns
    -------
    str
        A sentence; empty where they would bring nothing, or are written anyway.
    """
    if traced.null.floors <= NOTHING or not _file_is_worse(traced):
        return ""
    said = (
        "no effect explains the error, but the file's own numbers, fitted anew to the rest, predict what was left out "
        f"to {traced.null.score_K:.2g} K instead of {traced.file.score_K:.2g} K"
    )
    if declared:
        return f"{said}; --accept-change writes them"
    return (
        f"{said}: the motor is another than the one that was identified, or the file was wrong. They are not written "
        "without --accept-change: it would learn a fault, too"
    )


def _file_is_worse(traced: Traced) -> bool:
    """Whether the file as it is predicts the runs worse than what was fitted predicts what was left out of it."""
    by_chance = p_better(traced.data, traced.file, traced.null)
    return by_chance < LEVEL and traced.null.score_K < (1.0 - LEAST_GAIN) * traced.file.score_K
