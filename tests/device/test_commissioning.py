"""Commissioning on the emulated Mega: what a person and the board find together, and that it is kept or not."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import pytest

from gen.firmware.project import project_files
from gen.firmware.sketch.device import device_context
from gen.lowering.lower import lower
from tests.device.board import OPEN, Board, Said
from tests.device.conftest import Open
from tests.device.variants import variant

FORWARD, REVERSE = 4, 5
PARTS = ("brush", "bearing", "magnet", "casing", "ambient")
STEP_S = 0.25
PULSES_PER_S = 100.0
"""Of a motor at PWM 1: any speed that an encoder of 500 lines can tell from a standstill."""


@dataclass
class Bench:
    """The motor as it is, and the person before it, who does what the board says.

    Attributes
    ----------
    wired
        By channel: the part at which its thermocouple really is.
    reversed_leads
        Channels whose leads are exchanged: warmth reads as cold, about the room.
    encoder, turns_on, backwards
        Whether the encoder gives pulses; the motor ignores PWM 0 once it has turned; it turns the other way.
    warms
        By what the board asks for: the part that the person takes into the hand instead.
    lazy
        Lines of the board to which the person does nothing.
    events, turned
        What was said of it; the PWMs that the motor has had.
    cools
        Whether parts cool down.
    open
        A channel whose thermocouple is open.
    """

    board: Board
    wired: Mapping[str, str] = field(default_factory=dict)
    reversed_leads: tuple[str, ...] = ()
    encoder: bool = True
    turns_on: bool = False
    backwards: bool = False
    warms: Mapping[str, str] = field(default_factory=dict)
    lazy: str = "\0"
    room_degC: float = 24.0
    events: list[str] = field(default_factory=list)
    turned: list[int] = field(default_factory=list)
    cools: bool = True
    open: str = ""

    def __post_init__(self) -> None:
        self.rises = dict.fromkeys(PARTS, 0.0)
        self.hand = ""
        wiring = variant("my1016").document.wiring
        assert wiring is not None
        assert wiring.encoder is not None
        self.board.encoder.attach(wiring.encoder.pin)
        self._show()

    def wait(self, seconds: float) -> list[str]:
        """Let time pass; what was said meanwhile."""
        heard: list[str] = []
        for _ in range(round(seconds / STEP_S)):
            self._turn()
            heard += self._hear(self.board.hear(STEP_S))
        return heard

    def until(self, word: str, most_s: float = 200.0) -> str:
        """Go on until an event has a word in it."""
        for _ in range(round(most_s / STEP_S)):
            for event in self.wait(STEP_S):
                if word in event:
                    return event
        raise AssertionError(f"nobody said {word!r}: {self.events}")

    def start(self) -> None:
        self._hear(self.board.started())

    def commission(self, most_s: float = 300.0) -> str:
        """Go through all of it; how it ended."""
        self.board.send("commission")
        for _ in range(round(most_s / STEP_S)):
            for event in self.wait(STEP_S):
                if "FAILED" in event or "passed" in event or "not begun" in event:
                    return event.split(" ", 1)[1]
        raise AssertionError(f"it did not end: {self.events}")

    @property
    def pwm(self) -> int:
        return round(self.board.pins.pwm(FORWARD, REVERSE))

    def _turn(self) -> None:
        pwm = self.pwm
        if pwm and (not self.turned or self.turned[-1] != pwm):
            self.turned.append(pwm)
        pulses = PULSES_PER_S * abs(pwm if pwm or not self.turns_on or not self.turned else self.turned[-1])
        if self.encoder and pulses:
            self.board.encoder.send(round(pulses * STEP_S), STEP_S)
        for part in PARTS:  # a hand's 34 degC, and the room's air
            if part == self.hand:
                self.rises[part] += (10.0 - self.rises[part]) * 0.1
            elif self.cools:
                self.rises[part] -= 0.03 * self.rises[part]
        self._show()

    def _show(self) -> None:
        for channel in PARTS:
            rise = self.rises[self.wired.get(channel, channel)]
            self.board.set_celsius(channel, self.room_degC + (-rise if channel in self.reversed_leads else rise))
        if self.open:
            self.board.chips[self.open].set_word(OPEN)

    def _hear(self, said: Said) -> list[str]:
        events = [event for event in said.events if "commissioning" in event or "protection" in event]
        for event in events:
            if "FAILED" in event:
                self.hand = ""
            elif self.lazy not in event:
                self._obey(event.partition("commissioning: ")[2])
        self.events += events
        return events

    def _obey(self, told: str) -> None:
        if told.startswith("warm "):
            asked = told.split()[1]
            self.hand = self.warms.get(asked, asked)
        elif "let go" in told:
            self.hand = ""
        elif "`arm`" in told:
            self.board.send("arm")
        elif told.startswith("did it turn"):
            wanted = -1 if "reverse" in told else 1
            right = self.turned and self.turned[-1] * wanted * (-1 if self.backwards else 1) > 0
            self.board.send("yes" if right else "no")
        elif "`yes`" in told:
            self.board.send("yes")


Start = Callable[..., Bench]


@pytest.fixture
def bench(power_up: Open) -> Start:
    def start(name: str = "my1016", **faults: object) -> Bench:
        made = Bench(power_up(name), **faults)  # type: ignore[arg-type]
        made.start()
        return made

    return start


def is_commissioned(bench: Bench) -> str:
    bench.board.send("?")
    return bench.board.hear(1.0).comments["commissioned"]


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


def passed(power_up: Open) -> Bench:
    motor = Bench(power_up())
    motor.start()
    assert motor.commission() == "commissioning passed"
    return motor


def record() -> tuple[int, int]:
    """Address and size of what is kept."""
    context = device_context(variant("my1016"), lower(variant("my1016"), "fixed", "table"))["commissioning"]
    assert context is not None
    return context["at"], context["bytes"]


@pytest.mark.parametrize("written", [None, 0, 2, 4])
def test_a_loss_of_power_in_the_middle_or_while_it_is_kept_leaves_it_undone(
    power_up: Open, written: int | None
) -> None:
    """Five bytes make a record of a pass out of one of none: the verdict, and four of the CRC."""
    motor = Bench(power_up())
    motor.start()
    motor.board.send("commission")
    motor.until("warm magnet" if written is None else "writing")
    if written is not None:
        enough = motor.board.eeprom.counts.writes + written
        motor.board.run_until(lambda: motor.board.eeprom.counts.writes >= enough, 3.0, step_s=0.0005)
        assert motor.board.eeprom.busy == (written > 0)
    motor.board.cut_power(1.0, seed=7)
    assert motor.board.started().comments["commissioned"] == "no"


def test_any_single_bit_that_turns_in_what_is_kept_undoes_it(power_up: Open) -> None:
    motor = passed(power_up)
    contents = motor.board.eeprom.image
    at, size = record()
    for bit in range(0, 8 * size, 5):
        damaged = bytearray(contents)
        damaged[at + bit // 8] ^= 1 << bit % 8
        other = power_up()
        other.eeprom.image = bytes(damaged)
        assert other.started().comments["commissioned"] == "no"


def test_a_cell_that_does_not_hold_is_said(power_up: Open) -> None:
    motor = Bench(power_up())
    motor.start()
    at, _ = record()
    motor.board.send("commission")
    motor.until("writing")

    def written() -> bool:
        return motor.board.eeprom.image[at + 4] == 0xA5

    motor.board.run_until(written, 3.0)
    image = bytearray(motor.board.eeprom.image)
    image[at] ^= 1
    motor.board.eeprom.image = bytes(image)
    assert motor.until("FAILED", 5.0).endswith("FAILED at eeprom: the record does not hold")
    motor.wait(3.0)
    assert is_commissioned(motor) == "no"


def test_a_line_while_it_is_kept_leaves_it_undone(bench: Start) -> None:
    motor = bench()
    motor.board.send("commission")
    motor.until("writing")
    motor.board.send("stop")
    assert motor.until("FAILED", 5.0).endswith("ended by a line")
    motor.wait(3.0)
    assert is_commissioned(motor) == "no"


def test_another_wiring_is_not_commissioned_and_a_refined_model_is(power_up: Open) -> None:
    kept = passed(power_up).board.eeprom.image
    for name, said in (("watched_brush", "yes"), ("directed", "no")):
        other = power_up(name)
        other.eeprom.image = kept
        assert other.started().comments["commissioned"] == said


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
