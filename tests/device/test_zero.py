"""What the thermocouples read too much, learnt on the emulated Mega while the motor is cold."""

from __future__ import annotations

import json
import math
import statistics
import struct
from itertools import cycle, islice

import pytest

from gen.coefficients import parse
from gen.errors import InputError
from tests.device.board import OPEN, Board, Said
from tests.device.conftest import Open
from tests.device.variants import BASE, CHANNELS

#: What the thermocouples of one room read: a set with offsets, the casing's the largest.
READ = {"brush": 22.25, "bearing": 21.75, "magnet": 22.0, "casing": 23.25, "ambient": 21.5}
WINDOW_S = 60.0
WRITTEN_S = 6.0  # a byte of 18 in a sample


def cold(board: Board, read: dict[str, float] = READ) -> Said:
    for channel, celsius in read.items():
        board.set_celsius(channel, celsius)
    return board.started()


def ask(board: Board) -> Said:
    board.send("zero")
    return board.hear(WINDOW_S + 1.0)


def offsets(board: Board) -> dict[str, float]:
    """What the header says."""
    board.send("?")
    said = board.hear(1.0).comments
    return {key[5:-2]: float(value) for key, value in said.items() if key.startswith("zero_")}


def test_offsets_are_those_from_the_median_and_are_taken_off(power_up: Open) -> None:
    board = power_up("zeroed_by_command")
    before = cold(board)
    assert before.rows[-1]["casing_degC"] == "23.25"
    assert offsets(board) == {}
    said = ask(board)
    assert [event.partition(" ")[2] for event in said.events] == ["zero: 60 s", "zero learnt"]
    middle = statistics.median(READ.values())
    assert offsets(board) == {channel: READ[channel] - middle for channel in CHANNELS}
    row = board.hear(1.0).rows[-1]
    assert {row[f"{channel}_degC"] for channel in CHANNELS} == {f"{middle:.2f}"}
    # The model begins anew with them, at the room's temperature.
    assert float(row["casing_model_degC"]) == pytest.approx(middle, abs=0.002)
    # Warmer by 10 K is read as that.
    for channel, celsius in READ.items():
        board.set_celsius(channel, celsius + 0.75)
    assert board.hear(3.0).rows[-1]["casing_degC"] == f"{middle + 0.75:.2f}"


def test_the_mean_of_the_window_is_taken(power_up: Open) -> None:
    """Readings that go to and fro by a count: the mean is between, to a hundredth of a kelvin."""
    board = power_up("zeroed_by_command")
    cold(board)
    board.send("zero")
    board.hear(0.3)
    shown: dict[str, list[float]] = {channel: [] for channel in CHANNELS}
    swings = {"brush": (0, 1), "bearing": (0, 0, 1), "magnet": (0,), "casing": (0, 0, 0, 1), "ambient": (1, 0, 1)}
    for counts in islice(zip(*(cycle(swings[channel]) for channel in CHANNELS), strict=True), 240):
        for channel, count in zip(CHANNELS, counts, strict=True):
            celsius = READ[channel] + 0.25 * count
            board.set_celsius(channel, celsius)
            shown[channel].append(celsius)
        board.hear(0.25)
    means = {channel: statistics.mean(read) for channel, read in shown.items()}
    middle = statistics.median(means.values())
    found = offsets(board)
    # One reading may be the one before the window: a count of 240.
    assert found == {channel: pytest.approx(means[channel] - middle, abs=0.012) for channel in CHANNELS}


def test_they_outlive_a_loss_of_power_and_end_by_command(power_up: Open) -> None:
    board = power_up("zeroed_by_command")
    cold(board)
    ask(board)
    learnt = offsets(board)
    board.hear(WRITTEN_S)
    board.cut_power(1.0)
    again = board.started()
    assert {key[5:-2]: float(value) for key, value in again.comments.items() if key.startswith("zero_")} == learnt
    assert again.rows[-1]["casing_degC"] == "22.00"
    board.send("zero off")
    assert [event.partition(" ")[2] for event in board.hear(1.0).events] == ["zero: none"]
    assert board.hear(WRITTEN_S).rows[-1]["casing_degC"] == "23.25"
    board.cut_power(1.0)
    assert board.started().rows[-1]["casing_degC"] == "23.25"


@pytest.mark.parametrize(
    ("casing_degC", "said"),
    [
        (23.75, "zero refused: casing reads beside the others by 1.75 K"),
        (20.0, "zero refused: casing reads beside the others by -1.75 K"),
    ],
)
def test_what_is_no_offset_is_told_and_nothing_is_learnt(power_up: Open, casing_degC: float, said: str) -> None:
    board = power_up("zeroed_by_command")
    cold(board, READ | {"casing": casing_degC})
    assert ask(board).events[-1].endswith(said)
    assert offsets(board) == {}


