"""The steps of a tracing: their order, that they change nothing they were given, and what the late ones refuse."""

from __future__ import annotations

import hashlib
import re
from collections.abc import Mapping
from dataclasses import fields, is_dataclass, replace
from pathlib import Path

import numpy as np
import pytest

from gen.coefficients import load
from gen.model.effects import Variant, registry
from gen.refinement.condense import condense
from gen.refinement.parts.candidates import Candidate, Found
from gen.refinement.parts.judgement import Judgement
from gen.refinement.parts.refine import refine
from gen.refinement.parts.simulation_fit import Term, fit
from gen.refinement.parts.stacked_runs import THIRDS, WHOLE_RUNS, stack_runs
from gen.refinement.parts.steps.further_effects import further_effects
from gen.refinement.parts.steps.judge_again import judge_again
from gen.refinement.parts.steps.prune import prune
from gen.refinement.parts.steps.refuse_runaway import refuse_runaway
from gen.refinement.parts.trace import STEPS, trace
from gen.refinement.parts.trace_state import ComponentState, TraceState, beginning
from tests.examples import ROOT
from tests.refinement.plant import COEFFICIENTS
from tests.refinement.plant_effects import make


def begun(folder: Path, *kinds: str, seed: int, runs: int | None = None) -> TraceState:
    baseline = load(COEFFICIENTS)
    fit_paths, _, _ = make(folder, kinds, seed)
    return beginning(baseline, [condense(baseline, path) for path in fit_paths[:runs]])


def fingerprint(value: object) -> str:
    """Of all numbers and names that hang on a value."""
    made = hashlib.sha256()

    def add(part: object) -> None:
        if isinstance(part, np.ndarray):
            made.update(repr((part.shape, part.dtype.str)).encode() + part.tobytes())
        elif is_dataclass(part) and not isinstance(part, type):
            for field in fields(part):
                add(getattr(part, field.name))
        elif isinstance(part, Mapping):
            for key, entry in part.items():
                add(key)
                add(entry)
        elif isinstance(part, (list, tuple)):
            made.update(str(len(part)).encode())
            for entry in part:
                add(entry)
        else:
            made.update(repr(part).encode())

    add(value)
    return made.hexdigest()


def test_no_step_changes_the_state_that_it_is_given(tmp_path: Path) -> None:
    state = begun(tmp_path, "hidden_node", seed=11, runs=3)
    changed = []
    for name, step in STEPS:
        before = fingerprint(state)
        after = step(state, lambda _: None)
        assert fingerprint(state) == before, name
        changed += [name] if fingerprint(after) != before else []
        state = after
    assert changed[:2] == [name for name, _ in STEPS[:2]]  # else nothing was seen


def test_a_state_cannot_be_written_to(tmp_path: Path) -> None:
    state = begun(tmp_path, seed=1, runs=2)
    with pytest.raises(TypeError):
        state.components["brush"] = state.components["casing"]  # type: ignore[index]
    with pytest.raises(AttributeError):
        state.components["brush"].found = ()  # type: ignore[misc]


def test_the_steps_stand_in_the_documentation_in_their_order() -> None:
    text = (ROOT / "docs" / "refine.md").read_text(encoding="utf-8")
    section = text[text.index("## The steps of a tracing") :].split("\n## ")[0]
    assert re.findall(r"^\d+\. \*([^*]+)\*", section, flags=re.MULTILINE) == [name for name, _ in STEPS]


def test_progress_names_each_step_and_what_it_is_at(tmp_path: Path) -> None:
    baseline = load(COEFFICIENTS)
    paths, _, _ = make(tmp_path, ("sensor_gain",), 5)
    said: list[str] = []
    found = trace(baseline, [condense(baseline, path) for path in paths], said.append)
    assert [text for text in said if ":" not in text] == [name for name, _ in STEPS]
    at = found.found[0].component
    assert f"each effect alone: {at}, sensor_gain" in said


def with_effects(component: ComponentState, *names: str) -> ComponentState:
    """A component that was given these effects, whatever the data say, each with its first variant."""
    terms, variants = [], {}
    for name in names:
        variant: Variant = registry()[name].variants(component.offered)[0]
        variants[name] = variant
        terms.append(Term(registry()[name], variant, tuple(free.start for free in variant.free)))
    made = fit(component.runs, terms)
    judged = Judgement(1e-9, 3.0, 1.0, ())
    found = [Found(component.name, Candidate(registry()[name], variants[name], made, 0, judged), []) for name in names]
    return replace(component, found=tuple(found), final=made, considered=())


@pytest.fixture(scope="module")
def gained(tmp_path_factory: pytest.TempPathFactory) -> TraceState:
    """Of a plant with another gain at one sensor."""
    return begun(tmp_path_factory.mktemp("gained"), "sensor_gain", seed=5)


