"""Defects of the emitted C++: changes of one sign, number or statement in the text of a template."""

from __future__ import annotations

import re
from collections.abc import Callable
from functools import partial
from pathlib import Path

from benchmarks.mutants.defects import Mutant, changed

FOLDERS = ("templates/project/lib", "templates/project/src", "templates/harness")
SIGNS: tuple[tuple[str, str, str], ...] = (
    ("< to <=", r" < ", " <= "),
    ("<= to <", r" <= ", " < "),
    ("> to >=", r" > ", " >= "),
    (">= to >", r" >= ", " > "),
    ("== to !=", r" == ", " != "),
    ("!= to ==", r" != ", " == "),
    ("&& to ||", r" && ", " || "),
    ("|| to &&", r" \|\| ", " && "),
    ("+ to -", r" \+ ", " - "),
    ("- to +", r" - ", " + "),
    ("* to +", r" \* (?![a-z]+\b[^;]*\{)", " + "),
    ("/ to *", r" / ", " * "),
    ("<< to >>", r" << ", " >> "),
    (">> to <<", r" >> ", " << "),
    ("& to |", r" & ", " | "),
    ("| to &", r" \| ", " & "),
    ("+= to -=", r" \+= ", " -= "),
    ("|= to =", r" \|= ", " = "),
    ("&= to =", r" &= ", " = "),
    ("++ to --", r"\+\+(?=\w)", "--"),
    ("-- to ++", r"--(?=\w)", "++"),
    ("true to false", r"\btrue\b", "false"),
    ("false to true", r"\bfalse\b", "true"),
    ("not left out", r"(?<=[( ])!(?=\w)", ""),
)
_NUMBER = re.compile(r"(?<![\w.#])(\d+)(?=[uUlL]*\b)(?!\.)")
_STATEMENT = re.compile(
    r"^\s+[\w.>:\-\[\]]+(\([^{}]*\)| [|&+\-]?= [^{}]+|\+\+|--);\s*(//.*)?$|^\s+(\+\+|--)[\w.>\-]+;$"
)
_HIDDEN = re.compile(r"\{\{.*?\}\}|\{%.*?%\}|\{#.*?#\}|//.*$|/\*.*?\*/|\"(?:\\.|[^\"\\])*\"|'(?:\\.|[^'\\])*'|^\s*#.*$")


def templates(root: Path) -> list[Path]:
    """The templates of C++."""
    return [file for folder in FOLDERS for file in sorted((root / folder).rglob("*.j2"))]


def mutants_of(path: Path, root: Path) -> list[Callable[[], Mutant | None]]:
    """All mutants of a template outside comments, texts and what Jinja fills in."""
    text = path.read_text(encoding="utf-8")
    name = path.relative_to(root).as_posix()
    lines = text.splitlines(keepends=True)

    def make(at: int, kind: str, line: str) -> Mutant | None:
        return changed(name, kind, text, "".join([*lines[:at], line, *lines[at + 1 :]]))

    return [partial(make, at, *change) for at, line in enumerate(lines) for change in _changes(line)]


def _changes(line: str) -> list[tuple[str, str]]:
    # what is hidden keeps its length, so that places in it are places in the line
    code = _HIDDEN.sub(lambda found: "\0" * len(found.group()), line.rstrip("\n"))
    made = []
    for kind, sign, other in SIGNS:
        made += [(kind, line[: m.start()] + other + line[m.end() :]) for m in re.finditer(sign, code)]
    for found in _NUMBER.finditer(code):
        number = int(found.group(1))
        made.append((f"{number} to {number + 1}", line[: found.start()] + str(number + 1) + line[found.end() :]))
    if _STATEMENT.match(line) and "\0" not in code.split(";")[0][:1]:
        indentation = line[: len(line) - len(line.lstrip())]
        made.append(("statement left out", f"{indentation};\n"))
    return made
