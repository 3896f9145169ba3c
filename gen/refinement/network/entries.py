"""What was found as the JSON summary has it."""

from __future__ import annotations

from typing import Any

import numpy as np

from gen.model.effects import registry
from gen.refinement.gains import LEVEL
from gen.refinement.network.ambient import MovingAmbient
from gen.refinement.network.effects.base import WHOLE
from gen.refinement.network.effects.warm_inside import NAME as INITIAL_STATE
from gen.refinement.network.fitting.fit import Fitted
from gen.refinement.network.fitting.folds import described
from gen.refinement.network.tracing.search import Considered, Step
from gen.refinement.network.tracing.trace import Traced
from gen.refinement.network.tracing.warm_start import WarmStart

INTERVAL = 1.96
AMBIENT = "ambient"
GENERIC = "vary what drives the one while the other's drive is held, for two hours each"


def ambient_entry(room: MovingAmbient, later: int) -> dict[str, Any]:
    """The measured ambient in the place of a fixed one, as the summary has it."""
    return {
        "name": AMBIENT,
        "title": registry()[AMBIENT].title,
        "component": WHOLE,
        "parameters": {"channel": room.channel},
        "evidence": {
            "left_out_rmse_K": {"before": room.fixed_K, "after": room.measured_K},
            "p_value": room.p_value,
            "level": LEVEL,
            "judged_on": described(later),
            "intervals_95": {},
            "lookalikes": [],
        },
    }


def start_entry(start: WarmStart) -> dict[str, Any]:
    """Hidden nodes that begin warmer than the file lets them, as the summary has it."""
    return {
        "name": INITIAL_STATE,
        "title": registry()[INITIAL_STATE].title,
        "component": WHOLE if len(start.factors) > 1 else next(iter(start.factors)),
        "parameters": {f"start_factor_of_{name}": factor for name, factor in start.factors.items()},
        "evidence": {
            "left_out_rmse_K": {"before": start.file.score_K, "after": start.with_factors.score_K},
            "p_value": start.p_value,
            "level": LEVEL,
            "judged_on": "each later run, with factors from the others",
            "intervals_95": {},
            "lookalikes": [],
        },
    }


def effect_entry(step: Step, found: Considered, traced: Traced, change: str, *, written: bool) -> dict[str, Any]:
    """One effect as the summary has it.

    Parameters
    ----------
    step, found
        The search that added it, and what it added.
    traced
        All that was found: its numbers are those of the last fit.
    change
        Why it may be another motor; empty for an effect.
    written
        Whether the file holds it.
    """
    final = traced.final.fitted
    place = next(k for k, effect in enumerate(final.shape.effects) if effect is found.effect)
    values = traced.values[found.effect]
    listed = registry().get(found.effect.name)  # some are there in networks alone
    note = change or found.effect.note
    return {
        "name": found.effect.name,
        "title": found.effect.title_of(values) or (listed.title if listed else found.effect.name),
        "component": found.effect.component,
        "near": list(final.shape.network.near(found.effect.component)),
        "changed": bool(change),
        "written": written,
        "parameters": {
            **found.effect.acts_by,
            **{number.name: value for number, value in zip(found.effect.numbers, values, strict=True)},
        },
        "evidence": {
            "left_out_rmse_K": {"before": step.without.score_K, "after": found.judged.score_K},
            "p_value": found.p_value,
            "level": LEVEL,
            "judged_on": described(traced.data.later),
            "intervals_95": _intervals(final, place),
            "lookalikes": [
                {
                    "name": other.effect.name,
                    "component": other.effect.component,
                    "left_out_rmse_K": other.judged.score_K,
                    "told_apart_by": listed.lookalikes.get(other.effect.name, GENERIC) if listed else GENERIC,
                }
                for other in step.lookalikes
            ],
            **({"note": note} if note else {}),
        },
    }


def _intervals(fitted: Fitted, place: int) -> dict[str, list[float]]:
    """95 % intervals of an effect's numbers, from the last linearised problem."""
    matrix, _ = fitted.problem.assembled(fitted.fit.normal, fitted.vector)
    deviation = np.sqrt(np.maximum(np.diag(np.linalg.inv(matrix)), 0.0))
    made = {}
    effect, columns = fitted.shape.effects[place], fitted.shape.places[place].columns
    for number, column in zip(effect.numbers, columns.tolist(), strict=True):
        half = INTERVAL * float(deviation[column])
        ends = [number.value(float(fitted.vector[column]) + side * half) for side in (-1.0, 1.0)]
        made[number.name] = [max(ends[0], number.low), min(ends[1], number.high)]
    return made


def considered_entry(step: Step) -> dict[str, Any]:
    """What one search looked at."""
    return {
        "without_K": step.without.score_K,
        "candidates": [
            {
                "name": one.effect.name,
                "component": one.effect.component,
                "left_out_rmse_K": one.judged.score_K,
                "p_value": one.p_value,
                "against": list(one.reasons),
            }
            for one in step.considered
        ],
    }
