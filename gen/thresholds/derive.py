"""Error bands and thresholds from a healthy motor's deviations.

**Band**: lowest and highest deviation of any healthy run within a range of PWM. **Margin**: what a further healthy run
may lie beyond it: the scatter of the runs' own extremes, and no less than two counts of the converter. A rule's missing
numbers follow from these two; what its author has written stays.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from gen.coefficients import Coefficients
from gen.coefficients.document import Document
from gen.coefficients.provenance import ErrorBand
from gen.coefficients.rules import RuleDraft
from gen.errors import InputError
from gen.thresholds.healthy import MEAN_S, SETTLE_S, HealthyRun, differences
from gen.thresholds.missing_heat import with_heat

LEAST_MARGIN_K = 0.5
"""Two counts of a MAX6675."""
HALF_HOUR_S = 1800.0
"""A CUSUM's threshold is the margin for so long."""
HEADROOM_K = 10.0
"""An over-temperature limit over the hottest healthy reading, moved to the warmest declared ambient."""
_LIMIT_STEP_DEGC = 5.0


@dataclass(frozen=True)
class Spread:
    """Healthy deviations of a quantity.

    Attributes
    ----------
    low_K, high_K
        Of any run.
    scatter_K
        Standard deviation of the runs' own extremes about their range's mean, pooled over the ranges; of both sides
        the larger one.
    runs
        How many runs took part.
    """

    low_K: float
    high_K: float
    scatter_K: float
    runs: int

    @property
    def margin_K(self) -> float:
        """What goes beyond the band, rounded up to hundredths."""
        return math.ceil(max(LEAST_MARGIN_K, self.scatter_K) * 100.0 - 1e-9) / 100.0


def spread(runs: Sequence[HealthyRun], component: str, ranges: Sequence[tuple[int, int]]) -> Spread:
    """Spread of a component's deviation over ranges of |PWM|, both ends included.

    Raises
    ------
    InputError
        When no run says anything about it.
    """
    sides: list[list[float]] = [[], []]
    lows, highs, took = [], [], set()
    for span in ranges:
        extremes = {run.name: ends for run in runs if (ends := _extremes(run, component, span)) is not None}
        took |= set(extremes)
        for number, side in enumerate(sides):
            own = np.array([ends[number] for ends in extremes.values()])
            if own.size > 1:
                side += ((own - own.mean()) * math.sqrt(own.size / (own.size - 1))).tolist()
        lows += [ends[0] for ends in extremes.values()]
        highs += [ends[1] for ends in extremes.values()]
    if not took:
        raise InputError(f"the healthy runs say nothing about {component} that has settled for {SETTLE_S:g} s")
    scatter = max((math.sqrt(float(np.mean(np.square(side)))) for side in sides if side), default=0.0)
    return Spread(min(lows), max(highs), scatter, len(took))


def _extremes(run: HealthyRun, component: str, span: tuple[int, int]) -> tuple[float, float] | None:
    values = run.deviation_K.get(component)
    if values is None:
        return None
    mine = values[(run.pwm >= span[0]) & (run.pwm <= span[1]) & ~np.isnan(values)]
    return (float(mine.min()), float(mine.max())) if mine.size else None


def error_bands(document: Document, runs: Sequence[HealthyRun]) -> list[ErrorBand]:
    """The file's bands, with what the healthy runs show in their place.

    A band between speeds without a healthy run spans those of its two neighbours that have one. A file without bands
    gets one over its validity range; a component of which the runs say nothing keeps what the file declares.
    """
    entries: list[ErrorBand] = []
    for component in document.component_names:
        declared = _declared(document, component)
        spans = [band.pwm for band in declared] or [document.validity.pwm]
        found = [_range(runs, component, span) for span in spans]
        if not any(found):
            entries += declared
            continue
        for i, span in enumerate(spans):
            if span[1] == 0:  # at rest no rule needs it, and no run is healthy or faulty
                entries += [band for band in declared if band.pwm == span]
            else:
                entries.append(_band(component, span, i, found))
    return entries


_Seen = tuple[float, float, int]
"""Lowest and highest deviation in K, and how many runs showed it."""


def _band(component: str, span: tuple[int, int], i: int, found: Sequence[_Seen | None]) -> ErrorBand:
    """The band of the i-th span of speeds: what runs there show, or else those of the nearest spans on both sides."""
    below, above = [item for item in found[:i] if item], [item for item in found[i + 1 :] if item]
    own = found[i]
    ends = [own] if own else [*below[-1:], *above[:1]]
    low, high = min(item[0] for item in ends), max(item[1] for item in ends)
    where = "" if own else " at the speeds beside it"
    return ErrorBand(
        component=component,
        pwm=span,
        model_minus_measured_K=(round(-high, 3), round(-low, 3)),
        note=f"{max(item[2] for item in ends)} healthy runs{where}, means over {MEAN_S:g} s "
        f"from {SETTLE_S:g} s after a change of PWM",
    )


