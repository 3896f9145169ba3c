"""False alarms in many hours of a healthy motor, delays over a fault's severity, and faults where life is not steady.

    python -m benchmarks.alarm_hours [COEFFS] [--hours 1000] [--seed 1] [--jobs 2] [--only oracle] ..

The motor is the simulated one (`gen.rig`), the model the exact solution of COEFFS (`examples/my1016_rig/coeffs.json`),
and the rules are the reference's: `gen verify` proves them the board's on the words that the board is given; those
here differ from the board's by the error that `gen build` guarantees.

`healthy`: hours of each kind of life, with the false alarms of the level rules beside those on missing heat.
A load that comes on is heat like a fault's: its alarms are counted, but no model of PWM alone can tell.
`faults`: delay of the first alarm and the verdict for both faults at every speed, whole and at a half, a quarter and
an eighth of their severity.
`--zeroed`: each set of sensors had its offsets learnt by the board before (`$.wiring.zero`); give it a COEFFS that was
made of such runs (`examples/my1016_rig/make.py --zeroed`).
`loads`: loads that come and go, alone and with both faults: give it a COEFFS whose model reads the current
(`examples/my1016_rig/make.py --loaded`) to see what that tells.
`oracle`: delay over false alarms, beside that of one who knows the motor (:mod:`benchmarks.alarm_hours.oracle`).
`lives`: faults in duty cycles, at changing speed, growing over hours, both at once, in a moving room, after a start.
"""
