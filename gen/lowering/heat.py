"""Rules on missing heat as the board evaluates them.

With r = measured - model of a component, and 1/tau the slowest rate of its model at the present PWM, the heat that the
model lacks is r' + r / tau: an added heat q / C gives just that from its first moment on, when r itself is still zero.
Summed over time the noise of r does not grow, so that a rule keeps a cumulated sum (Page 1954; Basseville and
Nikiforov, "Detection of abrupt changes", 1993, chapter 2) of what goes beyond the *usual* heat, itself followed slowly:
constant errors of sensors and model are usual after a while. What was usual *before* is forgotten slowly, so that heat
which comes back, as when a draught has ended, is no change. What a change of PWM or a start makes uncertain is a
further slack, which fades.

The board takes means over blocks of :data:`BLOCK_S`, so that a converter's steps are no heat. Units: temperatures
1/:data:`PER_mK` of a thousandth of a kelvin; heats the same for each block.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gen.arrays import FloatArray, IntArray
from gen.coefficients.alarms import MissingHeat, window_counts
from gen.coefficients.document import Document
from gen.model import ThermalModel

BLOCK_S = 20.0
"""Samples are taken together for so long."""
MOST_BLOCK = 1024
"""Samples in a block: their sum fits 32 bits (2^10 times :data:`MOST_DEVIATION_mK`)."""
PER_mK = 16
MOST_DEVIATION_mK = 2**19
"""Measured minus model is held to so much to either side."""
BINS = 32
"""Values over |PWM|, each for :data:`BIN_COUNTS` counts."""
BIN_COUNTS = 8
RATE_BITS = 16
"""Fractions that are lost in a block, below one."""
WEIGHT_BITS = 8
FINE_BITS = 8
"""Usual heat and unsettled slack have so many bits more."""
PRIOR_BLOCKS = 4
"""At a start the usual heat is taken for zero with the weight of so many blocks."""
MOST_UNSETTLED = 2**29
MOST_CHANGE = 2**19
"""Unsettled slack for each count of a change: 510 times it is below :data:`MOST_UNSETTLED`."""
MOST_PENDING = 2**24
MOST_RATE = 2**20
"""A block's heat: 65 K."""
MOST_WAITED = 254
MOST_LIMIT = 2**26


@dataclass(frozen=True)
class HeatTerm:
    """One component's part in a rule.

    Attributes
    ----------
    component
        Its index.
    weight
        Times 2^:data:`WEIGHT_BITS`.
    forgetting
        By bins of |PWM|: what a deviation loses in a block by the model's slowest pole, times 2^:data:`RATE_BITS`.
    """

    component: int
    weight: int
    forgetting: tuple[int, ...]


@dataclass(frozen=True)
class LoweredHeat:
    """A rule on missing heat.

    Attributes
    ----------
    block
        Samples in a block.
    low, high
        |PWM| at which the rule counts, both included.
    terms
        The components.
    slack
        Heat of a block that is not counted.
    unknown
        Further slack while nothing is known of the usual heat; it falls with the blocks that have been learnt.
    change, start
        Unsettled slack after a change of PWM by one count, and after a start, times 2^:data:`FINE_BITS`.
    fading
        By bins of |PWM|: what the unsettled slack loses in a block, times 2^:data:`RATE_BITS`.
    memory
        Blocks after which missing heat has become usual.
    forgetting
        What a block takes of the difference between what was usual before and what is, times 2^:data:`RATE_BITS`; the
        whole of it where nothing is remembered.
    limit
        The sum at which the alarm is raised; the sum is held to twice that.
    """

    block: int
    low: int
    high: int
    terms: tuple[HeatTerm, ...]
    slack: int
    unknown: int
    change: int
    start: int
    fading: tuple[int, ...]
    memory: int
    forgetting: int
    limit: int

    @property
    def told(self) -> int:
        """Blocks after which what has been learnt is sure enough to be remembered: noise would be, too."""
        return (PRIOR_BLOCKS + self.memory) // 2


def block_samples(sample_time: float) -> int:
    """Samples in a block."""
    return max(1, min(MOST_BLOCK, round(BLOCK_S / sample_time)))


def lower_heat(document: Document, model: ThermalModel, rule: MissingHeat) -> LoweredHeat:
    """Lower a rule on missing heat."""
    block = block_samples(model.sample_time)
    seconds = block * model.sample_time
    in_block = 1000.0 * PER_mK * seconds / 3600.0
    counts = window_counts(rule, document.input.full_scale)
    rest, full = rule.unsettled.decay_s
    share = _levels(model) / model.full_scale
    fine = 1 << FINE_BITS
    return LoweredHeat(
        block=block,
        low=counts[0],
        high=counts[-1],
        terms=tuple(
            HeatTerm(
                model.component_names.index(name),
                round(weight * (1 << WEIGHT_BITS)),
                _lost(slowest_rates(model, name, _levels(model)), seconds),
            )
            for name, weight in rule.weight_of.items()
        ),
        slack=max(1, min(MOST_RATE, round(rule.slack_K_per_h * in_block))),
        unknown=min(MOST_RATE, round(rule.unknown_K_per_h * in_block)),
        change=min(MOST_CHANGE, round(rule.unsettled.per_change_K_per_h * in_block * fine / model.full_scale)),
        start=min(MOST_UNSETTLED, round(rule.unsettled.at_start_K_per_h * in_block * fine)),
        fading=_lost(1.0 / rest + (1.0 / full - 1.0 / rest) * share, seconds),
        memory=max(PRIOR_BLOCKS, min(2**16 - 1, round(rule.usual_s / seconds))),
        forgetting=_forgetting(rule.remembered_s, seconds),
        limit=max(1, min(MOST_LIMIT, round(rule.threshold_K * 1000.0 * PER_mK))),
    )


def slowest_rates(model: ThermalModel, name: str, levels: IntArray) -> FloatArray:
    """Slowest rate of a component's model at each |PWM|, 1/s: of a network's, the network's.

    Parameters
    ----------
    model, name
        The component.
    levels
        PWM in counts, shape (n,).
    """
    matrices = (
        model.network.matrices(levels)[0]
        if model.network is not None
        else model.component(name).state_matrices(levels)[0]
    )
    return np.array([np.abs(np.linalg.eigvals(matrix).real).min() for matrix in matrices])


def _levels(model: ThermalModel) -> IntArray:
    """|PWM| in the middle of each bin, within the model's domain."""
    middle = np.arange(BINS) * BIN_COUNTS + BIN_COUNTS // 2
    return np.minimum(middle, model.domain_pwm[1])


def _forgetting(remembered_s: float | None, seconds: float) -> int:
    return 1 << RATE_BITS if remembered_s is None else _lost(np.array([1.0 / remembered_s]), seconds)[0]


def _lost(rates: FloatArray, seconds: float) -> tuple[int, ...]:
    whole = 1 << RATE_BITS
    lost = np.rint(whole * -np.expm1(-rates * seconds)).astype(np.int64)
    return tuple(int(value) for value in np.clip(lost, 1, whole - 1))
