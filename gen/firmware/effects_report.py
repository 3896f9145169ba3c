"""The report's table of effects: what each gains, and what it costs."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from gen.coefficients import Coefficients
from gen.model.effects.channel_ranges import columns

Cells = tuple[str, ...]
_UNKNOWN = "not measured"
_NONE = "none: in the model's own table"


def effect_rows(coefficients: Coefficients, own: Mapping[str, Any] | None) -> list[Cells]:
    """Effect, component, RMSE on left-out runs before and after in K, cycles, flash and RAM in bytes.

    Parameters
    ----------
    coefficients
        Its effects, those in the model's own entries too.
    own
        What `gen verify` found for the combination, or None.
    """
    costs = list(own.get("effects", [])) if own is not None else []
    emitted = list(coefficients.effects)
    rows: list[Cells] = []
    for entry in coefficients.document.effects:
        applied = entry.applied()
        gain = entry.evidence.get("left_out_rmse_K", {})
        before, after = (f"{gain[key]:.3g}" if key in gain else "not stated" for key in ("before", "after"))
        cost: Cells = (_NONE, "0", "0")
        if applied in emitted:
            place = emitted.index(applied)
            cost = (_UNKNOWN,) * 3
            if len(costs) == len(emitted):
                cost = tuple(str(costs[place][key]) for key in ("cycles", "flash_bytes", "ram_bytes"))
        rows.append((applied.effect.title, entry.component, before, after, *cost))
    return rows


def unwired(coefficients: Coefficients) -> list[str]:
    """What to say of channels that effects need and the sketch cannot read; nothing for a file without wiring."""
    wiring = coefficients.document.wiring
    if wiring is None:
        return []
    known = {*(channel.column for channel in wiring.channels), *coefficients.document.thermocouple_columns}
    return [
        f"$.wiring.{'thermocouples' if column.endswith('_degC') else 'channels'} has no {column}: "
        "in the sketch the effects that need it do nothing"
        for column in columns(coefficients.model, coefficients.effects)
        if column not in known
    ]
