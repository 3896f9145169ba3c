"""What steady rises are of."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any


def steady_rise_title(heats_by_column: Sequence[Mapping[str, Any]]) -> str:
    """Name the table of steady rises: heat that a measured column brings is none of them, whatever it was in the runs.

    Parameters
    ----------
    heats_by_column
        As the JSON summary has them.
    """
    columns = dict.fromkeys(str(heat["column"]) for heat in heats_by_column)
    return "steady rise (K) by PWM" + (f", without the heat of {', '.join(columns)}" if columns else "")
