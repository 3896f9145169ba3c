"""What the alarm rules are compared on: inputs that dwell where rules decide, and the reference's answer to them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from gen.arrays import BoolArray, IntArray, RecordArray
from gen.lowering import heat
from gen.lowering.alarms import LoweredRule
from gen.lowering.heat import LoweredHeat
from gen.lowering.program import Program
from gen.reference.alarms import ReferenceAlarms, alarm_record_type
from gen.reference.board import reference_of
from gen.reference.heat import watched
from gen.verification.profiles import Profile
from gen.verification.sample import sample_fields

STEP, BEGIN, RESET_AND_STEP = 0, 1, 2
_RESET_SHARE = 4e-3
#: A sensor's step, in thousandths of a degree: half of the readings lie on it, so that thresholds are met exactly.
_COUNT_MC = 250
#: Samples for which a part is not measured at most; now and then it is whole blocks.
_GAP, _LONG_GAP = 30, 400


@dataclass(frozen=True)
class AlarmCampaign:
    """Inputs of the alarm rules over L lanes of N samples, and what the reference makes of them.

    Attributes
    ----------
    inputs
        Records as the harnesses read them, shape (L, N + 1): the first begins the lane.
    expected
        The reference's records, shape (L, N).
    """

    inputs: RecordArray
    expected: RecordArray


def input_type(components: int, rules: Sequence[LoweredRule]) -> np.dtype[np.void]:
    """The harnesses' input record; the alarm structure at its end is what a lane begins with."""
    return np.dtype([("op", "u1"), ("pwm", "<i2"), *sample_fields(components), *_fields(alarm_record_type(rules))])


def output_type(program: Program, rules: Sequence[LoweredRule]) -> np.dtype[np.void]:
    """The harnesses' output record: temperatures and the alarm structure."""
    temperatures = [(f"{component.name}.mC", "<i4") for component in program.parts]
    return np.dtype([*temperatures, *_fields(alarm_record_type(rules))])


def alarm_profile(program: Program, rules: Sequence[LoweredRule], lanes: int, length: int, seed: int = 511) -> Profile:
    """PWM that stays within the rules' ranges for long, visits their ends, and leaves them now and then."""
    random = np.random.default_rng(seed)
    scale = program.model.full_scale
    edges = sorted(
        {0, scale} | {end for rule in rules for segment in rule.segments for end in (segment.low, segment.high)}
    )
    pwm = np.zeros((lanes, length), dtype=np.int64)
    for lane in pwm:
        low, high = 0, scale
        if rules:
            rule = rules[int(random.integers(len(rules)))]
            low, high = rule.segments[0].low, rule.segments[-1].high
        position = 0
        while position < length:
            hold = int(random.integers(1, 400))
            level = random.integers(low, high + 1)
            if random.random() < 0.1:
                level = np.clip(edges[random.integers(len(edges))] + random.integers(-1, 2), 0, scale)
            lane[position : position + hold] = level * random.choice([1, -1])
            position += hold
    start = random.integers(-30_000, 60_000, lanes)
    return Profile(pwm, start.astype(np.int64))


