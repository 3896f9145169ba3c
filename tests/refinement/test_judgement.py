"""What is accepted as an effect, and what a verdict means: the rules alone, on residuals made for them."""

from __future__ import annotations

import json
from collections.abc import Sequence
from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest

from gen.arrays import FloatArray
from gen.coefficients import parse
from gen.model.effects import Applied, Free, Variant, registry
from gen.refinement.admission import admitted
from gen.refinement.condense import Condensed
from gen.refinement.gains import TOO_LITTLE
from gen.refinement.parts.candidates import Candidate, Found, Tracing
from gen.refinement.parts.effect_entries import entry
from gen.refinement.parts.judgement import ALONE, RUNS_AWAY, Judgement, judge, p_better
from gen.refinement.parts.refine import judge_verdict
from gen.refinement.parts.simulation_fit import HypothesisFit, Term
from gen.refinement.parts.stacked_runs import StackedRuns
from tests.examples import ROOT, example

BINS, RUNS, BLOCKS = 60, 6, 6
EFFECT = registry()["direction"]
GAIN = Free("reverse_heating", 0.1, -5.0, 5.0)
TAU = Free("node_tau_s", 600.0, 10.0, 40_000.0, log=True, role="time constant")


def problem(noise_K: float = 1.0) -> StackedRuns:
    """Runs of equal bins, one sample each."""
    blocks = (np.arange(BINS) * BLOCKS // BINS)[:, None] + BLOCKS * np.arange(RUNS)[None, :]
    made = SimpleNamespace(
        components=("casing",),
        noise_K=np.array([noise_K]),
        weight=np.ones((BINS, 1, 1, RUNS)),
        blocks=blocks,
        runs_away=lambda _: False,
    )
    return cast(StackedRuns, made)


def fitted(
    left_out: FloatArray,
    *free: Free,
    value: float = 1.0,
    spread: float = 0.05,
    folds: tuple[float, ...] = (1.0,) * RUNS,
) -> HypothesisFit:
    """A fit that leaves this on the runs that it did not see, shape (BINS, RUNS)."""
    chosen = free or (GAIN,)
    numbers = np.full((1, len(chosen)), value)
    return HypothesisFit(
        terms=(Term(EFFECT, Variant({}, chosen), tuple(item.start for item in chosen)),),
        numbers=numbers,
        spread=np.full((1, len(chosen)), spread),
        folds=np.tile(np.array(folds)[None, :, None], (1, 1, len(chosen))),
        offset=np.zeros(1),
        error=left_out[:, None, :],
        left_out=left_out[:, None, :],
        loss=np.array([np.mean(left_out**2)]),
    )


def residual(seed: int, rms_K: float = 3.0) -> FloatArray:
    """Blocks of one size each, as slow errors are."""
    sizes = rms_K * np.random.default_rng(seed).uniform(0.8, 1.2, (BLOCKS, RUNS))
    return np.repeat(sizes, BINS // BLOCKS, axis=0)


def test_a_clear_improvement_is_accepted() -> None:
    null = residual(1)
    judgement = judge(problem(), 0, fitted(null), fitted(0.5 * null), 100, 0)
    assert judgement.accepted
    noisy = np.sqrt(np.mean(null**2) + 1.0), np.sqrt(np.mean(null**2) / 4.0 + 1.0)
    assert (judgement.before_K, judgement.after_K) == pytest.approx(noisy)


def test_an_effect_with_which_temperatures_would_run_away_is_refused_however_good_it_is() -> None:
    null = residual(1)
    asked: list[Applied] = []

    def runs_away(effects: Sequence[Applied]) -> bool:
        asked.extend(effects)
        return True

    growing = cast(StackedRuns, SimpleNamespace(**{**vars(problem()), "runs_away": runs_away}))
    assert judge(growing, 0, fitted(null), fitted(0.5 * null), 100, 0).reasons == (RUNS_AWAY,)
    assert [(a.effect.name, a.component, a.values) for a in asked] == [(EFFECT.name, "casing", {GAIN.name: 1.0})]


def test_an_improvement_not_worth_a_parameter_is_refused_however_sure_it_is() -> None:
    null = residual(2)
    judgement = judge(problem(), 0, fitted(null), fitted(0.98 * null), 1, 0)
    assert judgement.p_value < 1e-6
    assert judgement.reasons == (TOO_LITTLE,)


def test_who_tries_many_hypotheses_needs_a_clearer_one() -> None:
    """Of twenty that say nothing one passes a test at 5 %."""
    random = np.random.default_rng(3)
    null, moved = residual(3), np.repeat(random.normal(0.0, 1.0, (BLOCKS, RUNS)), BINS // BLOCKS, axis=0)
    low, high = 0.0, 2.0
    for _ in range(40):
        shift = 0.5 * (low + high)
        found = fitted(np.sqrt(np.maximum(null**2 - 4.0 * (moved + shift), 0.0)))
        p = p_better(problem(), 0, fitted(null), found)
        low, high = (low, shift) if p < 0.01 else (shift, high)
    assert 0.002 < p < 0.04
    for tried, chance in ((1, False), (25, True)):
        judgement = judge(problem(), 0, fitted(null), found, tried, 0)
        assert ("not more than chance" in judgement.reasons) == chance


def test_effects_that_are_none_pass_no_more_often_than_the_level_says() -> None:
    random = np.random.default_rng(4)
    count, passed = 600, 0
    for _ in range(count):
        changes = np.repeat(random.normal(0.0, 1.0, (BLOCKS, RUNS)), BINS // BLOCKS, axis=0)
        pair = fitted(np.sqrt(9.0 + changes)), fitted(np.full((BINS, RUNS), 3.0))
        passed += p_better(problem(), 0, *pair) <= 0.05
    assert passed <= count * 0.05 + 2.0 * np.sqrt(count * 0.05 * 0.95)
    assert passed > 0.01 * count  # nor is the test one that never passes


@pytest.mark.parametrize(("spread", "told"), [(0.4, True), (0.6, False), (np.inf, False)])
def test_a_size_whose_interval_holds_zero_is_none(spread: float, told: bool) -> None:
    null = residual(5)
    judgement = judge(problem(), 0, fitted(null), fitted(0.5 * null, spread=spread), 100, 0)
    assert judgement.accepted == told
    assert ("reverse_heating cannot be told from no effect" in judgement.reasons) != told


def test_a_run_that_gets_worse_refuses_what_helps_all_others() -> None:
    null = residual(5)
    better = 0.5 * null
    better[:, 2] = 1.3 * null[:, 2]
    assert "makes a run worse where it was left out" in judge(problem(), 0, fitted(null), fitted(better), 1, 0).reasons
    better[:, 2] = null[:, 2]
    assert judge(problem(), 0, fitted(null), fitted(better), 1, 0).accepted


@pytest.mark.parametrize(
    ("folds", "reason"),
    [
        ((1.0, 1.1, 0.9, 1.0, 1.2, -0.2), "reverse_heating cannot be told from no effect"),
        ((1.0, 1.1, 0.9, 1.0, 1.2, 0.15), "reverse_heating cannot be told from no effect"),
        ((1.0, 1.1, 0.9, 1.0, 1.2, 0.1), ALONE),  # where the fit began: without that run nothing speaks for it
    ],
)
def test_an_effect_has_to_be_there_whichever_run_is_left_out(folds: tuple[float, ...], reason: str) -> None:
    null = residual(6)
    assert judge(problem(), 0, fitted(null), fitted(0.5 * null, folds=folds), 1, 0).reasons == (reason,)


@pytest.mark.parametrize(
    ("value", "spread", "reason"),
    [
        (600.0, 0.3, None),
        (600.0, 2.5, "node_tau_s is not determined"),
        (39_900.0, 0.3, "node_tau_s is at its limit"),
        (10.05, 0.3, "node_tau_s is at its limit"),
    ],
)
def test_a_time_constant_has_to_be_a_part_s(value: float, spread: float, reason: str | None) -> None:
    null = residual(7)
    found = fitted(0.5 * null, Free("heating_K_per_s", 0.1, 0.0, 1e6), TAU, value=value, spread=spread)
    assert judge(problem(), 0, fitted(null), found, 1, 0).reasons == ((reason,) if reason else ())


def test_a_size_at_its_physical_limit_stands_for_something_else() -> None:
    null = residual(8)
    found = judge(problem(), 0, fitted(null), fitted(0.5 * null, value=5.0), 1, 0)
    assert found.reasons == ("reverse_heating is at its physical limit",)


def tracing(before: tuple[float, ...], after: tuple[float, ...], *found: Found) -> Tracing:
    """Components that are off by so many noise floors without effects, and with those found."""
    names = tuple(f"part{i}" for i in range(len(before)))
    made = SimpleNamespace(components=names, noise_K=np.full(len(names), 0.5), left_out_parts="whole runs")

    def fits(ratios: tuple[float, ...]) -> dict[str, HypothesisFit]:
        return {
            n: fitted(np.full((BINS, RUNS), 0.5 * np.sqrt(r * r - 1.0))) for n, r in zip(names, ratios, strict=True)
        }

    return Tracing(cast(StackedRuns, made), list(found), fits(after), fits(before), {}, 20)


def effect(*, by_stretch: bool = False) -> Found:
    judgement = Judgement(1e-6, 3.0, 1.0, ())
    fit = fitted(residual(9))
    return Found("part0", Candidate(EFFECT, fit.terms[0].variant, fit, 0, judgement, by_stretch), [])


@pytest.mark.parametrize(
    ("before", "after", "found", "verdict"),
    [
        ((1.4, 1.3), (1.4, 1.3), (), "nothing missing"),
        ((1.6, 1.6), (1.6, 1.6), (), "unexplained"),
        ((1.0, 1.0, 1.0, 1.6), (1.0, 1.0, 1.0, 1.6), (), "unexplained"),  # one part is enough
        ((3.0, 1.2), (1.25, 1.2), (effect(),), "explained"),
        ((3.0, 1.2), (1.4, 1.35), (effect(),), "partly explained"),
        ((3.0, 1.0, 1.0, 1.6), (1.1, 1.0, 1.0, 1.6), (effect(),), "partly explained"),
        ((3.0, 1.2), (1.25, 1.2), (effect(by_stretch=True),), "partly explained"),  # no whole run was left out
    ],
)
def test_a_verdict_is_about_what_is_left_on_left_out_runs(
    before: tuple[float, ...], after: tuple[float, ...], found: tuple[Found, ...], verdict: str
) -> None:
    assert judge_verdict(tracing(before, after, *found)) == verdict


def test_an_interval_has_two_standard_errors_to_each_side_within_what_is_possible() -> None:
    traced = tracing((3.0,), (1.1,), effect())
    found = Found("part0", effect().candidate, [])
    traced.final["part0"] = fitted(residual(9), value=1.9, spread=0.25)
    assert entry(found, traced).evidence["intervals_95"]["reverse_heating"] == pytest.approx([1.4, 2.4])
    traced.final["part0"] = fitted(residual(9), value=1.9, spread=1.6)
    assert entry(found, traced).evidence["intervals_95"]["reverse_heating"] == pytest.approx([-1.3, 5.0])


def logged(name: str, residual_K: float = 0.0, comments: dict[str, str] | None = None) -> Condensed:
    """A run at PWM 128 whose casing is off by so much all the time."""
    trace = SimpleNamespace(residual=np.full(40, residual_K))
    made = SimpleNamespace(name=name, pwm=np.full(40, 128.0), traces={"casing": trace}, comments=comments or {})
    return cast(Condensed, made)


@pytest.mark.parametrize(
    ("comments", "taken"),
    [
        ({}, True),
        ({"fault": "none"}, True),
        ({"healthy": "yes"}, True),
        ({"fault": "Bearing"}, False),
        ({"healthy": "no"}, False),
        ({"fault": "none", "healthy": "False"}, False),
    ],
)
def test_a_run_of_a_motor_that_was_not_healthy_teaches_nothing(comments: dict[str, str], taken: bool) -> None:
    kept, warnings = admitted(example("my1016"), [logged("good.csv"), logged("this.csv", comments=comments)])
    assert [run.name for run in kept] == ["good.csv", *(["this.csv"] if taken else [])]
    assert bool([text for text in warnings if text.startswith("this.csv")]) != taken


@pytest.mark.parametrize(
    ("kind", "off_K", "warned"),
    [
        ("above_model", 6.0, True),
        ("above_model", -6.0, False),
        ("below_model", -6.0, True),
        ("below_model", 6.0, False),
        ("above_model", 4.5, False),
    ],
)
def test_what_looks_like_a_fault_that_a_rule_watches_for_is_pointed_at(kind: str, off_K: float, warned: bool) -> None:
    document = json.loads((ROOT / "examples" / "my1016" / "coeffs.json").read_text(encoding="utf-8"))
    document["alarms"] = [{"name": "watch", "kind": kind, "component": "casing", "threshold_K": 5.0}]
    coefficients = parse(json.dumps(document).encode())
    kept, warnings = admitted(coefficients, [logged("good.csv"), logged("odd.csv", off_K)])
    assert len(kept) == 2
    assert bool([text for text in warnings if '"watch"' in text and "odd.csv" in text]) == warned
