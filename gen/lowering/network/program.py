"""What the board holds of a network: the one description that the templates print and the reference executes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from gen.arrays import FloatArray, IntArray, SingleArray
from gen.lowering.effects.program import Channel
from gen.lowering.kinds import Arithmetic
from gen.lowering.network.factors import FactorProgram
from gen.lowering.network.gains import Gain, GainFormat
from gen.lowering.network.laws import LawProgram
from gen.lowering.network.series import Product
from gen.lowering.network.terms import Term, Warmth, identifier
from gen.lowering.recursion.guarantee import rounded_up

Words = IntArray | SingleArray


@dataclass(frozen=True, eq=False)
class TermProgram:
    """A term with its rate as the board holds it.

    Attributes
    ----------
    term
        What it stands for.
    words
        Rate by row of the domain: whole numbers of 2^-(32 + row's shift), raised by 30 - bits for each factor, or
        float32.
    reference
        A fixed source's temperature in words of a state.
    """

    term: Term
    words: Words
    reference: int

    @property
    def constant(self) -> bool:
        """Whether |PWM| has no part in it."""
        return bool((self.words == self.words[0]).all())


@dataclass(frozen=True, eq=False)
class HeatProgram:
    """A heat as the board holds it.

    Attributes
    ----------
    heat
        What it stands for.
    words
        By row of the domain. In fixed point, shifted up by `left` or times the first factor's word, it counts in units
        of the row's sum; in float32 in words of a state per sample.
    left
        Bits; 0 with a factor or in float32.
    """

    heat: Warmth
    words: Words
    left: int

    @property
    def constant(self) -> bool:
        """Whether |PWM| has no part in it."""
        return bool((self.words == self.words[0]).all())


@dataclass(frozen=True, eq=False)
class StateProgram:
    """A state and how it advances.

    Attributes
    ----------
    name
        A node's, or that of a reading that lags, or of a drift.
    terms, heats
        What its sum is made of, in order.
    shift
        Its rates count in 2^-(32 + shift); 0 in float32.
    orders
        Terms of the exponential's series that it takes part in, at least 1.
    """

    name: str
    terms: tuple[TermProgram, ...]
    heats: tuple[HeatProgram, ...]
    shift: int
    orders: int

    @property
    def identifier(self) -> str:
        """Its name in the C++, behind the model's."""
        return identifier(self.name)


@dataclass(frozen=True)
class Reading:
    """What a sensor shows.

    Attributes
    ----------
    name
        The component.
    node, state
        The node that is measured, and the state that is read: another one where the sensor lags.
    offset
        Added to what is read, in words of a state.
    gain
        None for a sensor without an error of its gain.
    drift
        The state that is added; None for a sensor that does not drift.
    """

    name: str
    node: int
    state: int
    offset: int
    gain: Gain | None = None
    drift: int | None = None


@dataclass(frozen=True, eq=False)
class NetworkProof:
    """What is guaranteed for every sequence of PWM, ambient and channels in the domain, of any length.

    Attributes
    ----------
    low, high
        Ends of what each state can reach, degC, shape (n,).
    error
        Largest difference between each state and the exact solution, K, shape (n,); no longer than any sample makes it:
        -h M error >= defect for every |PWM| and all that channels may say.
    defect
        Largest of what one sample adds to the error, by state, K, shape (n,).
    margin
        By which the ends are more than the exact temperatures reach, K.
    """

    low: FloatArray
    high: FloatArray
    error: FloatArray
    defect: FloatArray
    margin: float


@dataclass(frozen=True)
class NodeProof:
    """The guarantee of one component.

    Attributes
    ----------
    bound_K
        Largest difference between its reading, as a word, and the exact solution's.
    range_degC
        What its reading can reach.
    """

    bound_K: float
    range_degC: tuple[float, float]

    def describe(self) -> dict[str, Any]:
        """The proof for the manifest, rounded outwards."""
        low, high = self.range_degC
        return {
            "temperature_range_degC": [float(np.floor(low)), float(np.ceil(high))],
            "bound_K": rounded_up(self.bound_K),
        }


@dataclass(frozen=True)
class NodeComponent:
    """A sensed node, as the rest of the project knows components.

    Attributes
    ----------
    name
        The node's.
    proof
        Its guarantee; a network is built with one or not at all.
    fraction_bits
        Of its word.
    start_range_mK
        Ends of its rise at the start over the ambient that holds until one is told, in thousandths of a kelvin.
    """

    name: str
    proof: NodeProof
    fraction_bits: int
    start_range_mK: tuple[int, int]
    saturates: bool = False
    unproven: str | None = None

    def describe(self) -> dict[str, Any]:
        """The component for the manifest."""
        return {"name": self.name, "fraction_bits": self.fraction_bits, "proof": self.proof.describe()}


@dataclass(frozen=True, eq=False)
class NetworkProgram:
    """A network as the board computes it.

    Attributes
    ----------
    arithmetic
        Of its sums; states are whole numbers in both.
    fraction_bits
        Of a state's upper word: 2^-bits degC.
    products
        What the series' terms are made of, by order (fixed point).
    series_bits
        Fraction bits of y1, y2, .. as the next product takes them (fixed point).
    states
        Nodes, then readings that lag, then drifts.
    readings
        By component.
    gains
        Of the gains' words; None where no sensor has an error of its gain.
    rest
        Weights of the sensed nodes' rises in each hidden node's rise at the start, shape (hidden, sensed).
    rest_bits
        Their fraction bits.
    hidden
        Those nodes' states.
    factors, laws, channels
        What is told; channel 0 is the ambient.
    start_mC
        Ends of a temperature at the start, in thousandths.
    proof
        Of all states.
    """

    arithmetic: Arithmetic
    fraction_bits: int
    products: tuple[Product, ...]
    series_bits: tuple[int, ...]
    states: tuple[StateProgram, ...]
    readings: tuple[Reading, ...]
    gains: GainFormat | None
    rest: IntArray
    rest_bits: int
    hidden: tuple[int, ...]
    factors: tuple[FactorProgram, ...]
    laws: tuple[LawProgram, ...]
    channels: tuple[Channel, ...]
    start_mC: tuple[int, int]
    proof: NetworkProof

    @property
    def drifts(self) -> tuple[int, ...]:
        """States that say how far sensors have drifted: the last ones."""
        return tuple(reading.drift for reading in self.readings if reading.drift is not None)

    @property
    def orders(self) -> int:
        """Terms of the series."""
        return max(state.orders for state in self.states)

    def components(self) -> tuple[NodeComponent, ...]:
        """The sensed nodes."""
        lsb = 2.0**-self.fraction_bits
        made = []
        for reading in self.readings:
            offset = reading.offset * lsb
            low, high = (shown + offset for shown in self._shown(reading))
            bound = (
                float(self.proof.error[reading.state]) + 1.5 * lsb
            )  # the upper word alone, and the offset's rounding
            if reading.gain is not None and self.gains is not None:
                bound += reading.gain.error * float(self.proof.error[reading.state])
                bound += reading.gain.reading_error(self.gains.shown) * lsb
            if reading.drift is not None:
                low, high = low + float(self.proof.low[reading.drift]), high + float(self.proof.high[reading.drift])
                bound += float(self.proof.error[reading.drift]) + lsb
            room = self.channels[0].neutral
            start = (self.start_mC[0] - room, self.start_mC[1] - room)
            made.append(NodeComponent(reading.name, NodeProof(bound, (low, high)), self.fraction_bits, start))
        return tuple(made)

    def _shown(self, reading: Reading) -> tuple[float, float]:
        """Least and largest of what a sensor shows without its offset, degC."""
        low, high = (float(ends[reading.state]) for ends in (self.proof.low, self.proof.high))
        if reading.gain is None:
            return low, high
        told = self.channels[0]
        bases = (told.low / 1000.0, told.high / 1000.0) if reading.gain.about_ambient else (0.0,)
        shown = [at + reading.gain.error * (at - base) for at in (low, high) for base in bases]
        return min(shown), max(shown)

    def describe(self) -> dict[str, Any]:
        """For the manifest."""
        return {
            "states": [
                {
                    "name": state.name,
                    "range_degC": [float(np.floor(self.proof.low[i])), float(np.ceil(self.proof.high[i]))],
                    "bound_K": rounded_up(float(self.proof.error[i])),
                    "orders": state.orders,
                }
                for i, state in enumerate(self.states)
            ],
            "fraction_bits": self.fraction_bits,
            "channels": [channel.column for channel in self.channels],
        }
