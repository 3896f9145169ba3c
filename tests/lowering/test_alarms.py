"""Rules in whole counts, samples and thousandths; the wait after a start without slopes."""

from __future__ import annotations

import json
import math
from dataclasses import replace

import numpy as np
import pytest

from gen.coefficients import Coefficients, parse
from gen.errors import InputError
from gen.lowering.alarms import START_MARGIN_K, Segment, _outermost, lower_alarms, start_wait
from gen.model.exact import ExactSolution
from gen.model.network_parts import Sensor
from gen.model.network_solution import NetworkSolution
from gen.reference.alarms import ReferenceAlarms
from tests.examples import ROOT, example


def changed(**rule: object) -> Coefficients:
    document = json.loads((ROOT / "examples" / "two_mass" / "coeffs.json").read_text())
    document["alarms"] = [{"name": "rule", "component": "housing", "kind": "above_model", "threshold_K": 2.0} | rule]
    return parse(json.dumps(document).encode())


def test_the_studys_rules_in_board_units() -> None:
    rule = lower_alarms(example("my1016"))[0]
    assert rule.segments == (Segment(77, 178, 5000, 4000),)  # 30..70 % of 255 is 76.5..178.5
    assert (rule.settle, rule.persistence) == (2400, 240)  # 600 s and 60 s at 0.25 s


def test_a_threshold_beyond_the_error_band_follows_its_steps() -> None:
    # The band is -1.5..2.0 K up to PWM 127 and -3.0..0.5 K above; nothing is declared below 25: the widest holds there.
    (above,) = lower_alarms(changed(beyond="error_band", hysteresis_K=0.5))
    assert above.segments == (Segment(0, 24, 5000, 4500), Segment(25, 127, 3500, 3000), Segment(128, 255, 5000, 4500))
    (below,) = lower_alarms(changed(kind="below_model", beyond="error_band", speed_percent=[20, 100]))
    assert below.segments == (Segment(51, 127, 4000, 4000), Segment(128, 255, 2500, 2500))


def test_where_nothing_is_declared_the_widest_band_holds_though_it_be_of_full_speed_alone() -> None:
    document = json.loads((ROOT / "examples" / "two_mass" / "coeffs.json").read_text())
    rule = {"name": "rule", "component": "housing", "kind": "above_model", "threshold_K": 2.0, "beyond": "error_band"}
    bands = [band for band in document["provenance"]["error"] if band["component"] == "housing"]
    bands[-1]["pwm"][1] = 254
    bands.append({**bands[-1], "pwm": [255, 255], "model_minus_measured_K": [-9.0, 0.5]})
    document |= {"alarms": [rule], "provenance": {**document["provenance"], "error": bands}}
    (lowered,) = lower_alarms(parse(json.dumps(document).encode()))
    assert lowered.segments[0] == Segment(0, 24, 11000, 11000)
    assert lowered.segments[-1] == Segment(255, 255, 11000, 11000)


def test_a_band_on_the_other_side_of_the_model_moves_the_threshold_there() -> None:
    document = json.loads((ROOT / "examples" / "two_mass" / "coeffs.json").read_text())
    band = {"component": "housing", "pwm": [0, 255], "model_minus_measured_K": [3.0, 4.0]}
    document["provenance"]["error"] = [band]
    document["alarms"] = [
        {"name": "rule", "component": "housing", "kind": "above_model", "threshold_K": 2.0, "beyond": "error_band"}
    ]
    (rule,) = lower_alarms(parse(json.dumps(document).encode()))
    assert rule.segments == (Segment(0, 255, -1000, -1000),)  # healthy is at least 3 K below the model


@pytest.mark.parametrize(
    ("rule", "warned"),
    [
        ({"threshold_K": 3.1}, False),
        ({"threshold_K": 3.0}, True),
        ({"threshold_K": 2.0, "speed_percent": [10, 40]}, False),
        ({"threshold_K": 1.9, "kind": "below_model", "speed_percent": [10, 40]}, True),
        ({"threshold_K": 1.0, "beyond": "error_band"}, False),
    ],
)
def test_a_threshold_inside_the_declared_error_is_warned_of(rule: dict[str, object], warned: bool) -> None:
    warnings = [text for text in changed(**rule).warnings if text.startswith("$.alarms[0].threshold_K")]
    assert bool(warnings) == warned


@pytest.mark.parametrize(
    ("rule", "place"),
    [
        ({"settle_s": 20_000}, r"\$\.alarms\[0\]\.settle_s.*expected at most 16383\.5"),
        ({"persistence_s": 16_384}, r"\$\.alarms\[0\]\.persistence_s"),
        ({"speed_percent": [50.1, 50.15]}, r"\$\.alarms\[0\]\.speed_percent.*no whole PWM count"),
    ],
)
def test_what_the_board_cannot_hold_is_refused(rule: dict[str, object], place: str) -> None:
    with pytest.raises(InputError, match=place):
        changed(**rule)


