"""The board around the emulated Mega, and `gen emulate`: the firmware against a simulated motor.

`pins` maps Arduino numbers, `devices` puts sensors and loss of power at the chip's pins, `board` wires them as the
coefficient file says and lets the plant (`plant`) answer.
"""
