"""Whether temperatures run away while everything that drives a model with effects is held.

A necessary condition that costs milliseconds, and so is asked of every file that is read: at each |PWM| held, a part's
heat must grow less with its own temperature than its cooling does, and what parts hand each other must come back
smaller. Switching, and parts of higher order than 1, are the business of :mod:`gen.lowering.effects.contraction`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from gen.model.dynamics import ThermalModel
from gen.model.effects.base import Applied
from gen.model.effects.channel_ranges import channel_ranges
from gen.model.effects.gains import Domain, PartGains, ZERO_K_degC, gains, in_loops, largest_loop, steady_loops

HOTTEST_K = 5000.0
"""Rise up to which curved effects are looked at: as much as a coefficient file may ask of any part."""


@dataclass(frozen=True)
class Runaway:
    """Effects with which temperatures grow without end.

    Parameters
    ----------
    applied
        The effect that adds most of it.
    message
        What grows, by how much, and what was expected.
    """

    applied: Applied
    message: str


def domain_of(model: ThermalModel, effects: Sequence[Applied], declared: Mapping[str, tuple[float, float]]) -> Domain:
    """Ranges of all that effects read: PWM as declared, every temperature above absolute zero.

    Parameters
    ----------
    model, effects
        The model and its effects.
    declared
        Ranges of channels that the coefficient file declares, by column.
    """
    ambient, *told = channel_ranges(model, effects, declared)
    rise = ZERO_K_degC - ambient.low, HOTTEST_K
    low, high = model.domain_pwm
    return Domain(
        rows=np.arange(low, high + 1).astype(np.float64),
        rise=dict.fromkeys(model.component_names, rise),
        ambient=(ambient.low, ambient.high),
        channels={channel.column: (channel.low, channel.high) for channel in told},
    )


def runaway(model: ThermalModel, effects: Sequence[Applied], domain: Domain) -> Runaway | None:
    """Find what runs away at some |PWM| held; None where nothing does, or an equation cannot be looked into.

    Parameters
    ----------
    model, effects
        The model, with what can be folded into it already there, and the other effects.
    domain
        Ranges of all that they read.
    """
    if not effects:
        return None
    try:
        parts = gains(model, effects, domain)
    except TypeError:  # no board computes it either, and lowering says so
        return None
    return runaway_of(parts, domain)


def runaway_of(parts: Sequence[PartGains], domain: Domain) -> Runaway | None:
    """Find what runs away at some |PWM| held, from the slopes of all parts."""
    return _by_itself(parts, domain) or _together(parts, domain)


def _by_itself(parts: Sequence[PartGains], domain: Domain) -> Runaway | None:
    for part in parts:
        grown = part.own[1] / part.rate
        at = int(np.argmax(grown))
        if grown[at] < 1.0:
            continue
        worst = max(part.shares, key=lambda share: float(share.own[1][at]))
        return Runaway(
            worst.applied,
            f'for each kelvin of its rise "{part.component.name}" is heated by {grown[at]:.3g} times as much as '
            f"carries it off, at PWM {domain.rows[at]:.0f}; expected less than 1",
        )
    return None


def _together(parts: Sequence[PartGains], domain: Domain) -> Runaway | None:
    loops = steady_loops(parts)
    found = [largest_loop(matrix) for matrix in loops]
    at = int(np.argmax(found))
    if found[at] < 1.0:
        return None
    looped = in_loops(loops[at]) * loops[at]
    names = [part.component.name for part in parts]
    i, j = divmod(int(np.argmax(looped)), len(names))
    worst = max(parts[i].shares, key=lambda share: _answer(share.others, share.apart, names[j], at))
    heated = [f'"{name}"' for name, row in zip(names, looped, strict=True) if row.any()]
    return Runaway(
        worst.applied,
        f"{' and '.join(heated)} heat each other: of each kelvin {found[at]:.3g} K come back, at PWM "
        f"{domain.rows[at]:.0f}; expected less than 1",
    )


def _answer(others: Mapping[str, np.ndarray], apart: Mapping[str, np.ndarray], name: str, at: int) -> float:
    return float(sum(of[name][at] for of in (others, apart) if name in of))
