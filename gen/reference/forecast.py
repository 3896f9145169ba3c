"""The board's model run ahead of itself, sample by sample as the board does it."""

from __future__ import annotations

from copy import deepcopy

import numpy as np

from gen.arrays import IntArray, RecordArray
from gen.lowering.forecast import NOISE_MK, SMOOTHED, LoweredForecast
from gen.reference.board import Reference
from gen.reference.network import ReferenceNetwork

RUNNING, SEARCHING, KNOWN, HOLDABLE, NEAR = 1, 2, 4, 8, 16
"""Bits of the state: a run is under way; it tries a PWM; the time is known; so is the PWM to hold; a limit is near."""

_FIELDS = (
    ("gone", "<u4"),
    ("begun", "<u4"),
    ("until", "<u4"),
    ("age", "<u4"),
    ("left", "<u2"),
    ("pwm", "<i2"),
    ("tried", "<i2"),
    ("low", "<i2"),
    ("high", "<i2"),
    ("holdable", "<i2"),
    ("first", "u1"),
    ("state", "u1"),
)
_HELD = ("since", "<u4")


def forecast_fields(forecast: LoweredForecast) -> list[tuple[str, str]]:
    """The board's structure, byte by byte, packed and little endian."""
    return [*_FIELDS, _HELD] if forecast.holds else [*_FIELDS]


