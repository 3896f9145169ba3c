"""The sensor chips: their words against the data sheets, in the reference, the emitted C++ and at the emulated pins."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gen.coefficients.wiring import CHIP_RANGES_degC
from gen.emulate.scenario import converters
from gen.emulate.wiring.registers import RegisterChip
from gen.lowering.platinum import resistance
from gen.lowering.sensors import CONFIRMATIONS, SensorLimits, reading_samples, sensor_limits
from gen.reference.chips import SensorCode, decoded
from gen.reference.sensors import SensorCheck
from gen.rig.chips import Converter
from tests.device.board import OPEN, Board
from tests.device.conftest import Open
from tests.device.sensor_harness import Cpp, Step, by_reference
from tests.device.variants import BASE, KINDS, variant

CHANNELS = list(KINDS)
FILE = variant("every_chip")
LIMITS = {item.channel: item for item in sensor_limits(FILE)}
WIRING = FILE.document.wiring
assert WIRING is not None
CHIPS = converters(WIRING)
PLACES = WIRING.thermocouples
CLOCK = BASE["wiring"]["thermocouples"][0]["sck"]


@pytest.mark.parametrize("channel", CHANNELS)
def test_every_temperature_of_a_chips_range_comes_through_to_its_count(channel: str) -> None:
    """Encoded by the simulated sensor, which shares no line with what decodes."""
    limits, chip = LIMITS[channel], CHIPS[channel]
    lowest, highest = CHIP_RANGES_degC[limits.chip]
    for celsius in np.linspace(max(lowest, 0.25 if limits.chip == "MAX6675" else lowest), highest, 3001).tolist():
        if chip.kind == "MAX31865" and resistance(celsius) * chip.platinum_ohm > chip.reference_ohm * 0.9999:
            continue
        code, counts = decoded(limits, chip.word(celsius, 23.5, False))
        assert code is SensorCode.OK
        assert abs(counts * 0.25 - celsius) <= (0.4 if chip.kind == "MAX31865" else 0.13)
    assert decoded(limits, chip.word(25.0, 23.5, True))[0] is SensorCode.OPEN
    assert decoded(limits, chip.all_ones)[0] in (SensorCode.ONES, SensorCode.OPEN)
    assert decoded(limits, 0)[0] is SensorCode.ZEROS


def test_words_of_the_data_sheets() -> None:
    """MAX31855, tables 4 and 5; MAX31856, table 4; a PT100 at 100 degC has 138.51 ohm (IEC 60751)."""
    k55, k56, platinum = LIMITS["brush"], LIMITS["bearing"], LIMITS["magnet"]
    own = 0x0190_0 & 0xFFFF  # 25 degC
    for bits, counts in ((0b0110_0100_0000_00, 6400), (0b0000_0110_0100_11, 403), (0b1111_1111_1111_11, -1)):
        assert decoded(k55, bits << 18 | own) == (SensorCode.OK, counts)
    assert decoded(k55, 0b11_1100_0110_0000 << 18 | own) == (SensorCode.OK, -928)
    for bits, celsius in ((0x64_0000, 1600.0), (0x3E_8000, 1000.0), (0x06_4F00, 100.9375), (0xFF_FF00, -0.0625)):
        assert decoded(k56, bits << 8)[1] == round(celsius * 4)
    code = round(138.51 / 430.0 * 32768)
    assert decoded(platinum, 0xC1 << 16 | code << 1) == (SensorCode.OK, 400)


def foreign(upper: int, lower: int) -> int:
    """What the board reads where it takes the chip for a MAX6675."""
    return lower << 16 | upper


@given(st.floats(0.5, 1300.0), st.floats(-20.0, 80.0), st.booleans())
def test_a_max31855_in_a_max6675s_place_is_never_taken_for_half(celsius: float, own: float, is_open: bool) -> None:
    word = Converter("MAX31855").word(celsius, own, is_open)
    if word & 0xFFFF == 0:  # its own temperature is 0.00 degC
        return
    found = decoded(LIMITS["ambient"], foreign(word >> 16, word & 0xFFFF))
    assert found[0] is not SensorCode.OK


@given(st.floats(0.25, 1023.0), st.sampled_from(["zeros", "ones", "last bit", "again"]), st.booleans())
def test_a_max6675_in_its_own_place_is_one_whatever_it_sends_behind_its_word(
    celsius: float, behind: str, floats: bool
) -> None:
    word = Converter().word(celsius, 25.0, False) | floats
    after = {"zeros": 0, "ones": 0xFFFF, "last bit": 0xFFFF * (word & 1), "again": word}[behind]
    assert decoded(LIMITS["ambient"], foreign(word, after)) == (SensorCode.OK, word >> 3)
    if behind != "again":  # and it is none in a MAX31855's place
        assert decoded(LIMITS["brush"], word << 16 | after)[0] is SensorCode.ONES


def test_a_max6675s_zeros_go_on_from_a_temperature_that_came_down_to_them() -> None:
    limits = SensorLimits("ambient", 0, 240, 5, 0, 0)
    check = SensorCheck(limits)
    falling = [*[9] * CONFIRMATIONS, 8, 7, 5, 4, 3, 2, 1, 0, 0, 0, 0, 0, 0, 1, 2]
    found = [int(check.check(counts << 3, True, 0)) for counts in falling]
    assert found == [8] * (CONFIRMATIONS - 1) + [0] * (len(falling) - CONFIRMATIONS + 1)
    dead = SensorCheck(limits)
    assert [int(dead.check(counts << 3, True, 0)) for counts in [40] * 4 + [0] * 8] == [8, 8, 8, 0] + [2] * 8
    assert dead.temperature_mC == 10_000
    never_seen = SensorCheck(limits)
    assert {int(never_seen.check(0, True, 0)) for _ in range(20)} == {2}


@pytest.fixture(scope="module")
def cpp(tmp_path_factory: pytest.TempPathFactory) -> Cpp:
    return Cpp(tmp_path_factory.mktemp("chips"), FILE)


def random_steps(seed: int, count: int) -> list[Step]:
    """Each chip's own words, below zero too, with bits turned, words of other chips, and anything."""
    generator = np.random.default_rng(seed)
    level = dict.fromkeys(CHANNELS, 20.0)
    steps: list[Step] = []
    for _ in range(count):
        number = int(generator.integers(len(CHANNELS)))
        channel = CHANNELS[number]
        level[channel] = float(np.clip(level[channel] + generator.normal(0.0, 0.6), -45.0, 300.0))
        kind = generator.integers(0, 30)
        chip = CHIPS[CHANNELS[int(generator.integers(len(CHANNELS)))]] if kind == 0 else CHIPS[channel]
        word = chip.word(level[channel], float(generator.choice([-20.0, 0.0, 23.0, 60.0])), kind == 1)
        if kind == 2:
            word ^= 1 << int(generator.integers(0, 32))
        elif kind == 3:
            word = int(generator.integers(0, 1 << 32))
        elif kind == 4:
            word = int(generator.choice([0, 0xFFFF, 0xFFFF_FFFF, word << 16 & 0xFFFF_FFFF, word >> 16]))
        steps.append((number, word, bool(kind != 5), int(1000 * level[channel])))
    return steps


