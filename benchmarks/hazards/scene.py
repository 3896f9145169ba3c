"""A board, a motor, and somebody who does things to them; what came of it."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Self

from benchmarks.hazards.boards import PULSES, Variant
from benchmarks.hazards.plant import HazardPlant, Moment
from gen.avr.simulator import EmulationFailed
from gen.coefficients.wiring import Wiring
from gen.emulate.board import Board
from gen.emulate.plants.plant import STEP_S

MOST_BEYOND_K = 5.0
HOT = {"brush": 100.0, "bearing": 92.0, "magnet": 92.0, "casing": 92.0}
"""Where the motor starts, degC: a minute below its limits."""
WARMING = {"brush": 0.5, "bearing": 0.4, "magnet": 0.4, "casing": 0.4}
"""K/s at full current: the limits come within a minute, in which nothing can cool."""

_COMMISSIONING = re.compile(rb"# event: [\d.]+ commissioning FAILED at \w+: ([^\r]+)")
_PROTECTION = re.compile(rb"# event: [\d.]+ protection (\w+) begins")


@dataclass(frozen=True)
class Outcome:
    """What came of a hazard.

    Attributes
    ----------
    did
        What the board did after the hazard had begun.
    after_s
        From then until current flowed no more, s; None: it flowed to the end.
    beyond_driven_K, beyond_K
        How far the hottest part was over its limit, with current and at all; negative below.
    blind_s, allowed_s
        The longest stretch that was driven blind, and how long the file allows.
    end
        How it stands at the end.
    """

    did: str
    after_s: float | None
    beyond_driven_K: float
    beyond_K: float
    blind_s: float
    allowed_s: float
    end: str

    @property
    def passes(self) -> bool:
        """Whether the goal holds."""
        return self.beyond_driven_K <= MOST_BEYOND_K and self.blind_s <= self.allowed_s


class Scene:
    """What a hazard's script acts on.

    Parameters
    ----------
    variant
        The board.
    elf
        Another firmware than the variant's own.
    eeprom
        What the EEPROM holds at the start.
    astray
        Whether a firmware that has gone astray runs on, as on a chip.
    others
        Thermocouples that have a MAX31855, whatever the file says.

    Attributes
    ----------
    plant, board, said
        The motor, the board, and what it sent.
    crashed
        Whether the emulator gave up on the firmware.
    alive
        Whether a computer at the line's other end asks for the status every 5 s, as one that drives a motor does.
    """

    def __init__(
        self,
        variant: Variant,
        *,
        elf: Path | None = None,
        eeprom: bytes | None = None,
        astray: bool = False,
        others: Sequence[str] = (),
    ) -> None:
        self.variant = variant
        self.plant = HazardPlant(dict(HOT), variant.limits, dict(WARMING), PULSES)
        firmware = replace(variant.firmware, elf=elf or variant.firmware.elf)
        self.board = Board(firmware.elf, firmware.cache, _fitted(variant.wiring, others), self.plant, encoder="batched")
        if astray:
            self.board.mega.let_go_astray()
        if eeprom is not None:
            self.board.mega.eeprom.image = eeprom
        pin, pins = variant.wiring.relay_pin, self.board.mega.pins
        self.plant.relay_closed = lambda: pin is None or (pins.is_output(pin) and pins.level(pin))
        self.said = bytearray()
        self.crashed = False
        self.alive = True
        self._began_s, self._heard, self._quiet = 0.0, 0, 0

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.board.close()

    # ---- what a script does ----

    def wait(self, seconds: float) -> None:
        """Let time pass, in whole steps; a firmware that crashed the emulator stands still from then on."""
        board = self.board
        end = board.steps_end_s + seconds
        while board.steps_end_s < end - STEP_S / 2:
            self._keep_alive()
            board.begin_step()
            self._run(board.steps_end_s - board.seconds)
            board.end_step()
            while board.steps_end_s < board.seconds - STEP_S / 2:  # the power was off
                board.stand_still()
            self.said += board.mega.uart.take()

    def _keep_alive(self) -> None:
        self._quiet += 1
        if self.alive and self._quiet * STEP_S >= 5.0:
            self._quiet = 0
            self.send("?")

    def _run(self, seconds: float) -> None:
        if seconds <= 0.0 or self.crashed:
            return
        try:
            self.board.mega.run_seconds(seconds)
        except EmulationFailed:
            self.crashed = True

    def start(self, pwm: int = 255) -> None:
        """Let the board start, and drive the motor."""
        self.wait(4.0)
        if pwm:
            self.drive(pwm)
        self.wait(3.0)

    def drive(self, pwm: int) -> None:
        """Arm, and command a PWM."""
        self.board.command(pwm)

    def send(self, line: str) -> None:
        """Send a line."""
        self.board.mega.uart.send(line.encode() + b"\n")

    def begins(self) -> None:
        """Now the hazard begins."""
        self._began_s, self._heard = self.plant.time_s, len(self.said)

    # ---- for scripts that look inside ----

    def address(self, name: str) -> int:
        """Address of a variable by the name that it has in the source."""
        mangled = f"{len(name)}{name}"
        memory = self.board.mega.memory
        plain = {n: n.split(".")[0] for n in memory.symbols}  # the linker may have put its own ending behind a name
        names = [n for n, named in plain.items() if named == name or named.endswith((mangled, f"{mangled}E"))]
        assert len(names) == 1, names
        return memory.address(names[0])

    # ---- what came of it ----

    def outcome(self) -> Outcome:
        """Judge by the motor's truth; to be asked once, at the end."""
        moments = self.plant.moments
        driven = [moment for moment in moments if moment.driven]
        return Outcome(
            did=self._did(),
            after_s=self._after_s(),
            beyond_driven_K=max((moment.beyond_K for moment in driven), default=float("-inf")),
            beyond_K=max(moment.beyond_K for moment in moments),
            blind_s=longest(moments),
            allowed_s=self.variant.blind_s,
            end=self._end(),
        )

    def _after_s(self) -> float | None:
        after = [moment for moment in self.plant.moments if moment.time_s > self._began_s]
        if not after or after[-1].driven:
            return None
        return max((moment.time_s - self._began_s for moment in after if moment.driven), default=0.0)

    def _did(self) -> str:
        said = bytes(self.said[self._heard :])
        actions = self.variant.actions
        did = [f"{label}: {actions[label]}" for label in dict.fromkeys(_names(said)) if label in actions]
        did[:0] = [f"commissioning: {found.decode()}" for found in _COMMISSIONING.findall(said)]
        if self.board.mega.resets and b"# reset: watchdog" in said:
            did.append("reset by the watchdog")
        if b"not armed: the motor is stopped" in said:
            did.append("refused to be armed")
        elif b"not armed" in said:
            did.append("refused a PWM")
        return ", ".join(did) or "nothing"

    def _end(self) -> str:
        last = self.plant.moments[-1]
        if self.crashed:
            return f"emulator crashed, {'driven' if last.driven else 'stands'}"
        if last.driven:
            return "driven"
        return "stands" if self.plant.relay_closed() else "stands, relay open"


def longest(moments: list[Moment]) -> float:
    """Longest time driven blind, s, added up while one blindness lasts, stops and resets included."""
    most = blind = 0.0
    for moment in moments:
        blind = blind + STEP_S * moment.driven if moment.blind else 0.0
        most = max(most, blind)
    return most


def _fitted(wiring: Wiring, others: Sequence[str]) -> Wiring:
    """What is really on the board."""
    chips = tuple(
        chip.model_copy(update={"chip": "MAX31855"}) if chip.channel in others else chip
        for chip in wiring.thermocouples
    )
    return wiring.model_copy(update={"thermocouples": chips})


def _names(said: bytes) -> list[str]:
    return [name.decode() for name in _PROTECTION.findall(said)]
