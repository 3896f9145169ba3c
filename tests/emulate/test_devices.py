"""What the firmware sees at its pins is what the world puts there, and the other way round."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gen.emulate.wiring.devices import DeviceBoard, ResetCause

from .conftest import OpenBoard

STUDY = ((29, 35, 31), (33, 35, 31), (39, 45, 41), (43, 45, 41), (49, 47, 51))
"""CS, SO and SCK of the study's rig: SO and SCK shared by two."""
ODD = ((54, 14, 3), (69, 15, 12), (24, 53, 46))
CYCLE_S = 0.25
SECOND = 16_000_000


class Asked:
    """The firmware devices.cpp, with its chips, ready for commands."""

    def __init__(self, open_board: OpenBoard, chips: Sequence[tuple[int, int, int]], *, edge: str = "RISING") -> None:
        table = ",".join(f"{{{cs},{so},{sck}}}" for cs, so, sck in chips)
        self.mega = open_board("devices.cpp", f"CHIPS={table}", f"EDGE={edge}")
        self.chips = [self.mega.add_max6675(*chip) for chip in chips]

    def start(self) -> DeviceBoard:
        self.mega.run_until_bytes(b"ready\r\n", SECOND)
        return self.mega

    def ask(self, command: str) -> str:
        self.mega.uart.send(command.encode())
        return self.mega.run_until_bytes(b"\n", SECOND).decode().strip()

    def words(self) -> list[int]:
        return [int(word, 16) for word in self.ask("r").split()]


@pytest.fixture(scope="module")
def study(open_board: OpenBoard) -> Asked:
    asked = Asked(open_board, STUDY)
    asked.start()
    return asked


@settings(max_examples=40, deadline=None, derandomize=True)
@given(words=st.lists(st.integers(0, 0xFFFF), min_size=5, max_size=5))
def test_every_word_is_read_over_shared_lines(study: Asked, words: list[int]) -> None:
    for chip, word in zip(study.chips, words, strict=True):
        chip.set_word(word)
    study.mega.run_seconds(0.45)  # a conversion that began before the change, and one after it
    assert study.words() == words
    assert all(chip.counts.clashes == 0 for chip in study.chips)


def test_words_are_read_on_other_ports_too(open_board: OpenBoard) -> None:
    asked = Asked(open_board, ODD)
    asked.start()
    for chip, word in zip(asked.chips, (0x0001, 0x8000, 0x5AA5), strict=True):
        chip.set_word(word)
    asked.mega.run_seconds(0.45)
    assert asked.words() == [0x0001, 0x8000, 0x5AA5]


def test_a_read_before_the_conversion_is_finished_gives_the_old_word(open_board: OpenBoard) -> None:
    asked = Asked(open_board, STUDY[:1])
    mega = asked.start()
    (chip,) = asked.chips
    assert asked.words() == [0]  # nothing converted yet since power-on
    chip.set_word(0x0320)
    mega.run_seconds(0.3)
    assert asked.words() == [0x0320]
    chip.set_word(0x0640)
    early = chip.counts.early
    mega.run_seconds(0.15)
    assert asked.words() == [0x0320]  # and this read has stopped the conversion
    mega.run_seconds(0.15)
    assert asked.words() == [0x0320]
    mega.run_seconds(0.23)
    assert asked.words() == [0x0640]
    assert chip.counts.early == early + 2


def test_two_selected_chips_on_one_line_are_noticed(open_board: OpenBoard) -> None:
    asked = Asked(open_board, STUDY[:2])
    mega = asked.start()
    mega.pins.drive(33, False)  # a short that keeps the second chip selected
    mega.run_seconds(0.3)
    asked.words()
    assert asked.chips[0].counts.clashes == 1


def test_a_max31855_gives_the_upper_half_of_its_word_to_who_reads_16_bits(open_board: OpenBoard) -> None:
    """60 degC, its own temperature 25 degC: bits 14..3 of the upper half are 30 degC, as people have seen."""
    mega = open_board("devices.cpp", "CHIPS={29,35,31}", "EDGE=RISING")
    chip = mega.add_chip("MAX31855", 29, 35, 31)
    chip.set_word(240 << 18 | 400 << 4)
    mega.run_until_bytes(b"ready\r\n", SECOND)
    mega.run_seconds(0.3)
    mega.uart.send(b"r")
    word = int(mega.run_until_bytes(b"\n", SECOND).decode().strip(), 16)
    assert (word >> 3 & 0xFFF) * 0.25 == 30.0