def test_the_boards_checks_of_every_chip_equal_the_reference(cpp: Cpp) -> None:
    for seed in range(3):
        steps = random_steps(seed, 20_000)
        found = cpp.run(steps)
        assert found == by_reference(cpp.limits, steps)
        assert min(mC for _, mC, *_ in found) < -20_000
        assert {code for code, *_ in found} >= {0, 1, 2, 3, 4, 5, 7, 8}


def test_the_emulated_boards_checks_of_every_chip_equal_the_reference(cpp: Cpp) -> None:
    steps = random_steps(9, 6000)
    found, cycles = cpp.run_on_board(steps)
    assert found == by_reference(cpp.limits, steps)
    assert cycles < 3000


@settings(max_examples=40, deadline=None)
@given(st.lists(st.tuples(st.integers(0, 4), st.integers(0, 0xFFFF_FFFF), st.booleans(), st.just(0)), max_size=80))
def test_the_boards_checks_of_every_chip_equal_the_reference_on_anything(cpp: Cpp, steps: list[Step]) -> None:
    assert cpp.run(steps) == by_reference(cpp.limits, steps)


TEMPERATURES = {"brush": -12.5, "bearing": 61.5, "magnet": -7.25, "casing": 48.0, "ambient": 3.25}


def started(power_up: Open) -> Board:
    board = power_up("every_chip")
    for channel, celsius in TEMPERATURES.items():
        board.set_celsius(channel, celsius)
    board.started()
    return board


def test_every_chip_is_read_at_its_pins_below_zero_too(power_up: Open) -> None:
    row = started(power_up).hear(1.0).rows[-1]
    assert row["sensors"] == "00000"
    for channel, celsius in TEMPERATURES.items():
        assert float(row[f"{channel}_degC"]) == pytest.approx(celsius, abs=0.3)


