"""Values that a sensor or a converter gives when it measures nothing."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from gen.importing.table import FloatArray

WORDS: dict[float, str] = {
    1023.75: "MAX6675 at its end, without a thermocouple",
    2047.75: "MAX31855 at its end",
    2048.0: "a converter at its end",
    -127.0: "DS18B20 not connected",
    -196.6: "DS18B20 not connected, degF",
    999.0: "an error's number",
    999.9: "an error's number",
    -999.0: "an error's number",
    -999.9: "an error's number",
    9999.0: "an error's number",
    -9999.0: "an error's number",
    9999.9: "an error's number",
    65535.0: "0xFFFF",
    32767.0: "0x7FFF",
    -32768.0: "0x8000",
    6553.5: "0xFFFF in tenths",
    3276.7: "0x7FFF in tenths",
    -3276.8: "0x8000 in tenths",
    655.35: "0xFFFF in hundredths",
    327.67: "0x7FFF in hundredths",
    -327.68: "0x8000 in hundredths",
    4294967295.0: "0xFFFFFFFF",
}
"""In the sensor's own unit; hexadecimal ones are told of every channel, the rest of temperatures."""
_POWER_ON = {85.0: "DS18B20 before its first conversion", 185.0: "DS18B20 before its first conversion, degF"}
_LEAP = 10.0
"""In the sensor's unit: a power-on value stands that far from both neighbours, or it may be a temperature."""


def overflows(values: FloatArray, *, temperature: bool) -> list[tuple[NDArray[np.int64], float, str]]:
    """Rows that hold such a value, by the value.

    Parameters
    ----------
    values
        As the log has them, NaN where missing, shape (N,).
    temperature
        Whether the column is one.

    Returns
    -------
    list
        Of rows, the value, and what gives it.
    """
    found = []
    for value, words in WORDS.items():
        if not temperature and "0x" not in words:
            continue
        rows = np.flatnonzero(values == value)
        if rows.size:
            found.append((rows, value, words))
    for value, words in _POWER_ON.items() if temperature else ():
        rows = _alone(values, value)
        if rows.size:
            found.append((rows, value, words))
    return found


def _alone(values: FloatArray, value: float) -> NDArray[np.int64]:
    """Rows with a value that those around it are far from."""
    rows = np.flatnonzero(values == value)
    if not rows.size:
        return rows
    others = np.flatnonzero(np.isfinite(values) & (values != value))
    if not others.size:
        return rows[:0]
    after = np.searchsorted(others, rows)
    near = np.minimum(
        np.abs(values[others[np.maximum(after - 1, 0)]] - value),
        np.abs(values[others[np.minimum(after, others.size - 1)]] - value),
    )
    return rows[near > _LEAP]
