"""The alarm rules, sample by sample as the board evaluates them, for many runs at once."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from gen.arrays import BoolArray, IntArray, RecordArray
from gen.lowering.alarms import AHEAD_TIMES, HASTE_mK, LoweredRule, asks_heat
from gen.model.dynamics import MAX_PWM
from gen.reference.heat import ReferenceHeat, fields


class ReferenceAlarms:
    """A model's rules over L independent lanes.

    Parameters
    ----------
    rules
        What the board evaluates.
    trusted
        For each lane, whether the model starts with the right slopes, shape (L,).

    Attributes
    ----------
    latched, active, asleep, deaf
        Bit masks of the rules, shape (L,). Deaf: the rule on missing heat that they wait for to stay silent had nothing
        to hear when the alarm came that they require.
    """

    def __init__(self, rules: Sequence[LoweredRule], trusted: BoolArray) -> None:
        self._rules = tuple(rules)
        lanes = len(trusted)
        self.latched = np.zeros(lanes, dtype=np.int64)
        self.active = np.zeros(lanes, dtype=np.int64)
        self.asleep = np.full(lanes, (1 << len(rules)) - 1, dtype=np.int64)
        self.deaf = self.asleep.copy()
        self._settled = np.zeros((len(rules), lanes), dtype=np.int64)
        self._held = np.zeros((len(rules), lanes), dtype=np.int64)
        self._sum = np.zeros((len(rules), lanes), dtype=np.int64)
        self._heat = ReferenceHeat([rule.heat for rule in rules], trusted)
        self._wait = np.array([np.where(trusted, 0, rule.start_wait) for rule in rules], dtype=np.int64).reshape(
            len(rules), lanes
        )

    def advance(self, record: RecordArray) -> None:
        """Go on from what a board keeps, shape (L,), see :func:`alarm_record_type`."""
        for number, rule in enumerate(self._rules):
            self._settled[number] = record[f"{rule.name}.settled"]
            self._wait[number] = record[f"{rule.name}.start_wait"]
            self._held[number] = record[f"{rule.name}.held"]
            self._sum[number] = record[f"{rule.name}.sum"]
        self._heat.advance(record)
        for mask in _masks(self._rules):
            setattr(self, mask, record[mask].astype(np.int64))

    def restore(self, latched: IntArray) -> None:
        """Raise alarms that were latched before a reset of the board.

        Parameters
        ----------
        latched
            Bit masks, shape (L,); bits without a rule are ignored.
        """
        self.latched |= latched & ((1 << len(self._rules)) - 1)

    def reset(self, lanes: BoolArray) -> None:
        """Forget the alarms raised in the lanes that are marked, shape (L,)."""
        # A limit's persistence goes on: else resets in time would keep its alarm away for ever.
        held = [self._held[number] for number, rule in enumerate(self._rules) if rule.quantity != "measured"]
        for values in (self.latched, self.active, *held, *self._sum):
            values[lanes] = 0
        self._heat.reset(lanes)

    def step(
        self,
        pwm: IntArray,
        measured_mC: IntArray,
        model_mC: IntArray,
        valid: IntArray,
        plausible: IntArray | None = None,
        rising_mK: IntArray | None = None,
    ) -> None:
        """Evaluate every rule after a sample.

        Parameters
        ----------
        pwm
            What acted over the sample, shape (L,).
        measured_mC, model_mC
            Measured and modelled temperatures, shape (components, L), in thousandths of a degree Celsius.
        valid
            Bit masks of the components whose measurement passed its checks, shape (L,).
        plausible
            Bit masks of those whose measurement may be the truth, believed or not, shape (L,): limits of a temperature
            heed them too. None: what is valid.
        rising_mK
            By how much each part rose over the last two readings, beyond what noise is, shape (components, L); None:
            not at all. Limits that look ahead heed it.
        """
        heeded = valid if plausible is None else valid | plausible
        magnitude = np.minimum(np.abs(pwm), MAX_PWM)
        self._heat.step(pwm, measured_mC - model_mC, valid)
        for number, rule in enumerate(self._rules):
            inside, trip, clear = thresholds(rule, magnitude)
            awake = self._awake(number, rule, inside)
            self._settled[number][~inside] = 0
            asleep = ~inside | ~awake
            seen = ~asleep & ((((valid if rule.needs_model else heeded) >> rule.component) & 1) == 1)
            if rule.relative_to is not None:
                seen &= ((valid >> rule.relative_to) & 1) == 1
            value = compared(rule, measured_mC, model_mC, rising_mK)
            holds = seen & self._holds(number, rule, value, trip, clear, seen)
            released = asleep | (seen & ~holds)
            held = self._held[number] + np.where(holds, counted(rule, value, trip), 0)
            self._held[number] = np.where(released, 0, np.minimum(held, rule.persistence + 1))
            self._mark(number, "asleep", on=asleep, off=~asleep)
            raised = holds & (self._held[number] > rule.persistence)
            self._mark(number, "active", on=raised, off=released)
            self._mark(number, "latched", on=raised, off=np.zeros_like(raised))

    def record(self) -> RecordArray:
        """What the board keeps, shape (L,), see :func:`alarm_record_type`."""
        record = np.zeros(len(self.latched), dtype=alarm_record_type(self._rules))
        for number, rule in enumerate(self._rules):
            record[f"{rule.name}.settled"] = self._settled[number]
            record[f"{rule.name}.start_wait"] = self._wait[number]
            record[f"{rule.name}.held"] = self._held[number]
            record[f"{rule.name}.sum"] = self._sum[number]
        self._heat.keep(record)
        for mask in _masks(self._rules):
            record[mask] = getattr(self, mask)
        return record

    def _awake(self, number: int, rule: LoweredRule, inside: BoolArray) -> BoolArray:
        waiting = inside & (self._wait[number] > 0)
        settling = inside & (self._settled[number] < rule.settle)
        self._wait[number] -= waiting
        self._settled[number] += settling
        awake: BoolArray = ~waiting & ~settling
        if rule.requires is not None:
            awake &= ((self.latched >> rule.requires) & 1) == 1
        if rule.unless is not None:
            awake &= ((self.latched >> rule.unless) & 1) == 0
            if self._rules[rule.unless].heat is not None:
                hears = self._heat.settled(rule.unless)
                early = inside if rule.requires is None else inside & (((self.latched >> rule.requires) & 1) == 0)
                self._mark(number, "deaf", on=early & ~hears, off=early & hears)
                awake &= hears & (((self.deaf >> number) & 1) == 0)
        return awake

    def _holds(
        self, number: int, rule: LoweredRule, value: IntArray, trip: IntArray, clear: IntArray, seen: BoolArray
    ) -> BoolArray:
        if rule.heat is not None:
            reached: BoolArray = self._heat.sums[number] >= rule.heat.limit
            return reached
        if rule.sum_limit is None:
            above: BoolArray = value > np.where(self._held[number] > 0, clear, trip)
            return above
        total = np.clip(self._sum[number] + value - trip, 0, rule.sum_limit)
        self._sum[number] = np.where(seen, total, self._sum[number])
        full: BoolArray = self._sum[number] == rule.sum_limit
        return full

    def _mark(self, number: int, mask: str, *, on: BoolArray, off: BoolArray) -> None:
        values = getattr(self, mask)
        values |= np.where(on, 1 << number, 0)
        values &= np.where(off, ~(1 << number), -1)


def alarm_record_type(rules: Sequence[LoweredRule]) -> np.dtype[np.void]:
    """The board's alarm structure, byte by byte, packed and little endian."""
    timers = [
        (f"{rule.name}.{field}", kind)
        for rule in rules
        for field, kind in (("settled", "<u2"), ("start_wait", "<u2"), ("held", "<u2"), ("sum", "<i4"))
    ]
    masks = [(mask, "<u2") for mask in _masks(rules)]
    return np.dtype([*timers, *fields([rule.heat for rule in rules]), *masks])


