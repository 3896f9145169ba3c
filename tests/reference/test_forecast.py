"""The look ahead against what it looks ahead to: the board's own later words, and the exact solution."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import pytest

from gen.coefficients import Coefficients, parse
from gen.lowering.forecast import LoweredForecast, lower_forecast
from gen.lowering.kinds import Arithmetic
from gen.lowering.lower import lower
from gen.lowering.program import Program
from gen.model.exact import ExactSolution
from gen.model.network_solution import NetworkSolution
from gen.reference.board import Reference, reference_of
from gen.reference.forecast import HOLDABLE, KNOWN, ReferenceForecast
from gen.reference.network import ReferenceNetwork
from tests.examples import ROOT

NOTHING_MEASURED = 0
PARTS: dict[str, Any] = {
    "horizon_s": 300,
    "steps_per_sample": 1200,
    "limits": [{"component": name, "limit_degC": limit} for name, limit in (("brush", 61), ("bearing", 51.5))],
}
WINDING: dict[str, Any] = {
    "horizon_s": 300,
    "steps_per_sample": 1200,
    "limits": [{"component": "winding", "limit_degC": 62.5}],
}


def made(
    example: str, forecast: dict[str, Any], arithmetic: Arithmetic
) -> tuple[Coefficients, Program, LoweredForecast]:
    tree = json.loads((ROOT / "examples" / example / "coeffs.json").read_text(encoding="utf-8"))
    tree |= {"version": 2, "forecast": forecast, "alarms": []}
    coefficients = parse(json.dumps(tree).encode())
    program = lower(coefficients, arithmetic, "table")
    lowered = lower_forecast(coefficients, program)
    assert lowered is not None
    return coefficients, program, lowered


def looked(lowered: LoweredForecast, board: Reference, pwm: int, ambient_mC: int, until: int) -> ReferenceForecast:
    """Samples of a board whose model stands still until a bit of the state is set."""
    ahead = ReferenceForecast(lowered)
    parts = len(board.rises_mK)
    for _ in range(100):
        ahead.sample(pwm, board, np.zeros(parts, dtype=np.int64), ambient_mC, NOTHING_MEASURED)
        while ahead.work(1000):
            pass
        if ahead.state & until:
            return ahead
    raise AssertionError("it came to no end")


@pytest.mark.parametrize("arithmetic", ["fixed", "float"])
def test_parts_reach_their_limit_when_they_were_said_to_and_by_the_exact_solution_no_earlier(
    arithmetic: Arithmetic,
) -> None:
    coefficients, program, lowered = made("my1016", PARTS, arithmetic)
    board = reference_of(program, [20_000])
    ahead = looked(lowered, board, 255, 30_000, KNOWN)
    assert 0 < ahead.until < lowered.horizon
    for sample in range(ahead.until + 1):
        reached = [int(board.rises_mK[item.part, 0]) + 30_000 >= item.limit_mC for item in lowered.limits]
        assert any(reached) == (sample == ahead.until)
        board.step(np.array([255]))
    model = coefficients.model
    time = np.arange(lowered.horizon + 1) * model.sample_time
    exact = ExactSolution(model).simulate_times(
        time, np.full(len(time), 255), dict.fromkeys(model.component_names, 20.0)
    )
    crossed = int(np.argmax(np.any([exact[item.name] + 30.0 >= item.source_degC for item in lowered.limits], axis=0)))
    assert 0 <= crossed - ahead.until <= 2


def test_a_winding_that_nobody_measures_reaches_its_limit_when_it_was_said_to() -> None:
    coefficients, program, lowered = made("network", WINDING, "fixed")
    board = reference_of(program, [30_000])
    ahead = looked(lowered, board, 230, 25_000, KNOWN)
    assert 0 < ahead.until < lowered.horizon
    solution = NetworkSolution(coefficients.model)
    time = np.arange(lowered.horizon + 1) * coefficients.model.sample_time
    start = dict.fromkeys(coefficients.model.component_names, 55.0)
    states = solution.states_along(time, np.full(len(time), 230), 25.0, None, start)
    place = [node.name for node in solution.network.nodes].index("winding")
    crossed = int(np.argmax(states[:, place] >= 62.5))
    assert 0 <= crossed - ahead.until <= 2


def test_a_network_that_reads_the_sign_of_pwm_is_told_the_one_that_is_tried() -> None:
    """Half as much heat again backwards; the board's own model has stood still, and was told so."""
    tree = json.loads((ROOT / "examples" / "network" / "coeffs.json").read_text(encoding="utf-8"))
    tree |= {"forecast": WINDING}
    tree["network"]["channels"].append({"column": "pwm", "range": [-255, 255], "neutral": 0})
    tree["network"]["heats"][0]["factors"] = [{"channel": "pwm", "table": {"at": [-1, 0], "value": [1.5, 1.0]}}]
    coefficients = parse(json.dumps(tree).encode())
    program = lower(coefficients, "fixed", "table")
    lowered = lower_forecast(coefficients, program)
    assert lowered is not None
    found = []
    for pwm in (230, -230):
        board = reference_of(program, [30_000])
        ahead = looked(lowered, board, pwm, 25_000, KNOWN)
        board.set_channels(np.array([[25_000], [0], [1000 * pwm]]))
        assert isinstance(board, ReferenceNetwork)
        winding = lowered.limits[ahead.first]
        for sample in range(ahead.until + 1):
            reached = int(board.node_mC(winding.part - len(program.parts))[0]) >= winding.limit_mC
            assert reached == (sample == ahead.until)
            board.step(np.array([pwm]))
        found.append(ahead.until)
    assert 0 < found[1] < found[0] < lowered.horizon


