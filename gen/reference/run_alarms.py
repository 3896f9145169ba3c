"""The alarms that a coefficient file's rules raise on a measured run."""

from __future__ import annotations

from collections.abc import Mapping

from gen.arrays import FloatArray
from gen.coefficients import Coefficients
from gen.lowering.alarms import lower_alarms
from gen.reference.first_alarms import first_raised
from gen.reference.sampled import sampled
from gen.runs import Run


def raised_s(coefficients: Coefficients, run: Run, model_degC: Mapping[str, FloatArray]) -> dict[str, float]:
    """Give when each rule's alarm is first raised, if nobody resets it.

    The board's own judgement (:func:`first_raised`) on what it would be given (:func:`sampled`).

    Parameters
    ----------
    coefficients
        Model and rules.
    run
        What was measured.
    model_degC
        The model's temperatures at the run's rows by component, shape (N,) each.

    Returns
    -------
    dict
        By rule, in the file's order: time in the run, s. Rules that are not raised are missing.
    """
    rules = lower_alarms(coefficients)
    given = sampled(coefficients.model, run, model_degC)
    if not rules or not given.time_s.size:
        return {}
    first = first_raised(rules, given.pwm, given.measured_mC, given.model_mC, given.valid, trusted=given.trusted)
    return {rule.name: float(given.time_s[at]) for rule, at in zip(rules, first, strict=True) if at is not None}
