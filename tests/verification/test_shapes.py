"""Kinds of components that no example has: each must be equal on the host and on the emulated board too."""

from __future__ import annotations

import json
from functools import cache
from typing import Any

import pytest

from gen.coefficients import Coefficients, parse
from gen.lowering.fixed.component import FixedComponent
from gen.lowering.lower import lower
from gen.lowering.program import Program
from gen.verification.limits import exceeded
from gen.verification.verify import summary, verify
from tests.examples import ROOT

FAST = [{"real": {"poly": [-0.09]}}, {"real": {"poly": [-1e-6, -0.02]}}]
SLOW = [{"real": {"poly": [-1e-6, -0.002]}}, {"real": {"poly": [-0.001]}}, {"real": {"poly": [-0.004]}}]
STIFFER = {"pwm": [0, 255], "value": [0.008, 0.05], "interpolation": "linear"}
SOFTER = {"pwm": [0, 255], "value": [-0.008, -0.05], "interpolation": "linear"}
#: Switched in time, this oscillator pumps itself up: nothing can be proven, so it saturates.
UNSTABLE = [
    {"real": {"poly": [-0.002]}, "imag": {"table": STIFFER}},
    {"real": {"poly": [-0.002]}, "imag": {"table": SOFTER}},
]
#: Each step alone shrinks within its neighbourhood, but no polytope holds all of their sequences.
SPREAD = [
    {"real": {"poly": [-8e-7, -0.00016]}},
    {"real": {"exp1": [-0.018, -0.0032]}},
    {"real": {"poly": [-1.3e-6, -0.00025]}},
    {"real": {"poly": [-8e-7, -0.00015]}},
]


def _component(name: str, poles: list[dict[str, Any]], gain: float) -> dict[str, Any]:
    return {"name": name, "order": len(poles), "gain": {"poly": [gain]}, "poles": poles}


#: In the order of their shapes on the board: what saturates lies between what does not.
COMPONENTS = [
    _component("winding", FAST, 5.0e-4),
    _component("wire", FAST, 5.1e-4),
    _component("spring", UNSTABLE, 2e-5),
    _component("housing", SLOW, 1.0e-9),
    _component("cover", SLOW, 1.1e-9),
    _component("bulk", SPREAD, 2.8e-14),
    _component("sensor", [{"real": {"poly": [-1e-4, -0.05]}}], 2e-3),
]


@cache
def coefficients(names: tuple[str, ...], limit: float = 1.0) -> Coefficients:
    document: dict[str, Any] = json.loads((ROOT / "examples" / "two_mass" / "coeffs.json").read_text())
    document["components"] = [item for item in COMPONENTS if item["name"] in names]
    document["accuracy"] = {"fixed_limit_K": limit, "float_limit_K": limit, "unproven": "saturate"}
    document["alarms"] = []
    document["wiring"] = {}
    document.pop("provenance", None)
    return parse(json.dumps(document).encode())


def fixed(program: Program, name: str) -> FixedComponent:
    found = next(component for component in program.components if component.name == name)
    assert isinstance(found, FixedComponent)
    return found


ALL = tuple(str(item["name"]) for item in COMPONENTS)


def test_the_kinds_are_there() -> None:
    program = lower(coefficients(ALL), "fixed", "table")
    for name in ("winding", "sensor"):
        assert fixed(program, name).layout.product_shifts[-1] == 16
    members = [{program.components[member].name for member in shape.members} for shape in program.shapes]
    assert {"winding", "wire"} in members
    assert {"housing", "cover"} in members
    place = members.index({"spring"})
    assert fixed(program, "spring").saturates
    assert 0 < place < len(members) - 1
    assert {item.name for item in program.components if fixed(program, item.name).saturates} == {"spring", "bulk"}


@pytest.mark.parametrize("names", [ALL, ("spring", "sensor")])
def test_they_are_equal_everywhere(names: tuple[str, ...]) -> None:
    result = verify(coefficients(names), ["fixed"], ["table"], "all", scale=0.01, host_builds=["g++ sanitized"])[0]
    assert [target.mismatch for target in result.targets] == [None] * len(result.targets)
    assert result.passed


def test_what_is_not_proven_must_keep_the_limit_when_measured() -> None:
    strict = coefficients(("spring",), limit=1e-9)
    result = verify(strict, ["fixed"], ["table"], "host", scale=0.01, host_builds=["g++ -O2"])[0]
    assert result.equal
    assert not result.passed
    assert result.exceeded[0].startswith("component spring: the measured error of ")
    assert result.exceeded[0].endswith(" exceeds $.accuracy.fixed_limit_K = 1.0e-09 K")
    assert summary(strict, [result])["verdict"] == "inaccurate"


def test_an_error_above_its_proof_is_told_even_within_the_limit() -> None:
    bounds = {"proven": 1e-6, "disproven": 1e-6, "open": None}
    errors = {"proven": 0.9e-6, "disproven": 1.1e-6, "open": 0.9e-5}
    (sentence,) = exceeded(bounds, errors, 1e-5, "fixed_limit_K")
    assert sentence.startswith("component disproven: the measured error of 1.1e-06 K exceeds the guaranteed 1.0e-06 K")
