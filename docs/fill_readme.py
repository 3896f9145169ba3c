"""Put the figures of a verification into the README: `python docs/fill_readme.py VERIFICATION.json`."""

from __future__ import annotations

import json
import re
import sys
from pathlib import Path
from typing import Any

from gen.lowering.recursion.guarantee import rounded_up

README = Path(__file__).parent.parent / "README.md"


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


def main() -> None:
    """Rewrite the README's figures."""
    record = json.loads(Path(sys.argv[1]).read_text())
    text = README.read_text()
    text = between(text, "table", f"\n\n{table(record)}\n\n")
    samples, words = f"{record['samples']:,}", f"{record['words']:,}"
    text = between(text, "equal", f"**{samples} samples, {words} words compared, {record['differing']} differ.**")
    README.write_text(text)


if __name__ == "__main__":
    main()
