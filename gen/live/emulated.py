"""The firmware on the emulated Mega beside a motor that the page can break."""

from __future__ import annotations

import queue
import time
from collections.abc import Callable
from dataclasses import replace
from math import inf
from typing import Any

from gen.coefficients import Coefficients
from gen.emulate.board import Board
from gen.emulate.plants.plant import STEP_S, Changeable
from gen.emulate.session import Session, run_session
from gen.errors import InputError
from gen.live.control import Control, checked
from gen.live.heat import HeatInMemory, heat_rules
from gen.live.pace import Pace
from gen.live.signals import UNKNOWN, Signals, from_pins
from gen.live.source import Source
from gen.live.view import View
from gen.record.profile import Profile
from gen.rig import SENSOR_FAULTS, SensorFault

_MONTH_S = 30 * 86_400.0
_NAP_S = 0.05
_SHORT_NAP_S = 0.01
FASTEST = 1000.0
HEALTHY = "none"
ROOM_K_PER_S = 0.2
"""A room does not jump, and the board would not believe a sensor of one that does."""
_MOST_WAITING = 64
_LOOK_EVERY_S = 0.2
"""So often, by this computer's clock, somebody looks at the pins."""


def heat_of(coefficients: Coefficients, board: Board) -> HeatInMemory | None:
    """The sums of missing heat in a board's memory; None where its file has no rule on it."""
    if not heat_rules(coefficients):
        return None
    memory = board.mega.memory
    address = memory.address(f"{coefficients.name}_alarm_state")
    return HeatInMemory(coefficients, lambda size: memory.peek(address, size))


