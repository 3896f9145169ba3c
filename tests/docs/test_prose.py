"""Lines of the docs can be read in an editor and in a comparison of versions."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
LONGEST = 140
PAGES = [
    *sorted((ROOT / "docs").glob("*.md")),
    *(ROOT / name for name in ("README.md", "CONTRIBUTING.md", "RELEASE.md")),
]


def prose(text: str) -> list[tuple[int, str]]:
    """Numbered lines that are no table, no code, and without the targets of links."""
    lines: list[tuple[int, str]] = []
    fenced = False
    for number, line in enumerate(text.splitlines(), start=1):
        if line.lstrip().startswith("```"):
            fenced = not fenced
        elif not fenced and not line.startswith("    ") and not line.lstrip().startswith("|"):
            lines.append((number, re.sub(r"\]\([^)]*\)", "]", line)))
    return lines


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.name))
def test_no_line_of_prose_is_longer_than_140_characters(page: Path) -> None:
    text = page.read_text(encoding="utf-8")
    assert not [f"{number}: {line}" for number, line in prose(text) if len(line) > LONGEST]


def test_tables_code_and_the_targets_of_links_may_be_longer() -> None:
    long = "x" * 150
    text = f"| {long} |\n\n    {long}\n\n```\n{long}\n```\n[a]({long})\n{long}\n"
    assert [number for number, line in prose(text) if len(line) > LONGEST] == [9]
