"""An effect that gen does not have, and runs of a motor with it by a generator that does not know the effect's code.

Oil under pressure is churned once it has been drawn in: ``H' = (|PWM|/full - H)/film``, ``E' = k H (p - p0) - rate E``.
It has a channel with a unit of its own, a reference parameter that is the channel's neutral value, and an inner state.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, ClassVar

import numpy as np
from pydantic import Field

from gen.arrays import FloatArray
from gen.coefficients import parse
from gen.model.effects import Effect, Free, Input, Lanes, Moment, Parameters, Setting, Values, Variant
from gen.runs import Run, write_run
from tests.examples import ROOT

GAUGE = "oil_bar"
PART = "casing"
AMBIENT = 30.0
CHURNING_K_PER_S_BAR, RESTING_BAR, FILM_S = 2.5e-3, 3.0, 900.0
STEP, EVERY, HOURS = 2.0, 4, 2.5


class ChurningParameters(Parameters):
    gauge: Annotated[str, Field(description="Column with the oil's pressure in bar.")] = GAUGE
    churning_K_per_s_bar: Annotated[float, Field(ge=-1.0, le=1.0, description="Heating k for each bar.")]
    resting_bar: Annotated[float, Field(ge=0.0, le=10.0, description="Pressure p0 of the identification.")]
    film_s: Annotated[float, Field(ge=5.0, le=40000.0, description="Time in which the oil is drawn in, s.")]


class Churning(Effect):
    """Oil that is churned where the shaft turns in it."""

    name = "oil_churning"
    title = "oil that is churned under pressure"
    equation = "H' = (|PWM|/full - H)/film;  E' = k H (p - p0) - rate E"
    parameters = ChurningParameters
    inputs = (Input("gauge", units=("_bar",), quantity="oil pressure", neutral="resting_bar", limits=(0.0, 10.0)),)
    signature = "the error follows the oil's pressure, and only once the motor has run for a while"
    lookalikes: ClassVar[Mapping[str, str]] = {"hidden_node": "vary the pressure at constant speed for 2 h"}

    def variants(self, setting: Setting) -> list[Variant]:
        made = []
        for column in setting.ending("_bar"):
            mean = setting.channels[column]
            free = (
                Free("churning_K_per_s_bar", setting.rate, -1.0, 1.0),
                Free("resting_bar", 0.8 * mean, 0.0, 10.0, role="reference"),
                Free("film_s", 0.3 / setting.rate, 5.0, 40000.0, log=True, role="time constant"),
            )
            made.append(Variant({"gauge": column}, free))
        return made

    def inner(self, p: Values, m: Moment) -> tuple[Lanes, Lanes] | None:
        return m.pwm, p["film_s"]

    def heat(self, p: Values, m: Moment) -> Lanes:
        return p["churning_K_per_s_bar"] * m.inner * (m.channels[p["gauge"]] - p["resting_bar"])


def document() -> dict[str, Any]:
    """The MY1016's casing alone, of order 1."""
    made: dict[str, Any] = json.loads((ROOT / "examples" / "my1016" / "coeffs.json").read_text(encoding="utf-8"))
    made["components"] = [part for part in made["components"] if part["name"] == PART]
    return made | {"alarms": [], "wiring": None, "provenance": None, "ambient": {"fixed_degC": AMBIENT}}


def write_runs(folder: Path, count: int) -> list[Path]:
    """Runs of the casing with churned oil: Heun's rule on the equations written out, noise, readings of 0.25 K."""
    casing = parse(json.dumps(document()).encode()).model.component(PART)
    levels = np.arange(256)
    rate = casing.denominator(levels)[:, -1]
    heat = casing.effective_gain(levels) * levels
    random = np.random.default_rng(71)
    paths = []
    for number in range(count):
        steps = int(HOURS * 3600 / STEP) + 1
        pwm = _pieces(random, steps, 2000.0, [0, 77, 128, 179, 230, 255]).astype(np.int64)
        pressure = _pieces(random, steps, 1300.0, [1.0, 2.0, 3.5, 5.0, 6.0])
        y = np.array([random.uniform(0.0, 4.0), 0.0])  # rise, oil that is drawn in
        course = np.empty(steps)
        for k in range(steps):
            course[k] = y[0]
            first = _slope(y, pwm[k], pressure[k], rate, heat)
            y = y + 0.5 * STEP * (first + _slope(y + STEP * first, pwm[k], pressure[k], rate, heat))
        rows = np.arange(0, steps, EVERY)
        shown = AMBIENT + course[rows] + random.normal(0.0, 0.15, rows.size)
        run = Run(
            time_s=np.asarray(rows * STEP, dtype=np.float64),
            pwm=pwm[rows],
            temps={PART: np.round(shown / 0.25) * 0.25},
            ambient=np.full(rows.size, AMBIENT),
            extras={GAUGE: pressure[rows], "vibration_g": np.round(random.normal(1.0, 0.2, rows.size), 3)},
        )
        paths.append(folder / f"run{number}.csv")
        write_run(paths[-1], run)
    return paths


def _slope(y: FloatArray, pwm: int, bar: float, rate: FloatArray, heat: FloatArray) -> FloatArray:
    churned = CHURNING_K_PER_S_BAR * y[1] * (bar - RESTING_BAR)
    return np.array([heat[pwm] + churned - rate[pwm] * y[0], (pwm / 255.0 - y[1]) / FILM_S])


def _pieces(random: np.random.Generator, steps: int, typical_s: float, values: list[float]) -> FloatArray:
    """Constant pieces; they change where a row is written."""
    out = np.empty(steps)
    at = 0
    while at < steps:
        length = int(random.uniform(0.5, 1.5) * typical_s / STEP) // EVERY * EVERY
        out[at : at + length] = random.choice(values)
        at += length
    return out