class EmulatedSource(Source):
    """An emulated board.

    Parameters
    ----------
    name
        The model's.
    board, plant
        The board, not yet started, and the motor that it is wired to.
    channels
        Its thermocouples.
    faults
        Motor faults to offer.
    pace
        Simulated seconds in a second here; shared with another source, both are at about the same time.
    profile
        PWM to command until the page does.
    view
        Where the rows go.
    leads
        Whether the pace is one of its controls: of those that share it one is enough.
    """

    def __init__(
        self,
        name: str,
        board: Board,
        plant: Changeable,
        channels: tuple[str, ...],
        faults: tuple[str, ...],
        pace: Pace,
        profile: Profile,
        view: View,
        ambient_degC: float = 30.0,
        *,
        leads: bool = True,
    ) -> None:
        super().__init__("emulated", name, view)
        self._board, self._plant, self._profile, self._pace = board, plant, profile, pace
        self._typed: queue.Queue[bytes] = queue.Queue(_MOST_WAITING)
        self._asked: queue.Queue[Callable[[], None]] = queue.Queue(_MOST_WAITING)
        self._anchor = (0.0, 0.0)
        self._place = pace.join()
        self._now_s = 0.0
        self._stepped_s = 0.0
        self._seen: Signals | None = None
        self._look_at = 0.0
        self._room = self._wanted = ambient_degC
        kinds, most_Nm = (HEALTHY, *SENSOR_FAULTS), plant.largest_load_Nm
        self._controls = {
            control.name: control
            for control in (
                *([pace.control] if leads else []),
                Control("ambient", "ambient, degC", "number", ambient_degC, -40.0, 80.0, 0.5),
                *([Control("load", "load of the shaft, Nm", "slider", 0.0, 0.0, most_Nm, 0.05)] if most_Nm else []),
                Control("fault", "fault of the motor", "choice", HEALTHY, options=(HEALTHY, *faults)),
                Control("own fault", "or, as --fault has it", "text", ""),
                *(
                    Control(f"sensor {channel}", f"thermocouple of {channel}", "choice", HEALTHY, options=kinds)
                    for channel in channels
                ),
            )
        }

    def controls(self) -> list[Control]:
        """See :meth:`Source.controls`."""
        return list(self._controls.values())

    def change(self, name: str, value: Any) -> None:  # noqa: ANN401
        """See :meth:`Source.change`; it holds from the plant's next step on."""
        if name not in self._controls:
            super().change(name, value)
        found = checked(self._controls[name], value)
        if name == "pace":
            self._pace.speed = float(found)
            self._remember(name, found)
            return
        self._ask(lambda: self._set(name, found))

    def send(self, data: bytes) -> None:
        """See :meth:`Source.send`."""
        if not self.connected:
            raise InputError("the emulated board has ended: nothing was sent")
        try:
            self._typed.put_nowait(data)
        except queue.Full:
            raise InputError("the board takes nothing: nothing was sent") from None

    def signals(self) -> Signals:
        """See :meth:`Source.signals`."""
        return self._seen if self._seen is not None and self.connected else Signals(UNKNOWN, UNKNOWN, self.link)

    def run(self) -> None:
        """See :meth:`Source.run`."""
        self.connected, self.link = True, "running"
        self._anchor = (time.monotonic(), 0.0)
        try:
            run_session(
                self._board,
                _MONTH_S,
                profile=self._profile,
                terminal=self,
                progress=self._step,
                interrupted=self.stopped.is_set,
            )
        finally:
            self._pace.leave(self._place)
            self._board.close()
        self.link = "came to its end"

    # ---- the serial line's other end, and the clock: called by the session, in the source's thread ----

    def read(self) -> bytes:
        """See `gen.emulate.session.Line.read`."""
        return b"".join(self._typed.get_nowait() for _ in range(self._typed.qsize()))

    def write(self, data: bytes, *, given_up: Callable[[], bool]) -> None:
        """See `gen.emulate.session.Line.write`."""
        self.view.feed(data, self._now_s)

    def _step(self, session: Session) -> None:
        self._now_s = session.seconds
        while not self._asked.empty():
            try:
                self._asked.get_nowait()()
            except InputError as error:  # what the plant cannot do is said; the motor runs on
                self.view.say(str(error))
        self._warm(session.seconds - self._stepped_s)
        self._stepped_s = session.seconds
        if time.monotonic() >= self._look_at:  # here: nobody else may touch the emulator
            self._look_at = time.monotonic() + _LOOK_EVERY_S
            self._seen = from_pins(self._board.led_now, self._board.relay_closed, self.view.known.rules)
        session.sent.clear()  # the view keeps what came; a month of it twice would be much
        self._wait(session.seconds)

    def _warm(self, seconds: float) -> None:
        """Let the room go towards what was asked for."""
        if self._room != self._wanted:
            most = ROOM_K_PER_S * seconds
            self._room += min(max(self._wanted - self._room, -most), most)
            self._plant.set_ambient(self._room)

    def _wait(self, seconds: float) -> None:
        """Let no more than the pace's share of simulated time pass; what the emulator cannot follow is not owed."""
        pace, speed = self._pace, self._pace.speed
        pace.reach(self._place, seconds)
        begin, at = self._anchor
        while not self.stopped.is_set():
            ahead_s = (seconds - at) / speed - (time.monotonic() - begin)
            if pace.too_far(self._place):
                ahead_s = _SHORT_NAP_S
            if ahead_s <= 0.0 or speed != pace.speed:
                break
            self.stopped.wait(min(ahead_s, _NAP_S))
        self._anchor = (time.monotonic(), seconds)

    def _ask(self, action: Callable[[], None]) -> None:
        try:
            self._asked.put_nowait(action)
        except queue.Full:
            raise InputError("the emulator does not follow: nothing was changed") from None

    def _set(self, name: str, value: float | str) -> None:
        if name == "ambient":
            self._wanted = float(value)
        elif name == "load":
            self._plant.set_load(float(value))
        elif name == "own fault":
            self._plant.set_faults(str(value).strip())
        elif name == "fault":
            self._plant.set_faults("" if value == HEALTHY else str(value))
        else:
            kind = next((one for one in SENSOR_FAULTS if one == value), None)
            faults = () if kind is None else (SensorFault(kind, self._now_s - STEP_S, inf),)
            self._plant.set_sensor_faults(name.removeprefix("sensor "), faults)
        self._remember(name, value)
        self.view.say(f"{self._now_s:.2f} s since power-on: {self._controls[name].label} is now {value}")
        since = f"from {self._now_s:.0f} s since power-on"
        if name == "load":
            self.view.note("shaft_load", f"{value:g} Nm {since}")
        elif name != "ambient" and value not in (HEALTHY, ""):
            key = "motor_fault" if name.endswith("fault") else f"{name.replace(' ', '_')}_fault"
            self.view.note(key, f"{value} {since}")

    def _remember(self, name: str, value: float | str) -> None:
        """Let who opens the page later see what is set. Of the two ways to name a fault the latest holds."""
        self._controls[name] = replace(self._controls[name], value=value)
        other = {"fault": "own fault", "own fault": "fault"}.get(name)
        if other is not None:
            healthy = "" if other == "own fault" else HEALTHY
            self._controls[other] = replace(self._controls[other], value=healthy)