def test_where_an_effect_leaves_a_residual_a_second_one_is_looked_for(gained: TraceState) -> None:
    """Of a gain that was taken for a drift much is left; where nothing was considered nothing is looked for."""
    at = planted_at(gained)
    given = with_effects(gained.components[at], "drift")
    few = tuple(h for h in given.hypotheses if h[0].name in ("drift", "sensor_gain"))
    given = replace(given, considered=(given.found[0].candidate,), hypotheses=few)
    state = replace(gained, components={at: given})
    grown = further_effects(state, lambda _: None).components[at]
    assert [found.candidate.effect.name for found in grown.found] == ["drift", "sensor_gain"]
    assert float(grown.final.loss[0]) < 0.1 * float(given.final.loss[0])
    unasked = replace(given, considered=None)
    assert further_effects(replace(gained, components={at: unasked}), lambda _: None).components[at] is unasked


def test_an_effect_that_another_makes_needless_is_dropped(gained: TraceState) -> None:
    """The plant has a gain alone; a drift beside it is fitted to noise."""
    state = gained
    at = planted_at(state)
    given = with_effects(state.components[at], "drift", "sensor_gain")
    pruned = prune(state.each(lambda c: given if c.name == at else c), lambda _: None).components[at]
    assert [term.effect.name for term in pruned.final.terms] == ["sensor_gain"]
    assert [found.candidate.effect.name for found in pruned.found] == ["sensor_gain"]


def test_effects_that_do_not_pass_together_go_together(tmp_path: Path) -> None:
    state = begun(tmp_path, seed=11)  # nothing planted
    given = state.each(lambda c: with_effects(c, "drift", "sensor_gain") if c.name == "casing" else c)
    judged = judge_again(given, lambda _: None)
    assert judged.components["casing"].found == ()
    assert judged.components["casing"].final is state.components["casing"].null
    assert judged.components["brush"] is given.components["brush"]


def test_together_all_of_an_effects_sizes_are_judged_and_not_the_later_ones_alone(gained: TraceState) -> None:
    """The first of two effects has one free size; when the left-out runs do not agree on it, neither stays."""
    at = planted_at(gained)
    given = with_effects(gained.components[at], "sensor_gain", "drift")
    first = np.where(np.arange(given.final.folds.shape[1]) % 2 == 0, 1.0, -1.0)
    torn = given.final.folds.copy()
    torn[0, :, 0] = first * np.abs(given.final.numbers[0, 0])
    sure = replace(given.final, spread=1e-3 * np.abs(given.final.numbers))
    for folds, kept in ((np.broadcast_to(sure.numbers[:, None, :], torn.shape), True), (torn, False)):
        unlike = replace(given, final=replace(sure, folds=folds))
        judged = judge_again(replace(gained, components={at: unlike}), lambda _: None).components[at]
        assert bool(judged.found) == kept


def test_parts_that_would_heat_each_other_without_end_keep_the_effect_that_helps_more(tmp_path: Path) -> None:
    """Each part settles with what it takes from the other; together more comes back than went out."""
    state = begun(tmp_path, seed=11)

    def taking(component: ComponentState, source: str, per_s: float, loss: float) -> ComponentState:
        variant = Variant({"source": source, "exchange": False, "tau_s": None, "conductance_per_s": per_s})
        made = replace(fit(component.runs, [Term(registry()["coupling"], variant, ())]), loss=np.array([loss]))
        judged = Judgement(1e-9, 3.0, 1.0, ())
        found = Found(component.name, Candidate(registry()["coupling"], variant, made, 0, judged), [])
        null = replace(component.null, loss=np.array([10.0]))
        return replace(component, found=(found,), final=made, null=null, considered=())

    for per_s, kept in ((1e-5, {"brush", "casing"}), (1e-3, {"casing"})):
        made = dict(state.components)
        made["brush"] = taking(made["brush"], "casing", per_s, 8.0)
        made["casing"] = taking(made["casing"], "brush", per_s, 1.0)
        given = replace(state, components=made)
        left = refuse_runaway(given, lambda _: None).components
        assert {name for name, part in left.items() if part.found} == kept
        assert all(bool(part.final.terms) == bool(part.found) for part in left.values())


def planted_at(state: TraceState) -> str:
    """The component with the largest residual: where the gain was planted."""
    return max(state.components.values(), key=lambda c: float(c.null.loss[0])).name


def test_a_single_run_is_left_out_in_thirds_and_this_is_said(tmp_path: Path) -> None:
    baseline = load(COEFFICIENTS)
    paths, test, _ = make(tmp_path, ("sensor_gain",), 5)
    runs = [condense(baseline, path) for path in paths[:2]]
    one, two = stack_runs(baseline, runs[:1]), stack_runs(baseline, runs)
    assert (one.left_out_parts, two.left_out_parts) == (THIRDS, WHOLE_RUNS)
    size = one.left_out.shape[1]
    assert one.left_out.shape == (3, size, 1)
    assert np.array_equal(one.left_out.sum(axis=0), np.ones((size, 1)))  # each bin is left out once
    assert np.all(np.abs(one.left_out.sum(axis=1) - size / 3) < 1.0)
    for fold, mask in enumerate(two.left_out):
        assert mask[:, fold].all()
        assert not mask[:, 1 - fold].any()
    found = refine(baseline, COEFFICIENTS.read_text(encoding="utf-8"), paths[:1], test[:1])
    summary = found.summary()
    assert summary["judged_on"] == THIRDS
    assert found.effects[0]["evidence"]["judged_on"] == THIRDS