def test_the_wait_outlasts_what_unknown_slopes_can_do() -> None:
    """The exact solution: a motor on its way to full speed, restarted in mid-run from its temperature alone."""
    model = example("my1016").model
    solution = ExactSolution(model)
    wait = start_wait(model, model.component_names[0], range(150, 151)) * model.sample_time
    times = np.arange(0.0, 40_000.0, 30.0)
    worst = 0.0
    for before in (51, 150, 255):
        for first in range(10, 200, 30):
            pwm = np.where(np.arange(times.size) < first, before, 150)
            warm = solution.simulate_times(times, pwm)["brush"]
            cold = solution.simulate_times(times[first:], pwm[first:], {"brush": float(warm[first])})["brush"]
            error = np.abs(cold - warm[first:])
            settled = times[first:] - times[first] >= wait
            assert error[settled].max() <= START_MARGIN_K
            worst = max(worst, float(error.max()))
    assert worst > 5.0  # without the wait it matters
    assert start_wait(model, model.component_names[1], range(150, 151)) == 0


def test_the_wait_outlasts_what_unknown_hidden_nodes_can_do() -> None:
    """The same in a network: restarted in mid-run from its readings, its winding where it would rest between them."""
    model = example("network").model
    solution = NetworkSolution(model)
    names = model.component_names
    waits = {name: start_wait(model, name, range(150, 151)) * model.sample_time for name in names}
    times = np.arange(0.0, 40_000.0, 30.0)
    worst, longest = 0.0, dict.fromkeys(names, 0.0)
    for before in (51, 150, 255):
        for first in range(10, 200, 30):
            pwm = np.where(np.arange(times.size) < first, before, 150)
            warm = solution.simulate_times(times, pwm, 25.0)
            begin = {name: float(warm[name][first]) for name in names}
            cold = solution.simulate_times(times[first:], pwm[first:], 25.0, start=begin)
            for name in names:
                error = np.abs(cold[name] - warm[name][first:])
                settled = times[first:] - times[first] >= waits[name]
                assert error[settled].max() <= START_MARGIN_K
                worst = max(worst, float(error.max()))
                longest[name] = max(longest[name], float(30.0 * np.count_nonzero(error > START_MARGIN_K)))
    assert worst > 1.0
    assert all(waits[name] <= 1.5 * longest[name] for name in names), (
        waits,
        longest,
    )  # and no rule is deaf for much longer than needed
    assert start_wait(example("two_nodes").model, "casing", range(150, 151)) > 0


def test_a_sensor_that_shows_too_much_waits_until_that_much_of_an_error_has_faded() -> None:
    """What is unknown fades with one time constant at last: three times as much takes ln 3 of it longer."""
    model = example("two_nodes").model
    network = model.network
    assert network is not None
    waits = []
    for gain in (0.0, 2.0, -0.5):
        sensor = Sensor(gain_error=gain)
        nodes = tuple(replace(n, sensor=sensor) if n.sensor is not None else n for n in network.nodes)
        changed_model = replace(model, network=replace(network, nodes=nodes))
        waits.append(start_wait(changed_model, "casing", range(150, 151)) * model.sample_time)
    slowest = 1.0 / np.abs(np.linalg.eigvals(network.matrices(np.array([150]))[0][0]).real).min()
    assert waits[1] - waits[0] == pytest.approx(slowest * math.log(3.0), abs=61.0)
    assert waits[2] < waits[0]


def test_a_time_that_is_no_whole_number_of_samples_is_not_cut_short() -> None:
    (rule,) = lower_alarms(changed(persistence_s=0.6, settle_s=0.3))
    assert (rule.persistence, rule.settle) == (3, 2)  # a sample is 0.25 s


def test_a_sum_s_threshold_is_kelvins_times_seconds() -> None:
    """10 K over the slack of 0.5 K for 20 s fill a sum of 200 K s."""
    document = json.loads((ROOT / "examples" / "two_mass" / "coeffs.json").read_text())
    sum_of = {"name": "sum", "component": "housing", "kind": "cusum", "slack_K": 0.5, "threshold_K_s": 200.0}
    document["alarms"] = [sum_of]
    (rule,) = lower_alarms(parse(json.dumps(document).encode()))
    alarms = ReferenceAlarms([replace(rule, start_wait=0)], np.array([True]))
    model = np.full((2, 1), 40_000)
    raised = []
    for _ in range(100):
        alarms.step(np.array([100]), model + 10_500, model, np.array([3]))
        raised.append(bool(alarms.latched[0]))
    assert raised.index(True) + 1 == 20.0 / 0.25


def test_a_relative_rule_waits_for_the_slower_part_of_the_two() -> None:
    """What one of the two is off by after such a start is in their difference."""
    coefficients = changed(relative_to="winding")
    model = coefficients.model
    waits = {name: start_wait(model, name, range(256)) for name in model.component_names}
    assert waits["winding"] != waits["housing"]
    for component, other in (("housing", "winding"), ("winding", "housing")):
        (rule,) = lower_alarms(changed(component=component, relative_to=other))
        assert rule.start_wait == max(waits.values())


@pytest.mark.parametrize("dimensions", [2, 3, 4])
def test_the_outermost_of_many_starts_decide_whatever_is_read_later(dimensions: int) -> None:
    rng = np.random.default_rng(dimensions)
    errors = rng.standard_normal((dimensions, 5000)) * np.linspace(0.1, 3.0, dimensions)[:, None]
    few = _outermost(errors)
    assert few.shape[1] < 0.2 * errors.shape[1]
    for read in rng.standard_normal((200, dimensions)):
        assert np.abs(read @ few).max() == pytest.approx(np.abs(read @ errors).max(), rel=1e-12)


def test_starts_that_lie_in_one_plane_are_all_kept() -> None:
    errors = np.vstack([np.random.default_rng(1).standard_normal((2, 2000)), np.zeros(2000)])
    assert _outermost(errors).shape == errors.shape
