"""Missing heat beside a board's rows: the sums of the rules on it, in per cent of where each raises its alarm.

No row holds them. An emulated board's are read out of its memory; of another board they are computed here from its
rows, by the reference's words: where a row comes every sample, and the start was seen, they are the board's.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from gen.coefficients import Coefficients
from gen.coefficients.alarms import MissingHeat
from gen.lowering.alarms import COLD_mK, lower_alarms
from gen.lowering.heat import LoweredHeat, MOST_DEVIATION_mK, PER_mK, lower_heat
from gen.reference.alarms import alarm_record_type
from gen.reference.heat import ReferenceHeat, truncated, watched

Row = Mapping[str, float | None]

HELD_S = 120.0
"""So long a row's measurement holds until the next one; later nothing is measured."""
_TO_THE_GRID = 1e-6
"""A row this close to a sample, in samples, counts as on it."""
_FIRST_S = 1.0
"""A first row later than this was not the board's first."""


@dataclass(frozen=True)
class HeatRule:
    """A rule on missing heat, and the column that the page has for it."""

    name: str
    threshold_K: float

    @property
    def column(self) -> str:
        """Its name."""
        return f"{self.name}_missing_percent"


class Heat(Protocol):
    """Whoever knows the sums."""

    @property
    def rules(self) -> tuple[HeatRule, ...]:
        """The rules."""
        ...

    @property
    def told(self) -> str:
        """How they are known."""
        ...

    def take(self, row: Row) -> list[float | None]:
        """Take a row; gives each rule's sum after it, % of its threshold, None where it is not known."""
        ...


def heat_rules(coefficients: Coefficients) -> tuple[HeatRule, ...]:
    """The rules on missing heat of a coefficient file."""
    rules = coefficients.document.alarms
    return tuple(HeatRule(rule.name, rule.threshold_K) for rule in rules if isinstance(rule, MissingHeat))


class HeatInMemory:
    """The board's own sums.

    Parameters
    ----------
    coefficients
        What the board holds.
    peek
        Gives the bytes of its alarms' state, see :func:`gen.reference.alarms.alarm_record_type`.
    """

    told = "the board's own, out of its memory"

    def __init__(self, coefficients: Coefficients, peek: Callable[[int], bytes]) -> None:
        self.rules = heat_rules(coefficients)
        lowered = lower_alarms(coefficients)
        self._type, self._peek = alarm_record_type(lowered), peek
        self._limits = [(number, rule.heat.limit) for number, rule in enumerate(lowered) if rule.heat is not None]

    def take(self, row: Row) -> list[float | None]:
        """See :meth:`Heat.take`."""
        record = np.frombuffer(self._peek(self._type.itemsize), dtype=self._type)[0]
        return [100.0 * int(record[f"heat.{number}.sum"]) / limit for number, limit in self._limits]


class HeatFromRows:
    """The sums that a board would have which took what its rows say, held until the next one.

    Parameters
    ----------
    coefficients
        The board's file.
    """

    told = "computed here from the rows"

    def __init__(self, coefficients: Coefficients) -> None:
        self.rules = heat_rules(coefficients)
        self._model, document = coefficients.model, coefficients.document
        self._lowered: list[LoweredHeat | None] = [
            lower_heat(document, self._model, rule) if isinstance(rule, MissingHeat) else None
            for rule in document.alarms
        ]
        self._limits = [(number, rule.limit) for number, rule in enumerate(self._lowered) if rule is not None]
        self._block = next((rule.block for rule in self._lowered if rule is not None), 1)
        self._watched = watched(self._lowered)
        self._reference: ReferenceHeat | None = None
        self._before: Row = {}
        self._pwm = 0
        self._begin_block()

    def take(self, row: Row) -> list[float | None]:
        """See :meth:`Heat.take`."""
        if self._reference is None:
            self._reference = ReferenceHeat(self._lowered, np.array([self._starts_settled(row)]))
        elif self._before:
            self._pass(self._reference, self._before, row)
        self._before = row
        measured = any(self._deviation(row, component) is not None for component in self._watched)
        if not measured and not self._counts.any():
            return [None] * len(self._limits)
        return [100.0 * int(self._reference.sums[number, 0]) / limit for number, limit in self._limits]

    def _pass(self, reference: ReferenceHeat, before: Row, row: Row) -> None:
        """Go through the samples after a row, up to the next one."""
        begin_s, end_s = before["time_s"] or 0.0, row["time_s"] or 0.0
        if (row.get("alarms") or 0.0) < (before.get("alarms") or 0.0):
            reference.reset(np.array([True]))  # somebody has ended the alarms
        step_s = self._model.sample_time
        first = int(np.floor(begin_s / step_s + _TO_THE_GRID)) + 1
        last = int(np.floor(end_s / step_s + _TO_THE_GRID))
        if last - first > HELD_S / step_s:  # nothing is known of the time between
            first = last
        then, now = (self._deviations(each) for each in (before, row))
        for sample in range(first, last + 1):
            arrived = sample == last and end_s - sample * step_s < _TO_THE_GRID
            share = (sample * step_s - begin_s) / (end_s - begin_s)
            self._sample(reference, before, now if arrived else self._between(then, before, row, share))
            if sample % self._block == 0:
                self._end_block(reference)

    def _sample(self, reference: ReferenceHeat, acting: Row, deviations: Sequence[int | None]) -> None:
        pwm = int(acting["pwm"] or 0)
        if pwm != self._pwm:
            reference.change(np.array([abs(pwm - self._pwm)]))
            self._pwm = pwm
        for place, value in enumerate(deviations):
            if value is not None:
                self._sums[place] += min(max(value, -MOST_DEVIATION_mK), MOST_DEVIATION_mK)
                self._counts[place] += 1

    def _begin_block(self) -> None:
        self._sums, self._counts = (np.zeros(len(self._watched), dtype=np.int64) for _ in range(2))

    def _end_block(self, reference: ReferenceHeat) -> None:
        means = truncated(self._sums * PER_mK, np.maximum(self._counts, 1))
        present = self._counts > 0
        reference.end_block(np.array([abs(self._pwm)]), means[:, None], present[:, None], np.array([True]))
        self._begin_block()

    def _deviations(self, row: Row) -> list[int | None]:
        return [self._deviation(row, component) for component in self._watched]

    def _deviation(self, row: Row, component: int) -> int | None:
        """Measured minus model of a part, in thousandths of a kelvin."""
        name = self._model.component_names[component]
        measured, model = row.get(f"{name}_degC"), row.get(f"{name}_model_degC")
        return None if measured is None or model is None else round(1000.0 * measured) - round(1000.0 * model)

    def _between(self, then: Sequence[int | None], before: Row, row: Row, share: float) -> list[int | None]:
        """Between two rows what was measured is held, and the model runs straight."""
        found: list[int | None] = []
        for place, value in enumerate(then):
            column = f"{self._model.component_names[self._watched[place]]}_model_degC"
            a, b = before.get(column), row.get(column)
            moved = 0.0 if a is None or b is None else 1000.0 * share * (b - a)
            found.append(None if value is None else value - round(moved))
        return found

    def _starts_settled(self, row: Row) -> bool:
        """Whether the model's slopes are known: at its first row the board was cold."""
        room = row.get("ambient_degC", self._model.ambient_fixed)
        measured = [row.get(f"{name}_degC") for name in self._model.component_names]
        if room is None or (row["time_s"] or 0.0) > _FIRST_S:
            return False
        return all(value is not None and abs(value - room) <= COLD_mK / 1000.0 for value in measured)
