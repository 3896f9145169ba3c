"""The board as the coefficient file wires it: the firmware's pins lead to a plant."""

from __future__ import annotations

from pathlib import Path
from typing import Literal

from gen.coefficients.wiring import Wiring
from gen.emulate.plants.plant import FULL_PWM, STEP_S, Plant, Reading
from gen.emulate.wiring.devices import DeviceBoard
from gen.emulate.wiring.divider import Divider
from gen.emulate.wiring.led import shown_now
from gen.emulate.wiring.levels import Edges
from gen.emulate.wiring.max6675 import Max6675
from gen.emulate.wiring.registers import RegisterChip

EncoderMode = Literal["true", "batched"]

BATCH_S = 0.001
"""What `EncoderMode` ``batched`` gathers, s: some 22 pulses at full speed."""

_LED_EDGES = 512
"""A flicker makes 16 changes a second, for at most 1.5 s between two numbers."""


class Board:
    """An emulated Mega or Uno with what the wiring names, and a plant that answers.

    Parameters
    ----------
    elf
        The firmware.
    cache
        The folder that keeps the emulator's compiled half.
    wiring
        The coefficient file's.
    plant
        The motor and its sensors. It runs for one step before the board gets power, so that the converters have
        something to convert.
    encoder
        ``true``: every edge of the encoder comes at its own time. ``batched``: see `EncoderPulses.attach`. Pulses
        that Timer 5 counts are exact either way and cost nothing.
    """

    def __init__(self, elf: Path, cache: Path, wiring: Wiring, plant: Plant, *, encoder: EncoderMode = "true") -> None:
        self.mega = DeviceBoard(elf, cache, wiring.board)
        self.wiring = wiring
        self._plant = plant
        self.thermocouples: dict[str, Max6675 | RegisterChip | Divider] = {
            chip.channel: self.mega.add_chip(chip.chip, chip.cs, chip.so, chip.sck, chip.sdi, chip.analog_pin)
            for chip in wiring.thermocouples
        }
        if wiring.encoder is not None:
            self.mega.encoder.attach(wiring.encoder.pin, batch_s=BATCH_S if encoder == "batched" else 0.0)
        self._led = self.mega.pins.watch(wiring.led_pin) if wiring.led_pin is not None else None
        self._steps = 0
        self.commanded = 0
        self._observe(0)
        self._show(self._plant.step(0, STEP_S))

    def close(self) -> None:
        """Free the emulator."""
        self.mega.close()

    @property
    def seconds(self) -> float:
        """Simulated time since the board first got power, s."""
        return self.mega.seconds

    @property
    def pwm(self) -> int:
        """PWM that acts on the motor now, -255..255."""
        drive = self.wiring.drive
        if drive is None:
            return self.commanded
        if drive.pwm_pin is not None and drive.direction_pin is not None:
            return self.mega.pins.signed_pwm(drive.pwm_pin, drive.direction_pin, forward_level=drive.forward_is_high)
        assert drive.forward_pin is not None and drive.reverse_pin is not None
        return self.mega.pins.pwm(drive.forward_pin, drive.reverse_pin)

    @property
    def led(self) -> Edges | None:
        """Every change of the LED, None without one."""
        return self._led.edges() if self._led is not None else None

    @property
    def led_now(self) -> tuple[str, ...] | None:
        """What the LED says at present, see `gen.emulate.wiring.led.shown_now`; None without one."""
        return shown_now(self._led.latest(_LED_EDGES), self.seconds) if self._led is not None else None

    @property
    def relay_closed(self) -> bool | None:
        """Whether the relay is closed; None without one. A pin that nobody drives, as in a reset, opens it."""
        pin = self.wiring.relay_pin
        return None if pin is None else self.mega.pins.is_output(pin) and self.mega.pins.level(pin)

    def command(self, pwm: int) -> None:
        """Command a PWM: over the serial line, armed first; where the firmware observes, as the other controller."""
        self.commanded = pwm
        if self.wiring.observe is not None:
            self._observe(pwm)
        elif pwm:
            self.mega.uart.send(b"arm\n%d\n" % pwm)
        else:
            self.mega.uart.send(b"%d\n" % pwm)

    def press(self, down: bool) -> None:
        """Press the button, or let it go."""
        if self.wiring.button_pin is not None:
            self.mega.pins.drive(self.wiring.button_pin, False if down else None)

    def begin_step(self) -> None:
        """Let the plant run for the `STEP_S` that come, with the PWM that acts now; its pulses come meanwhile."""
        self._steps += 1
        reading = self._plant.step(self.pwm, STEP_S)
        if self.wiring.encoder is not None:
            self.mega.encoder.send(reading.pulses, STEP_S)
        self._next = reading

    def end_step(self) -> None:
        """Let the converters see the plant as it is at the step's end."""
        self._show(self._next)

    def stand_still(self) -> None:
        """Let the plant run for one step without power, and its sensors with it."""
        self._steps += 1
        self._show(self._plant.step(0, STEP_S))

    @property
    def steps_end_s(self) -> float:
        """Simulated time at which the plant stands, s."""
        return self._steps * STEP_S

    def _show(self, reading: Reading) -> None:
        self._next = reading
        for channel, chip in self.thermocouples.items():
            chip.set_word(reading.words.get(channel, 0))
        for wired in self.wiring.channels:
            value = reading.channels.get(wired.column, 0.0)
            if wired.analog_pin is not None:
                self.mega.pins.drive_analog(wired.analog_pin, wired.zero_V + value / wired.per_V)
            elif wired.contact_pin is not None:
                self.mega.pins.drive(wired.contact_pin, False if value >= 0.5 else None)

    def _observe(self, pwm: int) -> None:
        observe = self.wiring.observe
        if observe is None:
            return
        self.mega.pins.drive_wave(observe.forward_pin, max(pwm, 0) / FULL_PWM)
        if observe.reverse_pin is not None:
            self.mega.pins.drive_wave(observe.reverse_pin, max(-pwm, 0) / FULL_PWM)
