"""Running a board in time: profile, button, resets, losses of power, and what its serial line says."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from typing import Literal, Protocol

from gen.emulate.board import Board
from gen.emulate.plants.plant import STEP_S
from gen.emulate.wiring.devices import ResetCause
from gen.record import Recorder
from gen.record.profile import Profile

EventKind = Literal["press", "release", "reset", "power_cut", "brown_out", "send", "flood", "command", "held_up"]

_FLOOD = b"\xa5no command at all, only noise on the line\n"
_SLOWEST_PACE = 1e-3
_NAP_S = 0.1  # so soon an interruption is seen


@dataclass(frozen=True)
class Event:
    """Something that happens to the board.

    Parameters
    ----------
    time_s
        When, s.
    kind
        ``press`` and ``release`` of the button; ``reset`` by the board's own button; ``power_cut`` and ``brown_out``,
        for `duration_s`; ``send``: `data` on the serial line; ``flood``: noise on it without a pause for `duration_s`;
        ``command``: PWM `pwm`; ``held_up``: the firmware's loop for `duration_s`, by its own clock.
    duration_s, data, pwm
        See `kind`.
    """

    time_s: float
    kind: EventKind
    duration_s: float = 0.0
    data: bytes = b""
    pwm: int = 0


@dataclass
class Session:
    """What a run gives.

    Attributes
    ----------
    recorder
        The serial line's output as a run file.
    sent
        The same, byte for byte.
    time_zero_s
        Simulated time, since power-on, at which the board's time 0 lies, s: it checks itself and waits for its sensors
        before. Known to some hundredths, from when its first row came; None without a row.
    restarts_s
        When the firmware started again, s, simulated time.
    seconds
        Simulated time.
    wall_s
        Time that it took here.
    interrupted
        Whether it ended before its time.
    """

    recorder: Recorder = field(default_factory=Recorder)
    sent: bytearray = field(default_factory=bytearray)
    time_zero_s: float | None = None
    restarts_s: list[float] = field(default_factory=list)
    seconds: float = 0.0
    wall_s: float = 0.0
    interrupted: bool = False


def run_session(
    board: Board,
    duration_s: float,
    *,
    profile: Profile = (),
    events: Iterable[Event] = (),
    terminal: Line | None = None,
    pace: float | None = None,
    progress: Callable[[Session], None] = lambda _: None,
    interrupted: Callable[[], bool] = lambda: False,
) -> Session:
    """Run a board for a time.

    The plant runs in steps of `STEP_S`: the PWM at a step's beginning acts through it, its pulses come through it, and
    the converters see its temperatures from its end on. Events come at their own time.

    Parameters
    ----------
    board
        The board, not yet started.
    duration_s
        Simulated time, s.
    profile
        PWM to command. A command waits until the firmware has printed its header; after a restart of the firmware the
        present one is given again, as a computer that drives the board would do it.
    events
        What happens to the board, in any order.
    terminal
        Where the serial line goes as well, and comes from.
    pace
        Simulated seconds in a second here; None: as fast as it goes. Only the watching changes: firmware and plant are
        the same at every pace.
    progress
        Called after every step.
    interrupted
        Asked before every step; True ends the run with what came until then.

    Raises
    ------
    EmulationFailed
        When the firmware crashed or ended.
    """
    session = Session()
    runner = _Runner(board, session, profile, terminal, interrupted)
    waiting = sorted(events, key=lambda event: event.time_s)
    begin = time.monotonic()
    while board.steps_end_s < duration_s - STEP_S / 2:
        if interrupted():
            session.interrupted = True
            break
        board.begin_step()
        end_s = board.steps_end_s
        while waiting and waiting[0].time_s < end_s:
            event = waiting.pop(0)
            runner.run_to(max(event.time_s, board.seconds))
            runner.happen(event)
        runner.run_to(end_s)
        board.end_step()
        while board.steps_end_s < board.seconds - STEP_S / 2:  # the power was off
            board.stand_still()
        runner.serve()
        session.seconds = board.seconds
        session.wall_s = time.monotonic() - begin
        progress(session)
        if pace is not None:
            _sleep_until(begin + session.seconds / max(pace, _SLOWEST_PACE), interrupted)
    session.recorder.finish()
    return session


def _sleep_until(end_s: float, interrupted: Callable[[], bool]) -> None:
    while (left_s := end_s - time.monotonic()) > 0.0 and not interrupted():
        time.sleep(min(left_s, _NAP_S))


class Line(Protocol):
    """The other end of the serial line: a pseudo-terminal, or a page."""

    def read(self) -> bytes:
        """Give what was typed since the last call."""
        ...

    def write(self, data: bytes, *, given_up: Callable[[], bool]) -> None:
        """Take what the board sent."""
        ...


class _Runner:
    """The serial line's two ends, and the events."""

    def __init__(
        self,
        board: Board,
        session: Session,
        profile: Profile,
        terminal: Line | None,
        interrupted: Callable[[], bool] = lambda: False,
    ) -> None:
        self._board = board
        self._session = session
        self._profile = profile
        self._terminal = terminal
        self._interrupted = interrupted
        self._given = 0  # steps of the profile
        self._headers = 0
        self._resets = board.mega.resets

    def run_to(self, time_s: float) -> None:
        """Run the firmware up to a simulated time."""
        left = time_s - self._board.seconds
        if left > 0.0:
            self._board.mega.run_seconds(left)
        self._take()

    def serve(self) -> None:
        """Give what the profile and the terminal have for the board."""
        session, now = self._session, self._board.seconds
        if self._terminal is not None:
            typed = self._terminal.read()
            if typed:
                self._board.mega.uart.send(typed)
        if session.recorder.headers != self._headers:
            self._headers = session.recorder.headers
            self._given = max(self._given - 1, 0)
        if not self._headers and self._board.wiring.observe is None:
            return
        due = None
        while self._given < len(self._profile) and self._profile[self._given][0] < now + STEP_S / 2:
            due = self._profile[self._given][1]
            self._given += 1
        if due is not None:
            self._board.command(due)

    def happen(self, event: Event) -> None:
        """Let an event happen."""
        mega = self._board.mega
        if event.kind in ("press", "release"):
            self._board.press(event.kind == "press")
        elif event.kind == "reset":
            mega.press_reset()
        elif event.kind in ("power_cut", "brown_out"):
            cause = ResetCause.POWER_ON if event.kind == "power_cut" else ResetCause.BROWN_OUT
            mega.cut_power(event.duration_s, cause=cause, seed=1 + round(event.time_s * 1000.0))
        elif event.kind == "send":
            mega.uart.send(event.data)
        elif event.kind == "flood":
            bits_per_byte = 10
            count = round(event.duration_s * self._board.wiring.serial_baud / bits_per_byte)
            mega.uart.send((_FLOOD * (count // len(_FLOOD) + 1))[:count])
        elif event.kind == "held_up":
            mega.hold_up(round(event.duration_s * 1000.0))
        else:
            self._board.command(event.pwm)

    def _take(self) -> None:
        board, session = self._board, self._session
        sent = board.mega.uart.take()
        if board.mega.resets != self._resets:
            self._resets = board.mega.resets
            session.restarts_s.append(board.seconds)
        if not sent:
            return
        session.sent += sent
        session.recorder.feed(sent, board.seconds)
        if session.time_zero_s is None and session.recorder.rows:
            first = session.recorder.parts[0].rows[0]
            session.time_zero_s = round(board.seconds - float(first.split(",")[0]), 2)
        if self._terminal is not None:
            self._terminal.write(sent, given_up=self._interrupted)
