"""A motor whose truth is known: parts of first order that warm while current flows, a rotor, an encoder, a relay."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Literal

from gen.emulate.plants.plant import AMBIENT, FULL_PWM, Reading, word_of

FREE_RPM, SPIN_S = 2650.0, 0.2
"""Speed at PWM 255, the rotor's time constant in s."""
COOLING_S = 3000.0
OFF_K = 5.0
"""A thermocouple that is farther from its part than this tells nothing of it."""

Lie = Callable[[float, float], int]
"""The word that a faulty thermocouple gives, from the part's true temperature in degC and the time in s."""


@dataclass(frozen=True)
class Moment:
    """What was true over one step: a time in s, whether current flowed, K over the limits, whether it was blind."""

    time_s: float
    driven: bool
    beyond_K: float
    blind: bool


@dataclass
class HazardPlant:
    """The motor.

    Attributes
    ----------
    temperatures, heating, limits
        By part: true degC, K/s at full current, degC; parts without a limit have none.
    pulses
        Of the encoder, in a revolution.
    locked_heating
        The same as `heating` for a rotor that does not turn.
    lies
        By channel: a thermocouple that does not tell the truth.
    locked, shorted, encoder
        The rotor stands; the driver conducts whatever the pins say; what the encoder gives.
    relay_closed
        Whether the driver has its supply.
    moments
        What happened, a step each.
    """

    temperatures: dict[str, float]
    limits: Mapping[str, float]
    heating: dict[str, float]
    pulses: int
    locked_heating: float = 8.0
    room_degC: float = 25.0
    lies: dict[str, Lie] = field(default_factory=dict)
    locked: bool = False
    shorted: bool = False
    encoder: Literal["good", "broken", "noisy"] = "good"
    relay_closed: Callable[[], bool] = lambda: False
    moments: list[Moment] = field(default_factory=list)
    time_s: float = 0.0
    speed_rpm: float = 0.0
    _turned: float = 0.0
    _words: dict[str, int] = field(default_factory=dict)

    def step(self, pwm: int, dt_s: float) -> Reading:
        """See `gen.emulate.plants.plant.Plant.step`."""
        share = 1.0 if self.shorted else pwm / FULL_PWM
        share = share if self.relay_closed() else 0.0
        self.time_s += dt_s
        for part, degC in self.temperatures.items():
            rate = self.locked_heating if self.locked and part == "brush" else self.heating[part]
            self.temperatures[part] = degC + dt_s * (rate * share**2 - (degC - self.room_degC) / COOLING_S)
        wanted = 0.0 if self.locked else share * FREE_RPM
        self.speed_rpm += (wanted - self.speed_rpm) * min(dt_s / SPIN_S, 1.0)
        self.moments.append(Moment(self.time_s, share != 0.0, self.beyond_K, self.blind))
        self._words = {name: self._word(name, degC) for name, degC in self._truth().items()}
        return Reading(self._words, self._pulses(dt_s))

    @property
    def beyond_K(self) -> float:
        """How far the hottest part is over its limit, K; negative below all of them."""
        return max(self.temperatures[part] - limit for part, limit in self.limits.items())

    @property
    def blind(self) -> bool:
        """Whether a thermocouple that a limit watches tells nothing of its part: by the words that it gave last."""
        return any(
            tells_nothing(word, self.temperatures[part]) for part, word in self._words.items() if part in self.limits
        )

    def _truth(self) -> dict[str, float]:
        return self.temperatures | {AMBIENT: self.room_degC}

    def _word(self, channel: str, degC: float) -> int:
        lie = self.lies.get(channel)
        return word_of(degC) if lie is None else lie(degC, self.time_s)

    def _pulses(self, dt_s: float) -> int:
        if self.encoder != "good":
            return 0 if self.encoder == "broken" else round(30_000 * dt_s)
        before = int(self._turned)
        self._turned += abs(self.speed_rpm) / 60.0 * self.pulses * dt_s
        return int(self._turned) - before


def tells_nothing(word: int, degC: float) -> bool:
    """Whether a MAX6675's word is none, or is not about a part at this temperature; of 32 bits it is the first half."""
    own = word >> 16 if word > 0xFFFF else word
    return own & 0x8006 != 0 or own & 0xFFFE == 0 or abs((own >> 3) / 4.0 - degC) > OFF_K