def campaign(program: Program, rules: Sequence[LoweredRule], profile: Profile, seed: int = 7) -> AlarmCampaign:
    """Measurements around every rule's thresholds, with missing samples and resets, and the reference's answer.

    Parameters
    ----------
    program, rules
        What the board holds.
    profile
        PWM and start rises. The first lane begins trusted, the second untrusted with alarms restored, the others with
        timers and sums close to their ends, which would take hours to reach.
    """
    random = np.random.default_rng(seed)
    lanes, length = profile.pwm.shape
    count = len(program.parts)
    model = reference_of(program, [int(rise) for rise in profile.start_mK])
    trusted = np.arange(lanes) == 0
    preset = np.arange(lanes) >= 2
    alarms = ReferenceAlarms(rules, trusted)
    alarms.advance(_close_to_the_end(random, rules, alarms.record(), preset, profile.pwm[:, 0]))
    inputs = np.zeros((lanes, length + 1), dtype=input_type(count, rules))
    inputs["op"][:, 0] = BEGIN
    inputs["measured_mC"][:, 0, :] = profile.start_mK[:, None]
    inputs["valid"][:, 0] = trusted | preset << 1
    begun = alarms.record()
    restored = np.arange(lanes) == 1  # any mask, with bits that no rule has
    begun["latched"][restored] = random.integers(0, 1 << 16, int(restored.sum()))
    alarms.restore(np.where(restored, begun["latched"], 0).astype(np.int64))
    inputs["valid"][:, 0] |= (restored << 2).astype(np.uint16)
    for name in begun.dtype.names or ():
        inputs[name][:, 0] = begun[name]
    expected = np.zeros((lanes, length), dtype=output_type(program, rules))
    ambient: IntArray = np.zeros(lanes, dtype=np.int64)
    source = _Measurements(random, rules, lanes, count)
    for step in range(length):
        pwm = profile.pwm[:, step]
        resets = np.asarray(random.random(lanes) < _RESET_SHARE)
        model.step(pwm)
        if step % 50 == 0:
            ambient = np.asarray(random.integers(-10_000, 50_000, lanes), dtype=np.int64)
        modelled = model.rises_mK + ambient
        measured, valid, plausible = source.next(modelled)
        rising = _rising(random, measured.shape)
        alarms.reset(resets)
        alarms.step(pwm, measured, modelled, valid, plausible, rising)
        row = inputs[:, step + 1]
        row["op"] = np.where(resets, RESET_AND_STEP, STEP)
        row["pwm"], row["ambient_mC"], row["measured_mC"] = pwm, ambient, measured.T
        row["valid"], row["plausible"], row["rising_mK"] = valid, plausible, rising.T
        _keep(expected[:, step], program, modelled, alarms)
    return AlarmCampaign(inputs, expected)


def _rising(random: np.random.Generator, shape: tuple[int, ...]) -> IntArray:
    """How fast parts rise, shape (components, L): mostly not at all, or by kelvins, or as far as words go."""
    near = 250 * random.integers(0, 12, shape)
    far = random.integers(0, 1 << 16, shape)
    rising: IntArray = np.select([random.random(shape) < 0.8, random.random(shape) < 0.9], [0 * near, near], far)
    return rising


def _keep(row: RecordArray, program: Program, modelled: IntArray, alarms: ReferenceAlarms) -> None:
    state = alarms.record()
    for name in state.dtype.names or ():
        row[name] = state[name]
    for component, temperature in zip(program.parts, modelled, strict=True):
        row[f"{component.name}.mC"] = temperature


def _close_to_the_end(
    random: np.random.Generator,
    rules: Sequence[LoweredRule],
    begun: RecordArray,
    lanes: BoolArray,
    pwm: IntArray,
) -> RecordArray:
    record = begun.copy()
    count = int(lanes.sum())
    record["latched"][lanes] = random.integers(0, 1 << len(rules), count)
    for rule in rules:
        short = random.integers(0, 4, (3, count))
        record[f"{rule.name}.settled"][lanes] = np.maximum(rule.settle - short[0], 0)
        record[f"{rule.name}.start_wait"][lanes] = np.minimum(rule.start_wait, short[1])
        record[f"{rule.name}.held"][lanes] = np.maximum(rule.persistence - short[2], 0)
        if rule.sum_limit is not None:
            ends = np.where(random.random(count) < 0.5, 0, rule.sum_limit)
            record[f"{rule.name}.sum"][lanes] = np.abs(ends - random.integers(0, min(40_000, rule.sum_limit), count))
    _close_in_heat(random, [rule.heat for rule in rules], record, lanes, pwm)
    return record


