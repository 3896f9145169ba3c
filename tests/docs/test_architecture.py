"""docs/architecture.md against the code: the arrows between the rooms of `gen/`, and what it names."""

from __future__ import annotations

import ast
import re
from graphlib import TopologicalSorter
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
BESIDE = {
    "arrays",
    "compiled",
    "errors",
    "files",
    "interruption",
    "progress",
    "side_by_side",
    "templating",
    "toolchain",
    "version",
}
"""Modules beside the rooms that every room may import."""


def rooms() -> dict[str, set[str]]:
    """The page's table: each room and what it may import, in the page's order."""
    found: dict[str, set[str]] = {}
    for name, allowed in re.findall(r"^\| `(\w+)` \|.*\| ([^|]*)\|$", PAGE, re.MULTILINE):
        found[name] = {*found} if allowed.strip() == "all" else set(re.findall(r"`(\w+)`", allowed))
    return found


ROOMS = rooms()


def imported(path: Path) -> set[str]:
    """Rooms of `gen`, and modules beside them, that a module imports anywhere in it."""
    found: set[str] = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        names: list[str] = []
        if isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}: a relative import"
            names = [f"gen.{entry.name}" for entry in node.names] if node.module == "gen" else [node.module or ""]
        elif isinstance(node, ast.Import):
            names = [entry.name for entry in node.names]
        found |= {name.split(".")[1] for name in names if name.startswith("gen.")}
    return found


def test_the_table_has_every_room() -> None:
    assert set(ROOMS) == {path.parent.name for path in (ROOT / "gen").glob("*/__init__.py")}


@pytest.mark.parametrize("room", ROOMS)
def test_a_room_imports_what_the_table_allows_and_nothing_else(room: str) -> None:
    taken = {path: imported(path) for path in (ROOT / "gen" / room).rglob("*.py")}
    allowed = ROOMS[room] | BESIDE | {room}
    wrong = [f"{path.relative_to(ROOT)}: {name}" for path, names in taken.items() for name in sorted(names - allowed)]
    assert not wrong
    if room != "commands":  # arrows that nobody goes any more leave the table, too
        assert ROOMS[room] <= set().union(*taken.values())


def test_no_arrow_leads_to_a_later_row() -> None:
    order = list(ROOMS)
    assert not [(room, to) for room in order for to in ROOMS[room] if order.index(to) >= order.index(room)]


def test_no_file_imports_itself_in_a_circle() -> None:
    """Imports inside functions and for types count as well; a package's face counts as a file of its own."""
    modules = {
        ".".join(path.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__"): path
        for path in (ROOT / "gen").rglob("*.py")
    }
    arrows: dict[str, set[str]] = {}
    for module, path in modules.items():
        arrows[module] = set()
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Import):
                arrows[module] |= {entry.name for entry in node.names if entry.name in modules}
            elif isinstance(node, ast.ImportFrom) and node.module in modules:
                full = {f"{node.module}.{entry.name}" for entry in node.names}
                arrows[module] |= {name if name in modules else node.module for name in full} - {module}
    list(TopologicalSorter(arrows).static_order())  # a CycleError names the files


def test_modules_beside_the_rooms_import_none_of_them() -> None:
    for name in BESIDE:
        assert imported(ROOT / "gen" / f"{name}.py") <= BESIDE


def test_every_path_of_the_page_exists() -> None:
    folders = {path.relative_to(ROOT).parts[0] for path in ROOT.iterdir() if path.is_dir()}
    named = [text for text in re.findall(r"`([\w./*-]+)`", PAGE) if "/" in text and text.split("/")[0] in folders]
    assert len(named) > 50
    assert not [path for path in named if not list(ROOT.glob(path.rstrip("/")))]


def test_every_file_and_name_of_the_page_exists() -> None:
    """Bare names of files are those of some file; bare names of code occur in `gen/` or the templates."""
    spans = set(re.findall(r"`([^`\n]+)`", PAGE))
    sources = [path for folder in ("gen", "templates", "tests") for path in (ROOT / folder).rglob("*.*")]
    names = {path.name.removesuffix(".j2") for path in sources}
    files = {span for span in spans if re.fullmatch(r"\w+\.(?:py|c|cpp|h|ini|html)(?:\.j2)?", span)}
    assert not [file for file in files if file.removesuffix(".j2") not in names]
    code = "\n".join(path.read_text(encoding="utf-8") for path in sources if path.suffix in (".py", ".j2", ".c"))
    words = set(re.findall(r"\w+", code))
    assert not [
        span for span in spans - files if re.fullmatch(r"\w+(?:\.\w+)?", span) and not set(span.split(".")) <= words
    ]


def test_the_word_that_the_page_follows_is_in_the_emitted_table() -> None:
    words = re.search(r"`(\{\d+UL\}, \d+L)`", PAGE)
    assert words
    row = re.search(r"^.*// 128$", (ROOT / "firmware_out/lib/my1016/src/my1016_schedule.cpp").read_text(), re.MULTILINE)
    assert row
    assert words[1] in row[0]
