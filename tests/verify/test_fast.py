"""The fast form on the host and on the emulated board: equal to its reference, cheap, and faults are found."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from gen.firmware import render
from gen.firmware.context import project_context
from gen.lowering.lower import lower
from gen.verify.compare import first_mismatch, reference_run
from gen.verify.profiles import campaign
from gen.verify.runners import AvrRunner, HostRunner, write_library
from gen.verify.verify import CombinationResult, Target, verify
from tests.verify.test_verify import Files, replaced
from tests.verify_helpers import EXAMPLES, example


def run(name: str) -> CombinationResult:
    (result,) = verify(
        example(name),
        ["fixed"],
        ["table"],
        "all",
        scale=0.03,
        host_builds=["clang++ sanitized"],
        speeds=["fast"],
    )
    return result


@pytest.mark.parametrize("name", EXAMPLES)
def test_every_example_is_equal_and_within_its_bound(name: str) -> None:
    result = run(name)
    assert [target.target for target in result.targets if target.differing] == []
    assert sum(target.samples for target in result.targets) > 38_000
    for component, bound in result.bound_K.items():
        assert bound is not None
        assert result.error_K[component] < bound <= 1e-4
    assert result.helpers == []
    assert result.cost is not None
    assert result.cost.ram_bytes < 80
    if name != "two_mass":  # the MY1016's four components
        assert result.cost.cycles_constant < 450


def without(path_end: str, text: str) -> Callable[[Files], Files]:
    """A fault: the line with some text left out; there must be just one."""

    def mutate(files: Files) -> Files:
        path = next(path for path in files if path.endswith(path_end))
        lines = files[path].splitlines(keepends=True)
        kept = [line for line in lines if text not in line]
        assert len(kept) == len(lines) - 1
        return files | {path: "".join(kept)}

    return mutate


FAULTS: dict[str, tuple[Target, Callable[[Files], Files]]] = {
    "lost residue": ("host", replaced("_step.h", "(uint8_t)(whole & 0xFF)", "(uint8_t)(whole & 0xFE)")),
    "block not brought forward at a change": (
        "host",
        without("my1016.cpp", "_move(state->b[1].x, &now->b[1], elapsed(1), false"),
    ),
    "lost carry in the assembly": ("avr", replaced(".cpp", "adc r23, r24", "add r23, r24")),
    "missing cast to 32 bits": (
        "avr",
        replaced("_step.h", "const int32_t units = (rise_mK < 0", "const int32_t units = (int)(rise_mK < 0"),
    ),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_a_planted_fault_is_caught(fault: str, tmp_path: Path) -> None:
    """With the runners, profiles and comparison of `gen verify`, on a few samples."""
    target, mutation = FAULTS[fault]
    coefficients = example("my1016")
    program = lower(coefficients, "fixed", "table", "fast")
    context = project_context(coefficients, program, "coeffs.json")
    profile = campaign(program.model, lanes=6, length=300)
    expected = reference_run(program, profile)
    for faulty in (False, True):
        files = render.library(context)
        folder = tmp_path / ("faulty" if faulty else "right")
        folder.mkdir()
        library = write_library(program, context, mutation(files) if faulty else files, folder)
        runner = HostRunner(library, "g++ -O2") if target == "host" else AvrRunner(library, tmp_path / "cache")
        assert (first_mismatch(expected, runner.run(profile)) is not None) == faulty


@pytest.mark.parametrize("optimisation", ["-O2", "-Os"])
def test_a_sample_at_constant_pwm_takes_less_than_450_cycles(optimisation: str, tmp_path: Path) -> None:
    coefficients = example("my1016")
    program = lower(coefficients, "fixed", "table", "fast")
    context = project_context(coefficients, program, "coeffs.json")
    board = AvrRunner(
        write_library(program, context, render.library(context), tmp_path), tmp_path / "cache", optimisation
    )
    profile = campaign(program.model, lanes=6, length=300)
    board.run(profile)
    cost = board.cost(profile)
    assert cost.cycles_constant < 450
    assert cost.ram_bytes < 80
