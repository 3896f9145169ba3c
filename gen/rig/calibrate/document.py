"""The fitted numbers as tables in ``docs/rig.md``, between marks, so that no figure there is typed by hand."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from gen.errors import InputError
from gen.files import write_text
from gen.rig.calibrate.fit import BROKEN, Comparison, compare, settled
from gen.rig.calibrate.report import explain_fall
from gen.rig.calibrate.targets import Targets
from gen.rig.parameters import MEASURED, MotorParameters


def fill(path: Path, parameters: MotorParameters, targets: Targets) -> None:
    """Renew what stands between ``<!-- name -->`` and ``<!-- /name -->``.

    Raises
    ------
    InputError
        When the file cannot be read or a mark is missing.
    """
    try:
        text = path.read_text(encoding="utf-8")
    except OSError as error:
        raise InputError(f"cannot be read: {error.strerror}", file=str(path)) from error
    healthy = compare(parameters, targets)
    tables = {
        "nodes": _nodes(parameters),
        "paths": _paths(parameters),
        "losses": _losses(parameters),
        "steady": _by_speed(targets, "K", {n: healthy.end_K[n] for n in MEASURED}, "+.1f"),
        "times": _by_speed(targets, "%", {n: 100.0 * healthy.time_63[n] for n in MEASURED}, "+.0f"),
        "faults": _faults(parameters, targets),
        "worst": _worst(healthy),
        "fall": explain_fall(parameters),
    }
    for name, table in tables.items():
        pattern = re.compile(rf"<!-- {name} -->.*?<!-- /{name} -->", re.DOTALL)
        if len(pattern.findall(text)) != 1:
            raise InputError(f"expected one pair of marks {name}", file=str(path))
        start, end = next((m.start(), m.end()) for m in pattern.finditer(text))
        text = f"{text[:start]}<!-- {name} -->\n{table}\n<!-- /{name} -->{text[end:]}"
    write_text(path, text)


def _table(header: list[str], rows: list[list[str]]) -> str:
    lines = [header, ["---"] * len(header), *rows]
    return "\n" + "\n".join("| " + " | ".join(line) + " |" for line in lines) + "\n"


def _nodes(parameters: MotorParameters) -> str:
    rows = [[name, f"{value:.3g}"] for name, value in parameters.capacities_J_per_K.items()]
    rows.append(["together", f"{sum(parameters.capacities_J_per_K.values()):.3g}"])
    return _table(["node", "heat capacity, J/K"], rows)


def _paths(parameters: MotorParameters) -> str:
    rows = [
        [
            f"{path.a} - {path.b}",
            f"{path.still_W_per_K:.3g}",
            f"{path.forced_W_per_K:.3g}" if path.forced_W_per_K else "",
            f"{path.exponent:.2g}" if path.forced_W_per_K else "",
            f"{path.still_W_per_K + path.forced_W_per_K:.3g}",
        ]
        for path in parameters.paths
    ]
    return _table(["heat path", "at rest, W/K", "forced, W/K", "exponent", "at full speed, W/K"], rows)


def _losses(parameters: MotorParameters) -> str:
    rows = [[f"`{name}`", f"{value:.3g}"] for name, value in parameters.losses]
    return _table(["parameter", "value"], rows)


def _by_speed(targets: Targets, unit: str, values: dict[str, np.ndarray], form: str) -> str:
    header = [unit, *(f"{100 * speed:.0f} %" for speed in targets.speeds)]
    return _table(header, [[name, *(format(v, form) for v in row)] for name, row in values.items()])


def _faults(parameters: MotorParameters, targets: Targets) -> str:
    healthy = settled(parameters, targets.fault_speeds)
    rows = []
    for kind, condition in BROKEN.items():
        broken = settled(parameters, targets.fault_speeds, condition)
        for part in ("brush", "casing"):
            over = broken[part] - healthy[part]
            rows.append([f"{kind} fault: {part}", *(f"{value:+.1f}" for value in over)])
    return _table(["K over healthy", *(f"{100 * speed:.0f} %" for speed in targets.fault_speeds)], rows)


def _worst(healthy: Comparison) -> str:
    end = max(float(np.abs(values).max()) for values in healthy.end_K.values())
    settled_K = max(float(np.abs(values).max()) for values in healthy.settled_K.values())
    brush = 100.0 * float(np.abs(healthy.time_63["brush"]).max())
    others = 100.0 * max(float(np.abs(healthy.time_63[name]).max()) for name in MEASURED if name != "brush")
    return (
        f"Temperatures at 10 800 s: within {end:.2f} K of Table 4.1; settled: within {settled_K:.2f} K.\n"
        f"Time to 63 %: within {others:.0f} % for bearing, magnet and casing, within {brush:.0f} % for the brush."
    )