def _masks(rules: Sequence[LoweredRule]) -> tuple[str, ...]:
    usual = ("latched", "active", "asleep")
    return (*usual, "deaf") if asks_heat(rules) else usual


def compared(
    rule: LoweredRule, measured_mC: IntArray, model_mC: IntArray, rising_mK: IntArray | None = None
) -> IntArray:
    """What a rule compares with its threshold, shape (L,): a deviation, or the temperature as it is or soon will be."""
    value: IntArray = measured_mC[rule.component]
    if not rule.needs_model:
        if rule.looks_ahead and rising_mK is not None:
            value = value + AHEAD_TIMES * rising_mK[rule.component]
        return value
    value = measured_mC[rule.component] - model_mC[rule.component]
    if rule.relative_to is not None:
        value = value - (measured_mC[rule.relative_to] - model_mC[rule.relative_to])
    return -value if rule.quantity == "below" else value


def counted(rule: LoweredRule, value: IntArray, trip: IntArray) -> IntArray:
    """For how many samples of its persistence a sample counts at which a rule's condition holds, shape (L,)."""
    if not rule.looks_ahead:
        return np.ones_like(value)
    beyond: IntArray = 1 + np.maximum(value - trip, 0) // HASTE_mK
    return beyond


def thresholds(rule: LoweredRule, magnitude: IntArray) -> tuple[BoolArray, IntArray, IntArray]:
    """Whether each |PWM|, shape (L,), lies in a rule's segments, and where its condition begins and ends there, mK."""
    inside = np.zeros(len(magnitude), dtype=bool)
    trip, clear = np.zeros_like(magnitude), np.zeros_like(magnitude)
    for segment in rule.segments:
        here = (magnitude >= segment.low) & (magnitude <= segment.high)
        inside |= here
        trip[here], clear[here] = segment.trip_mK, segment.clear_mK
    return inside, trip, clear