@pytest.mark.parametrize("batch_s", [0.0, 0.001, 0.02])
@pytest.mark.parametrize("edge", ["RISING", "FALLING", "CHANGE"])
def test_every_pulse_is_counted(open_board: OpenBoard, batch_s: float, edge: str) -> None:
    asked = Asked(open_board, STUDY, edge=edge)
    mega = asked.mega
    mega.encoder.attach(2, batch_s=batch_s)
    asked.start()
    sent = 0
    for count in (0, 1, 5521, 777, 0, 5520):
        mega.encoder.send(count, CYCLE_S)
        mega.run_seconds(CYCLE_S)
        sent += count
        assert mega.encoder.sent == sent
    counted = int(asked.ask("p").split()[0])
    assert counted == sent * (2 if edge == "CHANGE" else 1)


@pytest.mark.parametrize("edge", ["RISING", "FALLING", "CHANGE"])
def test_true_pulses_come_evenly(open_board: OpenBoard, edge: str) -> None:
    asked = Asked(open_board, STUDY, edge=edge)
    asked.mega.encoder.attach(2)
    asked.start()
    probe = asked.mega.pins.watch(2)
    asked.mega.encoder.send(1000, CYCLE_S)
    asked.mega.run_seconds(CYCLE_S)
    edges = probe.edges()
    for level in (True, False):
        times = edges.seconds[edges.levels == level]
        assert np.diff(times) == pytest.approx(CYCLE_S / 1000, rel=0.02)
        assert len(times) in (999, 1000, 1001)


def test_batched_pulses_come_in_step_with_the_true_ones(open_board: OpenBoard) -> None:
    asked = Asked(open_board, STUDY)
    asked.mega.encoder.attach(2, batch_s=0.001)
    asked.start()
    probe = asked.mega.pins.watch(2)
    asked.mega.encoder.send(5000, CYCLE_S)
    for tenth in range(1, 10):
        asked.mega.run_seconds(CYCLE_S / 10)
        assert asked.mega.encoder.sent == pytest.approx(500 * tenth, abs=20)  # a batch has 20
    assert probe.edges().seconds.size == 0  # the pin rests, which spares the emulator its work