def test_the_pwm_that_can_be_held_can_and_the_next_one_cannot() -> None:
    coefficients, program, lowered = made("my1016", PARTS, "fixed")
    board = reference_of(program, [20_000])
    ahead = looked(lowered, board, -100, 30_000, HOLDABLE)
    assert 0 < ahead.holdable < lowered.most_pwm
    model = coefficients.model
    time = np.arange(lowered.horizon + 1) * model.sample_time
    for pwm, holds in ((ahead.holdable, True), (ahead.holdable + 1, False)):
        exact = ExactSolution(model).simulate_times(
            time, np.full(len(time), pwm), dict.fromkeys(model.component_names, 20.0)
        )
        highest = max(float(exact[item.name].max()) + 30.0 - item.limit_mC / 1000.0 for item in lowered.limits)
        assert (highest < 0.0) == holds


def test_a_part_that_is_measured_warmer_than_its_model_is_nearer_to_its_limit() -> None:
    _, program, lowered = made("my1016", PARTS, "fixed")
    found = []
    for warmer_mK in (-3_000, 0, 1_000, 2_000):
        board = reference_of(program, [20_000])
        ahead = ReferenceForecast(lowered)
        ahead.sample(255, board, board.rises_mK[:, 0] + 30_000 + warmer_mK, 30_000, 0b1111)
        while ahead.work(1000):
            pass
        found.append(ahead.until)
    assert found[0] == found[1] > found[2] > found[3] == 0


def test_what_was_measured_last_holds_while_a_part_is_not_measured() -> None:
    _, program, lowered = made("my1016", PARTS, "fixed")
    board = reference_of(program, [20_000])
    ahead = ReferenceForecast(lowered)
    measured = board.rises_mK[:, 0] + 31_000
    ahead.sample(100, board, measured, 30_000, 0b1111)
    ahead.sample(255, board, 0 * measured, 30_000, NOTHING_MEASURED)
    while ahead.work(1000):
        pass  # the run at 100
    found = looked(lowered, board, 255, 30_000, KNOWN).until
    ahead.sample(255, board, 0 * measured, 30_000, NOTHING_MEASURED)
    while ahead.work(1000):
        pass
    assert ahead.state & KNOWN
    assert ahead.until < found


def test_another_pwm_makes_it_unknown_and_time_that_passes_is_taken_off() -> None:
    _, program, lowered = made("my1016", PARTS, "fixed")
    board = reference_of(program, [20_000])
    ahead = looked(lowered, board, 255, 30_000, KNOWN)
    said, measured = ahead.samples, np.zeros(4, dtype=np.int64)
    for passed in range(1, 3):  # without work no other run ends
        ahead.sample(255, board, measured, 30_000, NOTHING_MEASURED)
        assert ahead.samples == said - passed
    ahead.sample(254, board, measured, 30_000, NOTHING_MEASURED)
    assert not ahead.state & KNOWN


