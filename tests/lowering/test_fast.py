"""The fast form's products, its proven bound against adversaries, and what it refuses."""

from __future__ import annotations

import json
from fractions import Fraction
from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from gen.coefficients import Coefficients, parse
from gen.errors import CheckFailed, InputError
from gen.lowering import fast_block
from gen.lowering.fast_format import (
    BLOCK,
    NARROW_LOSS,
    FastComponent,
    fast_loss,
    fast_product,
    narrow_product,
    rounded_product,
)
from gen.lowering.lower import Program, lower
from gen.model.exact import ExactSolution
from gen.reference import fast as reference
from gen.reference.model import ReferenceModel
from tests.verify.test_saturation import unstable
from tests.verify_helpers import EXAMPLES, ROOT, example

LIMIT_K = 1e-4


@cache
def fast(name: str) -> Program:
    return lower(example(name), "fixed", "table", "fast")


@given(st.integers(-(2**31), 2**31 - 1), st.integers(0, 2**32 - 1))
@settings(max_examples=400)
def test_the_product_loses_no_more_than_it_says(difference: int, rate: int) -> None:
    exact = Fraction(difference * rate, 2**32)
    assert 0 <= exact - fast_product(difference, rate) <= fast_loss()
    short = difference >> 8 << 8
    assert 0 <= Fraction(short * rate, 2**32) - fast_product(short, rate) <= fast_loss(narrow=True)
    assert abs(exact - rounded_product(difference, rate)) <= Fraction(1, 2)


@given(st.integers(-(2**23), 2**23 - 1), st.integers(0, 2**24 - 1))
@settings(max_examples=400)
def test_the_narrow_product_loses_no_more_than_it_says(difference: int, rate: int) -> None:
    assert 0 <= Fraction(difference * rate, 2**16) - narrow_product(difference, rate) <= NARROW_LOSS


def test_the_stated_loss_is_all_but_reached() -> None:
    difference, rate = 0xFDFDFDFD - 2**32, 0xABABABAB  # every byte product ends in 0xFF
    assert Fraction(difference * rate, 2**32) - fast_product(difference, rate) > 0.8 * fast_loss()


@pytest.mark.parametrize("j", range(1, BLOCK))
@pytest.mark.parametrize("y", [1e-5, 5.5e-4, 3e-3])
def test_a_share_of_a_block_is_the_exponential_s(j: int, y: float) -> None:
    part = np.array([300_000_000, -123_456_789, 5])
    rate = np.full(3, round(y * 2**40))
    forward = reference.share(part, rate, j, fast_block.FORWARD[j - 1])
    backward = reference.share(part, rate, j, fast_block.BACKWARD[j - 1])
    m = j / BLOCK
    room = 0.6 + 1.2 * y**3 * np.abs(part)  # rounding, and the series' rest
    assert np.all(np.abs(forward - part * -np.expm1(m * np.log1p(-y)) / y) < room)
    assert np.all(np.abs(backward - part * np.expm1(-m * np.log1p(-y)) / y) < room)


@pytest.mark.parametrize("name", EXAMPLES)
def test_every_component_is_proven_within_the_limit(name: str) -> None:
    assert example(name).accuracy.fast_limit_K == LIMIT_K
    for component in fast(name).components:
        assert component.proof is not None
        assert component.proof.bound_K <= LIMIT_K


def attacks(low: int, high: int, length: int) -> NDArray[np.int64]:
    """PWM lanes: random and toggling at every sample, held for a few samples, in step with the blocks."""
    random = np.random.default_rng(5)
    step = np.arange(length)
    lanes = [np.full(length, high), np.where(step % 2, high, low)]
    lanes += [np.repeat(random.integers(low, high + 1, length), hold)[:length] for hold in (1, 2, 3, 4, 5, 900)]
    slow = low + (high - low) // 5
    for turn in range(BLOCK):
        lanes += [np.where(step % BLOCK == turn, high, low), np.where(step % BLOCK == turn, slow, high)]
    return np.array(lanes, dtype=np.int64)


