"""The board around the emulated Mega, and `gen emulate`: the firmware against a simulated motor.

`wiring` is what is at the chip's pins, `plants` what heats at their other end. `board` wires both as the coefficient
file says; `session` runs it, as `scenario` and `options` ask for, and `results` says what came of it.
"""
