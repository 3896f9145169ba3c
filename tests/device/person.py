"""A motor and the person before it, who does what the board says: the other side of commissioning."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from tests.device.board import OPEN, Board, Said
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


def is_commissioned(bench: Bench) -> str:
    bench.board.send("?")
    return bench.board.hear(1.0).comments["commissioned"]
