"""Every effect, and several at once, on the examples."""

from __future__ import annotations

import json
from dataclasses import replace
from functools import cache
from typing import Any

from gen.coefficients import Coefficients, parse
from gen.lowering.effects import lower_effects
from gen.lowering.kinds import Arithmetic
from gen.lowering.lower import lower
from gen.lowering.program import Program
from tests.examples import ROOT

Entry = dict[str, Any]


def effect(name: str, component: str, **parameters: object) -> Entry:
    """An entry of $.effects."""
    return {"name": name, "component": component, "parameters": parameters}


#: Label -> (example, effects). The MY1016 has components of order 1 and 3, the two masses 2 and 4.
CASES: dict[str, tuple[str, list[Entry]]] = {
    "hidden_node": ("my1016", [effect("hidden_node", "casing", heating_K_per_s=6e-3, node_tau_s=1200.0)]),
    "hidden_node, exchange, order 3": (
        "my1016",
        [effect("hidden_node", "brush", heating_K_per_s=6e-3, node_tau_s=90.0, exponent=2, exchange=True)],
    ),
    "hidden_node, own time constant": (
        "my1016",
        [effect("hidden_node", "casing", heating_K_per_s=0.05, node_tau_s=20.0, tau_s=40.0)],
    ),
    "direction": ("my1016", [effect("direction", "brush", reverse_heating=0.3)]),
    "temperature_dependent_loss": (
        "my1016",
        [effect("temperature_dependent_loss", name, coefficient_per_K=0.004) for name in ("brush", "bearing")],
    ),
    "temperature_dependent_loss, order 2 and 4": (
        "two_mass",
        [effect("temperature_dependent_loss", name, coefficient_per_K=0.002) for name in ("winding", "housing")],
    ),
    "radiation": ("my1016", [effect("radiation", name, loss_K_per_s_1e8K4=1e-4) for name in ("brush", "casing")]),
    "radiation, order 4": ("two_mass", [effect("radiation", "housing", loss_K_per_s_1e8K4=1e-4)]),
    "coupling": (
        "my1016",
        [
            effect("coupling", "casing", source="brush", conductance_per_s=4e-4),
            effect("coupling", "brush", source="casing", conductance_per_s=3e-4),
        ],
    ),
    "coupling, one way, own time constant": (
        "my1016",
        [effect("coupling", "magnet", source="bearing", conductance_per_s=2e-4, exchange=False, tau_s=500.0)],
    ),
    "standstill_cooling, order 3": ("my1016", [effect("standstill_cooling", "brush", cooling_factor=2.5)]),
    "schedule_error, order 3": (
        "my1016",
        [effect("schedule_error", "brush", pwm=[100, 200], gain_factor=[1.1, 0.9], rate_factor=1.3)],
    ),
    "initial_state": ("my1016", [effect("initial_state", "casing", soak_per_s=1e-3, soak_tau_s=600.0)]),
    "ambient, delayed": (
        "my1016",
        [effect("ambient", name, delayed=True) for name in ("brush", "bearing", "magnet", "casing")],
    ),
    "ambient, own time constant": (
        "my1016",
        [effect("ambient", name, delayed=True, tau_s=900.0) for name in ("brush", "casing")],
    ),
    "load_heating": ("my1016", [effect("load_heating", "brush", heating_K_per_s_A2=2e-4, reference_A=3.0)]),
    "load_heating, own time constant": (
        "two_mass",
        [effect("load_heating", "winding", heating_K_per_s_A2=3e-4, tau_s=60.0)],
    ),
    "airflow": (
        "my1016",
        [effect("airflow", name, channel="fan", cooling_per_s=3e-4) for name in ("brush", "casing")],
    ),
    "supply_voltage": ("my1016", [effect("supply_voltage", "casing", sensitivity=0.8, nominal_V=24.0)]),
    "coupling to a column": (
        "two_mass",
        [effect("coupling", "housing", source="gearbox_degC", conductance_per_s=1e-4)],
    ),
    "sensor_offset": ("my1016", [effect("sensor_offset", "brush", offset_K=-2.5)]),
    "sensor_gain": (
        "my1016",
        [
            effect("sensor_gain", "brush", gain_error=0.05),
            effect("sensor_gain", "casing", gain_error=-0.03, about="zero_degC"),
        ],
    ),
    "sensor_lag": ("my1016", [effect("sensor_lag", "brush", lag_s=40.0)]),
    "drift": ("my1016", [effect("drift", "bearing", drift_K_per_h=0.5)]),
    "fast": (
        "fast",
        [
            effect("airflow", "casing", channel="fan", cooling_per_s=0.01),
            effect("radiation", "casing", loss_K_per_s_1e8K4=1e-3),
        ],
    ),
    "several": (
        "two_mass",
        [
            effect("load_heating", "winding", heating_K_per_s_A2=2e-4),
            effect("hidden_node", "winding", heating_K_per_s=8e-3, node_tau_s=400.0),
            effect("coupling", "housing", source="winding", conductance_per_s=1e-4),
            effect("sensor_gain", "winding", gain_error=0.02),
            effect("sensor_lag", "winding", lag_s=25.0),
            effect("drift", "winding", drift_K_per_h=0.3),
            effect("sensor_offset", "housing", offset_K=1.5),
        ],
    ),
}

#: All of them at once on each example, but for those that change what the ambient means.
TOGETHER = ("all on my1016", "all on two_mass")
CASES |= {
    label: (
        label.split()[-1],
        [
            entry
            for name, effects in CASES.values()
            for entry in effects
            if name == label.split()[-1] and entry["name"] != "ambient"
        ],
    )
    for label in TOGETHER
}


#: In an example without channels of its own: two units of air, as far as the brush's cooling settles.
FAN = {"column": "fan", "analog_pin": 68, "per_V": 0.4}


def _document(name: str) -> dict[str, Any]:
    """An example's; "fast" is a casing of order 1 with 68 s."""
    known = "my1016_averaged" if name == "fast" else name
    document: dict[str, Any] = json.loads((ROOT / "examples" / known / "coeffs.json").read_text(encoding="utf-8"))
    if name == "fast":
        document["components"] = [part for part in document["components"] if part["name"] == "casing"]
        casing = document["components"][0]
        for schedule in (casing["gain"], casing["poles"][0]["real"]):
            schedule["poly"] = [30.0 * value for value in schedule["poly"]]
        document |= {"alarms": [], "wiring": None, "provenance": None}
    elif "channels" not in document["wiring"]:
        document["wiring"]["channels"] = [FAN]
    return document


@cache
def case(label: str) -> Coefficients:
    """The example with these effects."""
    name, effects = CASES[label]
    document = _document(name)
    if any(entry["name"] == "ambient" for entry in effects):
        document["ambient"] = {"fixed_degC": 25.0}
    return parse(json.dumps({**document, "effects": effects}).encode())


@cache
def _baseline(name: str, arithmetic: Arithmetic) -> Program:
    return lower(parse(json.dumps(_document(name)).encode()), arithmetic, "table")


def lowered(label: str, arithmetic: Arithmetic) -> Program:
    """The case lowered; what it shares with the example alone is lowered once for all cases."""
    made, base = case(label), _baseline(CASES[label][0], arithmetic)
    assert made.model.components == base.model.components, "an effect was folded"
    return replace(base, model=made.model, effects=lower_effects(made, arithmetic, base.components))