def worst_error(program: Program, length: int) -> dict[str, float]:
    """Largest difference from the exact solution under all attacks, from the domain's extreme starts, in K."""
    pwm = attacks(*program.model.domain_pwm, length)
    pwm = np.vstack([pwm, pwm])
    low = max(component.start_range_mK[0] for component in program.components if isinstance(component, FastComponent))
    high = min(component.start_range_mK[1] for component in program.components if isinstance(component, FastComponent))
    start = np.repeat([-(-low // 250) * 250, high // 250 * 250], len(pwm) // 2)
    names = program.model.component_names
    exact = ExactSolution(program.model).simulate(pwm, dict.fromkeys(names, start / 1000.0))
    model = ReferenceModel(program, start.tolist())
    worst = np.zeros(len(names))
    for step in range(length):
        model.step(pwm[:, step])
        truth = np.array([exact[name][:, step + 1] for name in names])
        worst = np.maximum(worst, np.abs(model.rises - truth).max(axis=1))
    return dict(zip(names, worst.tolist(), strict=True))


@pytest.mark.parametrize("name", EXAMPLES)
def test_no_attack_exceeds_the_bound(name: str) -> None:
    program = fast(name)
    for component, error in worst_error(program, 4000).items():
        proof = next(item.proof for item in program.components if item.name == component)
        assert proof is not None
        assert error < proof.bound_K


def test_without_the_change_s_correction_the_bound_is_exceeded(monkeypatch: pytest.MonkeyPatch) -> None:
    """The attacks can tell: straight lines within a block instead of the series are far off."""
    monkeypatch.setattr(reference, "FORWARD", ((0, 0),) * 3)
    monkeypatch.setattr(reference, "BACKWARD", ((0, 0),) * 3)
    errors = worst_error(fast("my1016"), 3000)
    assert errors.pop("brush") < LIMIT_K  # not in blocks
    assert min(errors.values()) > 10.0 * LIMIT_K


def test_a_lost_residue_exceeds_the_bound(monkeypatch: pytest.MonkeyPatch) -> None:
    """Without the lowest byte of its words no component keeps its own bound."""
    advance = reference.FastLanes.sample

    def forgetful(self: reference.FastLanes, row: NDArray[np.int64], before: NDArray[np.int64] | None) -> None:
        advance(self, row, before)
        self._state = [word & ~0xFF for word in self._state]

    monkeypatch.setattr(reference.FastLanes, "sample", forgetful)
    program = fast("my1016")
    errors = worst_error(program, 3000)
    assert [item.name for item in program.components if item.proof and errors[item.name] < item.proof.bound_K] == []


def changed(**changes: object) -> Coefficients:
    document = json.loads((ROOT / "examples" / "my1016" / "coeffs.json").read_text())
    for path, value in changes.items():
        part = document
        *parents, last = path.split("__")
        for key in parents:
            part = part[int(key)] if isinstance(part, list) else part.setdefault(key, {})
        part[last] = value
    return parse(json.dumps(document).encode())


def test_a_bound_over_the_file_s_limit_is_an_error_that_names_the_component() -> None:
    with pytest.raises(CheckFailed, match=r"component brush: .* exceeds \$\.accuracy\.fast_limit_K"):
        lower(changed(accuracy__fast_limit_K=1e-6), "fixed", "table", "fast")


def test_what_is_too_fast_is_refused_by_name() -> None:
    too_fast = changed(components__1__poles=[{"real": {"poly": [-0.02]}}], components__1__gain={"poly": [1e-3]})
    with pytest.raises(CheckFailed, match=r"component bearing: no fast form, .*too fast"):
        lower(too_fast, "fixed", "table", "fast")


def test_what_cannot_be_proven_is_refused_instead_of_saturating() -> None:
    with pytest.raises(CheckFailed, match=r"component winding: no fast form, its range cannot be proven"):
        lower(unstable(), "fixed", "table", "fast")


@pytest.mark.parametrize(("arithmetic", "schedule"), [("float", "table"), ("fixed", "onboard"), ("float", "onboard")])
def test_only_fixed_point_with_a_table_is_made_fast(arithmetic: str, schedule: str) -> None:
    with pytest.raises(InputError, match="--speed fast"):
        lower(example("my1016"), arithmetic, schedule, "fast")  # type: ignore[arg-type]
