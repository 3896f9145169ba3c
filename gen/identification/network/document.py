"""The coefficient file of an identified network."""

from __future__ import annotations

import math

import numpy as np

from gen.coefficients import Coefficients, Document, dump, parse
from gen.coefficients.document import Accuracy, Ambient, Domain, Input, Validity
from gen.coefficients.messages import building
from gen.coefficients.network import (
    CurveEntry,
    HeatEntry,
    NetworkEntry,
    NodeEntry,
    PathEntry,
    PolyCurve,
    PowerCurve,
    PowerEntry,
    SensorEntry,
)
from gen.coefficients.provenance import ErrorBand, Provenance
from gen.coefficients.versions import FORMAT, VERSION
from gen.errors import CheckFailed, InputError
from gen.identification.coefficient_file import FIXED_LIMIT_K, FLOAT_LIMIT_K, Settings
from gen.identification.network.bins import FloatArray
from gen.identification.network.forecast import Band, bands
from gen.identification.network.identify import NetworkFound
from gen.identification.network.structure import SLOW
from gen.identification.network.uncertainty import Steady, spread_of, steady_of

FASTEST = 20.0
"""No node follows its neighbours within fewer steps of the board: its capacity is raised to this."""
LEAST = 1e-6
"""Of a path's conductance or a node's heat: smaller terms are not written."""


def network_text(result: NetworkFound, settings: Settings) -> tuple[str, Coefficients]:
    """Write the coefficient file's text, and read it back with every check.

    Raises
    ------
    CheckFailed
        When the model that the runs led to is none that can be built.
    """
    try:
        with building():
            text = dump(_document(result, settings))
        return text, parse(text.encode())
    except InputError as error:
        raise CheckFailed(f"the identified network is not one that can be built: {error}") from error


def measured_range(result: NetworkFound) -> tuple[int, int]:
    """Lowest and highest |PWM| that was measured, 0 where rest was held."""
    levels, scale = result.inputs.levels, result.data.full_scale
    turning = levels.rest < 0.5
    pwm = np.rint(levels.speed[turning] * scale)
    low = 0 if rest_was_measured(result) else int(pwm.min())
    return low, int(pwm.max())


def rest_was_measured(result: NetworkFound) -> bool:
    """Whether PWM 0 was held for long enough to say how the motor cools: a minute at least, or a 50th of the time."""
    inputs = result.inputs
    rest = float(inputs.width[inputs.rest > 0.99].sum())
    return rest >= max(60.0, 0.02 * float(inputs.width.sum()))


def _document(result: NetworkFound, settings: Settings) -> Document:
    low, high = measured_range(result)
    top = settings.full_scale
    spread = spread_of(result.found)
    steady = steady_of(result.found, spread, np.arange(top + 1), top)
    return Document(
        format=FORMAT,
        version=VERSION,
        name=settings.name,
        description=f"One thermal network, identified from {len(result.data.sources)} run(s).",
        sample_time_s=settings.sample_time_s,
        input=Input(name="pwm", full_scale=top, nominal_speed_rpm=settings.nominal_speed_rpm),
        ambient=_ambient(result),
        validity=Validity(pwm=(low, high), outside="extrapolate"),
        domain=_domain(result, steady, top),
        accuracy=Accuracy(fixed_limit_K=FIXED_LIMIT_K, float_limit_K=FLOAT_LIMIT_K),
        network=_network(result, settings),
        provenance=Provenance(
            source="gen identify --model network",
            method="One network of heat capacities fitted to all runs at once by the error of its simulation, with "
            "weak physical priors; hidden nodes and paths by the error on runs left out",
            data=tuple(source.path.rsplit("/", 1)[-1] for source in result.data.sources),
            fit=_figures(result),
            error=tuple(_error_bands(result, steady)),
        ),
    )


def _ambient(result: NetworkFound) -> Ambient:
    data = result.data
    return Ambient(
        fixed_degC=None if data.ambient_fixed is None else _round(data.ambient_fixed),
        channel="ambient_degC" if data.ambient_measured else None,
    )