class ReferenceForecast:
    """One board's look ahead.

    Parameters
    ----------
    forecast
        How far, and at what.

    Attributes
    ----------
    gone, begun
        Samples of the run under way, and of the board since it began.
    until, age
        Samples from the start of the last run at the PWM that is asked for to its end, and since that start.
    left
        Samples that may still go ahead within this one.
    pwm, tried
        Which PWM is asked for, and which the run holds, in counts.
    low, high, holdable
        Of the search: a |PWM| that could be held and one that could not; the result of the last search.
    first
        Which limit is reached first; as many as there are limits: none within the horizon.
    state
        Bits, see :data:`RUNNING`.
    since
        Samples since the last run of the search began that has ended; counted where a motor is held by it.
    """

    def __init__(self, forecast: LoweredForecast) -> None:
        self._forecast = forecast
        self._run: Reference | None = None
        self._above_mK = [0] * len(forecast.limits)
        self._warmer_mK = [0] * len(forecast.limits)
        self._ambient_mC = 0
        self.gone = self.begun = self.until = self.age = self.left = 0
        self.pwm = self.tried = self.holdable = self.state = self.since = 0
        self.first = len(forecast.limits)
        self._begin_search()

    def sample(self, pwm: int, board: Reference, measured_mC: IntArray, ambient_mC: int, valid: int) -> None:
        """Take a sample.

        Parameters
        ----------
        pwm
            Which is asked for from now on, in counts.
        board
            The board's own model, of one lane; not changed.
        measured_mC
            Measured temperatures, shape (components,), in thousandths of a degree Celsius.
        ambient_mC
            The ambient as the board has it.
        valid
            Bit mask of the components that are measured.
        """
        if pwm != self.pwm:
            self._take_pwm(pwm)
        self._compare(board, measured_mC, ambient_mC, valid)
        self.age += 1
        self.begun += 1
        self.since += self._forecast.holds
        self._judge_near()
        if not self.state & RUNNING:
            self._begin_run(board, ambient_mC)
        self.left = self._forecast.steps

    def work(self, samples: int) -> bool:
        """Go ahead by so many samples at most; whether something is left to do before the next sample."""
        for _ in range(samples):
            if not self.state & RUNNING or not self.left:
                break
            self.left -= 1
            assert self._run is not None
            first = self._reached(self._run)
            if first < len(self._forecast.limits) or self.gone == self._forecast.horizon:
                self._end_run(first)
            else:
                self._run.step(np.array([self.tried]))
                self.gone += 1
        return bool(self.state & RUNNING) and self.left > 0

    @property
    def samples(self) -> int:
        """While the time is known: no limit is reached within so many samples from now."""
        return max(0, self.until - self.age)

    @property
    def near(self) -> bool:
        """Whether a limit is near."""
        return bool(self.state & NEAR)

    @property
    def most_pwm(self) -> int:
        """To what a motor is derated that is to be held: the last answer, and what the search has found since.

        0 while nothing was shown to be held yet, or for longer than the horizon nothing any more.
        """
        if self.since > self._forecast.horizon:
            return 0
        return min(max(self.holdable, self.low), self.high - 1)

    def keep(self, record: RecordArray) -> None:
        """Write what the board keeps into a record, see :func:`forecast_fields`."""
        for name, _ in forecast_fields(self._forecast):
            record[name] = getattr(self, name)

    def _take_pwm(self, pwm: int) -> None:
        """Another PWM is asked for. What can be held does not change with it, unless the motor turns round."""
        turned = (pwm < 0) != (self.pwm < 0)
        self.pwm = pwm
        if not self._forecast.holds:
            self.state &= HOLDABLE
            self._begin_search()
            return
        self.state &= HOLDABLE | NEAR
        if turned:
            self._begin_search()

    def _judge_near(self) -> None:
        near = self._forecast.near
        if near is None:
            return
        if self._forecast.holds:
            self._judge_near_to_hold(near)
            return
        foreseen = bool(self.state & KNOWN) and self.first < len(self._forecast.limits)
        if foreseen and self.samples <= near:
            self.state |= NEAR
        elif not foreseen or self.samples > near + near // 2:
            self.state &= ~NEAR

    def _judge_near_to_hold(self, near: int) -> None:
        """It stays near until what is asked for can be held: a motor that is held would come back again and again."""
        if not self.state & KNOWN:
            return
        if self.first == len(self._forecast.limits):
            self.state &= ~NEAR
        elif self.samples <= near:
            self.state |= NEAR

    def _compare(self, board: Reference, measured_mC: IntArray, ambient_mC: int, valid: int) -> None:
        """Not every sample has a reading of every part: what was seen last holds."""
        modelled = board.rises_mK[:, 0] + ambient_mC
        for number, limit in enumerate(self._forecast.limits):
            if limit.part < len(modelled) and valid >> limit.part & 1:
                warmer = int(measured_mC[limit.part] - modelled[limit.part])
                if self._forecast.holds:
                    warmer -= self._warmer_mK[number]
                    self._warmer_mK[number] += int(warmer / SMOOTHED)  # towards 0, as the board divides
                else:
                    self._warmer_mK[number] = max(0, warmer)

    def _begin_search(self) -> None:
        self.low, self.high = 0, self._forecast.most_pwm + 1

    def _begin_run(self, board: Reference, ambient_mC: int) -> None:
        self._run = deepcopy(board)
        self._ambient_mC = ambient_mC
        self._above_mK = [max(0, warmer) for warmer in self._warmer_mK]
        self.tried = self.pwm
        if self.state & SEARCHING:
            size = self._next_size()
            self.tried = -size if self.pwm < 0 else size
        if self._forecast.pwm_channel is not None:
            assert isinstance(self._run, ReferenceNetwork)
            self._run.set_channel(self._forecast.pwm_channel, np.array([1000 * self.tried]))
        self.gone = self.begun = 0
        self.state |= RUNNING

    def _counted_mK(self, limit: int) -> int:
        """How much warmer than its model a part counts; of a search that a motor is held by noise only in the end."""
        above = self._above_mK[limit]
        if not self._forecast.holds or not self.state & SEARCHING or self.gone == self._forecast.horizon:
            return above
        return max(0, above - NOISE_MK)

    def _next_size(self) -> int:
        """Which |PWM| the search tries next."""
        most, known = self._forecast.most_pwm, self._forecast.holds and bool(self.state & HOLDABLE)
        if self.high <= most:
            size = 2 * self.high - self.holdable - 1 if known and self.low == 0 else 0
            return size if size > 0 else (self.low + self.high) // 2
        if not known:
            return most
        return min(most, 2 * self.low - self.holdable + 1 if self.low or not self.holdable else self.holdable)

    def _end_run(self, first: int) -> None:
        if self.state & SEARCHING:
            self.since = self.begun if self._forecast.holds else 0
            if first == len(self._forecast.limits):
                self.low = abs(self.tried)
            else:
                self.high = abs(self.tried)
            if self.high - self.low <= 1:
                self.holdable = self.low
                self.state |= HOLDABLE
                self._begin_search()
        else:
            self.first, self.until, self.age = first, self.gone, self.begun
            self.state |= KNOWN
        self.state = (self.state ^ SEARCHING) & ~RUNNING

    def _reached(self, run: Reference) -> int:
        """The first limit that is reached now."""
        limits = self._forecast.limits
        for number, reading in enumerate(self._readings_mC(run)):
            if reading + self._counted_mK(number) >= limits[number].limit_mC:
                return number
        return len(limits)

    def _readings_mC(self, run: Reference) -> list[int]:
        """Temperature of each limit's part, in thousandths of a degree Celsius."""
        rises = run.rises_mK[:, 0].tolist()
        found = []
        for limit in self._forecast.limits:
            if limit.part < len(rises):
                found.append(rises[limit.part] + self._ambient_mC)
            else:
                assert isinstance(run, ReferenceNetwork)
                found.append(int(run.node_mC(limit.part - len(rises))[0]))
        return found
