"""A network's certificate: its equations, and what is claimed of its states and readings (docs/proof.md)."""

from __future__ import annotations

from typing import Any

from gen.coefficients import Coefficients
from gen.firmware.contexts.identity import ROOM_degC
from gen.lowering.kinds import OUTPUT_BITS
from gen.lowering.network.program import NetworkProgram, NetworkProof
from gen.lowering.network.start import start_range_mC
from gen.lowering.network.terms import drifting_sensor, identifier, lagging_reading
from gen.lowering.program import Program
from gen.lowering.recursion.guarantee import rounded_up
from gen.model import ThermalModel
from gen.model.laws import Convection, Law
from gen.model.network import Network
from gen.model.network_parts import Factor, Node, Sensor

_INSIDE_K = 0.004
"""By which ranges are claimed wider than the linear programme has them, at most: its tolerances lie far below."""


def network_certificate(coefficients: Coefficients, program: Program, made: NetworkProgram) -> dict[str, Any]:
    """All of the certificate."""
    model = program.model
    statement = network_statement(coefficients)
    equations = statement["equations"]
    factors = [{**factor, "bits": own.bits} for factor, own in zip(equations["factors"], made.factors, strict=True)]
    scales = {law.path: law.scale for law in made.laws}
    paths = [
        {**path, **({"scale": scales[number]} if number in scales else {})}
        for number, path in enumerate(equations["paths"])
    ]
    return {
        "format": "gen-certificate",
        "version": 2,
        "model": model.name,
        "coefficients_sha256": coefficients.sha256,
        "arithmetic": program.arithmetic,
        "sample_time_s": model.sample_time,
        "domain_pwm": list(model.domain_pwm),
        "fraction_bits": made.fraction_bits,
        "start_mC": statement["start_mC"],
        "equations": {**equations, "factors": factors, "paths": paths},
        "states": _claimed(statement["states"], made.proof),
        "components": _components(statement["components"], made),
    }


def network_statement(coefficients: Coefficients) -> dict[str, Any]:
    """What a certificate is about: equations, starts, states and components without what is claimed of them."""
    model = coefficients.model
    network = model.network
    assert network is not None
    lagging = [node for node in network.sensed if node.sensor is not None and node.sensor.lag > 0.0]
    states: list[dict[str, Any]] = [
        {
            "name": identifier(node.name),
            "capacity_J_per_K": node.capacity,
            **({} if node.start_factor == 1.0 else {"start_factor": node.start_factor}),
            **_start_from(network, node),
        }
        for node in network.nodes
    ]
    components = []
    for node in network.sensed:
        assert node.sensor is not None
        place = network.index(node.name)
        state = place
        if node in lagging:
            state = len(states)
            name = identifier(lagging_reading(node.name))
            states.append({"name": name, "lags": place, "time_constant_s": node.sensor.lag})
        shown = {"shown_K": node.sensor.offset, **_gain(node.sensor)}
        components.append({"name": node.name, "node": place, "state": state, **shown})
    for component, node in zip(components, network.sensed, strict=True):
        assert node.sensor is not None
        if node.sensor.drift:
            component["drift"] = len(states)
            name = identifier(drifting_sensor(node.name))
            states.append({"name": name, "drifts_to_K": node.sensor.drift, "time_constant_s": node.sensor.settling})
    return {
        "equations": _equations(network, model),
        "start_mC": list(start_range_mC(model)),
        "states": states,
        "components": components,
    }


def _gain(sensor: Sensor) -> dict[str, Any]:
    if sensor.gain_error == 0.0:
        return {}
    return {"shown_per_K": sensor.gain_error, "shown_about": "ambient" if sensor.about_ambient else "zero_degC"}


def _equations(network: Network, model: ThermalModel) -> dict[str, Any]:
    factors: list[Factor] = []

    def known(own: tuple[Factor, ...]) -> list[int]:
        factors.extend(factor for factor in own if factor not in factors)
        return [factors.index(factor) for factor in own]

    rows = slice(model.domain_pwm[0], model.domain_pwm[1] + 1)
    paths = [
        {
            "between": [network.index(path.first), None if path.second is None else network.index(path.second)],
            "conductance_W_per_K": network.conductances[rows, number].tolist(),
            "at_rest_W_per_K": float(network.conductances[0, number]),
            "factors": known(path.factors),
            **_law(path.law),
        }
        for number, path in enumerate(network.paths)
    ]
    heats = [
        {
            "node": network.index(heat.node),
            "power_W": network.powers[rows, number].tolist(),
            "per_K": heat.per_K,
            "reference_degC": heat.reference,
            "factors": known(heat.factors),
        }
        for number, heat in enumerate(network.heats)
    ]
    columns = [channel.column for channel in network.channels]
    told = [
        {
            "channel": 1 + columns.index(factor.channel),
            "polynomial": list(factor.polynomial),
            "at": list(factor.at),
            "value": list(factor.value),
        }
        for factor in factors
    ]
    return {"channels": _channels(network, model), "factors": told, "paths": paths, "heats": heats}


def _start_from(network: Network, node: Node) -> dict[str, Any]:
    if node.start_from is None:
        return {}
    return {"start_from": [[network.index(name), weight] for name, weight in node.start_from]}


def _law(law: Law | None) -> dict[str, Any]:
    if isinstance(law, Convection):
        return {"convection": list(law.polynomial)}
    return {} if law is None else {"radiation_degC": law.reference}


def _channels(network: Network, model: ThermalModel) -> list[dict[str, Any]]:
    """The ambient first; in thousandths."""
    low, high = model.domain_ambient
    given = model.ambient_fixed if model.ambient_fixed is not None else ROOM_degC
    neutral = min(max(given, low), high)
    every = [(model.ambient_channel or "ambient_degC", low, high, neutral)]
    every += [(channel.column, channel.low, channel.high, channel.neutral) for channel in network.channels]
    keys = ("column", "low", "high", "neutral")
    return [dict(zip(keys, (name, *(round(end * 1000.0) for end in ends)), strict=True)) for name, *ends in every]


def _claimed(states: list[dict[str, Any]], proof: NetworkProof) -> list[dict[str, Any]]:
    """With each state's range and error."""
    # Errors fade, so towards them a range leads inside; the program's margin is for the board's own states.
    room = _INSIDE_K * proof.error / proof.error.max()
    low, high = proof.low + proof.margin - room, proof.high - proof.margin + room
    return [
        {**state, "range_degC": [float(low[k]), float(high[k])], "error_K": float(proof.error[k])}
        for k, state in enumerate(states)
    ]


def _components(components: list[dict[str, Any]], made: NetworkProgram) -> list[dict[str, Any]]:
    """With what is claimed of each reading."""
    # The ambient's own word and the nearest thousandth come with what is given out.
    beside = 2.0**-made.fraction_bits + 0.0005 + (2.0**-OUTPUT_BITS if made.fraction_bits > OUTPUT_BITS else 0.0)
    bounds = [component.proof.bound_K for component in made.components()]
    return [
        {**component, "bound_K": rounded_up(bound, 4), "reading_K": rounded_up(bound + beside, 4)}
        for component, bound in zip(components, bounds, strict=True)
    ]