def _close_in_heat(
    random: np.random.Generator,
    rules: Sequence[LoweredHeat | None],
    record: RecordArray,
    lanes: BoolArray,
    pwm: IntArray,
) -> None:
    """Blocks about to end, sums about to be full, what is usual and unsettled anywhere up to what the words hold."""
    count = int(lanes.sum())
    for row in range(len(watched(rules))):
        record[f"heat.part{row}.known"][lanes] = random.integers(0, 2, count)
        mean = heat.PER_mK * heat.MOST_DEVIATION_mK
        record[f"heat.part{row}.mean"][lanes] = random.integers(-mean, mean + 1, count) // _scales(random, count)
    for number, rule in enumerate(rules):
        if rule is None:
            continue
        most = heat.MOST_RATE << heat.FINE_BITS
        # Unsettled by close to nothing, or by close to the most; nearly all learnt, or about enough to remember it.
        ends = random.integers(0, 2, count)
        spread = random.integers(0, heat.MOST_UNSETTLED, count) // _scales(random, count)
        forgotten = random.integers(0, rule.memory - heat.PRIOR_BLOCKS + 1, count) // _scales(random, count)
        learnt = np.where(
            random.integers(0, 2, count) == 1, rule.memory - forgotten, rule.told + random.integers(-2, 2, count)
        )
        usual = random.integers(-most, most + 1, count) // _scales(random, count)
        words = {
            "sum": np.clip(rule.limit + random.integers(-2000, 2001, count), 0, 2 * rule.limit),
            "usual": usual,
            "before": np.minimum(most, usual + random.integers(0, 2 * most, count) // _scales(random, count)),
            "unsettled": np.abs(ends * heat.MOST_UNSETTLED - spread),
            "pending": random.integers(-heat.MOST_PENDING, heat.MOST_PENDING + 1, count) // _scales(random, count),
            "learnt": np.clip(learnt, heat.PRIOR_BLOCKS, rule.memory),
            "waited": random.integers(0, heat.MOST_WAITED + 1, count),
        }
        for field, values in words.items():
            record[f"heat.{number}.{field}"][lanes] = values
        record["heat.samples"][lanes] = random.integers(0, rule.block, count)
        record["heat.pwm"][lanes] = pwm[lanes]  # or nothing would be settled enough to learn


def _scales(random: np.random.Generator, count: int) -> IntArray:
    """Divisors that spread values over all orders of magnitude."""
    scales: IntArray = 2 ** random.integers(0, 30, count)
    return scales


def _fields(record: np.dtype[np.void]) -> list[tuple[str, str]]:
    return [(name, kind.str) for name, (kind, *_) in (record.fields or {}).items()]


def _mask(parts: BoolArray) -> IntArray:
    """A bit for each component, shape (components, L), as one mask for each lane."""
    mask: IntArray = (parts << np.arange(len(parts))[:, None]).sum(axis=0)
    return mask


class _Measurements:
    """Deviations from the model that dwell at, just beside and far from the thresholds."""

    def __init__(self, random: np.random.Generator, rules: Sequence[LoweredRule], lanes: int, components: int) -> None:
        self._random = random
        self._shape = (components, lanes)
        levels: list[list[tuple[str, int, int | None]]] = [[] for _ in range(components)]
        for rule in rules:
            for segment in rule.segments:
                ends = (segment.trip_mK, segment.clear_mK)
                levels[rule.component] += [(rule.quantity, end, rule.relative_to) for end in ends]
        self._levels = levels
        self._offset = np.zeros(self._shape, dtype=np.int64)
        self._absolute = np.zeros(self._shape, dtype=bool)
        self._left = np.zeros(self._shape, dtype=np.int64)
        self._missing = np.zeros(self._shape, dtype=np.int64)

    def next(self, modelled: IntArray) -> tuple[IntArray, IntArray, IntArray]:
        """Measured temperatures, shape (components, L); masks of the valid and of the plausible ones, shape (L,)."""
        self._left -= 1
        for component, lane in np.argwhere(self._left < 0):
            self._choose(component, lane)
        measured = np.where(self._absolute, 0, modelled) + self._offset
        counted = self._left % 2 == 0
        measured = np.where(counted, measured // _COUNT_MC * _COUNT_MC, measured)
        longest = np.where(self._random.random(self._shape) < 0.05, _LONG_GAP, _GAP)
        self._missing = np.where(
            self._random.random(self._shape) < 0.01, self._random.integers(1, longest), self._missing - 1
        )
        seen = self._missing < 0
        may_be = ~seen & (self._missing % 3 > 0)  # two in three of those that are not believed
        measured = measured + may_be * self._random.integers(-1500, 1501, self._shape)
        anything = self._random.integers(-(10**6), 10**6, self._shape)
        # What failed its checks may be anything; a mask of the plausible ones may leave out those that are valid.
        plausible = may_be | (seen & (self._left % 4 == 0))
        return np.where(seen | may_be, measured, anything), _mask(seen), _mask(plausible)

    def _choose(self, component: int, lane: int) -> None:
        random = self._random
        self._left[component, lane] = random.integers(0, 800)
        self._absolute[component, lane] = False
        if not self._levels[component] or random.random() < 0.2:
            self._offset[component, lane] = random.integers(-20_000, 20_000)
            return
        quantity, level, other = self._levels[component][random.integers(len(self._levels[component]))]
        near = level + int(random.choice([0, 1, -1, 250, -250, 1500, -1500, 10_000, -10_000]))
        self._absolute[component, lane] = quantity == "measured"
        self._offset[component, lane] = -near if quantity == "below" else near
        if other is not None:
            self._offset[component, lane] += self._offset[other, lane]