def _declared(document: Document, component: str) -> list[ErrorBand]:
    return [band for band in (document.provenance.error if document.provenance else ()) if band.component == component]


def _range(runs: Sequence[HealthyRun], component: str, span: tuple[int, int]) -> _Seen | None:
    """Lowest and highest deviation of any run in a range of |PWM|, and how many runs were there."""
    found = [ends for run in runs if (ends := _extremes(run, component, span)) is not None]
    if not found:
        return None
    return min(ends[0] for ends in found), max(ends[1] for ends in found), len(found)


def complete(rule: RuleDraft, coefficients: Coefficients, runs: Sequence[HealthyRun], hours: float) -> RuleDraft:
    """Give a rule with its missing numbers, and a note that says where they come from.

    Parameters
    ----------
    rule
        As in the rules file. A rule whose threshold is missing counts from the error band unless it is relative.
    coefficients, runs
        The model and its healthy runs.
    hours
        Wanted mean time between two false alarms, for rules that hold a rate.

    Raises
    ------
    InputError
        When the runs do not say enough.
    """
    if not rule.lacks_threshold:
        return rule
    document = coefficients.document
    if rule.kind == "missing_heat":
        return with_heat(rule, coefficients, runs, hours)
    if rule.kind == "over_temperature":
        return _with_limit(rule, document, runs)
    bands = [band.pwm for band in _declared(document, rule.component) if band.pwm[1] > 0]
    spans = bands or [document.validity.pwm]
    if rule.relative_to is not None:
        return _with_difference(rule, rule.relative_to, spans, runs)
    seen = spread(runs, rule.component, spans)
    of = f"Counted from the range of {seen.runs} healthy runs at the present speed (provenance.error)"
    if rule.kind == "cusum":
        return rule.completed(
            beyond="error_band",
            slack_K=0.0,
            threshold_K_s=round(seen.margin_K * HALF_HOUR_S, 1),
            note=f"{of}; the sum is the margin for half an hour. {_margin_text(seen)}",
        )
    return rule.completed(
        beyond="error_band",
        threshold_K=seen.margin_K,
        hysteresis_K=round(seen.margin_K / 2.0, 3),
        note=f"{of}; the threshold is the margin beyond. {_margin_text(seen)}",
    )


def _with_difference(
    rule: RuleDraft, other: str, spans: Sequence[tuple[int, int]], runs: Sequence[HealthyRun]
) -> RuleDraft:
    both = differences(runs, rule.component, other)
    if not both:
        raise InputError(f"no healthy run has both {rule.component} and {other}")
    seen = spread(both, rule.component, spans)
    end = -seen.low_K if rule.kind == "below_model" else seen.high_K
    of = f"{rule.component} minus {other}: {seen.low_K:+.2f}..{seen.high_K:+.2f} K in {seen.runs} healthy runs"
    return rule.completed(
        threshold_K=max(0.0, round(end + seen.margin_K, 3)),
        hysteresis_K=round(seen.margin_K / 2.0, 3),
        note=f"{of}, and the margin beyond. {_margin_text(seen)}",
    )


def _with_limit(rule: RuleDraft, document: Document, runs: Sequence[HealthyRun]) -> RuleDraft:
    name = rule.component
    rises = [run.hottest_rise_K[name] for run in runs if name in run.hottest_rise_K]
    if not rises:
        raise InputError(f"the healthy runs say nothing about {name}")
    warmest = document.domain.ambient_degC[1]
    return rule.completed(
        limit_degC=math.ceil((max(rises) + warmest + HEADROOM_K) / _LIMIT_STEP_DEGC) * _LIMIT_STEP_DEGC,
        hysteresis_K=5.0,
        note=f"{max(rises):.1f} K over ambient was the most in {len(rises)} healthy runs; at the warmest declared "
        f"ambient of {warmest:g} degC and with {HEADROOM_K:g} K to spare. A limit of the material, where known, goes "
        "before.",
    )


def _margin_text(seen: Spread) -> str:
    return (
        f"Margin {seen.margin_K:g} K: the larger of {LEAST_MARGIN_K:g} K (two counts of the converter) and the "
        f"standard deviation of the runs' extremes, {seen.scatter_K:.2f} K."
    )
