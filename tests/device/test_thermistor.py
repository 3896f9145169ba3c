"""NTCs on the Mega's own converter: their table against the formula, their checks, and at the emulated pins."""

from __future__ import annotations

import json
import math
import re
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gen.coefficients import parse
from gen.emulate.scenario import converters
from gen.emulate.wiring.pins import PIN_MAPS
from gen.errors import InputError
from gen.firmware.project import project_files
from gen.firmware.sketch.commissioning import wiring_identity
from gen.lowering.lower import lower
from gen.lowering.sensors import CONVERSION_MS, sensor_limits
from gen.reference.chips import SensorCode, decoded
from tests.device.board import Board
from tests.device.conftest import Open
from tests.device.sensor_harness import Cpp, Step, by_reference
from tests.device.variants import BEAD, variant
from tests.examples import ROOT

FILE = variant("thermistors")
LIMITS = {item.channel: item for item in sensor_limits(FILE)}
WIRING = FILE.document.wiring
assert WIRING is not None
PLACES = {one.channel: one for one in WIRING.thermocouples}
CHIPS = converters(WIRING)
SUMS = range(1023 * 16 + 1)


def by_hand(channel: str, share: float) -> float:
    """The temperature, degC, by the formulas of data sheets, for the two dividers of the variant."""
    if channel == "brush":  # at ground
        ohm = 2200.0 * share / (1.0 - share)
        return 1.0 / (1.0 / 298.15 + math.log(ohm / 10_000.0) / 3950.0) - 273.15
    a, b, c = (1.129148e-3, 2.34125e-4, 8.76741e-8)
    logarithm = math.log(1000.0 * (1.0 - share) / share)
    return float(1.0 / (a + b * logarithm + c * logarithm**3) - 273.15)


@pytest.mark.parametrize("channel", ["brush", "casing"])
def test_every_code_of_the_converter_and_every_sum_is_its_temperature(channel: str) -> None:
    """Half a count of 0.25 K is rounding; what is left is the table's."""
    lowest, highest = PLACES[channel].range_degC
    assert highest - lowest > 150.0
    off = []
    for total in SUMS:
        code, counts = decoded(LIMITS[channel], total)
        truth = by_hand(channel, total / 16384.0) if total > 0 else math.inf
        if lowest <= truth <= highest:
            assert code is SensorCode.OK
            off.append(abs(counts * 0.25 - truth))
    assert len(off) > 16 * 900
    assert max(off) < 0.155


@pytest.mark.parametrize("channel", ["brush", "casing"])
def test_beyond_its_range_a_sound_sum_still_is_as_hot_as_it_says(channel: str) -> None:
    """Rules of the kind over_temperature heed it: it may be coarse, and not cold."""
    _, highest = PLACES[channel].range_degC
    for total in SUMS:
        code, counts = decoded(LIMITS[channel], total)
        if code is SensorCode.OK and (truth := by_hand(channel, total / 16384.0)) > highest:
            assert counts * 0.25 == pytest.approx(truth, rel=0.02)


@pytest.mark.parametrize(
    ("channel", "ground", "supply"),
    [("brush", SensorCode.ZEROS, SensorCode.OPEN), ("casing", SensorCode.OPEN, SensorCode.ONES)],
)
def test_a_rail_is_a_broken_wire_or_a_short(channel: str, ground: SensorCode, supply: SensorCode) -> None:
    for total in (0, 1, 16, 31):
        assert decoded(LIMITS[channel], total)[0] is ground
    for total in (1023 * 16, 1022 * 16, 1021 * 16 + 1):
        assert decoded(LIMITS[channel], total)[0] is supply
    for word in (1023 * 16 + 1, 0xFFFF, 0xFFFF_FFFF):
        assert decoded(LIMITS[channel], word)[0] is SensorCode.ONES


@pytest.mark.parametrize("channel", ["brush", "casing"])
def test_every_temperature_of_its_range_comes_through(channel: str) -> None:
    """Encoded by the simulated sensor, which solves the curve the other way round; a code is half a step wide."""
    lowest, highest = PLACES[channel].range_degC
    for celsius in np.linspace(lowest, highest, 2001).tolist():
        code, counts = decoded(LIMITS[channel], CHIPS[channel].word(celsius, 23.0, False))
        assert code is SensorCode.OK
        assert abs(counts * 0.25 - celsius) <= 0.5 + 0.16
    assert decoded(LIMITS[channel], CHIPS[channel].word(25.0, 23.0, True))[0] is SensorCode.OPEN


