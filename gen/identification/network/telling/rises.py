"""What steady rises are of."""

from __future__ import annotations

from gen.identification.network.identify import NetworkFound


def steady_rise_title(result: NetworkFound) -> str:
    """Name the table of steady rises: none of them holds heat that a measured column brings, whatever it was."""
    columns = dict.fromkeys(result.data.driving[number].column for number, _ in result.found.structure.fed)
    return "steady rise (K) by PWM" + (f", without the heat of {', '.join(columns)}" if columns else "")
