"""Commissioning on the emulated Mega: what a person and the board find together."""

from __future__ import annotations

import pytest

from gen.firmware.project import project_files
from gen.lowering.lower import lower
from tests.device.conftest import Open
from tests.device.person import PARTS, Bench, Start, is_commissioned
from tests.device.variants import variant


def test_a_motor_that_is_wired_rightly_passes_within_two_minutes_and_it_is_kept(bench: Start) -> None:
    motor = bench()
    assert is_commissioned(motor) == "no"
    assert motor.commission(120.0) == "commissioning passed"
    asked = [event.split("warm ")[1].split()[0] for event in motor.events if "warm " in event]
    assert asked == list(PARTS)
    assert motor.turned == [52, -51]  # Timer 0 keeps its pin high for a count more
    assert motor.pwm == 0
    assert is_commissioned(motor) == "yes"
    for _ in range(2):
        motor.board.press_reset()
        assert motor.board.started().comments["commissioned"] == "yes"
    motor.board.cut_power(1.0, seed=6)
    assert motor.board.started().comments["commissioned"] == "yes"


@pytest.mark.parametrize(
    ("faults", "words"),
    [
        ({"wired": {"brush": "bearing", "bearing": "brush"}}, "brush: bearing warmed, not brush"),
        ({"wired": {"magnet": "ambient", "ambient": "magnet"}}, "magnet: ambient warmed, not magnet"),
        ({"warms": {"casing": "brush"}}, "casing: brush warmed, not casing"),
        ({"reversed_leads": ("brush",)}, "brush: brush got colder: leads exchanged"),
        ({"reversed_leads": ("ambient",)}, "ambient: ambient got colder: leads exchanged"),
        (
            {"wired": {"brush": "casing", "casing": "brush"}, "reversed_leads": ("casing",)},
            "brush: casing got colder: leads exchanged, and not brush",
        ),
        ({"warms": {"bearing": "nothing"}}, "bearing: nothing for 120 s"),
        ({"encoder": False}, "forward: no pulse of the encoder"),
        ({"turns_on": True}, "forward: 6"),
        ({"backwards": True}, "forward: the answer is no"),
        ({"lazy": "`arm`"}, "forward: nothing for 120 s"),
    ],
)
def test_what_is_wired_wrongly_is_named(bench: Start, faults: dict[str, object], words: str) -> None:
    motor = bench(**faults)
    said = motor.commission()
    assert said.startswith(f"commissioning FAILED at {words}")
    assert not motor.turns_on or said.endswith("rpm 10 s after PWM 0: it does not stop")
    motor.wait(2.0)
    assert motor.pwm == 0
    assert not any("protection" in event for event in motor.events)
    assert is_commissioned(motor) == "no"
    motor.board.send("100")  # and nothing is left armed
    motor.wait(1.0)
    assert motor.pwm == 0


@pytest.mark.parametrize(
    ("degC", "words"),
    [
        ({"casing": 29.0}, "cold: casing is 5.00 K warmer than another: let it cool"),
        ({"ambient": 19.0}, "cold: brush is 5.00 K warmer than another: let it cool"),
    ],
)
def test_a_warm_motor_has_to_cool_first(bench: Start, degC: dict[str, float], words: str) -> None:
    motor = bench()
    for channel, celsius in degC.items():
        motor.rises[channel] = celsius - motor.room_degC
    motor.cools = False
    motor.wait(4.0)
    for channel in degC:
        motor.board.send(f"accept {channel}")
    motor.wait(4.0)
    assert motor.commission() == f"commissioning FAILED at {words}"


def test_a_thermocouple_that_still_cools_from_a_hand_is_waited_for(bench: Start) -> None:
    motor = bench()
    motor.hand = "magnet"
    motor.wait(1.0)
    motor.hand = ""
    assert motor.commission() == "commissioning FAILED at cold: magnet moves: let it cool"


def test_a_thermocouple_that_comes_off_in_the_middle_is_named(bench: Start) -> None:
    motor = bench(lazy="warm bearing")
    motor.board.send("commission")
    motor.until("warm bearing")
    motor.open = "casing"
    assert motor.until("FAILED", 5.0).endswith("FAILED at bearing: casing is not believed")


def test_a_motor_that_is_driven_is_not_commissioned_and_runs_on(bench: Start) -> None:
    motor = bench()
    motor.board.drive(100)
    motor.wait(2.0)
    assert motor.commission() == "commissioning: not begun, the motor is driven"
    motor.wait(1.0)
    assert motor.pwm == 101  # Timer 0


