"""Commands go to the board while somebody has armed them, and only what the sketch understands."""

from __future__ import annotations

import re

import pytest

from gen.errors import InputError
from gen.live.commands import ARMED_S, Commands, NotArmedError
from tests.examples import ROOT


class Clock:
    now = 0.0

    def __call__(self) -> float:
        return self.now


def test_nothing_is_sent_before_arming_and_after_it_lapsed() -> None:
    sent: list[bytes] = []
    clock = Clock()
    commands = Commands(sent.append, clock)
    with pytest.raises(NotArmedError):
        commands.pwm(100)
    commands.arm(True)
    commands.pwm(100)
    clock.now = ARMED_S - 1.0
    commands.line(" rows 40 ")  # and is armed anew
    clock.now += ARMED_S - 1.0
    commands.pwm(-255)
    clock.now += ARMED_S
    with pytest.raises(NotArmedError):
        commands.pwm(0)
    commands.arm(True)
    commands.arm(False)
    with pytest.raises(NotArmedError):
        commands.line("?")
    assert sent == [b"arm\n100\n", b"rows 40\n", b"arm\n-255\n"]


@pytest.mark.parametrize(
    "text",
    [
        "",
        "format",
        "reset\nrows 1",
        "reset\x00",
        "rows",
        "rows 1 2",
        "1e3",
        "90000",
        "accept",
        "accept " + "x" * 80,
        "\u0661",
    ],
)
def test_other_lines_are_refused(text: str) -> None:
    sent: list[bytes] = []
    commands = Commands(sent.append)
    commands.arm(True)
    with pytest.raises(InputError, match="expected a PWM"):
        commands.line(text)
    assert sent == []


def test_a_pwm_beyond_the_scale_is_refused() -> None:
    commands = Commands(lambda _: None)
    commands.arm(True)
    with pytest.raises(InputError, match=r"found PWM 256, expected -255..255"):
        commands.pwm(256)


def test_every_word_of_the_sketch_is_let_through() -> None:
    """As the sketch's own help line lists them."""
    console = (ROOT / "templates/project/src/console.cpp.j2").read_text(encoding="utf-8")
    listed = re.search(r'F\(" commands: (.*)"\)\)', console)
    assert listed is not None
    words = re.sub(r"\{%.*?%\}", "", listed[1]).split("(PWM), ")[1].split(", ")
    sent: list[bytes] = []
    commands = Commands(sent.append)
    commands.arm(True)
    words += ["yes", "no"]  # what a commissioning asks for
    for word in words:
        commands.line(word.replace("N", "4"))
    given = [line.decode().strip().removeprefix("arm\n") for line in sent]
    assert given == [word.replace("N", "4") for word in words]
