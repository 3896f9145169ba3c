"""What was found, as plain numbers and words: the JSON summary, and what the report and the text are made of."""

from __future__ import annotations

from typing import Any

import numpy as np

from gen.identification.network.fitting.bends import BEND
from gen.identification.network.fitting.inputs import held
from gen.identification.network.fitting.natural import USUAL_K
from gen.identification.network.telling.forecast import bands
from gen.identification.network.telling.summary import INTERVAL, Summary
from gen.identification.network.telling.uncertainty import undetermined


def as_json(summary: Summary) -> dict[str, Any]:
    """Give everything as plain numbers and words."""
    result = summary.result
    structure = result.found.structure
    names = (*structure.names, "ambient")
    longest, slowest = summary.span_s
    return {
        "model": "network",
        "runs": [source.path for source in result.data.sources],
        "ambient": {
            "fixed_degC": result.data.ambient_fixed,
            "measured": result.data.ambient_measured,
            "unsure_K": result.data.ambient_unsure_K,
        },
        "verdict": summary.verdict,
        "warnings": summary.warnings(),
        "hidden_nodes": structure.hidden,
        "curves_bend": structure.bend == BEND,
        "heats_go_with": structure.driven or None,
        "natural_convection": _natural(summary),
        "heat_grows": _grows(summary),
        "candidates": [vars(candidate) for candidate in result.candidates],
        "left_out_K": result.judged.score_K,
        "longest_hold_s": longest,
        "slowest_time_constant_s": slowest,
        "components": {name: _component(summary, s) for s, name in enumerate(result.data.names)},
        "nodes": _nodes(summary),
        "paths": _paths(summary, names),
        "heats": _heats(summary, names),
        "heats_by_column": _heats_by_column(summary, names),
        "not_determined": [
            "the scale of all capacities, conductances and heats together",
            *undetermined(result.found, summary.spread, [one.column for one in result.data.driving]),
        ],
    }


def _grows(summary: Summary) -> dict[str, Any] | None:
    """By which share heats grow for each kelvin over a temperature, or None where that is not told apart."""
    found = summary.result.found
    if found.structure.warmth is None:
        return None
    place = found.structure.growing[0]
    value, deviation = float(found.vector[place]), float(summary.spread.deviation[place])
    return {
        "share_per_K": {"value": value, "interval": _interval(value, deviation)},
        "over_degC": found.structure.warmth,
    }


def _natural(summary: Summary) -> dict[str, Any] | None:
    """Natural convection's share of what surfaces lose at rest, or None where no part of it is told apart."""
    found = summary.result.found
    if not found.structure.natural:
        return None
    place = found.structure.still[0]
    logit, deviation = float(found.vector[place]), float(summary.spread.deviation[place])
    middle, low, high = (1.0 / (1.0 + np.exp(-(logit + by * deviation))) for by in (0.0, -INTERVAL, INTERVAL))
    return {"share_at_rest": {"value": float(middle), "interval": [float(low), float(high)]}, "at_K": USUAL_K}


def _component(summary: Summary, s: int) -> dict[str, Any]:
    result, steady = summary.result, summary.steady
    place = result.found.structure.offsets[s]
    speeds = {
        str(pwm): {
            "steady_rise_K": {
                "value": float(steady.rise[k, s]),
                "interval": _interval(float(steady.rise[k, s]), float(steady.deviation[k, s])),
            }
        }
        for k, pwm in enumerate(summary.speeds)
    }
    errors = [
        {
            "pwm": list(band.pwm),
            "model_minus_measured_K": [float(band.low[s]), float(band.high[s])],
            "rms_K": float(band.rms[s]),
        }
        for band in bands(result.inputs, result.judged, result.data.full_scale)
    ]
    offset = float(result.found.vector[place])
    return {
        "rms_K": {run.name: float(summary.rms_K[r, s]) for r, run in enumerate(result.data.fine)},
        "left_out_rms_K": float(summary.left_out_K[s]),
        "second_half_rms_K": _second_half(summary, s),
        "left_out": errors,
        "sensor_offset_K": {"value": offset, "interval": _interval(offset, float(summary.spread.deviation[place]))},
        "speeds": speeds,
    }


def _second_half(summary: Summary, s: int) -> float | None:
    """Of the only run, by a part, K; None where there are more, or nothing was read in it."""
    later = summary.later_K
    return None if later is None or not np.isfinite(later[s]) else float(later[s])


def _nodes(summary: Summary) -> list[dict[str, Any]]:
    structure, vector = summary.result.found.structure, summary.result.found.vector
    return [
        {
            "name": name,
            "sensed": i < len(structure.sensed),
            "capacity_J_per_K": _factor(float(vector[i]), float(summary.spread.deviation[i])),
            "determined_share": float(1.0 - min(summary.spread.share[i], 1.0)),
            **_start(summary, i),
        }
        for i, name in enumerate(structure.names)
    ]


def _start(summary: Summary, node: int) -> dict[str, Any]:
    """By how much more than it would rest at a hidden node begins; nothing where no run says."""
    found, hidden = summary.result.found, node - summary.result.found.structure.sensors
    if hidden < 0 or not found.structure.factors.size:
        return {}
    place = found.structure.factors[hidden]
    return {"start_factor": _factor(float(found.vector[place]), float(summary.spread.deviation[place]))}


def _paths(summary: Summary, names: tuple[str, ...]) -> list[dict[str, Any]]:
    structure, vector = summary.result.found.structure, summary.result.found.vector
    levels = held(np.array([0.0, 127.5, 255.0]), 255)
    conductance = structure.physical(levels, vector).conductance
    made = []
    for q, (i, j) in enumerate(structure.paths):
        level = structure.conductances[q].start + structure.laws[q].level
        made.append(
            {
                "between": [names[i], names[j]],
                "conductance_W_per_K": dict(
                    zip(("at_rest", "at_half_speed", "at_full_speed"), conductance[:, q].tolist(), strict=True)
                ),
                "determined_share": float(1.0 - min(summary.spread.share[level], 1.0)),
            }
        )
    return made


def _heats(summary: Summary, names: tuple[str, ...]) -> list[dict[str, Any]]:
    structure, vector = summary.result.found.structure, summary.result.found.vector
    heat = structure.physical(held(np.array([127.5, 255.0]), 255), vector).heat_in_room
    return [
        {"node": names[i], "power_W": {"at_half_speed": float(heat[0, i]), "at_full_speed": float(heat[1, i])}}
        for i in structure.heated
    ]


def _heats_by_column(summary: Summary, names: tuple[str, ...]) -> list[dict[str, Any]]:
    structure, vector = summary.result.found.structure, summary.result.found.vector
    driving = summary.result.data.driving
    return [
        {
            "node": names[i],
            "column": driving[number].column,
            "power": driving[number].power,
            "at": driving[number].largest,
            "power_W": _factor(float(vector[at]), float(summary.spread.deviation[at])),
        }
        for (number, i), at in zip(structure.fed, structure.feeds.tolist(), strict=True)
    ]


def _interval(value: float, sd: float) -> list[float]:
    return [value - INTERVAL * sd, value + INTERVAL * sd]


def _factor(log: float, sd: float) -> dict[str, Any]:
    bound = INTERVAL * min(sd, 5.0)
    return {"value": float(np.exp(log)), "interval": [float(np.exp(log - bound)), float(np.exp(log + bound))]}
