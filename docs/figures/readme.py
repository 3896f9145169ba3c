"""The figures of a verification in the README."""

from __future__ import annotations

import hashlib
import re
from pathlib import Path
from typing import Any

from gen.coefficients import load
from gen.firmware.project import project_files
from gen.lowering.kinds import Arithmetic, ScheduleKind
from gen.lowering.lower import lower
from gen.lowering.recursion.guarantee import rounded_up

ROOT = Path(__file__).parents[2]
README = ROOT / "README.md"
COEFFICIENTS = ROOT / "examples" / "my1016" / "coeffs.json"


COMBINATIONS: tuple[tuple[Arithmetic, ScheduleKind], ...] = (
    ("fixed", "table"),
    ("fixed", "onboard"),
    ("float", "table"),
    ("float", "onboard"),
)


def table(record: dict[str, Any]) -> str:
    """Rows of the table of error and cost, a line for each combination."""
    lines = [
        "| combination | measured error, worst part | guaranteed, worst part | cycles, PWM held | with a change "
        "| flash | RAM | stack |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for item in record["combinations"]:
        cost = item["cost"]
        lines.append(
            f"| {item['arithmetic']}/{item['schedule']} | {rounded_up(max(item['error_K'].values())):.1e} K "
            f"| {rounded_up(max(item['bound_K'].values())):.1e} K | {cost['cycles_constant']} "
            f"| {cost['cycles_change']} | {cost['flash_bytes']} B | {cost['ram_bytes']} B | {cost['stack_bytes']} B |"
        )
    return "\n".join(lines)


def between(text: str, name: str, value: str) -> str:
    """The text with what stands between two markers replaced."""
    pattern = rf"(<!-- {name} -->).*?(<!-- /{name} -->)"
    return re.sub(pattern, lambda match: f"{match[1]}{value}{match[2]}", text, flags=re.DOTALL)


def firmware_digest() -> str:
    """What the figures are of: every byte of the model's library in each combination.

    Error, cycles and sizes can change only where these bytes do (or the compiler).
    """
    coefficients = load(COEFFICIENTS)
    digest = hashlib.sha256()
    for arithmetic, schedule in COMBINATIONS:
        program = lower(coefficients, arithmetic, schedule)
        files = project_files(coefficients, program, COEFFICIENTS.name, None)
        for path in sorted(path for path in files if path.startswith("lib/") and path.endswith((".h", ".cpp"))):
            digest.update(f"{path}\0{files[path]}\0".encode())
    return digest.hexdigest()[:16]


def filled(text: str, record: dict[str, Any]) -> str:
    """The README's text with the figures of a verification."""
    samples, words = f"{record['samples']:,}", f"{record['words']:,}"
    text = between(text, "equal", f"**{samples} samples, {words} words compared, {record['differing']} differ.**")
    return between(text, "table", f"\n\n{table(record)}\n\n<!-- of {firmware_digest()} -->\n")
