"""The emitted C++ as a reader sees it on a computer that is no AVR: without comments, function by function."""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from pycparser import c_ast, c_parser

from gen.certificate.refuted import Refuted
from gen.errors import InputError

_FUNCTION = re.compile(r"^(?:static|extern|void)[^\n;{]*?\b(\w+)\(([^;{]*)\)\s*\{", re.M)
#: Files whose functions are read as text, by what follows the model's name.
_READ = ("_step.h", "_word.h", "_accumulator.h", "_accumulator.cpp", ".cpp")
#: Where constants live, which only the schedule's tables know of.
_FLASH = ("PROGMEM", "memcpy_P", "pgm_read_byte", "pgm_read_word", "pgm_read_dword", "pgm_read_float")
_MARK = re.compile(r"(__attribute__\(\((noinline|unused)\)\))?")
_QUALIFIERS = re.compile(
    r'\b(?:static|inline|__attribute__\(\(noinline\)\)|[A-Z0-9_]+_(?:ONE_COPY|SMALL|INLINE))\b|extern "C"'
)
_CAST = re.compile(r"static_cast<(\w+)>\(")
_TYPES = "typedef int int32_t; typedef unsigned uint32_t; typedef long long int64_t; typedef unsigned char uint8_t;"


@dataclass(frozen=True)
class Project:
    """An emitted project.

    Attributes
    ----------
    folder
        Where it is.
    model
        The C++ names' prefix.
    """

    folder: Path
    model: str

    @property
    def sources(self) -> Path:
        """The folder of the library's sources."""
        return self.folder / "lib" / self.model / "src"

    def text(self, name: str) -> str:
        """``NAME<name>`` without comments and without what only the AVR compiles.

        Raises
        ------
        InputError
            If it cannot be read.
        """
        path = self.sources / f"{self.model}{name}"
        try:
            text = path.read_text(encoding="utf-8")
        except (OSError, UnicodeDecodeError) as error:
            raise InputError(f"cannot be read: {error}", file=str(path)) from error
        return _without_avr(re.sub(r"/\*.*?\*/|//[^\n]*", "", text, flags=re.S))

    @cached_property
    def functions(self) -> dict[str, str]:
        """The functions of the recursion's files by name without the prefix, spaces made one.

        Raises
        ------
        Refuted
            If one is there twice, or a macro could make another text of one.
        """
        found: dict[str, str] = {}
        for path in sorted(self.sources.glob(f"{self.model}*")):
            text = self.text(path.name.removeprefix(self.model))
            self._check_macros(text)
            if path.name.removeprefix(self.model) not in _READ:
                continue
            for match in _FUNCTION.finditer(text + "\n"):
                name = match[1].removeprefix(f"{self.model}_")
                if name in found:
                    raise Refuted(f"the C++ has two functions {match[1]}")
                found[name] = spaced(match[0][:-1] + _braced(text, match.end() - 1))
        return found

    def check_macros(self) -> None:
        """Make sure that the text is what the compiler sees.

        Raises
        ------
        Refuted
            If a macro could make another text of it.
        """
        for path in sorted(self.sources.glob(f"{self.model}*")):
            self._check_macros(self.text(path.name.removeprefix(self.model)))

    def _check_macros(self, text: str) -> None:
        """Text is what the compiler sees only if no macro replaces a word of it."""
        for line in text.splitlines():
            words = line.split(maxsplit=2)
            if words[:1] == ["#undef"] or words[:1] == ["#pragma"]:
                raise Refuted(f"a line that the proof does not know: {line.strip()}")
            if words[:1] != ["#define"]:
                continue
            name, value = words[1], words[2] if len(words) > 2 else ""
            own = name.startswith(f"{self.model.upper()}_")
            marks = name.endswith(("_ONE_COPY", "_SMALL", "_INLINE", "_UNUSED"))
            if not (own or name.split("(")[0] in _FLASH) or (marks and not _MARK.fullmatch(value)):
                raise Refuted(f"a macro that the proof does not know: {line.strip()}")

    def parsed(self, name: str) -> c_ast.FuncDef:
        """The syntax tree of a function of the recursion.

        Raises
        ------
        Refuted
            If there is no such function, or it is not written as plain C.
        """
        if name not in self.functions:
            raise Refuted(f"the C++ has no function {self.model}_{name}")
        text = _CAST.sub(r"(\1)(", _QUALIFIERS.sub("", self.functions[name])).replace("bool ", "int ")
        kinds = {
            *re.findall(rf"\b{self.model}_(?:\w+_)?(?:State|Rates)\b", text),
            *(f"{self.model}_{k}" for k in _STRUCTS),
        }
        declared = " ".join(f"typedef struct {kind} {kind};" for kind in sorted(kinds))
        try:
            tree = c_parser.CParser().parse(f"{_TYPES} {declared} {text}")
        except Exception as error:  # the parser has exceptions of its own, by version
            raise Refuted(f"{self.model}_{name} is not written as expected: {error}") from error
        found = tree.ext[-1]
        if not isinstance(found, c_ast.FuncDef):
            raise Refuted(f"{self.model}_{name} is not written as expected")
        return found


_STRUCTS = ("Word", "Accumulator", "State", "Coefficients")


def spaced(text: str) -> str:
    """The text with one space for each run of white space."""
    return " ".join(text.split())


def _without_avr(text: str) -> str:
    """What ``#ifdef __AVR__`` leaves for every other machine; other conditions stay as they are."""
    kept: list[str] = []
    nested: list[str] = []  # "avr" or "else" of __AVR__, or "other"
    for line in text.splitlines():
        words = line.split()
        if words[:1] in (["#ifdef"], ["#ifndef"], ["#if"]):
            nested.append("avr" if words[:2] == ["#ifdef", "__AVR__"] else "other")
        elif words[:1] == ["#else"] and nested[-1] != "other":
            nested[-1] = "else"
            continue
        elif words[:1] == ["#endif"] and nested.pop() != "other":
            continue
        if "avr" not in nested and not (words[:1] == ["#ifdef"] and nested[-1] != "other"):
            kept.append(line)
    return "\n".join(kept)


def _braced(text: str, start: int) -> str:
    depth = 0
    for place in range(start, len(text)):
        depth += {"{": 1, "}": -1}.get(text[place], 0)
        if depth == 0:
            return text[start : place + 1]
    raise Refuted("a function of the C++ does not end")
