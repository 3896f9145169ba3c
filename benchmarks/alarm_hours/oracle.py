"""Delay over false alarms, beside that of an oracle that knows the motor.

The oracle knows what the healthy motor's temperatures would be, to the last digit, each sensor's offset, the noise of
their readings, and how the fault warms every part; all but when it begins. It sums likelihood ratios over all onsets
(Shiryaev and Roberts): with readings whose noise is independent, the mean time between two false alarms is no less than
the threshold (Pollak, Annals of Statistics 13, 1985), and no rule has a smaller delay by much. Its noise is a sensor's
and its converter's, whose steps are taken for independent, too: at 0.1 K they are, nearly.

The board's rule is judged by the same runs at the same rates: its threshold is moved to where the greatest sums of the
hours of healthy lives, by a Gumbel distribution, exceed it as often.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from rich.box import MARKDOWN
from rich.table import Table
from scipy.stats import gumbel_r

from benchmarks.alarm_hours.judged import Campaign, coefficients_of, lives_of, setup_of
from benchmarks.alarm_hours.lives import HOUR_S, Life
from gen.lowering.alarms import lower_alarms
from gen.lowering.heat import MOST_LIMIT, LoweredHeat
from gen.reference.heat import watched
from gen.reference.heat_blocks import blocks_of, sums_after
from gen.reference.sampled import sampled
from gen.reference.simulate import simulate_run
from gen.rig import MotorConfig, SensorConfig, Setup, make_run
from gen.rig.sensors import COUNT_DEGC
from gen.runs import Run

Array = NDArray[np.float64]

RATES_H = (10.0, 100.0, 1000.0, 10_000.0)
"""Hours per false alarm."""
BEFORE_S, LATEST_S = 300.0, 3600.0
"""Onsets that the oracle thinks of begin so long before the true one; what takes longer than this is not heard."""


@dataclass(frozen=True, eq=False)
class Delays:
    """Of one life with a fault, by `RATES_H`; infinite where it is not heard.

    Attributes
    ----------
    life
        What it is counted under.
    board_s, oracle_s
        Shape (rates,).
    """

    life: str
    board_s: Array
    oracle_s: Array


def board_sums(campaign: Campaign, run: Run, kind: str) -> tuple[Array, float]:
    """Sums after each block of the rule on missing heat that asks no other first, over its threshold; a block, s."""
    coefficients = coefficients_of(campaign.path)
    rule = _rule(campaign)
    shown = simulate_run(coefficients, run, "exact", "auto", kind)
    degrees = {part: shown[f"{part}_degC"].astype(np.float64) for part in coefficients.model.component_names}
    given = sampled(coefficients.model, run, degrees)
    record = blocks_of(rule.block, watched([rule]), given.pwm, given.measured_mC - given.model_mC, given.valid)
    open_ended = replace(rule, limit=MOST_LIMIT)
    sums = sums_after([open_ended], [record], np.array([given.trusted]))[0, 0] / rule.limit
    return sums, rule.block * coefficients.model.sample_time


def _rule(campaign: Campaign) -> LoweredHeat:
    rules = [rule for rule in lower_alarms(coefficients_of(campaign.path)) if rule.heat is not None]
    first = next(rule for rule in rules if rule.requires is None)
    assert first.heat is not None
    return first.heat


def thresholds(campaign: Campaign, lives: Sequence[Life]) -> Array:
    """What the rule's threshold is to be multiplied by for each of `RATES_H`, from hours of healthy lives."""
    greatest: list[float] = []
    for life in lives:
        sums, block_s = board_sums(campaign, make_run(life.profile, setup_of(campaign, life)).run, life.kind)
        blocks = round(HOUR_S / block_s)
        greatest += [float(sums[at : at + blocks].max()) for at in range(0, sums.size - blocks // 2, blocks)]
    place, scale = gumbel_r.fit(greatest)
    return np.array([place - scale * np.log(-np.log1p(-1.0 / rate)) for rate in RATES_H])


def delays(campaign: Campaign, number: int, factors: Array) -> Delays:
    """Run a life with a fault, by its number, and ask both."""
    life = lives_of(campaign, "faults")[number]
    assert life.fault_s is not None
    setup = setup_of(campaign, life)
    ill = make_run(life.profile, setup)
    sums, block_s = board_sums(campaign, ill.run, life.kind)
    ends: Array = block_s * np.arange(1.0, sums.size + 1.0)
    since = ends > life.fault_s
    board = [_first(ends[since], sums[since] >= factor) - life.fault_s for factor in factors]
    well = make_run(life.profile, replace(setup, motor=MotorConfig()))
    rise = {name: ill.truth.temperatures[name] - well.truth.temperatures[name] for name in ill.run.temps}
    residual = {
        name: ill.run.temps[name] - well.truth.temperatures[name] - setup.sensors[name].offset_K for name in rise
    }
    return Delays(life.kind, np.array(board), oracle_delays(life, setup, rise, residual))


def oracle_delays(life: Life, setup: Setup, rise: dict[str, Array], residual: dict[str, Array]) -> Array:
    """Delays of the sum of likelihood ratios over all onsets, shape (rates,)."""
    assert life.fault_s is not None
    begin = round((life.fault_s - BEFORE_S) / setup.sample_s)
    fault = round(life.fault_s / setup.sample_s)
    rows = round((BEFORE_S + LATEST_S) / setup.sample_s)
    log_ratio = np.full((rows, rows), -np.inf)  # of an onset, after a row
    names = list(rise)
    weight = np.array([1.0 / _variance(setup.sensors[name]) for name in names])
    shape = np.column_stack([rise[name][fault : fault + rows] for name in names])
    found = np.column_stack([residual[name][begin : begin + rows] for name in names])
    for onset in range(rows):
        risen = shape[: rows - onset]
        each = (found[onset:] * risen - 0.5 * risen**2) @ weight
        log_ratio[onset, onset:] = np.cumsum(each)
    highest = log_ratio.max(axis=0)
    total = highest + np.log(np.exp(log_ratio - highest).sum(axis=0))
    time: Array = (begin + np.arange(rows, dtype=np.float64)) * setup.sample_s
    since = time > life.fault_s
    asked = np.log(np.array(RATES_H) * HOUR_S / setup.sample_s)
    return np.array([_first(time[since], total[since] >= level) - life.fault_s for level in asked])


def _variance(sensor: SensorConfig) -> float:
    """Of a reading, K^2: its noise and its converter's steps."""
    return sensor.noise_K**2 + COUNT_DEGC**2 / 12.0


def _first(times: Array, flags: NDArray[np.bool_]) -> float:
    return float(times[np.argmax(flags)]) if flags.any() else np.inf


def oracle_table(found: Sequence[Delays]) -> Table:
    """Medians over speeds."""
    table = Table("fault", "hours per false alarm", "oracle: heard", "after (s): median, worst", "board: heard",
                  "after (s): median, worst", "median of ratios", box=MARKDOWN)  # fmt: skip
    for kind in dict.fromkeys(one.life for one in found):
        own = [one for one in found if one.life == kind]
        for number, rate in enumerate(RATES_H):
            board = np.array([one.board_s[number] for one in own])
            oracle = np.array([one.oracle_s[number] for one in own])
            ratio = float(np.median(board / oracle))
            cells = [cell for values in (oracle, board) for cell in _heard(values)]
            table.add_row(kind, f"{rate:g}", *cells, f"{ratio:.1f}" if np.isfinite(ratio) else "")
    return table


def _heard(values: Array) -> tuple[str, str]:
    some = values[values <= LATEST_S]
    spread = f"{np.median(some):.0f}, {some.max():.0f}" if some.size else ""
    return f"{some.size} of {values.size}", spread