@pytest.mark.parametrize("name", ["every_chip", "my1016"])
def test_the_clock_is_slow_enough_for_a_metre_of_wire(power_up: Open, name: str) -> None:
    board = power_up(name)
    probe = board.pins.watch({"every_chip": 52, "my1016": CLOCK}[name])
    board.hear(3.0)
    lasting = np.diff(probe.edges().seconds)
    of_bits = lasting[lasting < 20e-6]
    assert len(of_bits) > 200
    assert of_bits.min() >= 1e-6


def test_a_chip_that_lost_its_configuration_is_told_again(power_up: Open) -> None:
    """As after a dip of its supply that the board has not noticed."""
    board = started(power_up)
    for chip in board.chips.values():
        if isinstance(chip, RegisterChip):
            chip.lose_supply()
    board.send("rows 1")
    codes = [row["sensors"] for row in board.hear(4.0).rows]
    assert {"03", "00"} <= {code[0] + code[1] for code in codes}
    assert any(code[2] == "2" for code in codes)  # no configuration and no resistance: zeros
    assert codes[-1] == "00000"


def test_chips_that_changed_places_are_recognised(power_up: Open) -> None:
    """The board reads the ambient's MAX6675 as a MAX31855, and the brush's MAX31855 as a MAX6675."""
    right, swapped = PLACES, power_up("every_chip", connected=False)
    first, last = right[0], right[-1]
    swapped.add_chip("MAX6675", first.cs, first.so, first.sck).set_word(Converter().word(60.0, 25.0, False))
    other = swapped.add_chip("MAX31855", last.cs, last.so, last.sck)
    other.set_word(Converter("MAX31855").word(60.0, 25.0, False))
    rows = swapped.hear(9.0).rows
    assert rows
    assert {row["sensors"][0] + row["sensors"][4] for row in rows} <= {"33", "73"}


@pytest.mark.parametrize("name", ["my1016", "every_chip"])
def test_a_start_in_the_cold_takes_the_ambient_no_warmer_than_the_coldest_part(power_up: Open, name: str) -> None:
    """The ambient's MAX6675 sends zeros at -5 degC; 30 degC, the file's fixed ambient, would be 27 K off."""
    board = power_up(name)
    for channel, celsius in {"brush": 4.0, "bearing": 3.5, "magnet": 3.5, "casing": 3.0, "ambient": -5.0}.items():
        board.set_celsius(channel, celsius)
    board.started()
    row = board.hear(20.0).rows[-1]
    assert row["ambient_degC"] == ""
    for part, celsius in {"brush": 4.0, "bearing": 3.5, "magnet": 3.5, "casing": 3.0}.items():
        assert float(row[f"{part}_model_degC"]) == pytest.approx(celsius, abs=0.6)


@pytest.mark.parametrize("only", ["brush", "casing"])
def test_a_start_in_the_cold_asks_every_part_for_the_ambient(power_up: Open, only: str) -> None:
    """One part alone is believed, the first or the last: the others begin where it is, not at the file's 30 degC."""
    board = power_up("my1016")
    board.set_celsius("ambient", -5.0)
    for channel in set(board.chips) - {"ambient"}:
        board.chips[channel].set_word(OPEN)
    board.set_celsius(only, 3.0)
    board.started()
    row = board.hear(20.0).rows[-1]
    assert row["ambient_degC"] == ""
    for part in ("brush", "bearing", "magnet", "casing"):
        assert float(row[f"{part}_model_degC"]) == pytest.approx(3.0, abs=0.6)


def test_a_fall_below_zero_goes_on_as_zero_with_a_max6675(power_up: Open) -> None:
    board = power_up("my1016")
    for channel in board.chips:
        board.set_celsius(channel, 2.0)
    board.started()
    for quarter in range(8, -20, -1):
        board.set_celsius("ambient", quarter / 4.0)
        rows = board.hear(0.6).rows
    assert [row["ambient_degC"] for row in rows if row["ambient_degC"]] in (["0.00"], [])
    assert board.hear(3.0).rows[-1]["ambient_degC"] == "0.00"


@pytest.mark.parametrize("sample_s", [0.05, 0.1, 0.25])
def test_faster_chips_are_read_more_often(sample_s: float) -> None:
    assert reading_samples(sample_s, 66) <= reading_samples(sample_s, 220)
    assert reading_samples(sample_s, 66) * sample_s > 0.066
