"""A planned run, and what it is expected to decide: as a profile, for people, as JSON."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from gen.arrays import FloatArray, IntArray
from gen.planning.hypotheses import Hypothesis
from gen.planning.intervals import Interval
from gen.refinement.network.planned import Expectation, Pair
from gen.runs import EXPECTS

LAST_S = 1.0
"""The motor is stopped this long before the run's end, s: whoever follows the profile leaves it at rest."""


@dataclass(frozen=True)
class Told:
    """What two hypotheses differ by.

    Attributes
    ----------
    first, second
        By number.
    planned_K, plain_K
        What is left of the difference after a fit, root mean square over sensors and time, in the planned run and in
        the best one that holds a level or climbs in steps, K.
    """

    first: int
    second: int
    planned_K: float
    plain_K: float


@dataclass(frozen=True, eq=False)
class Plan:
    """A planned run and what it is expected to decide.

    Attributes
    ----------
    holds, plain
        The planned run, and the best plain one as long: PWM in counts and for how long, s.
    hypotheses
        What remains, by what is said of it; the named one first.
    beside
        Names of the effects that were found before the open question.
    told
        Every pair.
    intervals
        Of the numbers of the first hypothesis.
    readings_95_K
        Half of the widest 95 % interval of a predicted reading along the planned run, before it and after it, K.
    hottest, limits
        Of each of the file's nodes, degC: by the hottest hypothesis, and what is allowed, the margin taken off.
    names
        Of the nodes.
    noise_K
        The noise floor.
    decided
        Whether there is nothing to be decided.
    warnings
        Sentences for the user.
    """

    holds: tuple[tuple[int, float], ...]
    plain: tuple[tuple[int, float], ...]
    hypotheses: tuple[Hypothesis, ...]
    beside: tuple[str, ...]
    told: tuple[Told, ...]
    intervals: tuple[Interval, ...]
    readings_95_K: tuple[float, float]
    hottest: FloatArray
    limits: FloatArray
    names: tuple[str, ...]
    noise_K: float
    decided: bool
    warnings: tuple[str, ...]

    @property
    def expectation(self) -> Expectation:
        """What the profile says of itself."""
        pairs = []
        for one in self.told:
            first, second = self.hypotheses[one.first], self.hypotheses[one.second]
            pairs.append(
                Pair(
                    first=first.name,
                    second=second.name,
                    first_at=first.at,
                    second_at=second.at,
                    floors=round(one.planned_K / self.noise_K, 3),
                    separation_K=round(one.planned_K, 4),
                )
            )
        return Expectation(beside=self.beside, pairs=tuple(pairs), holds=self.holds)

    def rows(self) -> tuple[FloatArray, IntArray]:
        """Give the profile's rows: times in s, and the PWM that acts from then on."""
        begins = np.concatenate([[0.0], np.cumsum([seconds for _, seconds in self.holds])])
        pwm = [level for level, _ in self.holds]
        if pwm[-1] == 0:
            return begins[:-1], np.array(pwm, dtype=np.int64)
        begins[-1] -= LAST_S
        return begins, np.array([*pwm, 0], dtype=np.int64)

    def comments(self) -> dict[str, str]:
        """Give the profile's comment lines."""
        left = " / ".join(one.label for one in self.hypotheses)
        return {"plan": f"gen plan, {left}", EXPECTS: self.expectation.text()}

    def lines(self) -> list[str]:
        """Give the table for people."""
        return [*self._said_of_hypotheses(), *self._said_of_intervals(), *self._said_of_temperatures()]

    def _said_of_hypotheses(self) -> list[str]:
        if self.decided:
            return [
                f"nothing is to be decided: {self.hypotheses[0].label} alone is left, and what it predicts is known to "
                f"{self.readings_95_K[0]:.2f} K (95 %)"
            ]
        if len(self.hypotheses) == 1:
            return [f"one hypothesis is left: {self.hypotheses[0].label}; the run is to narrow its intervals"]
        beside = f" beside {', '.join(self.beside)}" if self.beside else ""
        made = [f"to be told apart{beside}, left after a fit in noise floors (K):   planned   constant or steps"]
        for one in self.told:
            pair = f"{self.hypotheses[one.first].label} / {self.hypotheses[one.second].label}"
            planned, plain = (f"{K / self.noise_K:.2f} ({K:.2f})" for K in (one.planned_K, one.plain_K))
            made.append(f"  {pair:<64} {planned:>12} {plain:>14}")
        return made

    def _said_of_intervals(self) -> list[str]:
        made = [f"95 % intervals of {self.hypotheses[0].label}, before and after:"]
        for one in self.intervals:
            before, after = (f"{low:.3g} .. {high:.3g}" for low, high in (one.before, one.after))
            made.append(f"  {one.what:<44} {one.value:>9.3g}   {before:<22} {after}")
        before_K, after_K = self.readings_95_K
        return [*made, f"  widest of a predicted reading along the run: {before_K:.2f} K before, {after_K:.2f} K after"]

    def _said_of_temperatures(self) -> list[str]:
        each = zip(self.names, self.hottest, self.limits, strict=True)
        return [f"hottest: {', '.join(f'{name} {top:.1f} of {most:.1f}' for name, top, most in each)} degC"]

    def summary(self) -> dict[str, Any]:
        """The JSON summary."""
        return {
            "hypotheses": [one.label for one in self.hypotheses],
            "nothing_to_decide": self.decided,
            "noise_floor_K": self.noise_K,
            "pairs": [
                {
                    "first": self.hypotheses[one.first].label,
                    "second": self.hypotheses[one.second].label,
                    "planned_K": one.planned_K,
                    "planned_floors": one.planned_K / self.noise_K,
                    "plain_K": one.plain_K,
                    "plain_floors": one.plain_K / self.noise_K,
                }
                for one in self.told
            ],
            "intervals_95": [one.summary() for one in self.intervals],
            "readings_95_K": {"before": self.readings_95_K[0], "after": self.readings_95_K[1]},
            "hottest_degC": dict(zip(self.names, self.hottest.tolist(), strict=True)),
            "allowed_degC": dict(zip(self.names, self.limits.tolist(), strict=True)),
            "profile": [list(hold) for hold in self.holds],
            "plain_profile": [list(hold) for hold in self.plain],
            "warnings": list(self.warnings),
        }