@pytest.mark.parametrize("line", ["200", "0", "stop", "no", "commission", "profile on"])
@pytest.mark.parametrize("place", ["warm bearing", "forward, pwm"])
def test_any_other_line_ends_it_and_stops_the_motor(bench: Start, line: str, place: str) -> None:
    motor = bench("profile", lazy="warm bearing" if "warm" in place else "\0")
    motor.board.send("commission")
    motor.until(place)
    motor.wait(1.0)
    assert (motor.pwm != 0) == ("pwm" in place)
    motor.board.send(line)
    assert "ended by a line" in motor.until("FAILED", 1.0)
    motor.wait(1.0)
    assert motor.pwm == 0
    motor.board.send("50")
    motor.wait(1.0)
    assert motor.pwm == 0
    assert is_commissioned(motor) == "no"


@pytest.mark.parametrize("line", ["yes", "no"])
def test_an_answer_to_nothing_is_no_command(bench: Start, line: str) -> None:
    motor = bench()
    motor.board.send(line)
    assert any("rejected lines: 1" in event for event in motor.board.hear(1.0).events)


def test_lines_that_only_ask_do_not_end_it_and_early_answers_are_none(bench: Start) -> None:
    motor = bench()
    motor.board.send("commission")
    for place, lines in (("warm bearing", ("?", "rows 8", "yes")), ("forward, pwm", ("yes", "?")), ("stop", ("yes",))):
        motor.until(place)
        for line in lines:
            motor.board.send(line)
    assert "passed" in motor.until("passed")


def test_an_alarm_in_the_middle_ends_it(power_up: Open) -> None:
    motor = Bench(power_up("often_copied", test_alarms=True))
    motor.start()
    motor.board.send("commission")
    motor.until("forward, pwm")
    motor.wait(2.0)
    motor.board.write("test_alarms", 1)
    assert motor.until("FAILED", 1.0).endswith("FAILED at forward: alarm")
    motor.wait(0.5)
    assert motor.pwm == 0
    assert motor.commission() == "commissioning FAILED at cold: alarm"


def test_a_reset_in_the_middle_ends_it_and_the_motor_stands(bench: Start) -> None:
    motor = bench()
    motor.commission()
    motor.board.send("commission")
    motor.until("forward, pwm")
    motor.wait(2.0)
    assert motor.pwm != 0
    motor.board.press_reset()
    said = motor.board.started()
    assert said.comments["commissioned"] == "no", "it was begun anew"
    assert any(event.endswith("start from RAM") for event in said.events)
    motor.events.clear()
    motor.wait(20.0)
    assert motor.pwm == 0
    assert motor.events == []


def test_where_the_file_asks_for_it_nothing_but_the_dialogue_drives_before_it_was_passed(power_up: Open) -> None:
    motor = Bench(power_up("locked"))
    motor.start()
    relay = 12

    def may_be_driven() -> bool:
        motor.board.drive(100)
        motor.wait(1.5)  # less than the line may be silent
        return motor.pwm != 0

    assert not may_be_driven()
    assert not motor.board.pins.level(relay)
    motor.board.send("commission")
    motor.until("warm magnet")
    assert not may_be_driven()  # and that has ended it
    motor.wait(60.0)
    motor.board.send("commission")
    motor.until("forward, pwm")
    motor.wait(3.0)
    assert motor.pwm in (51, 52)
    assert motor.board.pins.level(relay)
    assert not may_be_driven()
    assert not motor.board.pins.level(relay)
    motor.wait(60.0)
    motor.turned.clear()
    assert motor.commission() == "commissioning passed"
    assert [pwm > 0 for pwm in motor.turned if abs(pwm) > 50] == [True, False]
    motor.wait(1.0)
    assert may_be_driven()
    assert motor.board.pins.level(relay)


def test_without_an_encoder_the_person_says_whether_it_stands(power_up: Open) -> None:
    motor = Bench(power_up("every_chip"))
    motor.start()
    assert motor.commission() == "commissioning passed"
    assert any("did it turn forward, and does it stand?" in event for event in motor.events)


def test_where_another_controller_drives_it_is_about_the_thermocouples(power_up: Open) -> None:
    motor = Bench(power_up("watched"))
    motor.start()
    assert motor.commission() == "commissioning passed"
    assert not any("forward" in event for event in motor.events)
    motor = Bench(power_up("watched"), wired={"brush": "magnet", "magnet": "brush"})
    motor.start()
    assert motor.commission() == "commissioning FAILED at brush: magnet warmed, not brush"


@pytest.mark.parametrize("name", ["observed", "ambient_only", "no_wiring"])
def test_a_board_that_keeps_nothing_or_measures_no_part_has_none_of_it(name: str) -> None:
    coefficients = variant(name)
    files = project_files(coefficients, lower(coefficients, "fixed", "table"), "coeffs.json", None)
    assert not any("commission" in text for path, text in files.items() if path.startswith("src/"))