def _network(result: NetworkFound, settings: Settings) -> NetworkEntry:
    structure, vector = result.found.structure, result.found.vector
    names = (*structure.names, "ambient")
    terms = structure.path_terms(vector)
    paths = []
    loss = np.zeros(structure.nodes)
    for (i, j), own in zip(structure.paths, terms, strict=True):
        curve, most = _conductance(own, structure_is_outer=j < 0)
        paths.append(PathEntry(between=(names[i], names[j]), conductance_W_per_K=curve))
        loss[i] += most
        if j >= 0:
            loss[j] += most
    capacity = np.maximum(np.exp(vector[structure.capacities]), FASTEST * settings.sample_time_s * loss)
    nodes = []
    for i, name in enumerate(structure.names):
        own = _round(float(capacity[i]))
        if i < len(structure.sensed):
            offset = _round(float(vector[structure.offsets[i]]))
            nodes.append(NodeEntry(name=name, capacity_J_per_K=own, sensor=SensorEntry(offset_K=offset)))
        else:
            nodes.append(NodeEntry(name=name, capacity_J_per_K=own))
    heats = tuple(
        HeatEntry(node=names[node], power_W=_power(vector[structure.heats[h]], settings.full_scale))
        for h, node in enumerate(structure.heated)
    )
    return NetworkEntry(nodes=tuple(nodes), paths=tuple(paths), heats=heats)


def _conductance(terms: FloatArray, *, structure_is_outer: bool) -> tuple[CurveEntry, float]:
    """Give the curve of a path and its largest value, W/K."""
    ratio, constant, forced, exponent = (float(value) for value in np.exp(terms))
    rest = ratio * (constant + forced * SLOW**exponent)
    most = max(constant + forced, rest)
    if forced < LEAST * most:
        forced = 0.0
    if constant < LEAST * most:
        constant = 0.0
    power = PowerEntry(constant=_round(constant), forced=_round(forced), exponent=_round(exponent))
    return PowerCurve(power=power, at_rest=_round(rest)), most


def _power(terms: FloatArray, full_scale: int) -> CurveEntry:
    linear, square, hump = (float(value) for value in np.exp(terms))
    return PolyCurve(poly=(_round((square - hump) / full_scale**2), _round((linear + hump) / full_scale), 0.0))


def _domain(result: NetworkFound, steady: Steady, full_scale: int) -> Domain:
    data = result.data
    ambients = [float(value) for run in data.fine for value in (run.ambient.min(), run.ambient.max())]
    cold, warm = min([-10.0, *ambients]), max([50.0, *ambients])
    hottest = max(float(np.nanmax(run.reading)) for run in data.fine if np.isfinite(run.reading).any())
    top = max(150.0, 1.1 * hottest, 1.1 * (float(np.max(steady.rise)) + warm))
    return Domain(
        pwm=(0, full_scale),
        ambient_degC=(math.floor(cold), math.ceil(warm)),
        temperature_degC=(math.floor(cold), min(10.0 * math.ceil(top / 10.0), 5000.0)),
    )


def _figures(result: NetworkFound) -> dict[str, dict[str, float]]:
    covered = result.found.problem.inputs.covered
    total = np.maximum(covered.sum(axis=0), 1e-9)
    rms = np.sqrt(np.sum(covered * result.residual**2, axis=0) / total)
    made = {}
    for s, name in enumerate(result.data.names):
        own = float(rms[s])
        left = float(np.sqrt(np.nanmean(result.judged.by_fold[:, s])))
        made[name] = {"rms_K": _round(own)} | ({"left_out_rms_K": _round(left)} if math.isfinite(left) else {})
    return made


def _error_bands(result: NetworkFound, steady: Steady) -> list[ErrorBand]:
    made = []
    for s, name in enumerate(result.data.names):
        for band in bands(result.inputs, result.judged, result.data.full_scale):
            if math.isfinite(band.low[s]):
                made.append(_error_band(name, s, band, steady))
    return made


def _error_band(name: str, s: int, band: Band, steady: Steady) -> ErrorBand:
    first, last = band.pwm
    unknown = 2.0 * float(np.max(steady.deviation[first : last + 1, s]))
    low, high = min(float(band.low[s]), 0.0), max(float(band.high[s]), 0.0)
    return ErrorBand(
        component=name,
        pwm=band.pwm,
        model_minus_measured_K=(_round(low - unknown), _round(high + unknown)),
        note=f"on data left out: {band.low[s]:+.2f}..{band.high[s]:+.2f} K in means over ten minutes, "
        f"{band.rms[s]:.2f} K rms; widened by {unknown:.2f} K for what is not known of where it settles",
    )


def _round(value: float) -> float:
    return float(f"{value:.6g}")
