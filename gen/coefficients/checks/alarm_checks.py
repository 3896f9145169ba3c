"""Alarm rules against the error that the coefficient file itself declares for its model."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

from gen.coefficients.alarms import AlarmRule, Cusum, Deviation, MissingHeat, ModelRule, OverTemperature, window_counts
from gen.coefficients.document import Document
from gen.coefficients.provenance import ErrorBand

Quantity = Literal["above", "below", "measured", "heat"]
"""Measured minus model, model minus measured, the measured temperature itself, or the heat that the model lacks."""


def check_alarms(document: Document) -> tuple[str, ...]:
    """Warn of every rule that a healthy motor may trip, by the file's own error bands.

    Returns
    -------
    tuple of str
        Warnings.
    """
    bands = document.provenance.error if document.provenance else ()
    warnings = []
    for index, rule in enumerate(document.alarms):
        if not isinstance(rule, ModelRule) or rule.beyond == "error_band" or rule.relative_to is not None:
            continue
        key, threshold = ("slack_K", rule.slack_K) if isinstance(rule, Cusum) else ("threshold_K", rule.threshold_K)
        declared = {
            pwm: value
            for pwm in window_counts(rule, document.input.full_scale)
            if (value := declared_deviation_K(bands, rule, pwm)) is not None
        }
        if not declared:
            continue
        pwm = max(declared, key=lambda count: declared[count])
        if declared[pwm] >= threshold:
            side = f"{quantity(rule)} the model"
            warnings.append(
                f'$.alarms[{index}].{key}: the rule "{rule.name}" trips at {threshold:g} K {side}, and '
                f"provenance.error has a healthy {rule.component} up to {declared[pwm]:g} K {side} at PWM {pwm}: "
                'expect false alarms, or choose "beyond": "error_band"'
            )
    return tuple(warnings)


def declared_deviation_K(bands: Sequence[ErrorBand], rule: Deviation | Cusum, pwm: int) -> float | None:
    """How far a healthy motor may be on the rule's side of the model at a |PWM|, by the file's own error bands.

    Returns
    -------
    float or None
        In K, negative if it lies on the other side; None if the file declares nothing there.
    """
    own = [band for band in bands if band.component == rule.component and band.pwm[0] <= pwm <= band.pwm[1]]
    if not own:
        return None
    if quantity(rule) == "above":
        return max(-band.model_minus_measured_K[0] for band in own)
    return max(band.model_minus_measured_K[1] for band in own)


def healthy_end_K(document: Document, rule: Deviation | Cusum, counts: range) -> dict[int, float]:
    """Give the error band's end on the rule's side at each |PWM|, which may lie on the other side of the model.

    Where nothing is declared the widest end holds, and not less than the model itself.
    """
    bands = document.provenance.error if document.provenance else ()
    found = {pwm: declared_deviation_K(bands, rule, pwm) for pwm in counts}
    everywhere = (declared_deviation_K(bands, rule, pwm) for pwm in range(document.input.full_scale + 1))
    widest = max((value for value in everywhere if value is not None), default=0.0)
    return {pwm: max(0.0, widest) if value is None else value for pwm, value in found.items()}


def quantity(rule: AlarmRule) -> Quantity:
    """What a rule compares with its threshold."""
    if isinstance(rule, OverTemperature):
        return "measured"
    if isinstance(rule, MissingHeat):
        return "heat"
    if isinstance(rule, Cusum):
        return rule.direction
    return "above" if rule.kind == "above_model" else "below"