@given(
    st.floats(1000.0, 200_000.0),
    st.floats(2500.0, 5000.0),
    st.floats(500.0, 50_000.0),
    st.sampled_from(["ground", "supply"]),
)
@settings(max_examples=40, deadline=None)
def test_any_bead_s_table_is_within_a_sixth_of_a_kelvin_of_its_formula(
    r25: float, beta: float, series: float, to: str
) -> None:
    tree = json.loads((ROOT / "examples" / "my1016" / "coeffs.json").read_text())
    bead = {"chip": "NTC", "r25_ohm": r25, "beta_K": beta, "series_ohm": series, "thermistor_to": to}
    tree["wiring"]["thermocouples"] = [{"channel": "ambient", "analog_pin": 54, **bead}]
    tree["alarms"] = []
    try:
        coefficients = parse(json.dumps(tree).encode())
    except InputError as error:
        assert "a step of the converter is more than 1 K at every" in str(error)
        return
    (limits,) = sensor_limits(coefficients)
    wiring = coefficients.document.wiring
    assert wiring is not None
    lowest, highest = wiring.thermocouples[0].range_degC
    for total in range(16, 1023 * 16, 7):
        share = total / 16384.0
        ohm = series * (share / (1.0 - share) if to == "ground" else (1.0 - share) / share)
        truth = 1.0 / (1.0 / 298.15 + math.log(ohm / r25) / beta) - 273.15
        if lowest <= truth <= highest:
            code, counts = decoded(limits, total)
            assert code is SensorCode.OK
            assert abs(counts * 0.25 - truth) < 0.16


@pytest.fixture(scope="module")
def cpp(tmp_path_factory: pytest.TempPathFactory) -> Cpp:
    return Cpp(tmp_path_factory.mktemp("thermistors"), FILE)


def every_sum() -> list[Step]:
    """Each of both dividers' sums, up and down: a step is a fraction of a kelvin, or a jump."""
    rising = [(number, total, True, 0) for number in (0, 3) for total in SUMS]
    return [*rising, *reversed(rising)]


def random_steps(seed: int, count: int) -> list[Step]:
    """Parts that warm and cool, with noise, rails, other chips' words and anything."""
    generator = np.random.default_rng(seed)
    level = {"brush": 20.0, "casing": 30.0}
    steps: list[Step] = []
    for _ in range(count):
        number, channel = ((0, "brush"), (3, "casing"))[int(generator.integers(2))]
        level[channel] = float(np.clip(level[channel] + generator.normal(0.0, 0.6), -40.0, 250.0))
        kind = int(generator.integers(0, 30))
        total = CHIPS[channel].word(level[channel], 23.0, kind == 1)
        total = min(max(total + int(generator.integers(-8, 9)), 0), 1023 * 16)
        if kind == 2:
            total = int(generator.integers(0, 1 << 32))
        elif kind == 3:
            total = int(generator.choice([0, 31, 32, 1021 * 16, 1021 * 16 + 1, 1023 * 16, 0xFFFF_FFFF]))
        steps.append((number, total, kind != 4, int(1000 * level[channel])))
    return steps


def test_the_boards_checks_of_every_sum_equal_the_reference(cpp: Cpp) -> None:
    steps = every_sum()
    found = cpp.run(steps)
    assert found == by_reference(cpp.limits, steps)
    assert {code for code, *_ in found} >= {0, 1, 2, 3, 4, 8}
    for seed in range(3):
        steps = random_steps(seed, 20_000)
        found = cpp.run(steps)
        assert found == by_reference(cpp.limits, steps)
        assert {code for code, *_ in found} >= {0, 1, 2, 3, 4, 5, 7, 8}


def test_the_emulated_boards_checks_equal_the_reference(cpp: Cpp) -> None:
    steps = [(number, 16 * code, True, 0) for number in (0, 3) for code in range(1024)] + random_steps(9, 4000)
    found, cycles = cpp.run_on_board(steps)
    assert found == by_reference(cpp.limits, steps)
    assert cycles < 3000


