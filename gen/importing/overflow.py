"""Values that a sensor or a converter gives when it measures nothing."""

from __future__ import annotations

import numpy as np

from gen.arrays import BoolArray, FloatArray, IntArray

_OF_CELSIUS: dict[float, str] = {
    -127.0: "DS18B20 not connected",
    -200.0: "a Pt100 or a thermocouple at its range's end",
}
_OF_FAHRENHEIT: dict[float, str] = {-196.6: "DS18B20 not connected, degF"}
_OF_TEMPERATURES: dict[float, str] = {
    1023.75: "MAX6675 at its end, without a thermocouple",
    2047.75: "MAX31855 at its end",
    2048.0: "a converter at its end",
    999.0: "an error's number",
    999.9: "an error's number",
    -999.0: "an error's number",
    -999.9: "an error's number",
    9999.0: "an error's number",
    -9999.0: "an error's number",
    9999.9: "an error's number",
}
"""Told as they are, in whatever unit the others stand."""
_WITHIN_A_RANGE: dict[float, str] = {
    1023.0: "10 bits at their end",
    1024.0: "MAX6675 at its end, rounded",
    4095.0: "12 bits at their end",
}
"""What an oven may have, too: told where nothing beside it is near, and not where values stay there."""
_OF_ALL: dict[float, str] = {
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
_POWER_ON = {
    "degC": {85.0: "DS18B20 before its first conversion"},
    "degF": {185.0: "DS18B20 before its first conversion, degF"},
}
_LEAP = 10.0
"""In the sensor's unit: such a value stands that far from what is around it, or it may be measured."""
_LEAP_STEPS = 5.0
"""And that many usual steps."""
_LEAP_SHARE = 0.05
"""Of the value, for a channel that is no temperature, and whose unit may be any."""
_STAYS = 3
"""Rows in a row that a range's end fills where values come near it and none exceeds it."""


def overflows(values: FloatArray, *, temperature: str) -> list[tuple[IntArray, float, str]]:
    """Rows that hold such a value, by the value; none where it lies in the course of those around it.

    Parameters
    ----------
    values
        As the log has them, in its unit, NaN where missing, shape (N,).
    temperature
        The unit of a temperature: degC, degF or K, each with a factor or without; empty for another quantity.

    Returns
    -------
    list
        Of rows, the value, and what gives it.
    """
    ends, possible = _known(temperature)
    measured = np.isfinite(values) & ~np.isin(values, [*ends, *possible])
    found = []
    for value, words in (ends | possible).items():
        rows = np.flatnonzero(values == value)
        if not rows.size:
            continue
        leaps = _leaps(values, rows, measured, _LEAP if temperature else _LEAP_SHARE * abs(value))
        if value in ends:
            leaps |= not measured.any() or _stays_at_its_end(values, rows, measured)
        if leaps.any():
            found.append((rows[leaps], value, words))
    return found


def _known(temperature: str) -> tuple[dict[float, str], dict[float, str]]:
    """Values of a range's end and of errors, and those that may be measured as well, in a unit."""
    if not temperature:
        return _OF_ALL, {}
    unit = next((unit for unit in ("degC", "degF") if temperature.endswith(unit)), "")
    own = {"degC": _OF_CELSIUS, "degF": _OF_FAHRENHEIT}.get(unit, {})
    return own | _OF_TEMPERATURES | _OF_ALL, _POWER_ON.get(unit, {}) | _WITHIN_A_RANGE


def _leaps(values: FloatArray, rows: IntArray, measured: BoolArray, least: float) -> BoolArray:
    """Which of the rows are far from the nearest measured value before and behind them."""
    others = np.flatnonzero(measured)
    if not others.size:
        return np.zeros(rows.size, dtype=bool)
    after = np.searchsorted(others, rows)
    around = np.stack([values[others[np.maximum(after - 1, 0)]], values[others[np.minimum(after, others.size - 1)]]])
    steps = np.abs(np.diff(values[others]))
    usual = float(np.median(steps)) if steps.size else 0.0
    far: BoolArray = np.abs(around - values[rows]).min(axis=0) > max(least, _LEAP_STEPS * usual)
    return far


def _stays_at_its_end(values: FloatArray, rows: IntArray, measured: BoolArray) -> bool:
    """Whether a range ends there: values stay at it, row after row, and none goes beyond."""
    if rows.size < _STAYS or not (rows[_STAYS - 1 :] - rows[: 1 - _STAYS] == _STAYS - 1).any():
        return False
    beyond = np.abs(values[measured]) > abs(float(values[rows[0]]))
    return not beyond.any()
