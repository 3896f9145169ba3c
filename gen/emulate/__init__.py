"""The board around the emulated Mega, and `gen emulate`: the firmware against a simulated motor.

`pins` maps Arduino numbers. `levels`, `max6675`, `pulses` and `eeprom` are what is around the chip, `devices` is the
Mega with all of it. `board` wires it as the coefficient file says and lets the plant (`plant`) answer; `session` runs
it.
"""
