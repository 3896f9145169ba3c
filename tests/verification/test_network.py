"""`gen verify` of networks: every word on every target, and that a fault in the emitted C++ is seen."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import pytest

import gen
from gen.coefficients import Coefficients, load, parse
from gen.lowering.kinds import Arithmetic
from gen.verification.verify import verify
from tests.examples import ROOT
from tests.networks import loaded, network_tree

ARITHMETICS: tuple[Arithmetic, ...] = ("fixed", "float")
CASES: dict[str, Callable[[], Coefficients]] = {
    "example": lambda: load("examples/network/coeffs.json"),
    "two nodes": lambda: load("examples/two_nodes/coeffs.json"),
    "ten nodes": lambda: loaded(network_tree(5, 10, plain=True)),
    "seven nodes, channels": lambda: loaded(network_tree(6, 7)),
}


@pytest.mark.parametrize("arithmetic", ARITHMETICS)
@pytest.mark.parametrize("name", CASES)
def test_no_word_differs_and_no_error_exceeds_its_bound(name: str, arithmetic: Arithmetic) -> None:
    builds = ("g++ -O2", "clang++ sanitized")
    (result,) = verify(CASES[name](), (arithmetic,), ("table",), "all", scale=0.04, host_builds=builds)
    assert result.passed
    assert {target.target.partition(",")[0] for target in result.targets} == {*builds, "ATmega2560 (simavr)"}
    assert all(target.words > 0 for target in result.targets)
    assert set(result.error_K) == set(result.bound_K)
    for component, bound in result.bound_K.items():
        assert bound is not None
        assert 0.0 < result.error_K[component] <= bound
    assert result.cost is not None
    assert result.cost.cycles_change < 100_000


@pytest.mark.parametrize("arithmetic", ARITHMETICS)
def test_a_node_may_be_called_as_the_library_calls_its_own(arithmetic: Arithmetic) -> None:
    """Functions, types and states of the emitted C++, and what the reading that lags would be called."""
    text = (ROOT / "examples" / "network" / "coeffs.json").read_text(encoding="utf-8")
    for node, name in {
        "brush": "model",
        "winding": "model_sensor",
        "bearing": "step",
        "magnet": "T_model",
        "casing": "difference",
    }.items():
        text = text.replace(f'"{node}"', f'"{name}"')
    (result,) = verify(
        parse(text.encode()), (arithmetic,), ("table",), "host", scale=0.01, host_builds=("g++ -O2", "clang++ -O2")
    )
    assert result.passed
    assert result.refuted is None
    assert set(result.proven_K) == {"model", "step", "T_model", "difference"}


_FAULTS: dict[str, tuple[str, str, str]] = {
    "a table's word": ("schedule.cpp", r"(PROGMEM = \{\n    )(\d+)UL", r"\g<1>1\g<2>UL"),
    "a source": ("step.cpp", r"v\[AMBIENT\] - ", r"v[fan_motor_T_magnet] - "),
    "a shift": ("step.cpp", r"(take_up\(&T\[fan_motor_T_casing\], sum, )(\d+)", r"\g<1>9"),
    "an offset": (".cpp", r"(READING\[.*?\] PROGMEM = \{\n    \{)(-?\d+)L", r"\g<1>\g<2>1L"),
}


@pytest.mark.parametrize("name", _FAULTS)
def test_a_fault_in_the_emitted_library_is_seen(name: str) -> None:
    end, pattern, instead = _FAULTS[name]

    def planted(files: dict[str, str]) -> dict[str, str]:
        path = next(path for path in files if path.endswith(f"fan_motor{'_' if end != '.cpp' else ''}{end}"))
        changed, count = re.subn(pattern, instead, files[path], count=1, flags=re.DOTALL)
        assert count == 1
        assert changed != files[path]
        return {**files, path: changed}

    coefficients = load("examples/network/coeffs.json")
    (result,) = verify(
        coefficients, ("fixed",), ("table",), "host", scale=0.02, host_builds=("g++ -O2",), mutation=planted
    )
    assert not result.equal


def test_a_schedule_on_board_is_refused_in_one_line() -> None:
    model = gen.load(Path("examples/network/coeffs.json"))
    with pytest.raises(gen.InputError, match="--schedule onboard"):
        gen.verify(model, schedule="onboard")
