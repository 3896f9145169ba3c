"""The emulator's C half: warnings, and an order of its files in which each needs only those below it."""

from __future__ import annotations

import re
import subprocess
from graphlib import TopologicalSorter
from pathlib import Path

import pytest

from gen.avr.shim import SHIM_FOLDER

Graph = dict[str, set[str]]

FLAGS = ("-std=gnu11", "-O2", "-fPIC", "-Wall", "-Wextra", "-Wmissing-prototypes", "-Werror")
_INCLUDE = re.compile(r'^\s*#\s*include\s+"([^"]+)"', re.MULTILINE)


def included() -> Graph:
    """Which files include which, a header and the source of its name taken together."""
    graph: Graph = {}
    for path in SHIM_FOLDER.glob("*.[ch]"):
        names = {Path(name).stem for name in _INCLUDE.findall(path.read_text(encoding="utf-8"))}
        graph.setdefault(path.stem, set()).update(names - {path.stem})
    return graph


@pytest.fixture(scope="module")
def objects(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    folder = tmp_path_factory.mktemp("shim")
    made = {}
    for source in SHIM_FOLDER.glob("*.c"):
        made[source.stem] = folder / f"{source.stem}.o"
        command = ["gcc", *FLAGS, "-c", str(source), "-o", str(made[source.stem])]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        assert (done.returncode, done.stderr) == (0, "")
    return made


def names(item: Path, *options: str) -> set[str]:
    done = subprocess.run(["nm", "--format=posix", *options, str(item)], capture_output=True, text=True, check=True)
    return {line.split()[0] for line in done.stdout.splitlines()}


def used(objects: dict[str, Path]) -> Graph:
    """Which files use functions and tables of which, as the linker sees it."""
    defined = {name: file for file, item in objects.items() for name in names(item, "--defined-only", "--extern-only")}
    return {
        file: {defined[name] for name in names(item, "--undefined-only") if name in defined}
        for file, item in objects.items()
    }


def test_no_file_includes_itself_by_a_detour() -> None:
    graph = included()
    assert len(graph) > 10
    assert list(TopologicalSorter(graph).static_order())[-1] == "mega"


def test_no_file_uses_what_it_does_not_include(objects: dict[str, Path]) -> None:
    """So that the order of the includes is the order of the calls: a prototype of one's own would hide a circle."""
    reach = included()
    for name in TopologicalSorter(included()).static_order():
        reach[name] |= {further for direct in reach[name] for further in reach[direct]}
    for file, needed in used(objects).items():
        assert needed <= reach[file], file


def test_mega_alone_knows_every_part() -> None:
    graph = included()
    assert [name for name, direct in graph.items() if "mega" in direct] == []
    assert {"pins", "uart", "mailbox", "max6675", "counter", "encoder", "wave", "eeprom"} <= graph["mega"]
