"""`gen verify` finds nothing in good code and finds every planted fault."""

from __future__ import annotations

from collections.abc import Callable
from typing import get_args

import pytest

from gen.lowering.kinds import Arithmetic, ScheduleKind
from gen.verification.runners import HOST_BUILDS
from gen.verification.verify import CombinationResult, Target, summary, verify
from tests.campaign import FULL
from tests.examples import EXAMPLES, example

Files = dict[str, str]


def run(
    name: str,
    target: Target,
    mutation: Callable[[Files], Files] | None = None,
    arithmetic: Arithmetic = "fixed",
    schedule: ScheduleKind = "table",
) -> CombinationResult:
    return verify(
        example(name), [arithmetic], [schedule], target, mutation=mutation, scale=0.04, host_builds=["g++ -O2"]
    )[0]


@pytest.mark.parametrize("schedule", get_args(ScheduleKind))
@pytest.mark.parametrize("arithmetic", get_args(Arithmetic))
@pytest.mark.parametrize("name", EXAMPLES)
def test_every_combination_of_every_example_is_equal(name: str, arithmetic: Arithmetic, schedule: ScheduleKind) -> None:
    result = run(name, "all", arithmetic=arithmetic, schedule=schedule)
    assert [target.target for target in result.targets if target.differing] == []
    assert sum(target.samples for target in result.targets) > 40_000
    assert result.cost is not None
    limit = 1e-5 if arithmetic == "fixed" else 1e-3
    assert max(result.error_K.values()) < limit
    for component, bound in result.bound_K.items():
        assert bound is not None
        assert result.error_K[component] < bound
    if arithmetic == "fixed":
        assert result.helpers == []
    else:  # the check sees helpers where there are some
        assert "__mulsf3" in result.helpers


@pytest.mark.campaign
def test_the_full_campaign_on_every_host_compiler() -> None:
    scale = 1.0 if FULL else 0.15
    results = verify(example("my1016"), ["fixed"], ["table"], "all", scale=scale)
    assert summary(example("my1016"), results)["verdict"] == "equal"
    builds = [*HOST_BUILDS, "ATmega2560 (simavr)"]
    compared = {
        build + of for build in builds for of in ("", ", every command", ", outputs and alarms", ", protection")
    }
    assert {target.target for target in results[0].targets} == compared


def replaced(path_end: str, old: str, new: str) -> Callable[[Files], Files]:
    """A fault: some text in one file replaced; the text must be there."""

    def mutate(files: Files) -> Files:
        path = next(path for path in files if path.endswith(path_end))
        assert old in files[path], f"nothing to replace in {path}"
        return files | {path: files[path].replace(old, new, 1)}

    return mutate


FAULTS: dict[str, tuple[Target, Callable[[Files], Files]]] = {
    "wrong shift": ("host", replaced("_word.h", "_whole(word) >> 13)", "_whole(word) >> 12)")),
    "lost residue": ("host", replaced("_word.h", "(uint16_t)(whole & 0xFFFF)", "(uint16_t)(whole & 0xFFFE)")),
    "missing cast to 32 bits": (
        "avr",
        replaced("_word.h", "(uint32_t)(uint8_t)rise_mK * upper", "(uint8_t)rise_mK * upper"),
    ),
    "wrong product shift": ("host", replaced("_step.h", "_high32(inner", "_high24(inner")),
    "correction forgotten": ("host", replaced("_step.h", "change * twelfth", "0 * change * twelfth")),
    "half a correction on the board": ("avr", replaced("src/my1016.cpp", "fmul r21", "mul r21")),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_a_planted_fault_is_caught(fault: str) -> None:
    target, mutation = FAULTS[fault]
    result = run("my1016", target, mutation)
    assert not result.passed
    caught = next(item for item in result.targets if item.differing)
    assert caught.mismatch is not None
    assert caught.profile is not None
    assert "step" in caught.mismatch
    assert "reference" in caught.mismatch
    assert len(caught.profile["pwm"]) <= 40  # shrunk from thousands
    # With what the model was told before the start and before each sample, so that it can be run again.
    assert [len(told) for told in caught.profile["channels"].values()] == [len(caught.profile["pwm"]) + 1]


def test_a_changed_constant_is_caught_and_named() -> None:
    def mutate(files: Files) -> Files:
        path = next(path for path in files if path.endswith("_schedule.cpp"))
        lines = files[path].splitlines(keepends=True)
        number = next(i for i, line in enumerate(lines) if line.rstrip().endswith("// 137"))
        digits = lines[number].split("UL", 1)[0].rsplit("{", 1)[1]
        lines[number] = lines[number].replace(digits, str(int(digits) + 1), 1)
        return files | {path: "".join(lines)}

    result = run("my1016", "host", mutate)
    caught = next(item for item in result.targets if item.differing)
    assert caught.mismatch is not None
    assert "brush.R0" in caught.mismatch
    assert caught.profile is not None
    assert [abs(pwm) for pwm in caught.profile["pwm"]] == [137]
