"""The coefficient file of an identified model, with what it is known to be off by."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np

from gen.arrays import FloatArray, IntArray
from gen.coefficients import Coefficients, Document, dump, parse
from gen.coefficients.base import told
from gen.coefficients.document import Accuracy, Ambient, Domain, Validity
from gen.coefficients.messages import building
from gen.coefficients.provenance import ERROR_WINDOWS, ErrorBand, Provenance
from gen.coefficients.versions import FORMAT, VERSION
from gen.errors import CheckFailed, InputError
from gen.identification.drive import input_entry
from gen.identification.logs.data import Data
from gen.identification.parts.bands import Band
from gen.identification.parts.identify import Identified
from gen.identification.parts.schedule_entries import component_entry
from gen.identification.settings import FIXED_LIMIT_K, FLOAT_LIMIT_K, Settings, said_beside


def coefficient_text(
    data: Data, found: Mapping[str, Identified], settings: Settings, note: str = ""
) -> tuple[str, Coefficients]:
    """Write the coefficient file's text, and read it back with every check.

    Parameters
    ----------
    data, found, settings
        The runs, what was found in them, and what they do not say.
    note
        What to say of the method beside it.

    Raises
    ------
    CheckFailed
        When the model that the runs led to is none that can be built.
    InputError
        When the settings contradict the runs.
    """
    measured = _measured_range(data, found, settings)
    try:
        with building():
            text = dump(_document(data, found, settings, measured, note))
        return text, parse(text.encode())
    except InputError as error:
        raise CheckFailed(f"the identified model is not one that can be built: {error}") from error


HIGHEST_K = 3000.0
"""A steady rise over this at full scale is no result: the runs show no sign of settling."""


def usable(data: Data, found: Mapping[str, Identified], settings: Settings) -> tuple[Data, dict[str, Identified]]:
    """Leave out components that cool when driven, or whose runs show no steady state; the data's warnings say which.

    Raises
    ------
    CheckFailed
        When none is left.
    """
    kept: dict[str, Identified] = {}
    reasons = []
    for name, item in found.items():
        rise = float(np.max(item.model.evaluate(np.array([float(settings.full_scale)]))[1]))
        fault = next((why for why in item.choice.chosen.rejected if why.startswith("negative gain")), None)
        if fault is not None:
            reasons.append(f"{name} is left out: {fault}")
        elif rise > HIGHEST_K:
            longest = max(record.duration for record in item.problem.records)
            reasons.append(
                f"{name} is left out: runs of up to {longest:.0f} s do not show where it settles "
                f"({rise:.0f} K at full scale would fit); expected longer runs"
            )
        else:
            kept[name] = item
    if not kept:
        raise CheckFailed("; ".join(reasons))
    return replace(data, warnings=(*data.warnings, *reasons)), kept


def _measured_range(data: Data, found: Mapping[str, Identified], settings: Settings) -> tuple[int, int]:
    low = min(item.range[0] for item in found.values())
    high = max(item.range[1] for item in found.values())
    if high > settings.full_scale:
        fastest = max(data.sources, key=lambda source: int(np.abs(source.run.pwm).max()))
        message = f"found |PWM| {high}, over the full scale of {settings.full_scale}; expected another --full-scale"
        raise InputError(message, file=str(fastest.path), place="column pwm")
    return low, high


def _document(
    data: Data, found: Mapping[str, Identified], settings: Settings, measured: tuple[int, int], note: str
) -> Document:
    still = any(item.standstill for item in found.values())
    # With cooling known, the schedules go on to PWM 0; above the fastest speed a table holds its end by itself.
    written = (0, settings.full_scale) if still else measured
    return Document(
        format=FORMAT,
        version=VERSION,
        name=settings.name,
        description=f"Identified from {len(data.sources)} run(s): {_speeds_text(found)}.",
        sample_time_s=settings.sample_time_s,
        input=input_entry(data.runs, settings.full_scale, settings.nominal_speed_rpm),
        ambient=Ambient(
            fixed_degC=data.ambient_fixed,
            channel="ambient_degC" if data.ambient_measured or data.ambient_fixed is None else None,
        ),
        validity=Validity(pwm=measured, outside="extrapolate" if still else "hold"),
        domain=_domain(data, found, settings),
        accuracy=Accuracy(fixed_limit_K=FIXED_LIMIT_K, float_limit_K=FLOAT_LIMIT_K),
        components=tuple(component_entry(name, item.model, *written) for name, item in found.items()),
        provenance=Provenance(
            source="gen identify",
            method="Output-error fit of transfer functions without zeros at each speed; order by the error on "
            "held-out data; schedules by leave-one-speed-out error in K; all parameters refined on the runs"
            f"{said_beside(note)}",
            data=tuple(Path(source.path).name for source in data.sources),
            fit={name: _figures(item) for name, item in found.items()},
            error=tuple(band for name, item in found.items() for band in error_bands(name, item)),
            ambient_degC=_ambients(data),
        ),
    )


def _speeds_text(found: Mapping[str, Identified]) -> str:
    speeds = sorted({p for item in found.values() for p in item.speeds})
    still = any(item.standstill for item in found.values())
    return f"PWM {', '.join(map(str, speeds))}{' and cooling at standstill' if still else ''}"


def _ambients(data: Data) -> tuple[float, float] | None:
    """Lowest and highest ambient of the runs, degC, as far as anything says it."""
    ambients = [a for s in data.sources if s.run.ambient is not None for a in s.run.ambient[np.isfinite(s.run.ambient)]]
    ambients += [data.ambient_fixed] if data.ambient_fixed is not None else []
    return (told(min(ambients)), told(max(ambients))) if ambients else None


def _domain(data: Data, found: Mapping[str, Identified], settings: Settings) -> Domain:
    known = _ambients(data) or ()
    cold, warm = min([-10.0, *known]), max([50.0, *known])
    hottest = max(float(np.max(r.raw_rise)) for item in found.values() for r in item.problem.records) + warm
    steady = max(float(np.max(item.band.steady)) for item in found.values()) + warm
    top = min(10.0 * math.ceil(max(150.0, 1.1 * hottest, 1.1 * steady) / 10.0), 5000.0)
    return Domain(
        pwm=(0, settings.full_scale),
        ambient_degC=(math.floor(cold), math.ceil(warm)),
        temperature_degC=(math.floor(cold), top),
    )


def _figures(item: Identified) -> dict[str, float]:
    chosen = item.criteria[item.choice.chosen.structure.name]
    result: dict[str, float] = {"order": float(item.choice.chosen.structure.order)}
    for pwm, figures in chosen.items():
        result[f"pwm_{pwm}_mse_K2"] = _round(figures.mse_K2)
        if math.isfinite(figures.fit_percent):
            result[f"pwm_{pwm}_fit_percent"] = _round(figures.fit_percent)
        result[f"pwm_{pwm}_steady_rise_sd_K"] = _round(_steady_sd(item, pwm))
        result[f"pwm_{pwm}_settled_share"] = _round(item.settled.get(pwm, 0.0))
    if item.general.chosen.left_out is not None:
        result["leave_one_speed_out_rms_K"] = _round(item.general.chosen.left_out.total)
    if item.offset_sd is not None and item.fit.offset:
        result["sensor_offset_K"] = _round(item.fit.offset)
    return result


def _steady_sd(item: Identified, pwm: int) -> float:
    layout = item.fit.layout
    return float(item.spread.deviation[layout.thetas + item.speeds.index(pwm)])


def error_bands(name: str, item: Identified) -> list[ErrorBand]:
    """One band a speed: what was measured there, widened to the neighbours' middle by what is not known in between."""
    speeds = item.speeds
    edges = [item.range[0], *((a + b) // 2 for a, b in pairwise(speeds)), item.range[1] + 1]
    bands = []
    if item.standstill:
        bands.append(_band(name, item, 0, (0, 0), 0.0))
    for i, pwm in enumerate(speeds):
        first, last = edges[i], max(edges[i + 1] - 1, edges[i])
        bands.append(_band(name, item, pwm, (first, last), _between(item, first, last)))
    return bands


def _band(name: str, item: Identified, pwm: int, span: tuple[int, int], unknown: float) -> ErrorBand:
    low, high = measured_error(item, pwm)
    note = f"at PWM {pwm}: {low:+.2f}..{high:+.2f} K in the runs"
    left = item.general.chosen.left_out
    if pwm and left is not None:
        note += f"; {left.rms_K[item.speeds.index(pwm)]:.2f} K rms when this speed is left out"
    if unknown >= 0.005:
        note += f"; widened by {unknown:.2f} K for the speeds around it"
    return ErrorBand(
        component=name,
        pwm=span,
        model_minus_measured_K=(_round(low - unknown), _round(high + unknown)),
        note=note,
    )


def _between(item: Identified, first: int, last: int) -> float:
    """Two standard deviations of what is unknown in this range; see `bands.Band`."""
    band: Band = item.band
    inside = (band.pwm >= first) & (band.pwm <= last)
    return 2.0 * float(np.max(band.total_K[inside], initial=0.0)) if inside.any() else 0.0


def measured_error(item: Identified, pwm: int) -> tuple[float, float]:
    """Give the smallest and largest model minus measured at a speed, of means over a 60th of a run, K."""
    lows, highs = [], []
    for record, residual in zip(item.problem.records, item.model.residuals, strict=True):
        level = record.segments.pwm[record.segment]
        # Where no speed was held, a node stands for what lies nearest to it.
        mine = level == pwm if item.held else _nearest(item, level) == pwm
        if mine.any():
            means = _means(
                record.time[mine], -residual[mine] - item.model.offset_K, record.count[mine], record.duration
            )
            lows.append(float(means.min()))
            highs.append(float(means.max()))
    return (min(lows), max(highs)) if lows else (0.0, 0.0)


def _nearest(item: Identified, level: IntArray) -> IntArray:
    nodes = item.fit.layout.nodes
    return np.asarray(nodes[np.argmin(np.abs(level[:, None] - nodes[None, :]), axis=1)], dtype=np.int64)


def _means(time: FloatArray, error: FloatArray, count: FloatArray, duration: float) -> FloatArray:
    index = np.floor(time / duration * ERROR_WINDOWS).astype(np.int64)
    index -= index.min()
    total, weight = np.bincount(index, error * count), np.bincount(index, count)
    return np.asarray(total[weight > 0] / weight[weight > 0], dtype=np.float64)


def _round(value: float) -> float:
    return float(f"{value:.4g}")
