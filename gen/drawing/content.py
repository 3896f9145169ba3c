"""From a run file, and a model if there is one, to what is drawn of it."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from gen.arrays import FloatArray
from gen.coefficients import Coefficients
from gen.drawing import alarms
from gen.drawing.faults import declared
from gen.drawing.section import Bar, Curve, Panel, Section, shown
from gen.lowering.alarms import LoweredRule, lower_alarms
from gen.reference.simulate import simulate_run
from gen.replay import read_for
from gen.runs import Run, read_run
from gen.runs.drive import drive_of
from gen.runs.events import events

_MODEL = "_model_degC"
_STATUS = ("flags", "sensors", "protection", alarms.COLUMN)
_MOST_PANELS = 12


def section_of(path: Path, coefficients: Coefficients | None) -> Section:
    """Read a run and gather what is drawn of it.

    Parameters
    ----------
    path
        The run file.
    coefficients
        The model to show beside it, as `gen simulate --arithmetic exact` runs it; None: the board's own temperatures,
        where the run file has them.

    Raises
    ------
    InputError
        With file, line and column of what is wrong with the run, or what the model lacks in it.
    """
    run = read_run(path) if coefficients is None else read_for(coefficients, path)
    model = _recorded_model(run) if coefficients is None else _simulated(coefficients, run, str(path))
    measured = _temperatures(run)
    parts = list(dict.fromkeys([*model, *measured]))
    places = {name: place for place, name in enumerate(parts)}
    rules = lower_alarms(coefficients) if coefficients is not None else ()
    bars = _bars(path, run, coefficients, model)
    panels = [
        _temperature_panel(run, measured, model, places),
        *_residual_panel(run, measured, model, places, rules),
        Panel(_input_title(run, coefficients), (Curve("PWM", "held", None, run.pwm.astype(np.float64)),), 1.0),
        *_channel_panels(run),
    ]
    return Section(
        title=shown(path.stem),
        notes=tuple(_notes(coefficients, measured, model)),
        time_s=run.time_s,
        panels=tuple(panels),
        bars=tuple(bars),
        parts=tuple((shown(name), place) for name, place in places.items()),
    )


def _input_title(run: Run, coefficients: Coefficients | None) -> str:
    """What the counts are, and what they stand for where the file or the run says so."""
    meaning = "" if coefficients is None else coefficients.document.input.meaning
    drive = drive_of(run.comments)
    if not meaning and drive is not None and not drive.is_pwm:
        meaning = drive.text()
    return f"PWM, counts ({shown(meaning)})" if meaning else "PWM, counts"


def _simulated(coefficients: Coefficients, run: Run, file: str) -> dict[str, FloatArray]:
    columns = simulate_run(coefficients, run, "exact", "auto", file)
    return {name: np.asarray(columns[f"{name}_degC"], np.float64) for name in coefficients.model.component_names}


def _recorded_model(run: Run) -> dict[str, FloatArray]:
    """What the board's model said, by part."""
    own = {name.removesuffix(_MODEL): values for name, values in run.extras.items() if name.endswith(_MODEL)}
    return {name: values for name, values in own.items() if name in run.temps}


def _temperatures(run: Run) -> dict[str, FloatArray]:
    """Every temperature that was measured, but the ambient; columns without a value are left out."""
    found = dict(run.temps)
    for name, values in run.extras.items():
        if name.endswith("_degC") and not (name.endswith(_MODEL) and name.removesuffix(_MODEL) in run.temps):
            found[name.removesuffix("_degC")] = values
    return {name: values for name, values in found.items() if np.isfinite(values).any()}


def _temperature_panel(
    run: Run, measured: Mapping[str, FloatArray], model: Mapping[str, FloatArray], places: Mapping[str, int]
) -> Panel:
    curves = [Curve(shown(name), "measured", places[name], values) for name, values in measured.items()]
    curves += [Curve(shown(name), "model", places[name], values) for name, values in model.items()]
    if run.ambient is not None and np.isfinite(run.ambient).any():
        curves.insert(0, Curve("ambient", "measured", None, run.ambient))
    return Panel("temperature, °C", tuple(curves), 4.0)


def _residual_panel(
    run: Run,
    measured: Mapping[str, FloatArray],
    model: Mapping[str, FloatArray],
    places: Mapping[str, int],
    rules: tuple[LoweredRule, ...],
) -> list[Panel]:
    curves = []
    for number, name in enumerate(model):
        if name not in measured:
            continue
        for side in ("above", "below"):
            edge = alarms.band(rules, number, side, run.pwm)
            if edge is not None:
                curves.append(Curve(shown(name), "band", places[name], edge))
    both = [name for name in model if name in measured]
    curves += [Curve(shown(name), "measured", places[name], measured[name] - model[name]) for name in both]
    return [Panel("measured − model, K", tuple(curves), 2.5, zero=True)] if curves else []


def _channel_panels(run: Run) -> list[Panel]:
    """Other columns, those of one unit together; the unit is the letters that stand last in a column's name."""
    by_unit: dict[str, list[Curve]] = {}
    for name, values in run.extras.items():
        if name.endswith("_degC") or name in _STATUS or not np.isfinite(values).any():
            continue
        unit = name.rpartition("_")[2] if re.search(r"._[^\W\d_]+$", name) else ""
        own = by_unit.setdefault(unit or name, [])
        own.append(Curve(shown(name), "measured", len(own) or None, values))
    panels = []
    for curves in by_unit.values():
        named = ", ".join(curve.name for curve in curves)
        panels.append(Panel(shown(named), tuple(curves), 1.0))
    return panels[:_MOST_PANELS]


def _bars(path: Path, run: Run, coefficients: Coefficients | None, model: Mapping[str, FloatArray]) -> list[Bar]:
    said = events(path) if path.is_file() else []
    own = coefficients is not None and run.comments.get("coefficients_sha256") == coefficients.sha256
    names = [rule.name for rule in coefficients.document.alarms] if coefficients is not None and own else []
    bars = declared(run.comments, float(run.time_s[0]), float(run.time_s[-1]))
    bars += alarms.recorded(run, said, names)
    if coefficients is not None:
        bars += alarms.derived(coefficients, run, model)
    return bars


def _notes(
    coefficients: Coefficients | None, measured: Mapping[str, FloatArray], model: Mapping[str, FloatArray]
) -> list[str]:
    notes = []
    if coefficients is not None:
        notes.append(f"Model: {coefficients.name}, exact solution from the first measured temperatures.")
    elif model:
        notes.append("Model: what the board's own said while it ran.")
    for name in model:
        if name not in measured:
            notes.append(f"{shown(name)}: the run has no measured temperature (column {shown(name)}_degC).")
    unmodelled = [shown(name) for name in measured if name not in model] if model else []
    if unmodelled:
        notes.append(f"Measured without a model: {', '.join(unmodelled)}.")
    if not measured:
        notes.append("The run has no measured temperature.")
    return notes
