"""The tables of refinement: goals, confusion, right parts, faults."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import pytest

from benchmarks.network_refinement.judge import Judged, truth
from benchmarks.network_refinement.table import confusion, goals, patterns, rows
from benchmarks.plants.cases import bench
from benchmarks.plants.planted.trial import setting
from tests.benchmarks.refinement_oracle import made


def reached(results: Sequence[Judged], fit_runs: int = 2) -> dict[str, float]:
    return {goal.text: goal.reached for goal in goals(results, fit_runs) if goal.of}


def met(results: Sequence[Judged], fit_runs: int = 2) -> dict[str, bool | None]:
    return {goal.text: goal.met for goal in goals(results, fit_runs) if goal.of}


def test_each_goal_counts_its_own_trials() -> None:
    results = [
        made("1:drift:2", ["drift"]),
        made("2:drift:2", ["airflow", "drift"]),
        made("1:nothing:2", verdict="nothing missing"),
        made("2:nothing:2", ["drift"]),
        made("1:airflow+drift:2", ["drift", "airflow"]),
        made("2:airflow+drift:2", ["drift"]),
        made("1:melting:2", ["coupling"], verdict="explained", after_K=0.5),
        made("2:melting:2", ["coupling"], verdict="partly explained", after_K=0.5),
        made("1:worn_bearing:2", ["schedule_error"], warnings=["this looks like a fault of the bearing"]),
        made("2:worn_bearing:2", ["schedule_error"]),
        made("3:worn_bearing:2", verdict="unexplained"),
        made("1:drift:6", ["coupling"]),
    ]
    shares = reached(results)
    assert shares["single: right name first"] == 0.5
    assert shares["single: no false name"] == 0.5
    assert shares["single: error after at most 1.3 floors"] == 1.0
    assert shares["nothing: nothing named"] == 0.5
    assert shares["pairs: both named"] == 0.5
    assert shares["pairs: no false name"] == 1.0
    assert shares['outside: not "explained" above 1.5 floors'] == 0.5
    assert shares["faults: flagged"] == pytest.approx(1 / 3)
    assert shares["faults: not learnt without a word"] == pytest.approx(2 / 3)
    assert shares["no fault: not flagged"] == 1.0
    assert reached(results, 6)["single: right name first"] == 0.0
    assert [row.planted for row in rows(results)] == ["drift", "nothing", "pairs", "melting", "worn_bearing", "drift"]


def test_the_right_name_is_asked_for_more_often_with_six_runs() -> None:
    four_of_five = [made(f"{n}:drift:{runs}", ["drift" if n else "airflow"]) for n in range(5) for runs in (2, 6)]
    assert met(four_of_five)["single: right name first"] is True
    assert met(four_of_five, 6)["single: right name first"] is False


def test_what_made_a_model_worse_and_who_calls_the_healthy_faulty_is_told() -> None:
    fine = made("1:drift:2", ["drift"], after_K=1.25, told_K=1.25)
    worse = made("2:drift:2", ["drift"], after_K=1.27, told_K=1.0)
    shares = reached([fine, worse])
    assert shares["all: not worse than before by over 5 %"] == 0.5
    assert shares["all: error told is right to 10 %"] == 0.5
    crying = made("3:nothing:2", warnings=["refine with runs of a motor known to be healthy only"])
    assert reached([crying])["no fault: not flagged"] == 0.0


@pytest.mark.parametrize(
    ("warning", "flagged"),
    [
        ("The motor has changed (a worn bearing or brush heats like that)", True),
        ("rotor: as a fault's pattern", True),
        ("refine with runs of a motor known to be healthy only", True),
        ("the default ambient was taken", False),
        ("2 rows were left out", False),
    ],
)
def test_what_tells_of_a_fault_is_told_from_what_does_not(warning: str, flagged: bool) -> None:
    assert made("1:worn_bearing:2", warnings=[warning]).flagged is flagged


def truth_of(name: str) -> dict[str, Any]:
    found: dict[str, Any] = truth(setting(2, (name,)))[name]
    return found


def test_a_name_at_the_wrong_part_is_seen() -> None:
    true = {"sensor_gain": {"where": ["rotor"]}, "coupling": {"where": ["casing", "mount"]}}
    right = made("1:sensor_gain:2", ["sensor_gain"], truth=true)
    wrong = made("1:coupling:2", ["coupling"], truth=true)
    nowhere = made("1:supply_voltage:2", ["supply_voltage"], truth={"supply_voltage": {"where": []}})
    assert [result.placed for result in (right, wrong, nowhere, made("1:drift:2"))] == [True, False, None, None]
    known = truth_of("sensor_offset")
    assert known["where"] == [bench(2).plant.names[known["parameters"]["node"]]]
    plant = bench(2).plant
    bearings = truth_of("worn_bearing")
    nodes = {plant.sources[source].node for source in bearings["parameters"]["sources"]}
    assert bearings["where"] == ([plant.names[node] for node in nodes] if nodes <= set(plant.sensed) else [])
    placed = {row.planted: row.placed for row in rows([right, wrong])}
    assert placed == {"sensor_gain": 1.0, "coupling": 0.0}


def test_the_confusion_has_what_was_named_first_by_what_was_planted() -> None:
    results = [
        made("1:drift:2", ["drift"]),
        made("2:drift:2", ["coupling", "drift"]),
        made("3:drift:2"),
        made("1:nothing:2"),
        made("4:drift:2", status="refused"),
    ]
    head, drift, nothing, legend = confusion(results)
    assert legend.split() == ["1", "coupling,", "2", "drift,", "3", "-,", "4", "refused"]
    assert drift.split() == ["drift", "1", "1", "1", "1"]
    assert nothing.split() == ["nothing", ".", ".", "1", "."]
    assert head.split()[-4:] == ["1", "2", "3", "4"]


def test_how_what_is_left_goes_over_time_is_counted_by_what_was_planted() -> None:
    results = [
        made("1:sun:2", pattern="comes and goes"),
        made("2:sun:2", pattern="even"),
        made("1:fouling:2"),
        made("1:drift:2", ["drift"], pattern="even"),
    ]
    head, sun, fouling = patterns(results)
    assert head.split()[-5:] == ["comes", "and", "goes", "even", "-"]
    assert sun.split() == ["sun", "1", "1", "."]
    assert fouling.split() == ["fouling", ".", ".", "1"]
    assert patterns([made("1:sun:2")]) == []
