"""The checks of a thermocouple's samples, operation for operation as the board does them (``<name>_sensors.cpp``)."""

from __future__ import annotations

from itertools import pairwise

from gen.lowering.sensors import (
    CONFIRMATIONS,
    FASTER,
    LONGEST_SAMPLES,
    MOST_RISING_COUNTS,
    NOISE_COUNTS,
    PLAUSIBLE_SAMPLES,
    COUNT_mK,
    SensorLimits,
)
from gen.reference.chips import SensorCode, decoded

__all__ = ["SensorCheck", "SensorCode"]


class SensorCheck:
    """One channel's checks.

    Parameters
    ----------
    limits
        The channel's.
    """

    def __init__(self, limits: SensorLimits) -> None:
        self.limits = limits
        self.code = SensorCode.UNREAD
        self._believed = 0  # the last believed sample
        self._known = False  # it says where the part may be now
        self._since = 0  # samples since the last believed one
        self._then_mC: int | None = None  # the model's temperature at the last believed one; None: set anew since
        self._displaced = False  # it jumped farther than physics allows, and has not come back
        self._run = 0  # consistent samples in a row, up to CONFIRMATIONS
        self._agreed = 0  # samples in a row that could be a failing part's, up to CONFIRMATIONS
        self._latest = [0] * CONFIRMATIONS  # samples with a sound word, the last one first
        self._watching = False  # the next three are about the present model and count
        self._unchanged = 0
        self._moved = False
        self._model_mC = 0  # the model's temperature when the count changed last

    @property
    def temperature_mC(self) -> int:
        """The last believed sample in thousandths of a degree Celsius; 0 before the first."""
        return self._believed * COUNT_mK

    @property
    def plausible(self) -> bool:
        """Whether the last sample may be the truth, believed or not: what a limit that protects has to heed."""
        read = self.code not in {SensorCode.EARLY, SensorCode.STUCK}
        return read and self._agreed >= PLAUSIBLE_SAMPLES

    @property
    def plausible_mC(self) -> int:
        """The last sample with a sound word in thousandths of a degree Celsius; 0 before the first."""
        return self._latest[0] * COUNT_mK

    @property
    def rising_mK(self) -> int:
        """By how much the part rose over the last two readings and over the two before the last, the smaller of both.

        In thousandths of a kelvin and without what noise is; 0 where the last four readings could not be one part's.
        So neither noise nor one reading that is off makes a rise.
        """
        if not self.plausible or self._agreed < CONFIRMATIONS:
            return 0
        rise = min(self._latest[0] - self._latest[2], self._latest[1] - self._latest[3]) - NOISE_COUNTS
        return max(0, min(rise, MOST_RISING_COUNTS)) * COUNT_mK

    def model_set(self) -> None:
        """The model was started anew: what it moved before says nothing about a sensor."""
        self._watching = False
        self._then_mC = None

    def accept(self) -> None:
        """Somebody has looked at the sensor: the level at which it is now is confirmed as at the start."""
        if self._displaced:
            self._displaced = False
            self._known = False
            self._run = 0

    def restore(self, before: SensorCheck) -> None:
        """Go on with what the channel had come to before a reset, if it was refused then.

        Parameters
        ----------
        before
            The same channel's checks, as they were.
        """
        if before._displaced or before.code is SensorCode.STUCK:
            self.__dict__.update(before.__dict__)

    def check(self, word: int, finished: bool, model_mC: int) -> SensorCode:
        """Judge one reading.

        Parameters
        ----------
        word
            The bits as the chip sent them, see :func:`gen.reference.chips.decoded`.
        finished
            Whether its conversion had the time that it needs.
        model_mC
            The model's temperature of this part in thousandths of a degree Celsius; a constant if there is none.

        Returns
        -------
        SensorCode
            `OK` if the sample may be used.
        """
        self._since = min(self._since + 1, LONGEST_SAMPLES)
        self.code = self._judge(word, finished, model_mC)
        return self.code

    def _judge(self, word: int, finished: bool, model_mC: int) -> SensorCode:
        if not finished:
            return SensorCode.EARLY
        fault, counts = decoded(self.limits, word)
        if fault is SensorCode.ZEROS and self._is_cold():
            fault, counts = SensorCode.OK, 0
        if fault is not SensorCode.OK:
            self._run = 0
            self._agreed = 0
            return fault
        if not self.limits.lowest <= counts <= self.limits.highest:
            self._keep(counts)
            self._run = 0
            return SensorCode.RANGE
        self._watch_for_change(counts, model_mC)
        consistent = abs(counts - self._latest[0]) <= NOISE_COUNTS + self.limits.step
        jumped = self._run > 0 and not consistent
        self._run = min(self._run + 1, CONFIRMATIONS) if self._run and consistent else 1
        self._keep(counts)
        if self._stuck():
            return SensorCode.STUCK
        if self._is_displaced(counts, model_mC) or jumped:
            if not self._rises():
                return SensorCode.JUMP
        elif self._run < CONFIRMATIONS:
            return SensorCode.UNCONFIRMED
        self._believed = counts
        self._known = True
        self._then_mC = model_mC
        self._displaced = False
        self._since = 0
        return SensorCode.OK

    def _keep(self, counts: int) -> None:
        """Keep a sound sample, and count those in a row that could be one part's, be it one that fails."""
        agrees = self._agreed > 0 and abs(counts - self._latest[0]) <= NOISE_COUNTS + FASTER * self.limits.step
        self._agreed = min(self._agreed + 1, CONFIRMATIONS) if agrees else 1
        self._latest = [counts, *self._latest[:-1]]

    def _rises(self) -> bool:
        """Whether a part that fails outruns its largest physical change.

        The samples since the last believed one rise together, none by more than half of it all. A step is no such rise,
        and a fall neither: a sensor that comes off falls.
        """
        if self._agreed < CONFIRMATIONS or self._since >= CONFIRMATIONS:
            return False
        largest = max(later - earlier for later, earlier in pairwise(self._latest))
        whole = self._latest[0] - self._latest[-1]
        return whole > NOISE_COUNTS and 2 * largest <= whole + NOISE_COUNTS

    def _is_displaced(self, counts: int, model_mC: int) -> bool:
        """Whether the sample cannot be the part's temperature, by the last believed one.

        Once a sound sample was out of reach, time does not make its level true: it is believed again only where the
        last believed one would be now, had it moved as the model did.
        """
        if not self._known:
            return False
        if self._then_mC is None:
            self._then_mC = model_mC
        if not self._displaced:
            self._displaced = abs(counts - self._believed) > NOISE_COUNTS + self.limits.step * self._since
            return self._displaced
        expected_mC = self._believed * COUNT_mK + model_mC - self._then_mC
        return abs(counts * COUNT_mK - expected_mC) > (NOISE_COUNTS + self.limits.step) * COUNT_mK

    def _is_cold(self) -> bool:
        """Whether zeros go on from a temperature that has just come down to them: a MAX6675 sends nothing below."""
        return (
            self.limits.chip == "MAX6675"
            and self._known
            and self._believed <= NOISE_COUNTS
            and self._since <= CONFIRMATIONS
        )

    def _watch_for_change(self, counts: int, model_mC: int) -> None:
        if not self._watching or counts != self._latest[0]:
            self._watching = True
            self._unchanged = 0
            self._moved = False
            self._model_mC = model_mC
            return
        self._unchanged = min(self._unchanged + 1, 0xFFFFFFFF)
        if abs(model_mC - self._model_mC) > self.limits.stuck_mK:
            self._moved = True

    def _stuck(self) -> bool:
        limits = self.limits
        if not limits.stuck_samples or self._unchanged < limits.stuck_samples:
            return False
        return self._moved or limits.stuck_mK == 0
