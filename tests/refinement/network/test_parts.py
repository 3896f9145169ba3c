"""What is left out, which channels count, what looks like a fault."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from gen.refinement.network.effects.base import WHOLE
from gen.refinement.network.effects.hidden_node import HiddenNode
from gen.refinement.network.effects.schedule_error import ScheduleError
from gen.refinement.network.effects.sensors import SensorGain
from gen.refinement.network.fitting.anchored import Anchored
from gen.refinement.network.fitting.data import Data, make_data
from gen.refinement.network.fitting.folds import described, folds_of
from gen.refinement.network.tracing.changed import has_grown, looks_like_a_change
from tests.refinement.network.motor import profile, read, run, tree, wave


def data(runs: int) -> Data:
    """Runs with a load, a channel that only follows PWM, and one that stands still."""
    motor = read(tree())
    made = []
    for seed in range(1, runs + 1):
        pwm = profile(seed).astype(np.float64)
        told = {
            "load_A": wave(seed, 1.0, 4.0),
            "speed_rpm": 10.0 * np.abs(pwm),
            "supply_V": np.full(pwm.size, 24.0),
        }
        made.append((f"run {seed}", run(motor, seed, told)))
    return make_data(motor, made)


def test_channels_that_say_no_more_than_pwm_explain_nothing() -> None:
    assert data(2).columns.channels == ("load_A",)


@pytest.mark.parametrize("runs", [1, 2, 3, 4, 7])
def test_every_later_bin_is_left_out_once_and_none_of_the_file(runs: int) -> None:
    made = data(runs)
    times = np.sum(folds_of(made), axis=0)
    assert np.array_equal(times, made.is_later.astype(np.int64))


@pytest.mark.parametrize("runs", [1, 2, 3])
def test_each_fold_of_few_runs_keeps_driving_and_rest(runs: int) -> None:
    made = data(runs)
    for mask in folds_of(made):
        kept = made.is_later & ~mask
        assert np.any(made.inputs.rest[kept] > 0.9)
        assert np.any(made.inputs.rest[kept] < 0.1)


def test_what_is_left_out_is_told() -> None:
    assert described(2) == "stretches of an eighth of each run, in 4 groups"
    assert described(4) == "whole runs"
    assert described(20) == "whole runs, in 5 groups"


@pytest.mark.parametrize(
    ("values", "fault"),
    [
        ((1.0, 1.3, 1.4, 1.5, 1.4, 1.3), True),
        ((1.0, 1.2, 1.2, 1.0, 0.8, 0.8), False),
        ((1.0, 1.0, 1.0, 1.3, 1.0, 1.0), False),
    ],
)
def test_heat_that_has_grown_at_every_speed_is_a_fault_s_pattern(values: tuple[float, ...], fault: bool) -> None:
    made = data(2)
    network = read(tree()).model.network
    assert network is not None
    motor = Anchored.of(network, 255, made.columns).motor()
    for effect in (ScheduleError(motor, [0], "winding"), ScheduleError(motor, [0, 1], WHOLE)):
        said = looks_like_a_change(effect, values, made)
        assert bool(said) == fault
        assert (effect.component in said) == fault


def test_heat_that_has_grown_most_at_slow_speeds_is_no_wear_of_one_part() -> None:
    """A resonance fades slowly and so adds a little everywhere; what is worn rubs more the faster it turns."""
    made = data(2)
    network = read(tree()).model.network
    assert network is not None
    motor = Anchored.of(network, 255, made.columns).motor()
    resonance = (1.2, 1.4, 1.5, 1.2, 1.06, 1.04)
    assert not looks_like_a_change(ScheduleError(motor, [0], "winding"), resonance, made)
    assert looks_like_a_change(ScheduleError(motor, [0, 1], WHOLE), resonance, made)  # a cover may do that


@pytest.mark.parametrize(
    ("values", "changed"),
    [
        ((1.03, 0.95, 0.9, 0.87, 0.85, 0.82), True),
        ((1.0, 0.98, 0.98, 0.97, 0.98, 0.98), False),
        ((1.0, 0.95, 0.95, 0.6, 0.95, 0.95), False),
        ((1.0, 0.8, 0.8, 0.8, 1.0, 1.0), False),
    ],
    ids=["a lower supply", "within what a file errs by", "a dip", "at some speeds"],
)
def test_less_heat_of_the_whole_motor_at_every_speed_is_told_as_a_change(
    values: tuple[float, ...], changed: bool
) -> None:
    made = data(2)
    network = read(tree()).model.network
    assert network is not None
    motor = Anchored.of(network, 255, made.columns).motor()
    whole = ScheduleError(motor, [0, 1], WHOLE)
    assert ("its heat is less" in looks_like_a_change(whole, values, made)) == changed
    assert not has_grown(whole, values, made)  # nothing that a fault does
    assert not looks_like_a_change(ScheduleError(motor, [0], "winding"), values, made)


@pytest.mark.parametrize(("peak", "fault"), [(1.12, True), (1.4, False)])
def test_heat_of_the_whole_motor_that_peaks_between_its_speeds_is_no_cover(peak: float, fault: bool) -> None:
    made = data(2)
    network = read(tree()).model.network
    assert network is not None
    motor = Anchored.of(network, 255, made.columns).motor()
    values = (1.05, 1.05, 1.05, peak, 1.05, 1.05)
    assert bool(looks_like_a_change(ScheduleError(motor, [0, 1], WHOLE), values, made)) == fault


@pytest.mark.parametrize(
    ("capacity", "conductance", "shown"),
    [(60.0, 10.0, True), (60.0, 15.0, False), (20.0, 0.5, True), (20.0, 2.0, False), (60.0, 0.001, False)],
    ids=["bolted on", "within 4 s", "light", "light and quick", "a day"],
)
def test_a_mass_shows_however_firmly_it_is_bolted_on(capacity: float, conductance: float, shown: bool) -> None:
    """Of nodes of 120 and 400 J/K: a fifth of what they usually hold is 52 J/K."""
    network = read(tree()).model.network
    assert network is not None
    part = HiddenNode(Anchored.of(network, 255, data(2).columns).motor(), 0, outside=False)
    assert (not part.doubts((capacity, conductance, 0.0001, 0.001, 1.0))) == shown


@pytest.mark.parametrize(
    ("capacity", "conductance", "power", "exponent", "fault"),
    [
        (4.0, 0.1, 1.0, 1.0, True),
        (4.0, 0.1, 1.0, 0.0, True),
        (4.0, 0.1, 1.0, -0.5, False),
        (4.0, 0.01, 1.0, 1.0, True),
        (100.0, 2.0, 5.0, 1.0, True),
        (100.0, 0.2, 5.0, 1.0, False),
        (200.0, 5.0, 0.1, 1.0, False),
    ],
    ids=["at once", "as much at all speeds", "does not rub", "late", "heavy and hot", "a part", "a mass bolted on"],
)
def test_a_part_that_is_heat_rather_than_mass_has_a_fault_s_pattern(
    capacity: float, conductance: float, power: float, exponent: float, fault: bool
) -> None:
    made = data(2)
    network = read(tree()).model.network
    assert network is not None
    motor = Anchored.of(network, 255, made.columns).motor()
    values = (capacity, conductance, 0.001, power, exponent)
    said = looks_like_a_change(HiddenNode(motor, 0, outside=False), values, made)
    assert ("winding: its heat has grown" in said) == fault


def test_a_part_that_takes_more_heat_off_than_it_brings_is_no_wear() -> None:
    """A throttled pump's winding is colder: its part brings a watt, and takes ten off."""
    made = data(2)
    network = read(tree()).model.network
    assert network is not None
    motor = Anchored.of(network, 255, made.columns).motor()
    part = HiddenNode(motor, 0, outside=True)
    assert has_grown(part, (4.0, 0.1, 0.001, 1.0, 1.0), made)
    rise = made.offered.hottest_degC["winding"] - float(np.median(made.inputs.ambient[made.is_later]))
    cooling = 10.0 / rise
    assert not has_grown(part, (4.0, 10.0, cooling, 1.0, 1.0), made)


