"""A rule on missing heat from healthy runs: slack, unsettled slack and threshold for a wanted rate of false alarms.

**Slack and threshold** where the motor is settled: of the pairs that give the wanted rate, the one that hears the
smallest heat within :data:`SOON_S`; slack d and threshold h hear d + h / :data:`SOON_S`. The rate comes from the
greatest sum of each hour, to which a Gumbel distribution is fitted (the distribution of maxima whose tail is
exponential, as a cumulated sum's is: Basseville and Nikiforov 1993, section 5.2).
**Unsettled slack** (no less after a start than after a change by full scale) is as much, with the decay that leaves
least of it over time, as keeps the sum of every healthy run below :data:`TRANSIENT_SHARE` of that threshold after its
start and its changes of PWM. The threshold then follows anew from all of it.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.stats import gumbel_r

from gen.arrays import BoolArray, FloatArray
from gen.coefficients import Coefficients
from gen.coefficients.alarms import MissingHeat, Unsettled, window_counts
from gen.coefficients.rules import LEAST_HOURS, RuleDraft
from gen.errors import InputError
from gen.lowering.heat import BIN_COUNTS, RATE_BITS, LoweredHeat, PER_mK, block_samples, lower_heat, slowest_rates
from gen.reference.heat_blocks import Blocks, sums_after
from gen.thresholds.healthy import HealthyRun

SOON_S = 300.0
"""A heat is to be heard within so long."""
TRANSIENT_SHARE = 0.8
HOUR_S = 3600.0
HEADROOM = 1.2
"""The level is no less than this times the greatest sum of any healthy run."""
BEYOND = 1.5
"""The threshold is this times the level: what the healthy runs do not show (speeds that change every few minutes, a
sensor that scatters more) comes to more than they let one expect. Not of a rule that another alarm must precede: it
tells which fault it is, and would speak too late."""
SLACKS_K_PER_H = tuple(0.5 * 2.0 ** (number / 2.0) for number in range(15))
"""Half a kelvin an hour to 64."""
DECAYS_S = tuple(
    (rest, full) for rest in (200.0, 400.0, 800.0, 1600.0) for full in (50.0, 100.0, 200.0) if full <= rest
)
_GENEROUS = Unsettled(per_change_K_per_h=2000.0, at_start_K_per_h=1000.0, decay_s=(800.0, 200.0))
"""What leaves only settled motors to judge the slack by."""
SENSOR_TOLERANCE_K = 1.1
"""Of a MAX6675 with a type K thermocouple, as the study has them: either way, and for the ambient's sensor too."""
_MOST_K_PER_H = 5000.0
_HALVINGS = 8


