"""What the board's flags mean, see the emitted header."""

from __future__ import annotations

OUTSIDE_VALIDITY, PWM_CLAMPED, GAIN_ZEROED, START_CLAMPED, SATURATED = 0x01, 0x02, 0x04, 0x08, 0x10
#: Set in the board's own flags after the first sample; not shown to its user.
STARTED = 0x80
