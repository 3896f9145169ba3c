"""What the board is wired to: anything that takes PWM and gives sensor words and encoder pulses."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Protocol

from gen.rig import SensorFault

STEP_S = 0.25
"""Time between two steps of the plant, s."""

AMBIENT = "ambient"

FULL_PWM = 255
"""The count at which a pin is high all the time."""


@dataclass(frozen=True)
class Ran:
    """What a motor has run before it is looked at: a PWM, -255..255, for a time in s, from ambient on."""

    pwm: int
    seconds: float


@dataclass(frozen=True)
class Reading:
    """What the sensors tell after a step.

    Parameters
    ----------
    words
        By channel, a component's name or ``ambient``: the 16 bits that its MAX6675 gives from now on.
    pulses
        Rising edges of the encoder during the step.
    channels
        What else can be measured, by column and in its unit.
    """

    words: Mapping[str, int]
    pulses: int = 0
    channels: Mapping[str, float] = field(default_factory=dict)


class Plant(Protocol):
    """A motor with its sensors."""

    def step(self, pwm: int, dt_s: float) -> Reading:
        """Run for a while.

        Parameters
        ----------
        pwm
            Signed PWM, -255..255, that acts all the time.
        dt_s
            How long, s.
        """
        ...


class Motor(Plant, Protocol):
    """A motor whose truth can be told."""

    @property
    def temperatures(self) -> Mapping[str, float]:
        """True temperatures now, degC, by part, and ``ambient``."""
        ...


class Changeable(Motor, Protocol):
    """A motor that somebody changes while it runs; what is set holds from the next step on."""

    @property
    def typical_faults(self) -> tuple[str, ...]:
        """Faults to try, as :meth:`set_faults` takes them, each of a size that a board should see."""
        ...

    @property
    def largest_load_Nm(self) -> float:
        """The largest torque at its shaft that is worth a try, Nm; 0 of a motor that knows no torque."""
        ...

    def set_load(self, Nm: float) -> None:
        """Let the shaft drive this torque, Nm, not below 0, whichever way it turns.

        Raises
        ------
        InputError
            Of a motor that knows no torque.
        """
        ...

    def set_ambient(self, degC: float) -> None:
        """Let the room have this temperature, degC."""
        ...

    def set_faults(self, text: str) -> None:
        """Give the motor these faults, as the option ``--fault`` has them, and no others; an empty text heals it.

        Raises
        ------
        InputError
            For a fault that this motor cannot have.
        """
        ...

    def set_sensor_faults(self, channel: str, faults: tuple[SensorFault, ...]) -> None:
        """Give a thermocouple these faults and no others; their times are the plant's, which begins at 0 s.

        Raises
        ------
        KeyError
            When it has no such thermocouple.
        """
        ...


def word_of(temperature_degC: float) -> int:
    """Give the word of a MAX6675 at a temperature, degC: counts of 0.25 K in bits 14..3."""
    counts = min(max(round(temperature_degC * 4.0), 0), 4095)
    return counts << 3


@dataclass
class BenchPlant:
    """A plant without physics for trying boards: fixed temperatures, and a speed that follows PWM at once.

    Attributes
    ----------
    temperatures
        By channel, degC; change them at will.
    pulses_per_s
        At PWM 255.
    words
        By channel: a word that is given instead of the temperature's.
    pwm_seen
        The PWM of every step so far.
    """

    temperatures: dict[str, float]
    pulses_per_s: float = 0.0
    words: dict[str, int] = field(default_factory=dict)
    pwm_seen: list[int] = field(default_factory=list)
    _turned: float = 0.0

    def step(self, pwm: int, dt_s: float) -> Reading:
        """See `Plant.step`."""
        self.pwm_seen.append(pwm)
        before = int(self._turned)
        self._turned += abs(pwm) / FULL_PWM * self.pulses_per_s * dt_s
        words = {name: word_of(value) for name, value in self.temperatures.items()} | self.words
        return Reading(words, int(self._turned) - before)
