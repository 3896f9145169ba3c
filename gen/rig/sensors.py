"""Type K thermocouples through MAX6675 converters, or others, as the board reads them; errors and faults."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Literal, get_args

import numpy as np

from gen.rig.chips import OPEN_BIT, Converter

COUNT_DEGC = 0.25  #: Degrees of one count.
MAX_COUNTS = 4095  #: 12 bits: 1023.75 degC.

SensorFaultKind = Literal["open", "all_0", "all_1", "stuck", "spike", "jump", "noise"]
SENSOR_FAULTS: tuple[SensorFaultKind, ...] = get_args(SensorFaultKind)

_BLOCK = 1024


@dataclass(frozen=True)
class SensorFault:
    """Something wrong with one sensor for a while.

    Attributes
    ----------
    kind
        ``open``: the thermocouple's wire is broken; ``all_0``, ``all_1``: the data line is shorted or the converter
        has no supply; ``stuck``: the word stays as it was; ``spike``: one conversion every `every_s` is off by
        `size_K`; ``jump``: off by `size_K` all the time; ``noise``: Gaussian noise of `size_K` on top.
    start_s, end_s
        When it begins and when it is over.
    size_K, every_s
        See `kind`.
    """

    kind: SensorFaultKind
    start_s: float
    end_s: float = math.inf
    size_K: float = 20.0
    every_s: float = 30.0

    def __post_init__(self) -> None:
        if self.kind not in SENSOR_FAULTS:
            raise ValueError(f"unknown sensor fault {self.kind!r}; expected one of {', '.join(SENSOR_FAULTS)}")
        if not self.end_s > self.start_s or not self.every_s > 0.0:
            raise ValueError("a sensor fault ends after it begins, and spikes come at intervals above 0 s")


@dataclass(frozen=True)
class SensorConfig:
    """One thermocouple with its converter.

    Attributes
    ----------
    offset_K
        Constant error; the study's sensors are good to 1.1 K either way.
    gain
        Slope around the cold junction's temperature; 1 is right.
    noise_K
        Standard deviation of Gaussian noise on each conversion.
    lag_s
        Time constant of the thermocouple on its part.
    drift_K_per_h
        Growth of the offset.
    cold_junction_degC
        Temperature of the converter.
    conversion_s
        A read sooner than this after the last breaks the running conversion off and gives the old word again.
    faults
        What goes wrong, and when.
    converter
        The chip.
    """

    offset_K: float = 0.0
    gain: float = 1.0
    noise_K: float = 0.1
    lag_s: float = 2.0
    drift_K_per_h: float = 0.0
    cold_junction_degC: float = 25.0
    conversion_s: float = 0.22
    faults: tuple[SensorFault, ...] = ()
    converter: Converter = field(default_factory=Converter)

    def __post_init__(self) -> None:
        if not self.lag_s >= 0.0 or not self.noise_K >= 0.0 or not self.gain > 0.0:
            raise ValueError("expected lag and noise of at least 0 and a gain above 0")


class Thermocouple:
    """A thermocouple and its converter in time.

    Parameters
    ----------
    config
        The sensor.
    seed
        Of its noise; the same seed and the same reads give the same words.
    """

    def __init__(self, config: SensorConfig | None = None, seed: int | np.random.SeedSequence = 0) -> None:
        self.config = config or SensorConfig()
        self._random = np.random.default_rng(seed)
        self._noise: list[float] = []
        self._time = -math.inf
        self._true = math.nan
        self._tip = math.nan
        self._word = 0
        self._spikes: dict[int, int] = {}

    def read(self, true_degC: float, time_s: float) -> int:
        """Read the converter.

        Parameters
        ----------
        true_degC
            Temperature of the part now; since the last read it moved there in a straight line.
        time_s
            Now; not before the last read.

        Returns
        -------
        int
            The bits that the board shifts in.

        Raises
        ------
        ValueError
            When time runs backwards.
        """
        if time_s < self._time:
            raise ValueError(f"read at {time_s} s after a read at {self._time} s")
        waited = time_s - self._time
        self._follow(true_degC, waited)
        self._time = time_s
        if waited < self.config.conversion_s - 1e-9:
            return self._word
        self._word = self._convert(time_s)
        return self._word

    def _follow(self, true_degC: float, waited: float) -> None:
        """Let the tip follow the part; exact for a part whose temperature moves in a straight line."""
        lag = self.config.lag_s
        if lag == 0.0 or math.isinf(waited):
            self._tip = true_degC
        elif waited > 0.0:
            slope = (true_degC - self._true) / waited
            self._tip = true_degC - slope * lag + (self._tip - self._true + slope * lag) * math.exp(-waited / lag)
        self._true = true_degC

    def _convert(self, time_s: float) -> int:
        config = self.config
        shown = config.cold_junction_degC + config.gain * (self._tip - config.cold_junction_degC)
        shown += config.offset_K + config.drift_K_per_h * time_s / 3600.0 + config.noise_K * self._gauss()
        forced: int | None = None
        is_open = False
        for index, fault in enumerate(config.faults):
            if not fault.start_s <= time_s < fault.end_s:
                continue
            if fault.kind == "stuck":
                return self._word
            if fault.kind == "all_0":
                forced = 0
            elif fault.kind == "all_1":
                forced = config.converter.all_ones
            elif fault.kind == "open":
                is_open = True
            elif fault.kind == "noise":
                shown += fault.size_K * self._gauss()
            elif fault.kind == "jump":
                shown += fault.size_K
            else:
                due = int((time_s - fault.start_s) / fault.every_s)
                if self._spikes.get(index, -1) < due:
                    self._spikes[index] = due
                    shown += fault.size_K
        if forced is not None:
            return forced
        return config.converter.word(shown, config.cold_junction_degC, is_open)

    def _gauss(self) -> float:
        if not self._noise:
            self._noise = self._random.standard_normal(_BLOCK).tolist()
        return self._noise.pop()


def decode(word: int) -> float:
    """Temperature in a word, degC; NaN where no driver could take it for one: open, or not a MAX6675's word.

    Zero counts are a valid 0 degC in the data sheet; that a motor cannot be that cold is for the firmware to know.
    """
    if word & OPEN_BIT or word & 0x8002:
        return math.nan
    return (word >> 3 & MAX_COUNTS) * COUNT_DEGC
