"""Found effects as entries of the coefficient file, with what speaks for them."""

from __future__ import annotations

import numpy as np

from gen.coefficients.effects import EffectEntry
from gen.coefficients.messages import building
from gen.model.effects import calibration
from gen.refinement.parts.candidates import Found, Tracing


def effect_entries(tracing: Tracing, *, explained: bool) -> list[EffectEntry]:
    """All that tracing found, most important first; parameters are those of the last joint fit.

    Parameters
    ----------
    tracing
        What was found.
    explained
        Whether the effects explain the residual: only then is the name of one without look-alikes certain.

    Raises
    ------
    InputError
        When a parameter is none that the format allows.
    """
    with building():
        entries = [*(entry(found, tracing) for found in tracing.found), *_calibrations(tracing)]
    return [_with_confidence(made, explained) for made in entries]


def _with_confidence(made: EffectEntry, explained: bool) -> EffectEntry:
    confident = explained and not made.evidence["lookalikes"]
    return made.model_copy(update={"evidence": {**made.evidence, "confident": confident}})


def _calibrations(tracing: Tracing) -> list[EffectEntry]:
    """Offsets within the sensors' tolerance that were fitted beside accepted effects.

    They are no finding of their own (so none is written for a component without an effect), but the effects' parameters
    hold beside them only.
    """
    made = []
    effect = calibration()
    for name in dict.fromkeys(found.component for found in tracing.found):
        final = tracing.final[name]
        noise = float(tracing.problem.noise_K[tracing.problem.components.index(name)])
        offset = float(final.offset[0])
        if any(term.effect is effect for term in final.terms) or abs(offset) < 0.5 * noise:
            continue
        made.append(
            EffectEntry(
                name=effect.name,
                component=name,
                parameters=effect.calibrated(offset),
                evidence={
                    "within_tolerance": True,
                    "note": f"within the sensor's tolerance of {effect.tolerance_K:g} K; fitted with the others",
                    "lookalikes": [],
                },
            )
        )
    return made


def entry(found: Found, tracing: Tracing) -> EffectEntry:
    """One effect, with what the data say of it."""
    name, candidate = found.component, found.candidate
    final = tracing.final[name]
    at = next(i for i, term in enumerate(final.terms) if term.effect.name == candidate.effect.name)
    values = final.values(0)[at]
    intervals = {}
    for i, free in enumerate(candidate.variant.free, start=final.first_free(at)):
        value, spread = float(final.numbers[0, i]), 2.0 * float(final.spread[0, i])
        if not np.isfinite(spread):
            ends = [free.low, free.high]
        elif free.log:
            ends = [value * float(np.exp(-min(spread, 20.0))), value * float(np.exp(min(spread, 20.0)))]
        else:
            ends = [value - spread, value + spread]
        intervals[free.name] = [max(ends[0], free.low), min(ends[1], free.high)]
    experiments = candidate.effect.lookalikes
    judgement = candidate.judgement
    return EffectEntry(
        name=candidate.effect.name,
        component=name,
        parameters=values,
        evidence={
            "left_out_rmse_K": {"before": judgement.before_K, "after": judgement.after_K},
            "p_value": judgement.p_value,
            "level": tracing.level,
            "judged_on": "stretches of runs, as each speed was run once"
            if candidate.by_stretch
            else tracing.problem.left_out_parts,
            "intervals_95": intervals,
            "lookalikes": [
                {
                    "name": other.effect.name,
                    "left_out_rmse_K": other.judgement.after_K,
                    "told_apart_by": experiments.get(
                        other.effect.name, other.effect.lookalikes.get(candidate.effect.name, "")
                    )
                    or "vary what drives the one while the other's drive is held, for two hours each",
                }
                for other in found.lookalikes
            ],
        },
    )
