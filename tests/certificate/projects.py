"""Small emitted projects whose proofs take a second."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import gen

ROOT = Path(__file__).parents[2]
#: |PWM| of the small models: few rows make a proof short.
DOMAIN = [96, 119]


def small(*orders: int, name: str = "small") -> dict[str, Any]:
    """A coefficient file with a part for each order: slow, cleanly scheduled poles; order 3 is the MY1016's brush."""
    poles = [-0.001, -0.004, -0.012, -0.03]
    components = []
    brush = json.loads((ROOT / "examples" / "my1016" / "coeffs.json").read_text())["components"][0]
    for number, order in enumerate(orders):
        if order == 3:
            components.append({**brush, "name": f"part{number}"})
            continue
        gain = 60.0 / 255.0
        for pole in poles[:order]:
            gain *= -pole
        components.append(
            {
                "name": f"part{number}",
                "order": order,
                "gain": {"poly": [gain]},
                "poles": [{"real": {"exp2": [pole, 0.002, 0.0, 0.0]}} for pole in poles[:order]],
            }
        )
    return {
        "format": "gen-coefficients",
        "version": 1,
        "name": name,
        "sample_time_s": 0.25,
        "input": {"name": "pwm", "full_scale": 255, "nominal_speed_rpm": 2650},
        "ambient": {"fixed_degC": 30.0},
        "validity": {"pwm": DOMAIN, "outside": "extrapolate"},
        "domain": {"pwm": DOMAIN, "ambient_degC": [20.0, 40.0], "temperature_degC": [20.0, 100.0]},
        "accuracy": {"fixed_limit_K": 1e-3, "float_limit_K": 1e-1},
        "components": components,
    }


def built(folder: Path, coefficients: dict[str, Any], arithmetic: str, schedule: str) -> Path:
    """Emit a project for it."""
    path = folder / "coefficients.json"
    path.write_text(json.dumps(coefficients))
    out = folder / "project"
    gen.build(gen.load(path), out, arithmetic=arithmetic, schedule=schedule)  # type: ignore[arg-type]
    return out
