"""The plan of the house lasts: which room of `gen/` may know which, and no circle of files anywhere."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from graphlib import TopologicalSorter
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]

#: Modules of no room: what is needed everywhere and knows nothing of motors.
BASE = {"errors", "files", "progress", "templating", "toolchain"}

_LOWERING = {"lowering.kinds", "lowering.recursion", "lowering.fixed", "lowering.float32", "lowering.onboard"}
_BOARD = {"lowering", "lowering.effects", *_LOWERING}
_MODEL = {"model", "model.effects"}

#: Room -> rooms that it may import from, beside BASE; from the ground floor up.
ALLOWED: dict[str, set[str]] = {
    "model": set(),
    "model.effects": {"model"},
    "model.effects.catalogue": _MODEL,
    "runs": set(),
    "pages": set(),
    "avr": set(),
    "coefficients": _MODEL,
    "lowering.kinds": set(),
    "lowering.recursion": {"model"},
    "lowering.fixed": {"lowering.kinds", "lowering.recursion", "model"},
    "lowering.float32": {"lowering.kinds", "lowering.recursion", "model"},
    "lowering.onboard": {"lowering.kinds", "lowering.recursion", "lowering.fixed", "model"},
    "lowering.effects": {*_LOWERING, "coefficients", *_MODEL},
    "lowering": {*_LOWERING, "lowering.effects", "coefficients", "model"},
    "record": {"runs"},
    "rig": {"runs"},
    "reference": {*_BOARD, "coefficients", "runs", *_MODEL},
    "thresholds": {"lowering", "reference", "coefficients", "runs"},
    "identification": {"coefficients", "pages", "runs", "model"},
    "refinement": {"coefficients", "pages", "runs", *_MODEL},
    "firmware": {*_BOARD, "reference", "coefficients", "pages", "model"},
    "verification": {*_BOARD, "firmware", "avr", "reference", "coefficients", *_MODEL},
    "emulate": {*_BOARD, "firmware", "avr", "rig", "record", "reference", "coefficients", "runs"},
}
#: These stand above every room: they only put rooms together.
ROOF = {"commands", "cli", "__main__"}


def _modules() -> dict[str, Path]:
    """Every module of the package by its dotted name."""
    found = {}
    for path in sorted((ROOT / "gen").rglob("*.py")):
        name = ".".join(path.relative_to(ROOT).with_suffix("").parts)
        found[name.removesuffix(".__init__")] = path
    return found


def _imports(path: Path, modules: dict[str, Path]) -> Iterator[str]:
    """The package's modules that a file imports, inside functions and for types as well."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names if alias.name in modules)
        elif isinstance(node, ast.ImportFrom) and node.module in modules:
            for alias in node.names:
                full = f"{node.module}.{alias.name}"
                yield full if full in modules else node.module


def _room(module: str) -> str:
    """The room that a module belongs to: the longest name of a room that it begins with."""
    name = module.removeprefix("gen").removeprefix(".")
    rooms = [room for room in (*ALLOWED, *ROOF, *BASE) if name == room or name.startswith(f"{room}.")]
    return max(rooms, key=len, default=name)


MODULES = _modules()


def test_every_module_stands_in_a_room_of_the_plan() -> None:
    assert {_room(module) for module in MODULES} == {*ALLOWED, *ROOF, *BASE, ""}


def test_the_plan_runs_downwards() -> None:
    list(TopologicalSorter(ALLOWED).static_order())


@pytest.mark.parametrize("room", ALLOWED)
def test_a_room_imports_only_from_rooms_below_it(room: str) -> None:
    for module, path in MODULES.items():
        if _room(module) != room:
            continue
        for imported in _imports(path, MODULES):
            other = _room(imported)
            assert other in {room, "", *BASE, *ALLOWED[room]}, f"{module} imports {imported}"


@pytest.mark.parametrize("room", sorted(ALLOWED))
def test_every_arrow_of_the_plan_is_used(room: str) -> None:
    used = {
        _room(other) for module, path in MODULES.items() if _room(module) == room for other in _imports(path, MODULES)
    }
    assert ALLOWED[room] <= used, "an arrow that nothing needs"


def test_what_is_below_all_rooms_knows_none() -> None:
    for module, path in MODULES.items():
        if _room(module) in BASE:
            assert {_room(other) for other in _imports(path, MODULES)} <= BASE, module


def test_no_file_imports_itself_in_a_circle() -> None:
    arrows = {module: set(_imports(path, MODULES)) - {module} for module, path in MODULES.items()}
    list(TopologicalSorter(arrows).static_order())
