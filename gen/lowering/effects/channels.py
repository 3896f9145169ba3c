"""Which channels the effects need, and in which range each may lie."""

from __future__ import annotations

from collections.abc import Sequence

from gen.lowering.effects.program import Channel
from gen.model import ThermalModel
from gen.model.effects import Applied

#: The board's ambient may lie so far outside of the declared domain.
_AMBIENT_MARGIN_K = 10.0
_AMBIENT_DEGC = 25.0
#: By the unit at the end of a column's name, where the file says nothing else.
_RANGES = {"_a": (-50.0, 50.0), "_v": (0.0, 100.0), "_degc": (-50.0, 400.0), "_percent": (0.0, 100.0)}
_RANGES |= {"_pct": (0.0, 100.0), "_w": (0.0, 1000.0)}
_OTHER = (0.0, 20.0)


def columns(model: ThermalModel, effects: Sequence[Applied]) -> list[str]:
    """Extra columns that the effects need, each once."""
    names: dict[str, None] = {}
    for applied in effects:
        for key in ("channel", "source"):
            value = applied.values.get(key)
            if value is not None and value not in model.component_names and applied.effect.name != "ambient":
                names[str(value)] = None
    return list(names)


def channels(
    model: ThermalModel, effects: Sequence[Applied], declared: dict[str, tuple[float, float]]
) -> tuple[Channel, ...]:
    """The ambient and all columns.

    Parameters
    ----------
    model, effects
        What needs them.
    declared
        Ranges from the coefficient file, by column.
    """
    low, high = model.domain_ambient
    fixed = model.ambient_fixed if model.ambient_fixed is not None else _AMBIENT_DEGC
    found = [_channel("ambient_degC", (low - _AMBIENT_MARGIN_K, high + _AMBIENT_MARGIN_K), fixed)]
    for column in columns(model, effects):
        unit = next((r for end, r in _RANGES.items() if column.lower().endswith(end)), _OTHER)
        neutral = fixed if column.lower().endswith("_degc") else _neutral(column, effects)
        lowest, highest = declared.get(column, (min(unit[0], neutral), max(unit[1], 2.0 * neutral)))
        found.append(_channel(column, (lowest, highest), neutral))
    return tuple(found)


def _neutral(column: str, effects: Sequence[Applied]) -> float:
    """The value at which an effect does nothing."""
    for applied in effects:
        if applied.values.get("channel") == column:
            for key in ("nominal_V", "reference_A"):
                if key in applied.values:
                    return float(applied.values[key])
    return 0.0


def _channel(column: str, limits: tuple[float, float], neutral: float) -> Channel:
    low, high = (round(value * 1000.0) for value in limits)
    return Channel(column, low, high, min(max(round(neutral * 1000.0), low), high))
