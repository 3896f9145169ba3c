"""A limit by itself: what passes it, how far, and what noise makes of it, with and without looking ahead.

    .venv/bin/python -m benchmarks.hazards.limit_alone --hours 50

Checks and rules are the board's own, by their references (`gen.reference.sensors`, `gen.reference.alarms`), with the
brush's limit of `examples/my1016`, and on the same samples with `"look_ahead": false`. The sensor scatters normally and
is quantised as a MAX6675 is.

The first table is of a part that warms at one rate, for long or from 1.5 to 6 K below its limit on: how far beyond the
limit it is when the motor stops, a reading after the alarm, at worst over 40 starts. The second is of one that stays
just below it.
"""

from __future__ import annotations

import argparse
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from benchmarks.hazards.boards import ROOT
from gen.coefficients import Coefficients, parse
from gen.lowering.alarms import lower_alarms
from gen.lowering.sensors import sensor_limits
from gen.reference.alarms import ReferenceAlarms
from gen.reference.sensors import SensorCheck

SAMPLE_S = 0.25
PIECE_S = 900.0
"""An alarm is forgotten after each such piece, so that alarms can be counted."""
BELOW_K = (0.25, 0.5, 0.75, 1.0, 1.5, 2.0)
RATES_K_PER_S = (0.5, 1.0, 2.0, 3.0, 4.0, 5.0, 8.0, 12.0, 16.0)
STARTS = 40
NEAR_K = (1.5, 6.0)
"""So far below its limit a part is that begins to warm just below it: less is within the noise of a limit."""

Array = NDArray[np.float64]


class Lanes:
    """Sensors, each with the brush's limit twice: as it is, and without looking ahead.

    Parameters
    ----------
    coefficients
        Gives the rule and the checks.
    count
        How many.
    """

    def __init__(self, coefficients: Coefficients, count: int) -> None:
        (rule,) = [rule for rule in lower_alarms(coefficients) if rule.name == "brush_limit"]
        rule = replace(rule, component=0)
        self.limit_degC = rule.segments[0].trip_mK / 1000.0
        self._alarms = ReferenceAlarms([rule, replace(rule, looks_ahead=False)], np.ones(count, dtype=np.bool_))
        self._checks = [SensorCheck(sensor_limits(coefficients)[0]) for _ in range(count)]
        self._pwm = np.full(count, 200, dtype=np.int64)

    def read(self, degC: Array) -> None:
        """Take a reading of each, shape (L,)."""
        counts = np.rint(4.0 * degC).astype(np.int64)
        for check, count in zip(self._checks, counts.tolist(), strict=True):
            check.check(count << 3, True, 0)
        measured = np.array([[check.plausible_mC for check in self._checks]], dtype=np.int64)
        rising = np.array([[check.rising_mK for check in self._checks]], dtype=np.int64)
        heeded = np.array([int(check.plausible) for check in self._checks], dtype=np.int64)
        self._alarms.step(self._pwm, measured, np.zeros_like(measured), heeded, rising_mK=rising)

    @property
    def raised(self) -> NDArray[np.bool_]:
        """Which alarms are raised, shape (2, L): of the rule as it is, and of the other."""
        return np.array([self._alarms.latched & 1, self._alarms.latched >> 1 & 1]) > 0


def passed_K(coefficients: Coefficients, below_K: Array, rate_K_per_s: float, sigma_K: float, seed: int) -> Array:
    """How far beyond its limit a part is when the motor stops, at worst, shape (2,), in K.

    Parameters
    ----------
    coefficients
        Gives the rule and the checks.
    below_K
        How far below its limit the part begins to warm, shape (L,), in K.
    rate_K_per_s, sigma_K
        How fast, in K/s; the sensor's scatter, a standard deviation in K.
    seed
        Of the scatter.
    """
    random = np.random.default_rng(seed)
    lanes = Lanes(coefficients, len(below_K))
    degC = lanes.limit_degC - below_K
    stopped = np.full((2, len(below_K)), np.nan)
    for _ in range(6):
        lanes.read(degC + sigma_K * random.standard_normal(len(degC)))
    while np.isnan(stopped).any():
        degC = degC + rate_K_per_s * SAMPLE_S
        lanes.read(degC + sigma_K * random.standard_normal(len(degC)))
        now = lanes.raised & np.isnan(stopped)
        stopped = np.where(now, degC + rate_K_per_s * SAMPLE_S - lanes.limit_degC, stopped)
    worst: Array = stopped.max(axis=1)
    return worst


def nuisances(coefficients: Coefficients, below_K: float, sigma_K: float, pieces: int, seed: int) -> NDArray[np.int64]:
    """Count pieces of a quarter of an hour with an alarm, shape (2,), of a part that stays so far below its limit."""
    random = np.random.default_rng(seed)
    lanes = Lanes(coefficients, pieces)
    degC = np.full(pieces, lanes.limit_degC - below_K)
    for _ in range(round(PIECE_S / SAMPLE_S)):
        lanes.read(degC + sigma_K * random.standard_normal(pieces))
    count: NDArray[np.int64] = lanes.raised.sum(axis=1)
    return count


def main() -> None:
    """Print both tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--hours", type=float, default=50.0, help="simulated time for each row of the second table")
    parser.add_argument("--sigma", type=float, default=0.25, metavar="K", help="the sensor's scatter")
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    coefficients = parse((ROOT / "examples" / "my1016" / "coeffs.json").read_bytes())
    print("| K/s | for long: K beyond the limit | without looking ahead | from just below it | without looking ahead |")
    print("|---|---|---|---|---|")
    for rate in RATES_K_PER_S:
        long = 5.0 * rate + np.linspace(0.0, rate * SAMPLE_S, STARTS)
        found = [
            passed_K(coefficients, below_K, rate, options.sigma, options.seed)
            for below_K in (long, np.linspace(*NEAR_K, STARTS))
        ]
        print(f"| {rate:g} | " + " | ".join(f"{K:.1f}" for pair in found for K in pair) + " |", flush=True)
    pieces = max(1, round(options.hours * 3600.0 / PIECE_S))
    print("\n| below the limit, K | quarters of an hour with an alarm | without looking ahead | of |")
    print("|---|---|---|---|")
    for below in BELOW_K:
        ahead, plain = nuisances(coefficients, below, options.sigma, pieces, options.seed)
        print(f"| {below:g} | {ahead} | {plain} | {pieces} |", flush=True)


if __name__ == "__main__":
    main()
