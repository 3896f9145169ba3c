"""Planted names that are fitted as if they were known."""

from __future__ import annotations

import pytest

from benchmarks.network_refinement import told_apart
from benchmarks.network_refinement.told_apart import ToldApart, known, line, main
from benchmarks.plants.planted.draw import NotVisible
from gen.refinement.network.effects import candidates
from gen.refinement.network.fitting.anchored import Anchored
from gen.refinement.network.fitting.data import make_data
from gen.refinement.network.fitting.fit import Bench
from gen.refinement.network.tracing.judged import judged
from tests.refinement.network.motor import read, run, tree

OFF_K, LOSS = 2.0, 0.004


def test_two_effects_whose_names_are_known_leave_the_noise() -> None:
    changed = tree()
    changed["network"]["heats"][0]["per_K"] = LOSS
    changed["network"]["nodes"][1]["sensor"] = {"offset_K": OFF_K}
    bench = Bench(make_data(read(tree()), [(f"{seed}.csv", run(read(changed), seed)) for seed in (1, 2)]))
    network = read(tree()).model.network
    assert network is not None
    shape = Anchored.of(network, 255, bench.data.columns)
    every = candidates(shape.motor(), bench.data.offered)
    base = bench.first(shape)
    without = judged(bench.data, base, bench.left_out(base))

    found = known(bench, base, every, ("sensor_offset", "temperature_dependent_loss"))

    assert found is not None
    assert sorted(found.names) == ["sensor_offset", "temperature_dependent_loss"]
    assert found.floors < 1.1 < without.floors
    one = next(effect for effect in found.fitted.shape.effects if effect.name == "sensor_offset")
    values = found.fitted.shape.values(found.fitted.vector)[found.fitted.shape.effects.index(one)]
    assert one.component == "casing"
    assert values[0] == pytest.approx(OFF_K, abs=0.1)
    # The motor's runs have no channel that may be a flow of air.
    assert known(bench, base, every, ("sensor_offset", "airflow")) is None


@pytest.mark.parametrize(("planted", "p_value", "told"), [(1.0, 0.001, True), (1.0, 0.2, False), (1.3, 0.001, False)])
def test_told_apart_is_what_predicts_better_by_more_than_chance(planted: float, p_value: float, told: bool) -> None:
    one = ToldApart("1:drift:6", ("sensor_gain",), 1.2, planted, p_value)
    assert one.told is told
    assert line(one).endswith("not told apart") is not told


def test_what_could_not_be_fitted_is_not_said_to_look_alike() -> None:
    one = ToldApart("1:initial_state:6", (), 1.2, float("nan"), float("nan"))
    assert not one.told
    assert line(one).endswith("no term of this network")


def test_a_case_with_nothing_planted_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        main(["--case", "1:nothing:6"])
    assert ended.value.code == 2
    assert "--case: nothing is planted" in capsys.readouterr().err


def test_a_change_that_no_bench_shows_is_a_line(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def unseen(*_: object) -> None:
        raise NotVisible("drift: no bench shows it")

    monkeypatch.setattr(told_apart, "write_trial", unseen)
    main(["--case", "1:drift:6", "2:drift:6"])
    assert capsys.readouterr().out.splitlines() == [f"{seed}:drift:6: drift: no bench shows it" for seed in (1, 2)]
