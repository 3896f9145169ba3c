"""Emitted networks."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pytest

import gen
from gen.coefficients import Coefficients, parse
from gen.errors import CheckFailed
from gen.firmware import render
from gen.firmware.certificate import CERTIFICATE, certificate_json
from gen.firmware.context import project_context
from gen.lowering.kinds import Arithmetic
from gen.lowering.lower import lower
from gen.lowering.program import Program
from tests.certificate.projects import ROOT

EXAMPLE = ROOT / "examples" / "network" / "coeffs.json"


def _file(name: str, domain: tuple[int, int], network: dict[str, Any]) -> dict[str, Any]:
    return {
        "format": "gen-coefficients",
        "version": 2,
        "name": name,
        "sample_time_s": 0.25,
        "input": {"name": "pwm", "full_scale": 255, "nominal_speed_rpm": 2650},
        "ambient": {"fixed_degC": 25, "channel": "ambient_degC"},
        "validity": {"pwm": list(domain), "outside": "hold"},
        "domain": {"pwm": list(domain), "ambient_degC": [0, 45], "temperature_degC": [-10, 120]},
        "accuracy": {"fixed_limit_K": 1e-3, "float_limit_K": 1e-1},
        "network": network,
    }


def chain(nodes: int, *, domain: tuple[int, int] = (0, 255), channels: bool = False) -> dict[str, Any]:
    """Nodes in a row, every other one measured, the last one and every third one tied to the ambient.

    Parameters
    ----------
    nodes
        How many.
    domain
        Of |PWM|.
    channels
        Whether a fan, a current and a voltage scale conductances and heats, by tables and polynomials.
    """
    names = [f"node{k}" for k in range(nodes)]
    fan = {"channel": "fan_rpm", "table": {"at": [0, 800, 3000], "value": [1.0, 1.5, 2.5]}}
    current = {"channel": "current_A", "poly": [1, 0, 0]}
    voltage = {"channel": "voltage_V", "poly": [1e-4, -0.002, 0.05, 0.6]}
    paths: list[dict[str, Any]] = [
        {
            "between": [names[k], names[k + 1]],
            "conductance_W_per_K": {"power": {"constant": 0.3 + 0.1 * k, "forced": 0.2, "exponent": 0.8}}
            if k % 2
            else {"poly": [0.4 + 0.05 * k]},
        }
        for k in range(nodes - 1)
    ]
    for k in sorted({*range(0, nodes, 3), nodes - 1}):
        paths.append({"between": [names[k], "ambient"], "conductance_W_per_K": {"poly": [0.2 + 0.03 * k]}})
    heats: list[dict[str, Any]] = [{"node": names[0], "power_W": {"poly": [1e-4, 0.01, 0]}}]
    if channels:
        paths[-1]["factors"] = [fan, voltage]
        paths[0]["factors"] = [fan]
        heats.append(
            {"node": names[1], "power_W": {"poly": [0.05]}, "factors": [current], "per_K": 0.0039, "reference_degC": 20}
        )
    sensors: list[dict[str, Any]] = [{}, {"lag_s": 6.0}, {"offset_K": 0.4}]
    network: dict[str, Any] = {
        "nodes": [
            {
                "name": name,
                "capacity_J_per_K": 60.0 + 45.0 * k,
                **({"sensor": sensors[k // 2 % 3]} if k % 2 == 0 else {}),
            }
            for k, name in enumerate(names)
        ],
        "paths": paths,
        "heats": heats,
    }
    if channels:
        network["channels"] = [
            {"column": "fan_rpm", "range": [0, 3000], "neutral": 0},
            {"column": "current_A", "range": [-12, 12], "neutral": 0},
            {"column": "voltage_V", "range": [6, 14], "neutral": 12},
        ]
    return _file("chain", domain, network)


def with_sensors(sensors: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """A small network of three sensed nodes with these sensors."""
    file = chain(5, domain=(96, 119), channels=True)
    for node, sensor in zip(file["network"]["nodes"][::2], sensors, strict=True):
        node["sensor"] = sensor
    return file


def assert_proven(out: Path, program: Program) -> None:
    """What is emitted is proven, with a bound that is no looser than it has to be."""
    assert program.network is not None
    for part, component in zip(gen.check(out).parts, program.network.components(), strict=True):
        assert component.proof.bound_K <= part.bound_K <= component.proof.bound_K * 1.002


def assert_about(out: Path, folder: Path, file: dict[str, Any], key: str, parts: str) -> None:
    """A certificate is about its file, and not about one of which a sensor's number is another one by 1e-9."""
    same, other = folder / "same.json", folder / "other.json"
    same.write_text(json.dumps(file))
    assert gen.check(out, coefficients=gen.load(same))
    file["network"]["nodes"][0]["sensor"][key] *= 1.0 + 1e-9
    other.write_text(json.dumps(file))
    with pytest.raises(CheckFailed, match=f"about other {parts}"):
        gen.check(out, coefficients=gen.load(other))


def read(given: dict[str, Any]) -> Coefficients:
    """A coefficient file from its tree."""
    return parse(json.dumps(given).encode())


def emitted(folder: Path, coefficients: Coefficients, arithmetic: Arithmetic) -> tuple[Path, Program]:
    """The library, its certificate and its manifest."""
    program = lower(coefficients, arithmetic, "table")
    files = render.library(project_context(coefficients, program, "coefficients.json"))
    files[CERTIFICATE] = certificate_json(coefficients, program)
    proofs = [{"name": one.name, "proof": one.proof.describe()} for one in program.parts if one.proof is not None]
    files["manifest.json"] = json.dumps({"components": proofs})
    for name, text in files.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    return folder, program


def digest(folder: Path) -> str:
    """Of all files, to see that none was changed."""
    return hashlib.sha256(
        b"".join(path.read_bytes() for path in sorted(folder.rglob("*")) if path.is_file())
    ).hexdigest()
