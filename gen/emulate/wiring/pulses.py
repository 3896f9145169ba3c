"""The encoder on one of the board's pins."""

from __future__ import annotations

from gen.avr.shim import Handle
from gen.avr.simulator import FREQUENCY_HZ
from gen.emulate.wiring.pins import PinMap


class EncoderPulses:
    """The pulses of an encoder; there is one, on no pin until `attach`.

    Parameters
    ----------
    handle
        The emulator.
    pins
        The board's.
    """

    def __init__(self, handle: Handle, pins: PinMap) -> None:
        self._handle = handle
        self._map = pins

    def attach(self, pin: int, *, batch_s: float = 0.0) -> None:
        """Connect the encoder.

        Parameters
        ----------
        pin
            Where.
        batch_s
            0: every pulse comes at its own time. Else the interrupts of the pulses that fall due within this time, s,
            are raised together at its end, each when the firmware has taken the one before: as many, and each handled
            by the firmware, but not spaced as on the motor, with the pin at rest, and none can be lost. It spares the
            firmware a return to sleep for every pulse, and the emulator most of its work. On pin 47 (the input of
            Timer 5) it plays no role: the count is exact at every read.

        Raises
        ------
        ValueError
            When the board has no such pin.
        """
        place = self._map.port_pin(pin)
        self._handle.call("encoder_attach", place.port.encode(), place.bit, round(batch_s * FREQUENCY_HZ))

    def send(self, count: int, seconds: float) -> None:
        """Give pulses within the time that comes; what an earlier call left over is dropped.

        Raises
        ------
        ValueError
            When they are too many, or no encoder is attached.
        """
        cycles = round(seconds * FREQUENCY_HZ)
        if count < 0 or self._handle.call("encoder_pulses", count, cycles):
            raise ValueError(
                f"{count} pulses in {seconds:g} s: expected an attached encoder and at least 4 cycles each"
            )

    @property
    def sent(self) -> int:
        """Rising edges so far."""
        return int(self._handle.call("encoder_risen"))
