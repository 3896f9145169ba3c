"""``certificate.json``: what is claimed of the emitted project, and what it takes to prove it (docs/proof.md).

The room ``certificate`` reads it and trusts nothing of it; it shares no code with this.
"""

from __future__ import annotations

import json
from typing import Any

import numpy as np

from gen.coefficients import Coefficients
from gen.firmware.network_certificate import network_certificate
from gen.lowering.effects.channels import channels
from gen.lowering.effects.program import Channel
from gen.lowering.fixed.component import FixedComponent
from gen.lowering.fixed.formats import RESIDUE_BITS
from gen.lowering.kinds import OUTPUT_BITS
from gen.lowering.program import AnyComponent, Program
from gen.lowering.recursion.guarantee import Proof, rounded_up
from gen.model import Component
from gen.model.dynamics import MAX_PWM
from gen.model.effects.channel_ranges import channel_ranges
from gen.model.schedules import ExponentialSum, Polynomial, Schedule, Table

CERTIFICATE = "certificate.json"


def certificate_json(coefficients: Coefficients, program: Program) -> str:
    """The certificate's text."""
    if program.network is not None:
        return _pretty(network_certificate(coefficients, program, program.network)) + "\n"
    model = program.model
    places = {
        member: (shape.identifier, place) for shape in program.shapes for place, member in enumerate(shape.members)
    }
    components = []
    for number, (component, source) in enumerate(zip(program.components, model.components, strict=True)):
        shape, place = places[number]
        placed = {"name": component.name, "shape": shape, "place": place, "substeps": component.substeps}
        if component.proof is None:
            components.append({**placed, "order": component.order, "proof": None})
        else:
            components.append({**placed, **_claimed(component, component.proof, source)})
    certificate = {
        "format": "gen-certificate",
        "version": 1,
        "model": model.name,
        "coefficients_sha256": coefficients.sha256,
        "arithmetic": program.arithmetic,
        "schedule": program.schedule,
        "sample_time_s": model.sample_time,
        "domain_pwm": list(model.domain_pwm),
        **({"ambient": _ambient(program.ambient)} if program.ambient is not None else {}),
        "components": components,
    }
    return _pretty(certificate) + "\n"


def ambient_of(coefficients: Coefficients) -> dict[str, int] | None:
    """The ambient that acts on the equations as the certificate states it, None where none does."""
    model = coefficients.model
    return _ambient(channels(channel_ranges(model, (), {}))[0]) if model.ambient_passes else None


def _ambient(ambient: Channel) -> dict[str, int]:
    return {"reference_mC": ambient.neutral, "low_mC": ambient.low, "high_mC": ambient.high}


def equations(coefficients: Coefficients) -> dict[str, dict[str, Any]]:
    """Each component's equation as the certificate states it."""
    return {component.name: _equation(component) for component in coefficients.model.components}


def _claimed(component: AnyComponent, proof: Proof, source: Component) -> dict[str, Any]:
    if isinstance(component, FixedComponent):
        bits = [whole - RESIDUE_BITS for whole in component.layout.fraction_bits]
    else:
        bits = list(component.fraction_bits)
    bound, invariant = proof.bound_K, proof.invariant
    reading = bound + 0.0005 + (2.0**-OUTPUT_BITS if bits[0] > OUTPUT_BITS else 0.0)
    return {
        "fraction_bits": bits,
        "start_mK": list(component.start_range_mK),
        "bound_K": rounded_up(bound, 4),
        "reading_K": rounded_up(reading, 4),
        "equation": _equation(source),
        "map": invariant.map.tolist(),
        "centre": invariant.centre,
        "shape_matrix": invariant.shape.tolist(),
        "directions": _with_exact_axes(invariant.directions).tolist(),
        "reach": invariant.reach.tolist(),
        "error": invariant.error.tolist(),
    }


def _with_exact_axes(directions: np.ndarray[Any, np.dtype[np.float64]]) -> np.ndarray[Any, np.dtype[np.float64]]:
    """The first n lie along the axes but for float64's rounding."""
    exact = directions.copy()
    n = directions.shape[1]
    exact[:n] = np.diag(np.diag(directions))
    return exact


def _equation(source: Component) -> dict[str, Any]:
    held = source.validity if source.outside == "hold" else (0, MAX_PWM)
    zeroed = source.validity if source.negative_gain == "zero" else (0, MAX_PWM)
    poles = [
        {"real": _schedule(pole.real), **({"imag": _schedule(pole.imag)} if pole.imag is not None else {})}
        for pole in source.poles
    ]
    return {"poles": poles, "gain": _schedule(source.gain), "held": list(held), "no_gain_outside": list(zeroed)}


def _schedule(schedule: Schedule) -> dict[str, Any]:
    match schedule:
        case Polynomial(coefficients=coefficients):
            return {"pieces": [[0, MAX_PWM, list(coefficients)]]}
        case ExponentialSum(terms=terms):
            return {"exponentials": [list(term) for term in terms]}
        case Table(pwm=pwm, value=value):
            pieces = [[0, pwm[0] - 1, [value[0]]]] if pwm[0] > 0 else []
            pieces += [[part.start, part.end - 1, list(part.coefficients)] for part in schedule.segments()]
            return {"pieces": [*pieces, [pwm[-1], MAX_PWM, [value[-1]]]]}
    raise TypeError(f"no form for {type(schedule).__name__}")


def _pretty(value: Any, depth: int = 0) -> str:  # noqa: ANN401
    """JSON with a line for each row of numbers."""
    indent = " " * (depth + 1)
    if isinstance(value, dict) and any(isinstance(entry, dict | list) for entry in value.values()):
        lines = [f"{indent}{json.dumps(key)}: {_pretty(entry, depth + 1)}" for key, entry in value.items()]
        return "{\n" + ",\n".join(lines) + "\n" + " " * depth + "}"
    if isinstance(value, list) and any(isinstance(entry, dict | list) for entry in value) and depth < 5:
        lines = [indent + _pretty(entry, depth + 1) for entry in value]
        return "[\n" + ",\n".join(lines) + "\n" + " " * depth + "]"
    return json.dumps(value)
