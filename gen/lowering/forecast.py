"""How the board runs its own model ahead: limits in thousandths of a degree, times in samples."""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil, floor

from gen.coefficients import Coefficients
from gen.coefficients.forecast import limits_ahead
from gen.lowering.program import Program
from gen.lowering.samples import samples
from gen.model.network_parts import PWM

MOST_AHEAD = 2**32 - 1
"""Samples: a day at 0.25 s is 345 600."""
SMOOTHED = 16
"""Where a motor is held: readings beside the model are averaged over so many samples, a first-order lag."""
NOISE_MK = 500
"""Where a motor is held: so much of what a part is measured warmer than its model counts at the end of a run alone."""


@dataclass(frozen=True)
class WatchedLimit:
    """A temperature that a run ahead must not reach.

    Attributes
    ----------
    name
        The component, or the network's node.
    part
        A component's number; behind all of them, that of a network's state.
    limit_mC
        It is reached from here on, in thousandths of a degree Celsius: the limit, less what the board's words may lie
        below the exact solution, so that the board never says later than the exact solution does.
    source_degC
        The limit itself.
    """

    name: str
    part: int
    limit_mC: int
    source_degC: float


@dataclass(frozen=True)
class LoweredForecast:
    """How far the board looks ahead, and at what.

    Attributes
    ----------
    horizon
        In samples.
    steps
        Samples that a run goes ahead within one sample of the board.
    most_pwm
        The largest |PWM| that is tried.
    near
        A limit is near if it is reached within so many samples; None: the file does not say.
    limits
        At least one; the first of them that is reached is told.
    proven
        The limits allow for all that the board's words may be off the exact solution.
    pwm_channel
        Number of the channel in which a network reads the PWM with its sign; None of one that does not.
    holds
        A motor is held at the PWM that can be held: the search goes on from its last answer, and no answer is older
        than the horizon.
    """

    horizon: int
    steps: int
    most_pwm: int
    near: int | None
    limits: tuple[WatchedLimit, ...]
    proven: bool
    pwm_channel: int | None
    holds: bool


def lower_forecast(coefficients: Coefficients, program: Program) -> LoweredForecast | None:
    """Lower what a coefficient file says of running ahead; None where it says nothing.

    Parameters
    ----------
    coefficients
        A checked coefficient file.
    program
        What the board holds of its model.
    """
    document = coefficients.document
    asked = document.forecast
    if asked is None:
        return None
    sample_time = document.sample_time_s
    columns = [channel.column for channel in program.channels] if program.network is not None else []
    return LoweredForecast(
        horizon=samples(asked.horizon_s, sample_time, MOST_AHEAD),
        steps=asked.steps_per_sample,
        most_pwm=program.model.domain_pwm[1],
        near=None if asked.near_s is None else samples(asked.near_s, sample_time, MOST_AHEAD),
        limits=tuple(_watched(program, *limit) for limit in limits_ahead(asked, document.alarms).items()),
        proven=program.effects is None and not any(part.saturates for part in program.parts),
        pwm_channel=columns.index(PWM) if PWM in columns else None,
        holds=any(entry.holds for entry in document.protection),
    )


def _watched(program: Program, name: str, limit_degC: float) -> WatchedLimit:
    part, error_K = _component(program, name) if name in program.model.component_names else _node(program, name)
    # A thousandth for the rounding of what is read.
    return WatchedLimit(name, part, floor(limit_degC * 1000.0) - 1 - ceil(1000.0 * error_K), limit_degC)


def _component(program: Program, name: str) -> tuple[int, float]:
    """Its number, and what its word may lie off the exact solution, K; 0 where nothing is proven."""
    number = program.model.component_names.index(name)
    proof = program.parts[number].proof
    return number, float(proof.bound_K) if proof is not None and program.effects is None else 0.0


def _node(program: Program, name: str) -> tuple[int, float]:
    """The same of a node that nobody measures."""
    assert program.network is not None, "without a network every part is a component"
    state = [state.name for state in program.network.states].index(name)
    return len(program.parts) + state, float(program.network.proof.error[state])
