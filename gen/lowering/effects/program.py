"""Effects as the board holds them: the one description that the templates print and the reference executes.

All temperatures and rises are whole numbers of 2^-20 K in both arithmetics, all states are whole numbers, too, and the
equations between them are tapes (:mod:`gen.lowering.effects.tape`) in the model's arithmetic.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from gen.lowering.effects.contraction import Contraction
from gen.lowering.effects.tape import Tape
from gen.lowering.kinds import Arithmetic

#: Bits after the binary point of every temperature, in K.
KELVIN_BITS = 20
#: No temperature, rise or target leaves +/- this many kelvins.
KELVIN_LIMIT = 1000
#: Bits after the binary point of a weight and of an inner state without a unit.
WEIGHT_BITS = 30
#: Bits that a fixed-point chain has above those of the baseline's words.
GUARD_BITS = 8
#: Bits of a follower below the word that is read.
FOLLOWER_BITS = 32


@dataclass(frozen=True)
class Channel:
    """What the board is told beside the PWM; all numbers in thousandths of the unit.

    Attributes
    ----------
    column
        Name in run files; channel 0 is the ambient.
    low, high
        Values beyond them are held to them, and counted.
    neutral
        Before the first value.
    """

    column: str
    low: int
    high: int
    neutral: int


@dataclass(frozen=True)
class Chain:
    """A component's own poles once more, for all heat without a time constant of its own.

    Attributes
    ----------
    fraction_bits
        Of the drive's words and of what is read of the rise: 2^-fraction_bits K.
    limit
        Largest magnitude of the drive, in words: proven to keep every word within its bits.
    proven
        Whether it is; else words may be limited, too (and are counted).
    """

    fraction_bits: int
    limit: int
    proven: bool


@dataclass(frozen=True)
class Follower:
    """A first-order state y' = (target - y)/tau over a sample with a held target.

    Attributes
    ----------
    label
        What it is.
    tau_s
        Time constant, s.
    factor
        (1 - exp(-Ts/tau)) 2^32.
    """

    label: str
    tau_s: float
    factor: int


@dataclass(frozen=True)
class Inner:
    """An effect's inner state, whose target depends on |PWM| alone.

    Attributes
    ----------
    state
        The state.
    fraction_bits
        Of its word.
    targets
        By row of the domain.
    weight
        What counts of the distance at a sample's start, in its mean as heat: 2^-30.
    """

    state: Follower
    fraction_bits: int
    targets: tuple[int, ...]
    weight: int


@dataclass(frozen=True)
class Lag:
    """A sensor's lag, exact for a temperature that is straight between samples: factors of its ends, 2^-32."""

    lag_s: float
    old: int
    new: int


@dataclass(frozen=True)
class EffectComponent:
    """The effects of one component.

    Attributes
    ----------
    index, name
        Of the component.
    chain
        None without heat that passes the component's own poles.
    drives
        Outputs: the chain's drive (the steady rise that it would come to), then each follower's target.
    followers
        Effects with a time constant of their own.
    inners
        Inner states; operand ("inner", i) is the i-th.
    start
        Outputs: the baseline's start in mK, the chain's start, each follower's and each inner's.
    readings
        From the rise, or from the lag before, to the next lag; the last one gives the reading over the ambient.
    lags
        One fewer.
    sixth
        A component of order 1 that is fast and whose rise is in some drive: its rate times Ts/6 by row, 2^-30, for one
        more term of the rise's mean within a sample. Empty for all others.
    notes
        Title and equation of each effect, with its JSON path.
    """

    index: int
    name: str
    chain: Chain | None
    drives: Tape
    followers: tuple[Follower, ...]
    inners: tuple[Inner, ...]
    start: Tape
    readings: tuple[Tape, ...]
    lags: tuple[Lag, ...]
    sixth: tuple[int, ...]
    notes: tuple[str, ...]

    @property
    def heats(self) -> bool:
        """Whether it has a state that adds to the rise."""
        return self.chain is not None or bool(self.followers)


@dataclass(frozen=True)
class EffectsProgram:
    """All effects.

    Attributes
    ----------
    arithmetic
        The model's.
    components
        Those whose rise or reading an effect changes, in order.
    tracked
        Indices of components whose rise is kept: those, and the sources of coupling.
    felt
        Indices of components whose rise is in some drive: they are predicted first.
    rise_limits
        Where the rise of each tracked component may lie (else it is held there and counted), in 2^-20 K.
    channels
        The ambient first.
    elapsed_limit
        Samples since the start at which the clock stops (a drift), 0 without one.
    contraction
        What comes back of a kelvin by all loops at most, and of which components that is not proven.
    """

    arithmetic: Arithmetic
    components: tuple[EffectComponent, ...]
    tracked: tuple[int, ...]
    felt: tuple[int, ...]
    rise_limits: tuple[tuple[int, int], ...]
    channels: tuple[Channel, ...]
    elapsed_limit: int
    contraction: Contraction

    def describe(self) -> dict[str, Any]:
        """For the manifest."""
        return {
            "channels": [channel.column for channel in self.channels],
            "components": {component.name: list(component.notes) for component in self.components},
            "contraction": self.contraction.describe(),
        }

    def component(self, index: int) -> EffectComponent | None:
        """The effects of a component by its index."""
        return next((component for component in self.components if component.index == index), None)