@dataclass(frozen=True, eq=False)
class _Trial:
    """What a rule's numbers are tried on.

    Attributes
    ----------
    coefficients
        The model.
    rule
        The rule, its numbers anything.
    records, trusted
        Healthy runs in blocks, and whether each started cold.
    """

    coefficients: Coefficients
    rule: MissingHeat
    records: tuple[Blocks, ...]
    trusted: BoolArray

    def lowered(self, slack_K_per_h: float, unsettled: Unsettled) -> LoweredHeat:
        """The rule with other numbers, and a threshold that no sum reaches."""
        rule = self.rule.model_copy(
            update={"slack_K_per_h": slack_K_per_h, "unsettled": unsettled, "threshold_K": 4000.0}
        )
        return lower_heat(self.coefficients.document, self.coefficients.model, rule)

    def sums_K(self, lowered: LoweredHeat, runs: BoolArray | None = None) -> FloatArray:
        """Sums after each block, shape (runs, blocks)."""
        chosen = np.ones(len(self.records), dtype=np.bool_) if runs is None else runs
        records = [record for record, taken in zip(self.records, chosen, strict=True) if taken]
        sums: FloatArray = sums_after([lowered], records, self.trusted[chosen])[0] / (1000.0 * PER_mK)
        return sums

    @property
    def block_s(self) -> float:
        """Length of a block, s."""
        step_s = self.coefficients.model.sample_time
        return block_samples(step_s) * step_s

    @property
    def hours(self) -> float:
        """How long the runs are together."""
        return sum(len(record.magnitude) for record in self.records) * self.block_s / HOUR_S

    def level_K(self, sums: FloatArray, hours: float) -> float:
        """The level that a healthy hour's greatest sum exceeds once in so many hours."""
        maxima = np.array(list(self._hourly(sums)))
        greatest = float(maxima.max())
        if greatest == float(maxima.min()):
            return HEADROOM * greatest
        place, scale = gumbel_r.fit(maxima)
        by_rate = float(place - scale * np.log(-np.log1p(-1.0 / max(hours, 1.0 + 1e-6))))
        return max(by_rate, HEADROOM * greatest)

    def _hourly(self, sums: FloatArray) -> Iterator[float]:
        blocks = max(1, round(HOUR_S / self.block_s))
        for row, record in zip(sums, self.records, strict=True):
            own = row[: len(record.magnitude)]
            for begin in range(0, max(1, own.size - blocks // 2), blocks):
                yield float(own[begin : begin + blocks].max(initial=0.0))


def with_heat(rule: RuleDraft, coefficients: Coefficients, runs: Sequence[HealthyRun], hours: float) -> RuleDraft:
    """Give a rule on missing heat with its missing numbers, and a note that says what they rest on.

    Parameters
    ----------
    rule
        As in the rules file; what its author has written stays.
    coefficients
        The model.
    runs
        Of the healthy motor.
    hours
        Wanted mean time between two false alarms of the rule.

    Raises
    ------
    InputError
        When the runs say too little.
    """
    trial = _trial(rule, coefficients, runs)
    if trial.hours < LEAST_HOURS:
        raise InputError(
            f"the healthy runs in which {', '.join(trial.rule.weight_of)} is measured last {trial.hours:.1f} h "
            f"together; a rate of false alarms wants {LEAST_HOURS:g} h and more"
        )
    slack = trial.rule.slack_K_per_h if rule.says("slack_K_per_h") else _slack(trial, hours)
    unknown = trial.rule.unknown_K_per_h if rule.says("unknown_K_per_h") else _unknown(trial)
    trial = replace(trial, rule=trial.rule.model_copy(update={"unknown_K_per_h": unknown}))
    unsettled = trial.rule.unsettled
    if not rule.says("unsettled"):
        settled = trial.level_K(trial.sums_K(trial.lowered(slack, _GENEROUS)), hours)
        unsettled = _unsettled(trial, slack, TRANSIENT_SHARE * settled)
    sums = trial.sums_K(trial.lowered(slack, unsettled))
    beyond = BEYOND if trial.rule.requires is None else 1.0
    threshold = float(np.ceil(1000.0 * beyond * trial.level_K(sums, hours)) / 1000.0)
    return rule.completed(
        slack_K_per_h=slack,
        unknown_K_per_h=unknown,
        threshold_K=threshold,
        unsettled=unsettled,
        note=f"{len(trial.records)} healthy runs, {trial.hours:.0f} h together: greatest sum {sums.max():.3f} K. The "
        f"threshold is for one false alarm in {hours:g} h, by a Gumbel distribution of the greatest sums of their "
        f"hours, no less than {HEADROOM:g} times the greatest, and {beyond:g} times that; it rests on these "
        f"{trial.hours:.0f} h. Heat of {slack + threshold * HOUR_S / SOON_S:.1f} K/h is heard within "
        f"{SOON_S / 60.0:g} min of a settled motor."
        + ("" if not trial.trusted.all() else " No run starts warm: a start is taken for a change by full scale."),
    )


def _trial(rule: RuleDraft, coefficients: Coefficients, runs: Sequence[HealthyRun]) -> _Trial:
    parsed = rule.as_heat()
    columns = coefficients.model.component_names
    components = sorted({columns.index(name) for name in parsed.weight_of})
    taken = [run for run in runs if run.blocks is not None and run.blocks.present[components].any(axis=1).all()]
    return _Trial(
        coefficients,
        parsed,
        tuple(run.blocks.of(components) for run in taken if run.blocks is not None),
        np.array([run.cold for run in taken], dtype=np.bool_),
    )


def _slack(trial: _Trial, hours: float) -> float:
    """The slack that, with its own threshold, hears the smallest heat soon."""
    heard = {}
    for slack in SLACKS_K_PER_H:
        sums = trial.sums_K(trial.lowered(slack, _GENEROUS))
        heard[slack] = slack + trial.level_K(sums, hours) * HOUR_S / SOON_S
    least: float = min(heard, key=lambda slack: heard[slack])
    return round(least, 3)


def _unknown(trial: _Trial) -> float:
    """Heat that two sensors' offsets look like: part and ambient each off by their tolerance, times the rate."""
    model = trial.coefficients.model
    levels = np.array(window_counts(trial.rule, model.full_scale), dtype=np.int64)
    rates = {name: float(slowest_rates(model, name, levels).max()) for name in trial.rule.weight_of}
    off = 2.0 * SENSOR_TOLERANCE_K * HOUR_S
    return round(sum(abs(weight) * off * rates[name] for name, weight in trial.rule.weight_of.items()), 2)


def _unsettled(trial: _Trial, slack: float, most_K: float) -> Unsettled:
    """The decay and the amounts that keep every run's sum below a level, and slow the rule down least."""
    best: tuple[float, Unsettled] | None = None
    for decay in DECAYS_S:
        base = Unsettled(per_change_K_per_h=0.0, at_start_K_per_h=0.0, decay_s=decay)
        change = _least(trial, slack, base, "per_change_K_per_h", trial.trusted, most_K)
        base = base.model_copy(update={"per_change_K_per_h": change, "at_start_K_per_h": change})
        if not trial.trusted.all():
            start = _least(trial, slack, base, "at_start_K_per_h", ~trial.trusted, most_K)
            base = base.model_copy(update={"at_start_K_per_h": max(start, change)})
        left = _left_over_time(trial, trial.lowered(slack, base))
        if best is None or left < best[0]:
            best = (left, base)
    assert best is not None
    return best[1]


def _least(trial: _Trial, slack: float, base: Unsettled, key: str, runs: BoolArray, most_K: float) -> float:
    """The least amount with which the runs' sums stay below a level, or below what the most of it reaches."""
    if not runs.any():
        return 0.0

    def greatest(amount: float) -> float:
        return float(trial.sums_K(trial.lowered(slack, base.model_copy(update={key: amount})), runs).max())

    bound = max(most_K, 1.02 * greatest(_MOST_K_PER_H))
    if greatest(0.0) <= bound:
        return 0.0
    low, high = 0.0, np.log(_MOST_K_PER_H)
    for _ in range(_HALVINGS):
        middle = (low + high) / 2.0
        low, high = (low, middle) if greatest(float(np.exp(middle))) <= bound else (middle, high)
    return float(f"{np.exp(high):.3g}")


def _left_over_time(trial: _Trial, lowered: LoweredHeat) -> float:
    """Unsettled slack over all blocks of all runs, in any unit."""
    total, kept = 0.0, 1.0 - np.array(lowered.fading) / 2.0**RATE_BITS
    for record, cold in zip(trial.records, trial.trusted, strict=True):
        left = 0.0 if cold else float(lowered.start)
        for magnitude, change in zip(record.magnitude.tolist(), record.changes.tolist(), strict=True):
            left = (left + lowered.change * change) * kept[magnitude // BIN_COUNTS]
            total += left
    return float(total)