def held(horizon_s: float = 300.0) -> tuple[Program, LoweredForecast]:
    """A motor that is derated to what can be held, and a look ahead that ends a run in each sample."""
    forecast = PARTS | {"horizon_s": horizon_s, "near_s": 30}
    tree = json.loads((ROOT / "examples" / "my1016" / "coeffs.json").read_text(encoding="utf-8"))
    table = [{"cause": "limit_near", "action": "derate", "derate_pwm": "holdable"}]
    tree |= {"version": 2, "forecast": forecast, "alarms": [], "protection": table}
    coefficients = parse(json.dumps(tree).encode())
    program = lower(coefficients, "fixed", "table")
    lowered = lower_forecast(coefficients, program)
    assert lowered is not None
    return program, lowered


def sampled(ahead: ReferenceForecast, pwm: int, board: Reference, times: int, *, works: bool = True) -> None:
    for _ in range(times):
        ahead.sample(pwm, board, board.rises_mK[:, 0], 30_000, NOTHING_MEASURED)
        while works and ahead.work(1000):
            pass


def test_until_something_was_shown_to_be_held_nothing_is_and_then_what_was() -> None:
    program, lowered = held()
    board, ahead = reference_of(program, [20_000]), ReferenceForecast(lowered)
    assert ahead.most_pwm == 0
    most = [0]
    while not ahead.state & HOLDABLE:
        sampled(ahead, 255, board, 1)
        most.append(ahead.most_pwm)
    assert most == sorted(most), "it only rises, from 0"
    assert 0 < most[-1] == ahead.holdable < 255
    assert 0 < most[len(most) // 2] <= ahead.holdable


def test_what_is_held_stays_while_the_model_does_and_whatever_else_is_asked_for() -> None:
    program, lowered = held()
    board, ahead = reference_of(program, [20_000]), ReferenceForecast(lowered)
    while not ahead.state & HOLDABLE:
        sampled(ahead, 255, board, 1)
    found = ahead.holdable
    for pwm in (255, 100, 255, 0):
        sampled(ahead, pwm, board, 9)
        assert ahead.most_pwm == found
    sampled(ahead, -255, board, 1)
    assert ahead.most_pwm == found, "until a run the other way round says otherwise"


def test_what_is_held_falls_while_a_search_goes_on_and_is_0_at_the_limit() -> None:
    program, lowered = held()
    board, ahead = reference_of(program, [20_000]), ReferenceForecast(lowered)
    while not ahead.state & HOLDABLE:
        sampled(ahead, 255, board, 1)
    found, hot = ahead.holdable, reference_of(program, [35_000])
    fallen = []
    for _ in range(40):
        sampled(ahead, 255, hot, 1)
        fallen.append(ahead.most_pwm)
    assert fallen == sorted(fallen, reverse=True)
    assert fallen[0] <= found and fallen[-1] == 0
    assert len(set(fallen)) > 4, "in strides that grow, and not at once"


def test_near_stays_until_what_is_asked_for_can_be_held() -> None:
    program, lowered = held()
    board, ahead = reference_of(program, [20_000]), ReferenceForecast(lowered)
    near = reference_of(program, [30_000])
    while not ahead.near:
        sampled(ahead, 255, near, 1)
    sampled(ahead, 255, board, 9)
    assert lowered.near is not None
    assert ahead.state & KNOWN and ahead.samples > 2 * lowered.near
    assert ahead.near, "at what is asked for it is reached some time"
    sampled(ahead, 0, board, 1, works=False)
    assert ahead.near, "not known yet"
    sampled(ahead, 0, board, 9)
    assert not ahead.near


def test_an_answer_older_than_the_horizon_is_none() -> None:
    program, lowered = held(30.0)
    board, ahead = reference_of(program, [20_000]), ReferenceForecast(lowered)
    while not ahead.state & HOLDABLE:
        sampled(ahead, 255, board, 1)
    assert ahead.most_pwm > 0
    sampled(ahead, 255, board, lowered.horizon - 1, works=False)
    assert ahead.most_pwm > 0
    sampled(ahead, 255, board, 1, works=False)
    sampled(ahead, 255, board, 1, works=False)
    assert ahead.most_pwm == 0
