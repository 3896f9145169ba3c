"""What is said of an effect beside its parameters: the chance of an improvement, and whether the name is certain."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest

from gen.arrays import FloatArray
from gen.model.effects import Free, Variant, registry
from gen.refinement.parts.candidates import Candidate, Found, Tracing
from gen.refinement.parts.effect_entries import effect_entries
from gen.refinement.parts.judgement import Judgement, p_better
from gen.refinement.parts.simulation_fit import HypothesisFit, Term
from gen.refinement.parts.stacked_runs import StackedRuns
from gen.refinement.parts.steps.couple import _rise
from gen.refinement.parts.trace_state import ComponentState

DIRECTION = registry()["direction"]
GAIN = Free("reverse_heating", 0.1, -5.0, 5.0)


def fitted(left_out: FloatArray) -> HypothesisFit:
    """A fit of one run that leaves these errors where it did not look, shape (bins,)."""
    error = left_out[:, None, None]
    return HypothesisFit(
        terms=(Term(DIRECTION, Variant({}, (GAIN,)), (0.1,)),),
        numbers=np.full((1, 1), 0.2),
        spread=np.full((1, 1), 0.01),
        folds=np.full((1, 2, 1), 0.2),
        offset=np.zeros(1),
        error=error,
        left_out=error,
        loss=np.array([np.mean(left_out**2)]),
    )


def chance(gains: list[float]) -> float:
    """The p-value where each block's mean square falls by so much, K^2."""
    bins = len(gains)
    problem = SimpleNamespace(weight=np.ones((bins, 1, 1, 1)), blocks=np.arange(bins)[:, None])
    worse = np.sqrt(100.0 + np.array(gains))
    return p_better(cast(StackedRuns, problem), 0, fitted(worse), fitted(np.full(bins, 10.0)))


def test_the_smaller_of_two_chances_is_doubled_for_the_choice() -> None:
    # 1..6: mean 3.5, s 1.8708, t = 3.5/(1.8708/sqrt 6) = 4.5826, of which Student's t with 5 degrees leaves 0.002968 ..
    assert chance([1.0, 2.0, 3.0, 4.0, 5.0, 6.0]) == pytest.approx(2 * 0.002968, rel=1e-3)
    # .. and where one block gains nearly all, six signs of one kind have the chance 1/64, t has 0.18.
    assert chance([0.01, 0.02, 0.03, 0.04, 0.05, 60.0]) == pytest.approx(2 / 64, rel=1e-6)
    assert chance([-1.0, -2.0, -3.0, -4.0, -5.0, -6.0]) == 1.0


def test_fewer_than_three_blocks_say_nothing() -> None:
    assert chance([50.0, 60.0]) == 1.0
    assert chance([0.0, 0.0, 0.0, 0.0]) == 1.0
    assert chance([4.0, 4.0, 4.0]) == 0.0


def found(*, lookalikes: bool) -> Tracing:
    fit = fitted(np.full(8, 0.5))
    judgement = Judgement(1e-6, 3.0, 1.0, ())
    candidate = Candidate(DIRECTION, fit.terms[0].variant, fit, 0, judgement, False)
    other = Candidate(registry()["schedule_error"], fit.terms[0].variant, fit, 0, judgement, False)
    problem = SimpleNamespace(components=("casing",), noise_K=np.array([0.5]), left_out_parts="whole runs")
    one = Found("casing", candidate, [other] if lookalikes else [])
    return Tracing(cast(StackedRuns, problem), [one], {"casing": fit}, {"casing": fit}, {}, 20)


@pytest.mark.parametrize(
    ("lookalikes", "explained", "confident"),
    [(False, True, True), (True, True, False), (False, False, False), (True, False, False)],
)
def test_a_name_is_certain_only_where_all_is_explained_and_nothing_looks_alike(
    lookalikes: bool, explained: bool, confident: bool
) -> None:
    (entry,) = effect_entries(found(lookalikes=lookalikes), explained=explained)
    assert entry.evidence["confident"] is confident
    assert [other["name"] for other in entry.evidence["lookalikes"]] == (["schedule_error"] if lookalikes else [])


@pytest.mark.parametrize(("offset_K", "written"), [(0.24, False), (0.26, True), (-0.24, False), (-0.26, True)])
def test_an_offset_within_the_tolerance_is_written_down_from_half_the_noise_on(offset_K: float, written: bool) -> None:
    """It was fitted beside the effect, whose parameters hold beside it alone; the noise here is 0.5 K."""
    traced = found(lookalikes=False)
    traced.final["casing"] = replace(traced.final["casing"], offset=np.array([offset_K]))
    entries = effect_entries(traced, explained=True)
    assert [entry.name for entry in entries] == ["direction", *(["sensor_offset"] if written else [])]
    if written:
        assert dict(entries[1].parameters) == {"offset_K": pytest.approx(offset_K)}
        assert entries[1].evidence["within_tolerance"] is True


def test_what_another_part_is_told_is_a_rise_and_not_a_temperature() -> None:
    """A coupling compares rises: 30 degC of ambient in one of them would be a heater that nobody built."""
    base = np.linspace(0.0, 20.0, 5)[:, None, None, None]
    track = SimpleNamespace(
        base=base, ambient=np.full(base.shape, 30.0), measured_ambient=np.full(base.shape, 30.0), elapsed=base
    )
    final = SimpleNamespace(terms=(), values=lambda c: [])
    runs = SimpleNamespace(track=track, residual=np.zeros((4, 1, 1, 1)))
    track.measured_rise = np.zeros(1)
    track.fading = np.ones(base.shape)
    rise = _rise(cast(ComponentState, SimpleNamespace(final=final, runs=runs)))
    np.testing.assert_allclose(rise[:, 0], base[:, 0, 0, 0])