TEMPERATURES = {"brush": 61.5, "bearing": 55.5, "magnet": 52.0, "casing": 48.25, "ambient": 24.5}


def started(power_up: Open, name: str = "thermistors") -> Board:
    board = power_up(name)
    for channel, celsius in TEMPERATURES.items():
        if channel in board.chips:
            board.set_celsius(channel, celsius)
    board.started()
    return board


def test_it_is_read_at_its_pin_beside_chips_a_voltage_and_the_supply(power_up: Open) -> None:
    board = started(power_up)
    board.pins.drive_analog(56, 3.0)
    row = board.hear(3.0).rows[-1]
    assert row["sensors"] == "00000"
    for channel, celsius in TEMPERATURES.items():
        assert float(row[f"{channel}_degC"]) == pytest.approx(celsius, abs=0.5)
    assert float(row["a_V"]) == pytest.approx(3.0, abs=0.011)
    board.send("test")
    assert any(re.search(r"test supply ok (49|50)\d\d mV", event) for event in board.hear(4.0).events)


@pytest.mark.parametrize("channel", ["brush", "bearing", "ambient"])
def test_a_board_without_any_chip_reads_each_thermistor_at_its_own_pin(power_up: Open, channel: str) -> None:
    board = started(power_up, "thermistors_alone")
    for moved in (1.5, 3.0, 4.5):
        board.set_celsius(channel, TEMPERATURES[channel] + moved)
        row = board.hear(3.0).rows[-1]
        shown = {name: float(row[f"{name}_degC"]) for name in board.chips}
        expected = {name: TEMPERATURES[name] + (moved if name == channel else 0.0) for name in board.chips}
        assert shown == pytest.approx(expected, abs=0.5)


def test_the_supply_has_no_part_in_it(power_up: Open) -> None:
    """The divider's voltage and what it is compared with sag together."""
    board = started(power_up)
    before = board.hear(2.0).rows[-1]
    board.supply_with(4.6)
    after = board.hear(3.0).rows[-1]
    for channel in ("brush", "casing"):
        assert float(after[f"{channel}_degC"]) == pytest.approx(float(before[f"{channel}_degC"]), abs=0.26)


@pytest.mark.parametrize(
    ("channel", "word", "code"),
    [("brush", 1023 * 16, "1"), ("brush", 0, "2"), ("casing", 0, "1"), ("casing", 1023 * 16, "3")],
)
def test_a_broken_wire_and_a_short_are_told_at_once_and_end_by_themselves(
    power_up: Open, channel: str, word: int, code: str
) -> None:
    board = started(power_up)
    place = list(TEMPERATURES).index(channel)
    board.send("rows 1")
    board.hear(1.0)
    board.chips[channel].set_word(word)
    rows = board.hear(1.0).rows
    assert rows[2]["sensors"][place] == code
    assert rows[2][f"{channel}_degC"] == ""
    board.set_celsius(channel, TEMPERATURES[channel])
    assert board.hear(3.0).rows[-1]["sensors"] == "00000"


def test_a_part_that_is_too_hot_raises_its_limit(power_up: Open) -> None:
    """The example's limit of the brush, 120 degC, by a warming of 1 K/s."""
    board = started(power_up)
    board.send("rows 1")
    raised_at = None
    for celsius in np.arange(61.5, 126.0, 0.5).tolist():
        board.set_celsius("brush", celsius)
        if raised_at is None and any("alarm brush_limit" in event for event in board.hear(0.5).events):
            raised_at = celsius
    assert raised_at == pytest.approx(120.0, abs=1.5)


def test_a_converter_that_stands_still_is_not_believed(power_up: Open) -> None:
    board = started(power_up)
    board.write("converting", 0)
    board.memory.poke(0x7A, b"\0")  # ADCSRA: off
    said = board.hear(3.0)
    assert said.rows[-1]["sensors"][0] == said.rows[-1]["sensors"][3] == "3"


