"""Motors for which one kind is the better one, runs that one kind refuses, and what the choice costs."""

from __future__ import annotations

import json
import re
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gen
from gen.arrays import FloatArray
from gen.errors import CheckFailed, InputError
from gen.identification.choice import choose as module
from gen.identification.choice.choose import choose
from gen.identification.choice.folds import MOST_FOLDS, STRETCHES, Fold, folds_of
from gen.identification.choice.left_out import BLOCKS, Judged, errors
from gen.identification.choice.models import NetworkModel, Options, Progress, network_of, parts_of
from gen.identification.logs.sources import Source
from gen.identification.settings import Settings
from gen.runs import Run, write_run
from tests.identification.network.plant import TWO, holds

QUICK = Options(Settings("motor"), max_order=1, max_hidden=0)
THIRD = replace(QUICK, max_order=3)
DAYS = (holds((200, 50), (0, 40)), holds((200, 35), (0, 40)), holds((0, 5), (200, 45), (0, 30)))
"""One speed: that is quick, and no schedule is judged with the dynamics."""


def silent(_: str) -> None:
    """Say nothing."""


def days(count: int = 3) -> list[Source]:
    rng = np.random.default_rng(1)
    return [Source(f"day_{k}.csv", TWO.run(DAYS[k % 3], rng)) for k in range(count)]


def three_lags(count: int = 3) -> list[Source]:
    """A sensor behind three equal lags, each of which does not feel the next: no two bodies do that."""
    rng = np.random.default_rng(2)
    runs = []
    for k in range(count):
        pwm = DAYS[k]
        lags = np.zeros((pwm.size, 3))
        for n in range(1, pwm.size):
            before = np.append(60.0 * (abs(pwm[n - 1]) / 255.0) ** 1.5, lags[n - 1, :2])
            lags[n] = lags[n - 1] + (before - lags[n - 1]) * (1.0 - np.exp(-4.0 / 360.0))
        read = np.round((25.0 + lags[:, 2] + rng.normal(0.0, 0.1, pwm.size)) * 4.0) / 4.0
        time = 4.0 * np.arange(pwm.size, dtype=np.float64)
        runs.append(Source(f"lag_{k}.csv", Run(time, pwm, {"casing": read}, np.full(pwm.size, 25.0))))
    return runs


@pytest.fixture
def never_good(monkeypatch: pytest.MonkeyPatch) -> None:
    """No network is good on what was left out."""
    monkeypatch.setattr(NetworkModel, "good_to_K", None)


def test_a_network_that_is_good_is_taken_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    stubs = Stubs(monkeypatch, [])
    made = choose(days(), QUICK, silent)
    assert made.decision.kind == "network"
    assert stubs.asked == {"network": 1, "parts": 0}
    said = re.match(r"network, because data that took no part in its fit are predicted to (\S+) K", made.decision.why)
    assert said is not None
    assert 0.0 < float(said[1]) < 1.0
    assert made.decision.why in str(made.model.coefficients.document.provenance)


def test_a_network_without_a_temperature_of_the_runs_is_not_taken_at_once() -> None:
    runs = days()
    whole = network_of(runs, QUICK, silent)
    assert whole.good_to_K is not None
    still = [replace(s, run=replace(s.run, temps={**s.run.temps, "lamp": np.full(s.run.pwm.size, 25.0)})) for s in runs]
    assert network_of(still, QUICK, silent).good_to_K is None


@pytest.mark.usefixtures("never_good")
def test_one_motor_of_two_bodies_is_a_network() -> None:
    made = choose(days(), QUICK, silent)
    assert made.decision.kind == "network"
    assert made.decision.compared is not None
    assert made.decision.compared.ratio > 1.5
    assert "which the others could not turn" in made.decision.why
    assert made.model.coefficients.model.network is not None
    assert made.decision.why in str(made.model.coefficients.document.provenance)


def test_lags_that_no_bodies_show_are_parts_and_the_same_each_time() -> None:
    runs = three_lags()
    made = choose(runs, THIRD, silent)
    assert made.decision.kind == "parts"
    assert made.decision.compared is not None
    assert made.decision.compared.interval[1] < 1.0
    assert len(made.decision.compared.by_run["parts"]) == 3
    assert made.model.coefficients.model.network is None
    assert "Chosen: parts, because on 3 runs left out" in made.model.text
    again = choose(runs, THIRD, silent)
    assert again.model.text == made.model.text
    assert again.decision == made.decision


