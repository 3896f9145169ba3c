"""Hazards of a driven motor on the emulated Mega: does a part pass its limit, is the motor driven blind?

    python -m benchmarks.hazards [--only NAME ...] [--jobs 2] [--every] [--flash-bits N] [--ram-bits N] [--json FILE]
    python -m benchmarks.hazards --nuisance HOURS

The firmware of examples/my1016/coeffs.json, with a relay and a time-out for commands, drives a small motor of its own
(`plant.py`): each part is first order, hot at the start, and far faster than the real one, so that its
limits are a minute away. What counts is that motor's truth, not what the board believes:

beyond: how far the hottest part was above its own limit, in K, while current flowed, and at all.
blind: the longest stretch with current while the word of a thermocouple that a limit watches was none, or was more than
5 K from the part's temperature.

A hazard passes when no part is more than 5 K beyond its limit with current, and the motor is not driven blind for
longer than the file says: the delay of `sensor_lost`, and a second for what the board needs to see it. Exit status 1 if
a single fault breaks that. A row with two faults at once has its verdict in brackets, and does not count.
"""
