"""The MAX6675's word against its data sheet, the sensor's errors, and each fault."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gen.rig import SENSOR_FAULTS, SensorConfig, SensorFault, Thermocouple, decode
from gen.rig.sensors import SensorFaultKind

IDEAL = SensorConfig(noise_K=0.0, lag_s=0.0)
TICK = 0.25


def reads(config: SensorConfig, true_degC: float = 60.0, count: int = 400, seed: int = 1) -> list[int]:
    sensor = Thermocouple(config, seed)
    return [sensor.read(true_degC, k * TICK) for k in range(count)]


def faulty(kind: SensorFaultKind, **more: float) -> list[int]:
    """Words of an otherwise ideal sensor at 60 degC whose fault lasts from 25 s to 50 s: rows 100 to 199."""
    fault = SensorFault(kind, 25.0, 50.0, **more)
    return reads(SensorConfig(noise_K=0.0, lag_s=0.0, faults=(fault,)))


@pytest.mark.parametrize(
    ("true_degC", "word"),
    # Bits 14..3 in quarters of a degree; 0 and 1023.75 degC are the ends of the range.
    [
        (0.0, 0x0000),
        (0.25, 0x0008),
        (25.0, 0x0320),
        (100.0, 0x0C80),
        (1023.75, 0x7FF8),
        (-20.0, 0x0000),
        (2000.0, 0x7FF8),
    ],
)
def test_word_is_that_of_the_data_sheet(true_degC: float, word: int) -> None:
    assert Thermocouple(IDEAL).read(true_degC, 0.0) == word


@given(true_degC=st.floats(0.0, 1023.75))
def test_a_word_decodes_to_the_nearest_quarter_of_a_degree(true_degC: float) -> None:
    word = Thermocouple(IDEAL).read(true_degC, 0.0)
    assert word & 0x8007 == 0
    assert abs(decode(word) - true_degC) <= 0.125 + 1e-9


@pytest.mark.parametrize("word", [0xFFFF, 0x0004, 0x0324, 0x8320, 0x0322])
def test_open_and_impossible_words_decode_to_nothing(word: int) -> None:
    assert math.isnan(decode(word))


def test_offset_gain_and_drift_shift_the_reading() -> None:
    def after_an_hour(**changes: float) -> float:
        sensor = Thermocouple(SensorConfig(noise_K=0.0, lag_s=0.0, **changes))  # type: ignore[arg-type]
        sensor.read(65.0, 0.0)
        return decode(sensor.read(65.0, 3600.0))

    assert after_an_hour() == 65.0
    assert after_an_hour(offset_K=-1.0) == 64.0
    assert after_an_hour(drift_K_per_h=2.0) == 67.0
    assert after_an_hour(gain=1.05) == 67.0  # 5 % of 40 K over the cold junction at 25 degC


def test_noise_has_its_standard_deviation_and_follows_the_seed() -> None:
    config = SensorConfig(noise_K=0.8, lag_s=0.0)
    words = reads(config, count=20_000)
    values = np.array([decode(word) for word in words])
    assert values.mean() == pytest.approx(60.0, abs=0.03)
    assert values.std() == pytest.approx(math.hypot(0.8, 0.25 / math.sqrt(12.0)), rel=0.03)
    assert reads(config, count=200) == words[:200]
    assert reads(config, count=200, seed=2) != words[:200]


def test_lag_follows_a_step_and_a_ramp_exactly() -> None:
    fine = SensorConfig(noise_K=0.0, lag_s=5.0)
    sensor = Thermocouple(fine)
    sensor.read(20.0, 0.0)
    sensor.read(20.0, 1.0)
    # The part jumps within a microsecond, and after one time constant the tip has made 63 % of the way.
    sensor.read(120.0, 1.000001)
    assert decode(sensor.read(120.0, 6.000001)) == pytest.approx(20.0 + 100.0 * (1.0 - math.exp(-1.0)), abs=0.13)
    ramp = Thermocouple(fine)
    for t in (0.0, 10.0, 30.0, 100.0):
        word = ramp.read(20.0 + 0.5 * t, t)
    assert decode(word) == pytest.approx(70.0 - 0.5 * 5.0, abs=0.13)


def test_reading_during_a_conversion_gives_the_old_word() -> None:
    sensor = Thermocouple(IDEAL)
    first = sensor.read(40.0, 0.0)
    assert sensor.read(50.0, 0.1) == first
    assert decode(sensor.read(50.0, 0.35)) == 50.0


@pytest.mark.parametrize("kind", SENSOR_FAULTS)
def test_a_fault_shows_between_its_times_and_only_then(kind: SensorFaultKind) -> None:
    words, good = faulty(kind), reads(IDEAL)
    assert words[:100] == good[:100]
    assert words[200:] == good[200:]
    if kind != "stuck":
        assert words[100] != good[100]


def test_each_fault_looks_as_named() -> None:
    right = Thermocouple(IDEAL).read(60.0, 0.0)
    assert set(faulty("open")[100:200]) == {right | 0x0004}
    assert set(faulty("all_0")[100:200]) == {0x0000}
    assert set(faulty("all_1")[100:200]) == {0xFFFF}
    assert {decode(word) for word in faulty("jump", size_K=-15.0)[100:200]} == {45.0}
    noisy = np.array([decode(word) for word in faulty("noise", size_K=8.0)[100:200]])
    assert 5.0 < noisy.std() < 11.0
    spiky = [decode(word) for word in faulty("spike", size_K=100.0, every_s=10.0)]
    assert [k for k, value in enumerate(spiky) if value == 160.0] == [100, 140, 180]


def test_a_stuck_sensor_stays_while_the_part_warms_and_comes_back() -> None:
    sensor = Thermocouple(SensorConfig(noise_K=0.0, lag_s=0.0, faults=(SensorFault("stuck", 5.0, 10.0),)))
    values = [decode(sensor.read(40.0 + t, float(t))) for t in range(15)]
    assert values == [40.0 + (4 if 5 <= t < 10 else t) for t in range(15)]


def test_nonsense_is_refused() -> None:
    with pytest.raises(ValueError, match="expected one of open"):
        SensorFault("melted", 0.0)  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="after it begins"):
        SensorFault("open", 5.0, 5.0)
    with pytest.raises(ValueError, match="lag"):
        SensorConfig(lag_s=-1.0)
    sensor = Thermocouple()
    sensor.read(20.0, 1.0)
    with pytest.raises(ValueError, match="after a read"):
        sensor.read(20.0, 0.5)
