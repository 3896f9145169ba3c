"""Effects of a whole fleet: the same one is put on each motor's own network, by what it is called and where it acts."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from gen.arrays import FloatArray
from gen.coefficients import Coefficients, parse, with_network
from gen.coefficients.messages import building
from gen.errors import CheckFailed
from gen.model.network import Network
from gen.refinement.network.changing import excess
from gen.refinement.network.changing.columns import Columns
from gen.refinement.network.changing.writer import NetworkWriter
from gen.refinement.network.effects import NetworkEffect, Offered, candidates
from gen.refinement.network.fitting.anchored import Anchored

Key = dict[str, Any]
"""An effect: `what` it is, `where`, and what it `acts_by`."""


def key_of(effect: NetworkEffect) -> Key:
    """Say which effect it is, whatever the motor."""
    return {
        "what": effect.name,
        "where": effect.component,
        "acts_by": dict(sorted(effect.acts_by.items())),
    }


def said(key: Key) -> str:
    """Name an effect."""
    by = ", ".join(f"{name} {value}" for name, value in key["acts_by"].items())
    return f"{key['what']} at {key['where']}" + (f" ({by})" if by else "")


def network_of(coefficients: Coefficients) -> Network:
    """Give a file's network.

    Raises
    ------
    CheckFailed
        Where it holds transfer functions.
    """
    network = coefficients.model.network
    if network is None:
        raise CheckFailed("the model is no network")
    return network


def bare(coefficients: Coefficients, columns: Columns) -> Anchored:
    """Give a file without any effect."""
    return Anchored.of(network_of(coefficients), coefficients.document.input.full_scale, columns)


def variants(every: Sequence[NetworkEffect], key: Key) -> list[NetworkEffect]:
    """Give the candidates that are one effect: they differ in where their search begins, or in how finely they bend.

    The first one is what is written for the whole fleet.

    Raises
    ------
    CheckFailed
        Where none of them is.
    """
    found = [effect for effect in every if key_of(effect) == key]
    if not found:
        raise CheckFailed(f"{said(key)} cannot act on this motor, or its runs do not show it")
    return found


def with_means(text: str, found: Sequence[Key], mean: FloatArray, offered: Offered) -> str:
    """Give the text of a file with effects, their numbers the fleet's.

    Parameters
    ----------
    text
        The coefficient file.
    found
        The effects; those that no file can hold are passed over.
    mean
        Their numbers, in standard deviations from their priors' means.
    offered
        What the fleet's runs have.

    Raises
    ------
    CheckFailed
        Where one of them cannot act on this network.
    InputError
        When the file with them is none that can be built.
    """
    coefficients = parse(text.encode())
    shape = bare(coefficients, Columns(tuple(offered.ranges), excess.count(network_of(coefficients))))
    every = candidates(shape.motor(), offered)
    effects = [variants(every, key)[0] for key in found]
    document, first = coefficients.document, 0
    assert document.network is not None
    writer = NetworkWriter(document.network, document.input.full_scale, offered.ranges, document.sample_time_s)
    with building():
        for effect in effects:
            own = mean[first : first + len(effect.numbers)]
            first += len(effect.numbers)
            numbers = zip(effect.numbers, own.tolist(), strict=True)
            effect.write(writer, [number.value(number.mean + number.deviation * z) for number, z in numbers])
        named = ", ".join(said(key) for key in found)
        made = with_network(text, writer.entry, f"refined with its fleet: {named}")
    parse(made.encode())
    return made


def together(each: Sequence[Offered]) -> Offered:
    """Give what several motors' runs have: channels that all of them have, in the widest range."""
    names = [name for name in each[0].ranges if all(name in one.ranges for one in each)]
    return Offered(
        ranges={n: (min(o.ranges[n][0] for o in each), max(o.ranges[n][1] for o in each)) for n in names},
        typical={name: float(np.median([one.typical[name] for one in each])) for name in names},
        backwards=any(one.backwards for one in each),
        rests=any(one.rests for one in each),
        room_measured=all(one.room_measured for one in each),
        room_moves=all(one.room_moves for one in each),
        turned_s=tuple(map(sum, zip(*(one.turned_s for one in each), strict=True))),
        hottest_degC={
            name: max(one.hottest_degC[name] for one in each if name in one.hottest_degC)
            for name in dict.fromkeys(name for one in each for name in one.hottest_degC)
        },
    )
