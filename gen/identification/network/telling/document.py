"""The coefficient file of an identified network."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from gen.arrays import FloatArray, IntArray
from gen.coefficients import Coefficients, Document, dump, parse
from gen.coefficients.base import told
from gen.coefficients.document import Accuracy, Ambient, Domain, Validity
from gen.coefficients.messages import building
from gen.coefficients.network import (
    ChannelEntry,
    ConvectionEntry,
    CurveEntry,
    Exp1Curve,
    FactorEntry,
    HeatEntry,
    NetworkEntry,
    NodeEntry,
    PathEntry,
    PolyCurve,
    SensorEntry,
)
from gen.coefficients.network_curves import points_of, six_digits, tabulated
from gen.coefficients.provenance import Provenance
from gen.coefficients.versions import FORMAT, VERSION
from gen.errors import CheckFailed, InputError
from gen.identification.drive import input_entry
from gen.identification.network.fitting.as_found import usual
from gen.identification.network.fitting.followed import FASTEST
from gen.identification.network.fitting.inputs import held, joined, turning
from gen.identification.network.fitting.natural import polynomial
from gen.identification.network.fitting.speed_laws import CONSTANT, WITHIN, Law
from gen.identification.network.fitting.structure import Structure
from gen.identification.network.identify import NetworkFound
from gen.identification.network.search import Found
from gen.identification.network.telling.declared import error_bands
from gen.identification.network.telling.stiffness import slowed
from gen.identification.network.telling.uncertainty import spread_of
from gen.identification.network.used import start_from
from gen.identification.settings import FIXED_LIMIT_K, FLOAT_LIMIT_K, Settings, said_beside
from gen.lowering.network.ranges import LAW_MARGIN_K

HELD_SHARE = 0.05
"""Of the whole time: a |PWM| that is held for longer is named."""
MOST_FACTOR = 7.99
"""Of a start: a file may hold less than 8."""


def network_text(result: NetworkFound, settings: Settings, note: str = "") -> tuple[str, Coefficients]:
    """Write the coefficient file's text, and read it back with every check.

    Parameters
    ----------
    result, settings
        What was found, and what the runs do not say.
    note
        What to say of the method beside it.

    Raises
    ------
    CheckFailed
        When the model that the runs led to is none that can be built.
    """
    try:
        with building():
            text = dump(_document(result, settings, note))
        return text, parse(text.encode())
    except InputError as error:
        raise CheckFailed(
            f"the identified network is not one that can be built: {error}; {_missing(result)}"
        ) from error


def _missing(result: NetworkFound) -> str:
    """What the runs do not show, and which run would."""
    inputs = result.inputs
    pwm = np.rint(np.where(inputs.turns, inputs.speed, 0.0) * result.data.full_scale).astype(np.int64)
    time = np.bincount(pwm, inputs.width)
    held = ", ".join(str(level) for level in np.flatnonzero(time > HELD_SHARE * time.sum()))
    ask = "" if rest_was_measured(result) else ", and 20 minutes of rest after one of them,"
    return (
        f"most of the time |PWM| is {held}: log runs at other speeds{ask} or other channels that heat it as the input"
    )


def measured_range(result: NetworkFound) -> tuple[int, int]:
    """Lowest and highest |PWM| that was measured, 0 where rest was held."""
    low, high = turned_range(result)
    return (0 if rest_was_measured(result) else low), high


def turned_range(result: NetworkFound) -> tuple[int, int]:
    """Lowest and highest |PWM| that turned."""
    levels = result.inputs.levels
    pwm = np.rint(levels.speed[levels.turns] * result.data.full_scale)
    return int(pwm.min()), int(pwm.max())


def rest_was_measured(result: NetworkFound) -> bool:
    """Whether PWM 0 was held for long enough to say how the motor cools: a minute at least, or a 50th of the time."""
    inputs = result.inputs
    rest = float(inputs.width[inputs.rest > 0.99].sum())
    return rest >= max(60.0, 0.02 * float(inputs.width.sum()))


def _document(result: NetworkFound, settings: Settings, note: str) -> Document:
    low, high = measured_range(result)
    top = settings.full_scale
    spread = spread_of(result.found)
    return Document(
        format=FORMAT,
        version=VERSION,
        name=settings.name,
        description=f"One thermal network, identified from {len(result.data.sources)} run(s).",
        sample_time_s=settings.sample_time_s,
        input=input_entry(result.data.runs, top, settings.nominal_speed_rpm),
        ambient=_ambient(result),
        validity=Validity(pwm=(low, high), outside="extrapolate"),
        domain=_domain(result, top),
        accuracy=_accuracy(result),
        network=_network(result, settings),
        provenance=Provenance(
            source="gen identify --model network",
            method="One network of heat capacities fitted to all runs at once by the error of its simulation, with "
            f"weak physical priors; hidden nodes and paths by the error on runs left out{said_beside(note)}",
            data=tuple(Path(source.path).name for source in result.data.sources),
            fit=_figures(result),
            error=tuple(error_bands(result, spread, turned_range(result))),
            ambient_degC=result.data.ambient_range,
        ),
    )


def _accuracy(result: NetworkFound) -> Accuracy:
    if not result.found.structure.natural:
        return Accuracy(fixed_limit_K=FIXED_LIMIT_K, float_limit_K=FLOAT_LIMIT_K)
    # Natural convection's bound counts the fastest change that its ranges allow in every sample.
    return Accuracy(fixed_limit_K=LAW_MARGIN_K, float_limit_K=LAW_MARGIN_K)


def _ambient(result: NetworkFound) -> Ambient:
    data = result.data
    return Ambient(
        fixed_degC=None if data.ambient_fixed is None else told(data.ambient_fixed),
        channel="ambient_degC" if data.ambient_measured or data.ambient_fixed is None else None,
    )


def _network(result: NetworkFound, settings: Settings) -> NetworkEntry:
    structure, vector = result.found.structure, result.found.vector
    names = (*structure.names, "ambient")
    # The curves at rest, then at the points of their tables.
    pwm = points_of(settings.full_scale)
    levels = joined(held(np.zeros(1), settings.full_scale), turning(pwm.astype(np.float64), settings.full_scale))
    physics = structure.physical(levels, vector)
    paths = []
    loss = np.zeros(structure.nodes)
    least_s = FASTEST * settings.sample_time_s
    conductance = slowed(physics.conductance, structure.paths, physics.capacity, least_s)
    for q, (i, j) in enumerate(structure.paths):
        own, ends = conductance[:, q], (names[i], names[j])
        still = np.zeros_like(own)
        if physics.natural is not None and j < 0:
            # A node that is followed as fast as the board can is no surface in still air.
            still = np.minimum(physics.natural.conductance[:, i], own)
            entry = ConvectionEntry(poly=tuple(six_digits(float(c)) for c in polynomial(physics.natural.widest)))
            curve = _path_curve(structure.laws[q], pwm, still, settings.full_scale)
            paths.append(PathEntry(between=ends, conductance_W_per_K=curve, convection=entry))
        curve = _path_curve(structure.laws[q], pwm, own - still, settings.full_scale)
        paths.append(PathEntry(between=ends, conductance_W_per_K=curve))
        loss[[k for k in (i, j) if k >= 0]] += own.max()
    capacity = np.maximum(physics.capacity, least_s * loss)
    nodes = []
    likely = start_from(result.found)
    for i, name in enumerate(structure.names):
        mass = six_digits(float(capacity[i]))
        if i < len(structure.sensed):
            offset = six_digits(float(vector[structure.offsets[i]]))
            nodes.append(NodeEntry(name=name, capacity_J_per_K=mass, sensor=SensorEntry(offset_K=offset)))
        elif likely is not None:
            shares = zip(structure.sensed, likely[i - structure.sensors].tolist(), strict=True)
            rises = {sensed: six_digits(share) for sensed, share in shares}
            nodes.append(NodeEntry(name=name, capacity_J_per_K=mass, start_from=rises))
        else:
            factor = _start_factor(result.found, i)
            nodes.append(NodeEntry(name=name, capacity_J_per_K=mass, start_factor=factor))
    power = physics.heat_in_room[1:]
    by_pwm = [HeatEntry(node=names[node], power_W=tabulated(pwm, power[:, node], 0.0)) for node in structure.heated]
    channels, fed = _fed(result, names)
    heats = tuple(_growing(heat, structure, vector) for heat in (*by_pwm, *fed))
    return NetworkEntry(channels=channels, nodes=tuple(nodes), paths=tuple(paths), heats=heats)


def _growing(heat: HeatEntry, structure: Structure, vector: FloatArray) -> HeatEntry:
    """The same heat, growing with temperature where heats do."""
    if structure.warmth is None:
        return heat
    per_K = six_digits(float(vector[structure.growing[0]]))
    return heat.model_copy(update={"per_K": per_K, "reference_degC": structure.warmth})


def _start_factor(found: Found, node: int) -> float:
    """Of a hidden node: where it starts, as runs that begin warm do, or as it is found at rest in the runs."""
    structure, hidden = found.structure, node - found.structure.sensors
    if structure.factors.size:
        log = float(found.vector[structure.factors[hidden]])
    else:
        log = float(usual(found.problem, found.vector, found.fit.evaluated).log[hidden])
    return six_digits(min(float(np.exp(log)), MOST_FACTOR))


def _fed(result: NetworkFound, names: tuple[str, ...]) -> tuple[tuple[ChannelEntry, ...], tuple[HeatEntry, ...]]:
    """Heats by measured columns, and the channels that tell the board of them."""
    structure, driving = result.found.structure, result.data.driving
    heats = []
    for (number, node), at in zip(structure.fed, structure.feeds, strict=True):
        one = driving[number]
        watts = float(np.exp(result.found.vector[at])) / one.largest**one.power
        factor = FactorEntry(channel=one.column, poly=(1.0, *[0.0] * one.power))
        heats.append(HeatEntry(node=names[node], power_W=PolyCurve(poly=(six_digits(watts),)), factors=(factor,)))
    used = {driving[number].column: driving[number] for number, _ in structure.fed}
    channels = []
    for one in used.values():
        low, high = one.range
        channels.append(ChannelEntry(column=one.column, range=(six_digits(low), six_digits(high)), neutral=0.0))
    return tuple(channels), tuple(heats)


def _path_curve(law: Law, pwm: IntArray, value: FloatArray, full_scale: int) -> CurveEntry:
    """A path's curve from its values at rest and at the tables' points."""
    if law is CONSTANT:
        return PolyCurve(poly=(six_digits(float(value[0])),))
    return _exponential(value, full_scale) if law is WITHIN else tabulated(pwm, value[1:], float(value[0]))


def _exponential(value: FloatArray, full_scale: int) -> CurveEntry:
    """What is straight in its logarithm, from its values at rest and at full speed."""
    rate = float(np.log(value[-1] / value[0])) / full_scale
    return Exp1Curve(exp1=(six_digits(float(value[0])), six_digits(rate)))


def _domain(result: NetworkFound, full_scale: int) -> Domain:
    data = result.data
    ambients = [float(value) for run in data.fine for value in (run.ambient.min(), run.ambient.max())]
    cold, warm = min([-10.0, *ambients]), max([50.0, *ambients])
    top = data.highest_degC
    return Domain(
        pwm=(0, full_scale),
        ambient_degC=(math.floor(cold), math.ceil(warm)),
        temperature_degC=(math.floor(cold), max(10.0 * math.ceil(top / 10.0), math.ceil(warm))),
    )


def _figures(result: NetworkFound) -> dict[str, dict[str, float]]:
    covered = result.found.problem.inputs.covered
    total = np.maximum(covered.sum(axis=0), 1e-9)
    rms = np.sqrt(np.sum(covered * result.residual**2, axis=0) / total)
    made = {}
    for s, name in enumerate(result.data.names):
        own = float(rms[s])
        left = float(np.sqrt(np.nanmean(result.judged.by_fold[:, s])))
        made[name] = {"rms_K": six_digits(own)} | ({"left_out_rms_K": six_digits(left)} if math.isfinite(left) else {})
    return made