@pytest.mark.usefixtures("never_good")
def test_where_parts_refuse_the_network_is_taken_and_that_is_said() -> None:
    """A warm start, and nothing that says the room: parts ask, a network finds out."""
    rng = np.random.default_rng(3)
    run = TWO.run(holds((0, 1), (200, 60), (0, 60)), rng, measured=False)
    warm = Run(run.time_s, run.pwm, {**run.temps, "casing": run.temps["casing"] + 8.0})
    made = choose([Source("folder/warm.csv", warm)], QUICK, silent)
    assert made.decision.kind == "network"
    assert made.decision.refused.startswith("warm.csv: there is no ambient_degC")
    assert "because parts refused: warm.csv: there is no ambient_degC" in made.model.text


class Stubs:
    """Both kinds without a fit, and how often each was asked for one."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch, parts_over_network: Sequence[float]) -> None:
        self.asked = {"network": 0, "parts": 0}
        self.refuses: dict[str, InputError | CheckFailed] = {}
        self.real = {"network": network_of, "parts": parts_of}
        self.ratios = list(parts_over_network)
        self.at = 0
        monkeypatch.setattr(module, "network_of", self.of("network"))
        monkeypatch.setattr(module, "parts_of", self.of("parts"))
        monkeypatch.setattr(module, "errors", self.errors)

    def of(self, kind: str) -> Any:  # noqa: ANN401
        def fit(sources: Sequence[Source], options: Options, progress: Any) -> Any:  # noqa: ANN401
            self.asked[kind] += 1
            if kind in self.refuses:
                raise self.refuses[kind]
            if self.asked[kind] == 1:
                return self.real[kind](sources[:1], options, silent)
            return Stub(kind)

        return fit

    def errors(self, kind: str, fold: Fold) -> dict[Judged, FloatArray]:
        made = {}
        for k, (source, _) in enumerate(fold.judged):
            error = self.ratios[self.at + k] if kind == "parts" else 1.0
            made[Judged(source.path, "casing")] = np.full(BLOCKS, error**2)
        self.at += len(fold.judged) if kind == "parts" else 0
        return made


class Stub:
    """Its coefficients are its name."""

    def __init__(self, kind: str) -> None:
        self.coefficients = kind


@pytest.mark.usefixtures("never_good")
@pytest.mark.parametrize(
    ("ratios", "fits", "kind"),
    [
        ([0.5, 0.55, 0.45, 0.5, 0.5, 0.55, 0.45], MOST_FOLDS + 1, "parts"),
        ([0.5, 0.9, 0.4, 0.7, 1.5, 0.6, 1.5], MOST_FOLDS + 1, "network"),
        ([3.0, 1.2, 4.0, 2.0, 2.0, 2.0, 2.0], 3, "network"),
    ],
)
def test_each_kind_is_fitted_four_times_at_most(
    monkeypatch: pytest.MonkeyPatch, ratios: list[float], fits: int, kind: str
) -> None:
    stubs = Stubs(monkeypatch, ratios)
    made = choose(days(len(ratios)), QUICK, silent)
    assert made.decision.kind == kind
    assert stubs.asked == {"network": fits, "parts": fits}


def test_a_refusal_costs_one_fit_of_each(monkeypatch: pytest.MonkeyPatch) -> None:
    stubs = Stubs(monkeypatch, [])
    stubs.refuses["network"] = CheckFailed("winding settles 9e5 K over ambient")
    made = choose(days(), QUICK, silent)
    assert made.decision.why == "parts, because the network refused: winding settles 9e5 K over ambient"
    assert stubs.asked == {"network": 1, "parts": 1}


def test_where_both_refuse_both_reasons_are_told(monkeypatch: pytest.MonkeyPatch) -> None:
    stubs = Stubs(monkeypatch, [])
    stubs.refuses |= {"network": CheckFailed("no way out"), "parts": InputError("no ambient", file="a.csv")}
    with pytest.raises(CheckFailed, match=r"network: no way out; parts: a\.csv: no ambient"):
        choose(days(), QUICK, silent)
    stubs.refuses["network"] = InputError("no ambient", file="a.csv")
    with pytest.raises(InputError, match=r"^a\.csv: no ambient$"):
        choose(days(), QUICK, silent)


def test_a_fold_is_fitted_without_what_it_judges() -> None:
    for fold in folds_of(days(7)):
        assert not {source.path for source in fold.fit} & {source.path for source, _ in fold.judged}
    assert sorted(source.path for fold in folds_of(days(7)) for source, _ in fold.judged) == [
        f"day_{k}.csv" for k in range(7)
    ]
    (only,) = days(1)
    folds = folds_of([only])
    assert len(folds) == STRETCHES - 1
    rows = only.run.time_s.size
    for k, fold in enumerate(folds, start=1):
        ((kept,), ((judged, out),)) = fold.fit, fold.judged
        assert judged is only
        assert np.array_equal(kept.run.pwm, only.run.pwm)
        for name, values in kept.run.temps.items():
            assert np.isnan(values[out]).all()
            assert np.array_equal(values[~out], only.run.temps[name][~out])
        assert np.flatnonzero(out)[[0, -1]] == pytest.approx([k / 4 * rows, (k + 1) / 4 * rows - 1], abs=2)


@pytest.mark.parametrize("make", [network_of, parts_of], ids=["network", "parts"])
def test_the_error_is_that_of_gen_simulate_from_the_runs_start(make: Any, tmp_path: Path) -> None:  # noqa: ANN401
    sources = days(2)
    model = make(sources[:1], QUICK, silent)
    (tmp_path / "model.json").write_text(model.text)
    write_run(tmp_path / "left.csv", sources[1].run)
    shown = gen.simulate(gen.load(tmp_path / "model.json"), tmp_path / "left.csv")
    found = errors(model.coefficients, folds_of(sources)[1])
    assert {one.part for one in found} == {"winding", "casing"}
    for one, squares in found.items():
        own = (shown[f"{one.part}_degC"].to_numpy() - sources[1].run.temps[one.part]) ** 2
        rows = np.array_split(own, BLOCKS)
        assert np.mean(squares) == pytest.approx(np.mean([np.mean(each) for each in rows]), rel=0.01)


def test_from_python_and_in_the_report(tmp_path: Path) -> None:
    paths = [tmp_path / source.path for source in days(2)]
    for path, source in zip(paths, days(2), strict=True):
        write_run(path, source.run)
    found = gen.identify(paths, max_hidden=0, max_order=1)
    assert found.choice is not None
    assert found.text().startswith(f"chosen: {found.choice.why}")
    assert found.details()["choice"]["why"] == found.choice.why
    assert f"<strong>Chosen:</strong> {found.choice.why}".replace("'", "&#39;") in found.html()
    assert found.choice.why in json.loads(found.model.text)["provenance"]["method"]
    asked = gen.identify(paths, max_order=1, model="parts")
    assert asked.choice is None
    assert "choice" not in asked.details()
    assert "chosen" not in asked.text()


def test_where_neither_can_be_built_the_sensed_parts_alone_are_tried(monkeypatch: pytest.MonkeyPatch) -> None:
    tried: list[int] = []

    def needs_none(sources: Sequence[Source], options: Options, progress: Progress) -> NetworkModel:
        tried.append(options.max_hidden)
        if options.max_hidden:
            raise CheckFailed('"hidden1" settles 9488 K over ambient')
        return network_of(sources, options, progress)

    def refuse(sources: Sequence[Source], options: Options, progress: Progress) -> NetworkModel:
        raise InputError("where casing settles is not shown", file="folder/day_0.csv")

    monkeypatch.setattr(module, "network_of", needs_none)
    monkeypatch.setattr(module, "parts_of", refuse)
    made = choose(days(1), replace(QUICK, max_hidden=3), silent)
    assert tried == [3, 0]
    assert made.decision.kind == "network"
    assert made.decision.why == (
        "network without hidden nodes, because parts refused: day_0.csv: where casing settles is not shown; and with "
        'them: "hidden1" settles 9488 K over ambient'
    )
    assert made.decision.why.split('"')[0] in str(made.model.coefficients.document.provenance)
    with pytest.raises(InputError, match="settles is not shown"):
        monkeypatch.setattr(module, "network_of", refuse)
        choose(days(1), replace(QUICK, max_hidden=3), silent)