def test_a_sensor_that_is_not_believed_is_told(power_up: Open) -> None:
    board = power_up("zeroed_by_command")
    cold(board)
    board.chips["magnet"].set_word(OPEN)
    board.hear(1.0)
    assert ask(board).events[-1].endswith("zero refused: magnet is not believed")
    board.set_celsius("magnet", READ["magnet"])
    board.hear(3.0)
    assert ask(board).events[-1].endswith("zero learnt")


def test_what_moves_is_told(power_up: Open) -> None:
    board = power_up("zeroed_by_command")
    cold(board)
    board.send("zero")
    board.hear(WINDOW_S / 2)
    board.set_celsius("bearing", READ["bearing"] + 0.75)
    assert board.hear(WINDOW_S / 2 + 1).events[-1].endswith("zero refused: bearing is not steady")
    assert offsets(board) == {}


def test_a_motor_that_is_driven_or_was_is_not_cold(power_up: Open) -> None:
    board = power_up("zeroed_by_command")
    cold(board)
    board.send("zero")
    board.hear(5.0)
    board.drive(200)
    assert board.hear(2.0).events[-1].endswith("zero refused: the motor is driven")
    board.hear(120.0)
    board.send("zero off")
    assert board.hear(1.0).events[-1].endswith("zero refused: the motor is driven")
    board.send("0")
    board.hear(1.0)
    refused = ask(board).events[-1]
    assert "zero refused: by the model a part is off the room by " in refused
    assert offsets(board) == {}


def test_a_record_with_any_bit_turned_is_none(power_up: Open) -> None:
    board = power_up("zeroed_by_command")
    cold(board)
    ask(board)
    board.hear(WRITTEN_S)
    image = bytearray(board.eeprom.image)
    (at,) = [i for i in range(4096) if image[i : i + 10] == record_of(READ)]
    for place in (0, 5, 13, 17):
        damaged = bytearray(image)
        damaged[at - 4 + place] ^= 0x10
        board.eeprom.image = bytes(damaged)
        board.cut_power(1.0)
        assert board.started().rows[-1]["casing_degC"] == "23.25"
    board.eeprom.image = bytes(image)
    board.cut_power(1.0)
    assert board.started().rows[-1]["casing_degC"] == "22.00"


def record_of(read: dict[str, float]) -> bytes:
    middle = statistics.median(read.values())
    return struct.pack("<5h", *(round(1000 * (read[channel] - middle)) for channel in CHANNELS))


def test_by_itself_it_is_learnt_once_the_model_is_cold(power_up: Open) -> None:
    """The model begins where the thermocouples are, 1.75 K at most, and is within 0.1 K of the room 60 s later."""
    board = power_up("zeroed")
    cold(board)
    said = board.hear(140.0)
    (learnt,) = [event for event in said.events if event.endswith("zero learnt")]
    near_s = math.log((READ["casing"] - READ["ambient"]) / 0.1) / 0.05
    assert float(learnt.split()[0]) == pytest.approx(near_s + WINDOW_S, abs=2.0)
    assert offsets(board)["casing"] == 1.25
    assert "zero learnt" not in " ".join(board.hear(150.0).events)  # once is enough
    # Driven and cooled down again: what has moved since is learnt anew.
    board.drive(200)
    board.hear(5.0)
    board.send("0")
    board.set_celsius("brush", READ["brush"] + 0.5)
    assert [event.endswith("zero learnt") for event in board.hear(200.0).events].count(True) == 1
    assert offsets(board)["brush"] == 0.75


def test_what_is_latched_stays_and_the_offset_raises_it_no_more(power_up: Open) -> None:
    board = power_up("zeroed")
    cold(board)
    events = [event.partition(" ")[2] for event in board.hear(140.0).events]
    assert events == ["alarm off", "zero learnt"]
    assert board.hear(1.0).rows[-1]["alarms"] == "1"
    board.send("reset")
    said = " ".join(board.hear(30.0).events)
    assert "alarms reset" in said
    assert "alarm off" not in said


def tree_with(**wiring: object) -> bytes:
    return json.dumps(BASE | {"wiring": BASE["wiring"] | wiring}).encode()


@pytest.mark.parametrize(
    ("wiring", "said"),
    [
        ({"zero": {}, "memory": None}, r'\$\.wiring\.zero: found it without "memory"'),
        ({"zero": {}, "thermocouples": BASE["wiring"]["thermocouples"][:4]}, "without a thermocouple at the ambient"),
        ({"zero": {}, "thermocouples": BASE["wiring"]["thermocouples"][4:]}, "without a thermocouple at a part"),
        ({"zero": {"tolerance_K": 11}}, r"\$\.wiring\.zero\.tolerance_K"),
        ({"zero": {"tolerance_K": 0}}, r"\$\.wiring\.zero\.tolerance_K"),
    ],
)
def test_a_wiring_that_cannot_learn_is_refused(wiring: dict[str, object], said: str) -> None:
    with pytest.raises(InputError, match=said):
        parse(tree_with(**wiring))
