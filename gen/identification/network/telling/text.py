"""What was found, as text for the terminal."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

import numpy as np

from gen.arrays import FloatArray
from gen.identification.network.fitting.bends import BEND
from gen.identification.network.fitting.driven import CURRENT, POWER
from gen.identification.network.telling.as_json import as_json
from gen.identification.network.telling.rises import steady_rise_title
from gen.identification.network.telling.summary import INTERVAL, Summary

HEATING = ("_A", "_W", "_Nm", "_percent")
"""Ends of the names of columns that may heat a motor."""
COOLING = re.compile(
    r"(?i)(?:^|[^a-z])(?:fans?|blower|cool(?:er|ing)|pump|l(?:ü|ue)fter|ventilat\w*|ventola)(?:[^a-z]|$)"
)
"""Names of columns that may cool it."""
BENDING = "bend by more than sums of powers do, as the runs ask for or as they do not exclude"
POWERS = "are sums of powers: the runs ask for none that bends more"


def text(summary: Summary) -> str:
    """Give what the command prints."""
    whole = as_json(summary)
    structure = summary.result.found.structure
    lines = [
        f"network of {structure.nodes} nodes, {structure.hidden} of them hidden, {len(structure.paths)} paths, "
        f"{len(structure.heated) + len(structure.fed)} heats{_by_columns(summary)}",
        f"  over speed they {BENDING if structure.bend == BEND else POWERS}",
        *(f"  {line}" for line in by_input(whole["heats_go_with"])),
        *(f"  {line}" for line in in_still_air(whole["natural_convection"])),
        *(f"  {line}" for line in by_temperature(whole["heat_grows"])),
        "  hidden nodes  error on data left out (K)",
        *(f"  {c.hidden:>12}  {c.left_out_K:.2f}" for c in summary.result.candidates),
        f"part        in the runs (K)  left out (K)  {steady_rise_title(summary.result)}",
    ]
    for s, name in enumerate(summary.result.data.names):
        own = float(np.sqrt(np.nanmean(summary.rms_K[:, s] ** 2)))
        rises = ", ".join(
            f"{pwm}: {summary.steady.rise[k, s]:.1f} ±{INTERVAL * summary.steady.deviation[k, s]:.1f}"
            for k, pwm in enumerate(summary.speeds)
        )
        lines.append(f"{name:<10}  {own:<15.2f}  {summary.left_out_K[s]:<12.2f}  {rises}")
    lines += _not_used(summary)
    lines.append(whole["verdict"])
    lines += [f"warning: {warning}" for warning in whole["warnings"]]
    return "\n".join(lines)


def _by_columns(summary: Summary) -> str:
    """Which of the heats come by measured columns."""
    driving = summary.result.data.driving
    used = dict.fromkeys(driving[number].column for number, _ in summary.result.found.structure.fed)
    unused = dict.fromkeys(one.column for one in driving if one.column not in used)
    said = f", {len(summary.result.found.structure.fed)} of them by {', '.join(used)}" if used else ""
    return said + (f" ({', '.join(unused)} heats nothing that is seen)" if unused else "")


def _not_used(summary: Summary) -> list[str]:
    """Columns that could heat the motor, too: every run has them, and they change."""
    sources, taken = summary.result.data.sources, {one.column for one in summary.result.data.driving}
    common = set.intersection(*(set(source.run.extras) for source in sources)) - taken
    moving = [
        column
        for column in sorted(common)
        if column.endswith(HEATING) and any(_moves(source.run.extras[column]) for source in sources)
    ]
    cooling = [
        column
        for column in sorted(common - set(moving))
        if COOLING.search(column) and any(_moves(source.run.extras[column]) for source in sources)
    ]
    said = []
    if moving:
        said.append(
            f"not used: {', '.join(moving)}; what else heats the motor, and the board can measure, tell with --heat"
        )
    if cooling:
        said.append(f"not used: {', '.join(cooling)}; whether that cools the motor, gen refine with these runs tells")
    return said


def _moves(values: FloatArray) -> bool:
    """Whether a column changes; one without values does not."""
    return np.unique(values[np.isfinite(values)]).size > 1


def by_input(heats_go_with: str | None) -> list[str]:
    """Say what is expected of an input that is no motor's PWM; nothing of a motor's."""
    if heats_go_with is None:
        return []
    heats = {POWER: "the input", CURRENT: "the square of the input"}[heats_go_with]
    return [f"heats are expected to go with {heats}, and conductances not to: it moves no air"]


def by_temperature(grows: Mapping[str, Any] | None) -> list[str]:
    """Say what heats grow by with temperature; nothing where that was not found."""
    if grows is None:
        return []
    share = grows["share_per_K"]
    low, high = share["interval"]
    return [
        f"heats grow by {share['value']:.2%} ({low:.2%} to {high:.2%}) for each kelvin by which their node is warmer "
        f"than {grows['over_degC']:.0f} degC"
    ]


def in_still_air(natural: Mapping[str, Any] | None) -> list[str]:
    """Say what goes by natural convection; nothing where none was found."""
    if natural is None:
        return []
    share = natural["share_at_rest"]
    low, high = share["interval"]
    return [
        f"{share['value']:.0%} ({low:.0%} to {high:.0%}) of what surfaces lose at rest goes by natural convection, "
        "which grows with their rise"
    ]
