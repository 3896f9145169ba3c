"""What goes to the board, and when it may: the only place that knows the words of the sketch's serial line."""

from __future__ import annotations

import re
import time
from collections.abc import Callable

from gen.errors import InputError

ARMED_S = 300.0
"""So long after the last command nothing goes to the board any more, s."""
FULL_PWM = 255
_LONGEST = 60
_WORDS = re.compile(
    r"(?P<drives>-?\d{1,3}|profile on)|\?|arm|reset|test|rows \d{1,5}|profile off|commission|zero( off)?|yes|no|"
    r"accept \w{1,40}",
    re.ASCII,
)
"""What the sketch understands (templates/project/src/commands.cpp.j2), and of it what has to be armed there, too."""


class NotArmedError(Exception):
    """A command came while nobody had armed the page."""


class Commands:
    """Lets commands through while somebody has armed them.

    Parameters
    ----------
    send
        Gives bytes to the board.
    clock
        Seconds.
    """

    def __init__(self, send: Callable[[bytes], None], clock: Callable[[], float] = time.monotonic) -> None:
        self._send, self._clock = send, clock
        self._until: float | None = None

    @property
    def armed_s(self) -> float:
        """For how long commands still go to the board, s; 0: they do not."""
        return 0.0 if self._until is None else max(0.0, self._until - self._clock())

    def arm(self, armed: bool) -> None:
        """Let commands through, or none any more."""
        self._until = self._clock() + ARMED_S if armed else None

    def pwm(self, count: int) -> None:
        """Command a PWM, -255..255.

        Raises
        ------
        InputError
            For another number.
        NotArmedError
            While commands are not let through.
        """
        if abs(count) > FULL_PWM:
            raise InputError(f"found PWM {count}, expected -{FULL_PWM}..{FULL_PWM}")
        self.line(str(count))

    def line(self, text: str) -> None:
        """Give one line to the board.

        Raises
        ------
        InputError
            For what the sketch does not understand.
        NotArmedError
            While commands are not let through.
        """
        text = text.strip()
        known = _WORDS.fullmatch(text) if len(text) <= _LONGEST else None
        if known is None:
            raise InputError(
                f"found {text[:_LONGEST]!r}, expected a PWM, arm, ?, reset, accept CHANNEL, test, commission, yes, no, "
                "zero, zero off, rows N, profile on or profile off"
            )
        if not self.armed_s:
            raise NotArmedError
        self.arm(True)
        armed = b"arm\n" if known["drives"] and text not in ("0", "-0") else b""  # somebody has armed this page for it
        self._send(armed + text.encode("ascii") + b"\n")