def test_the_counter_of_pin_47_counts_every_pulse(open_board: OpenBoard) -> None:
    asked = Asked(open_board, STUDY)
    asked.mega.encoder.attach(47)
    asked.start()
    sent = 0
    for count in (3, 5521, 60_001 // 3, 0, 40_000):
        asked.mega.encoder.send(count, CYCLE_S)
        asked.mega.run_seconds(CYCLE_S)
        sent += count
        asked.mega.encoder.send(0, CYCLE_S)
        assert int(asked.ask("p").split()[1]) == sent % 65536
    asked.mega.encoder.send(10_000, 1.0)
    start = int(asked.ask("p").split()[1])
    asked.mega.run_seconds(0.5)
    assert (int(asked.ask("p").split()[1]) - start) % 65536 == pytest.approx(5000, abs=60)


def test_pwm_is_read_back_from_timers_and_levels(open_board: OpenBoard) -> None:
    asked = Asked(open_board, STUDY)
    mega = asked.start()
    assert mega.pins.pwm(4, 5) == 0
    mega.uart.send(b"d")
    mega.run_seconds(0.01)
    # analogWrite's own words: 8 bits; 0 and 255 are plain levels. Timer 0 is in fast mode: (OCR + 1) / 256.
    assert mega.pins.duty(4) == pytest.approx(78 / 256)
    assert mega.pins.duty(5) == pytest.approx(200 / 255)
    assert (mega.pins.duty(6), mega.pins.duty(7)) == (1.0, 0.0)
    assert mega.pins.pwm(9, 7) == 128
    assert mega.pins.pwm(7, 5) == -200


def test_a_pressed_button_stays_pressed_while_the_port_is_written(open_board: OpenBoard) -> None:
    asked = Asked(open_board, STUDY)
    mega = asked.start()
    assert asked.ask("b") == "1"
    mega.pins.drive(22, False)
    assert asked.ask("b") == "0"
    mega.pins.drive(22, None)
    assert asked.ask("b") == "1"


def test_the_probe_sees_the_led(open_board: OpenBoard) -> None:
    asked = Asked(open_board, STUDY)
    mega = asked.start()
    probe = mega.pins.watch(13)
    mega.uart.send(b"l")
    mega.run_seconds(0.05)
    edges = probe.edges()
    assert edges.levels.tolist() == [True, False]
    assert edges.seconds[1] - edges.seconds[0] == pytest.approx(0.020, abs=0.0011)


def test_no_byte_of_the_serial_line_is_lost(open_board: OpenBoard) -> None:
    asked = Asked(open_board, STUDY)
    asked.start()
    asked.mega.uart.send(b"a")
    asked.mega.run_seconds(1.0)
    assert asked.mega.uart.take().decode().split() == [str(i) for i in range(500)]


def test_an_eeprom_write_takes_its_time(open_board: OpenBoard) -> None:
    asked = Asked(open_board, STUDY)
    mega = asked.start()
    assert asked.ask("wA") == "busy"
    begun = mega.seconds
    while mega.eeprom.busy:
        mega.run_cycles(1600)
    assert mega.seconds - begun == pytest.approx(0.0034, abs=0.0004)
    assert asked.ask("e") == str(ord("A"))
    assert asked.mega.eeprom.counts.writes == 1
    image = mega.eeprom.image
    assert (len(image), image[17]) == (4096, ord("A"))


def test_a_byte_whose_write_lost_its_power_is_neither_old_nor_new(open_board: OpenBoard) -> None:
    asked = Asked(open_board, STUDY)
    mega = asked.start()
    seen: set[int] = set()
    for seed in range(1, 9):
        image = bytearray(mega.eeprom.image)
        image[16:19] = b"\x11\x5a\x22"
        mega.eeprom.image = bytes(image)
        mega.uart.send(b"w\xa5")
        mega.run_cycles(1)
        while not mega.eeprom.busy:
            mega.run_cycles(160)
        mega.run_seconds(0.001)
        mega.cut_power(0.5, seed=seed)
        assert not mega.eeprom.busy
        asked.start()
        left = mega.eeprom.image
        assert left[16] == 0x11 and left[18] == 0x22
        assert left[17] & 0x5A == 0x5A  # erasing only sets bits
        seen.add(left[17])
    assert len(seen) > 1
    mega.uart.send(b"wB")
    mega.run_seconds(0.1)
    assert mega.eeprom.image[17] == ord("B")  # once the power stays on


def test_a_reset_without_loss_of_power_finishes_the_write(open_board: OpenBoard) -> None:
    asked = Asked(open_board, STUDY)
    mega = asked.start()
    assert asked.ask("wC") == "busy"
    mega.press_reset()
    assert mega.eeprom.busy
    mega.run_until_bytes(b"ready\r\n", SECOND)
    assert asked.ask("e") == str(ord("C"))


def test_the_cause_of_a_reset_and_what_the_ram_keeps(open_board: OpenBoard) -> None:
    asked = Asked(open_board, STUDY)
    mega = asked.start()
    assert asked.ask("u").split()[0] == str(int(ResetCause.POWER_ON))
    mega.press_reset()
    asked.start()
    assert asked.ask("u") == f"{int(ResetCause.EXTERNAL)} 12345"
    mega.uart.send(b"z")
    asked.start()
    assert asked.ask("u") == f"{int(ResetCause.WATCHDOG)} 12345"
    before = mega.seconds
    mega.cut_power(10.0, cause=ResetCause.BROWN_OUT)
    assert mega.seconds == pytest.approx(before + 10.0)
    asked.start()
    cause, kept = asked.ask("u").split()
    assert cause == str(int(ResetCause.BROWN_OUT))
    assert kept != "12345"


def test_a_driven_level_outlives_a_reset(open_board: OpenBoard) -> None:
    asked = Asked(open_board, STUDY)
    mega = asked.start()
    mega.pins.drive(22, False)
    mega.press_reset()
    asked.start()
    assert asked.ask("b") == "0"
    mega.pins.drive(22, None)
    mega.press_reset()
    asked.start()
    assert asked.ask("b") == "1"  # the pull-up, which the firmware sets anew


def test_the_clock_can_start_just_before_it_rolls_over(open_board: OpenBoard) -> None:
    asked = Asked(open_board, STUDY)
    asked.mega.start_clock_at(2**32 - 500)
    asked.start()
    assert 2**32 - 500 <= int(asked.ask("m")) < 2**32
    asked.mega.run_seconds(1.0)
    assert 400 <= int(asked.ask("m")) <= 700


def test_a_loop_that_is_held_up_finds_the_clock_ahead(open_board: OpenBoard) -> None:
    asked = Asked(open_board, STUDY)
    mega = asked.start()
    before = int(asked.ask("m"))
    mega.hold_up(400)
    assert 400 <= int(asked.ask("m")) - before <= 410


def test_a_loop_may_be_held_up_while_the_clock_rolls_over(open_board: OpenBoard) -> None:
    asked = Asked(open_board, STUDY)
    asked.mega.start_clock_at(2**32 - 500)
    asked.start().hold_up(1000)
    assert 400 <= int(asked.ask("m")) <= 700


def test_another_controllers_pwm_is_on_its_pin(open_board: OpenBoard) -> None:
    asked = Asked(open_board, STUDY)
    mega = asked.start()
    probe = mega.pins.watch(18)
    mega.pins.drive_wave(18, 0.25, frequency_hz=1000.0)
    mega.run_seconds(0.1)
    edges = probe.edges()
    times, levels = edges.seconds, edges.levels
    high = sum(b - a for a, b, level in zip(times, times[1:], levels, strict=False) if level)
    assert high / (times[-1] - times[0]) == pytest.approx(0.25, abs=0.01)
    assert len(times) == pytest.approx(200, abs=3)