def example(**changes: object) -> dict[str, Any]:
    tree: dict[str, Any] = json.loads((ROOT / "examples" / "my1016" / "coeffs.json").read_text())
    ntc = {"channel": "brush", "analog_pin": 54, **BEAD} | changes
    tree["wiring"]["thermocouples"][0] = {key: value for key, value in ntc.items() if value is not None}
    return tree


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"analog_pin": None}, r'thermocouples\[0\]: missing key "analog_pin"'),
        ({"series_ohm": None}, r'thermocouples\[0\]: missing key "series_ohm"'),
        ({"beta_K": None}, r'thermocouples\[0\]\.r25_ohm: expected "r25_ohm" and "beta_K" together'),
        ({"r25_ohm": None}, r'thermocouples\[0\]\.beta_K: expected "r25_ohm" and "beta_K" together'),
        ({"r25_ohm": None, "beta_K": None}, r'thermocouples\[0\]: expected either "r25_ohm"'),
        ({"steinhart_hart": [1e-3, 2e-4, 1e-7]}, r'thermocouples\[0\]: expected either "r25_ohm"'),
        ({"beta_K": 300}, r"thermocouples\[0\]\.beta_K: found 300, expected"),
        ({"analog_pin": 22}, r"thermocouples\[0\]\.analog_pin: pin 22 of the Mega 2560 measures"),
        ({"cs": 22}, r"thermocouples\[0\]\.cs: the chip is an NTC"),
        ({"wires": 3}, r"thermocouples\[0\]\.wires: the chip is an NTC"),
        ({"r25_ohm": 1e6, "series_ohm": 100}, r"thermocouples\[0\]\.series_ohm: found 100: a step of the converter"),
        ({"max_degC": 190}, r"thermocouples\[0\]\.max_degC: found 190, expected at most 174\.381"),
        ({"chip": "MAX6675", "cs": 22, "so": 50, "sck": 52}, r"thermocouples\[0\]\.analog_pin: .*only an NTC has it"),
        ({"series_ohm": 47000, "max_degC": None}, r"\$\.alarms\[\d\]\.limit_degC: found 120, expected at most \d"),
    ],
)
def test_what_no_thermistor_can_be_is_refused(changes: dict[str, object], message: str) -> None:
    with pytest.raises(InputError, match=message):
        parse(json.dumps(example(**changes)).encode())


def test_a_chip_still_needs_its_lines_and_no_pin_has_two_roles() -> None:
    tree = example()
    del tree["wiring"]["thermocouples"][1]["so"]
    with pytest.raises(InputError, match=r'thermocouples\[1\]: missing key "so"'):
        parse(json.dumps(tree).encode())
    tree = example()
    tree["wiring"]["channels"] = [{"column": "a_V", "analog_pin": 54}]
    with pytest.raises(InputError, match="pin 54 is already taken"):
        parse(json.dumps(tree).encode())


def test_the_drawing_and_the_table_have_both_resistors() -> None:
    files = project_files(FILE, lower(FILE, "fixed", "table"), "coeffs.json", None)
    readme = str(files["README.md"])
    table = readme[readme.index("| part |") :]
    for row in ("| NTC: brush | 1 | A1 |", "|  | 2 | GND |", "| 2200 ohm, for brush | 1 | A1 |", "|  | 2 | 5 V |"):
        assert row in table
    assert "NTC: casing" in str(files["wiring.svg"])


def test_a_commissioning_is_of_the_thermistor_s_pin() -> None:
    identities = set()
    for pin in (54, 55):
        wiring = parse(json.dumps(example(analog_pin=pin)).encode()).document.wiring
        assert wiring is not None
        identities.add(wiring_identity(wiring, "my1016"))
    assert len(identities) == 2


def test_the_round_of_a_full_board_is_within_its_conversion() -> None:
    """All of A0..A15: 8 thrown away, 55 conversions of a voltage and 17 of an NTC, 24 of the reference, 112 us each."""
    for thermistors in range(1, 17):
        conversions = 8 + 55 * (16 - thermistors) + 17 * thermistors + 24
        assert 0.112 * conversions < CONVERSION_MS["NTC"]


def test_the_emulator_says_which_pins_it_has() -> None:
    with pytest.raises(ValueError, match=r"A0\.\.A7"):
        PIN_MAPS["mega"].analog_input(62)
    with pytest.raises(ValueError, match=r"A0\.\.A5"):
        PIN_MAPS["uno"].analog_input(13)