@pytest.mark.parametrize(("gain", "says"), [(0.18, "18% more of its rise"), (-0.1, "10% less of its rise")])
def test_a_gain_of_the_only_sensor_is_the_motor_s_heat_as_well(gain: float, says: str) -> None:
    made = data(2)
    network = read(tree()).model.network
    assert network is not None
    motor = Anchored.of(network, 255, made.columns).motor()
    effect = SensorGain(motor, 0, of_rise=True)
    assert not looks_like_a_change(effect, (gain,), made), "two sensors tell it from heat"
    alone = replace(made, offered=replace(made.offered, hottest_degC={"winding": 80.0}))
    said = looks_like_a_change(effect, (gain,), alone)
    assert says in said
    assert "the motor has changed since the file was made, or the file was wrong there" in said


@pytest.mark.parametrize(
    ("identified", "said"),
    [
        (None, ""),
        ((21.0, 26.0), ""),
        ((30.0, 34.0), "and 30 to 34 degC in those of the file"),
        ((36.5, 36.5), "and 36 degC in those of the file"),
        ((-4.0, 19.5), ""),
        ((-4.0, 12.0), "and -4 to 12 degC in those of the file"),
    ],
)
def test_a_change_in_another_season_says_so(identified: tuple[float, float] | None, said: str) -> None:
    """In a colder room grease is stiffer, and copper conducts better: neither is a fault."""
    made = replace(data(2), identified_degC=identified)
    network = read(tree()).model.network
    assert network is not None
    motor = Anchored.of(network, 255, made.columns).motor()
    found = looks_like_a_change(ScheduleError(motor, [0], "winding"), (1.0, 1.3, 1.4, 1.5, 1.4, 1.3), made)
    assert "its heat has grown" in found
    assert ("in a room as then" in found) == bool(said)
    assert said in found
