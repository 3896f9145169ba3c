"""How the board runs its own model ahead: limits in thousandths of a degree, times in samples."""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil, floor

from gen.coefficients import Coefficients
from gen.coefficients.forecast import limits_ahead
from gen.lowering.program import Program
from gen.lowering.samples import samples


@dataclass(frozen=True)
class WatchedLimit:
    """A temperature that a run ahead must not reach.

    Attributes
    ----------
    name
        The component, or the network's node.
    component, state
        Its index among the components; or, of a node that nobody measures, among the network's states. One is None.
    limit_mC
        It is reached from here on, in thousandths of a degree Celsius: the limit, less what the board's words may lie
        below the exact solution, so that a limit is never reached later than the exact solution says.
    source_degC
        The limit itself.
    """

    name: str
    component: int | None
    state: int | None
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
    """

    horizon: int
    steps: int
    most_pwm: int
    near: int | None
    limits: tuple[WatchedLimit, ...]
    proven: bool


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
    names = program.model.component_names
    found = []
    for name, limit in limits_ahead(asked, document.alarms).items():
        component = names.index(name) if name in names else None
        state = _state(program, name) if component is None else None
        # A thousandth for the rounding of what is read.
        below_mK = 1 + ceil(1000.0 * _error_K(program, component, state))
        found.append(WatchedLimit(name, component, state, floor(limit * 1000.0) - below_mK, limit))
    return LoweredForecast(
        horizon=ceil(asked.horizon_s / sample_time - 1e-9),
        steps=asked.steps_per_sample,
        most_pwm=program.model.domain_pwm[1],
        near=None if asked.near_s is None else samples(asked.near_s, sample_time),
        limits=tuple(found),
        proven=program.effects is None and not any(part.saturates for part in program.parts),
    )


def _state(program: Program, name: str) -> int:
    assert program.network is not None, "without a network every part is a component"
    return [state.name for state in program.network.states].index(name)


def _error_K(program: Program, component: int | None, state: int | None) -> float:
    """What the board's word may lie off the exact solution; 0 where nothing is proven (the thousandth is apart)."""
    if component is None:
        assert program.network is not None
        assert state is not None
        return float(program.network.proof.error[state])
    proof = program.parts[component].proof
    return float(proof.bound_K) if proof is not None and program.effects is None else 0.0
