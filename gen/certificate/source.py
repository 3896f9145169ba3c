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
_FLASH = {
    "PROGMEM": "",
    "memcpy_P": "memcpy",
    **{f"pgm_read_{kind}(address)": "(*(address))" for kind in ("byte", "word", "dword", "float")},
}
_MARKS = ("_ONE_COPY", "_SMALL", "_INLINE", "_UNUSED")
_MARK = re.compile(r"(__attribute__\(\((noinline|unused)\)\))?")
#: A comment, or what is none although it holds the signs of one.
_TOKEN = re.compile(r"""/\*.*?\*/|//[^\n]*|"(?:\\.|[^"\\\n])*"|'(?:\\.|[^'\\\n])*'""", re.S)
_GOES_ON = re.compile(r"\\[ \t\r\f\v]*(?:\n|$)")
#: Where text in quotes has become "": a raw one begins, an escape or the end of a line that goes on stands outside of
#: it, or signs that stand for # [ ] { }.
_OTHERWISE = re.compile(r'(?<!\w)(?:u8|[uUL])?R""|\\|<%|%>|<:|:>|%:|\b_Pragma\b')
#: Files of the system that the library's sources take in: none of them has a name of the library's.
_SYSTEM = ("<stdint.h>", "<string.h>", "<math.h>", "<avr/pgmspace.h>")
#: Own macros that are numbers.
_NUMBERS = ("_SAMPLE_MS", "_FORECAST_AT_ONCE", "_FORECAST_STEPS")
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
        Refuted
            If the compiler could see other lines, or another end of a comment.
        """
        path = self.sources / f"{self.model}{name}"
        try:
            text = path.read_bytes().decode("utf-8").replace("\r\n", "\n")
        except (OSError, UnicodeDecodeError) as error:
            raise InputError(f"cannot be read: {error}", file=str(path)) from error
        whole = _TOKEN.sub(_uncommented, text)
        if "\r" in text or re.search(r"[^\n\t -~]", _TOKEN.sub('""', whole)):
            raise Refuted(f"what ends a line in {path.name} is not the same for every reader")
        if re.search(r"\\[ \t]*\n\s*#", whole):
            raise Refuted(f"a line of the preprocessor in {path.name} belongs to the line before")
        plain = _without_avr(whole)
        if (found := _OTHERWISE.search(_TOKEN.sub('""', plain))) is not None:
            raise Refuted(f"the compiler reads {path.name} otherwise than it is written: {found[0]}")
        return plain

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
            self._check_macros(path.name, text)
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
            self._check_macros(path.name, self.text(path.name.removeprefix(self.model)))

    def _check_macros(self, file: str, text: str) -> None:
        """Text is what the compiler sees only if no macro replaces a word of it, and nothing else is taken in."""
        guard = file.removeprefix(self.model).upper().replace(".", "_")
        for line in text.splitlines():
            words = re.sub(r"#\s+", "#", line.strip()).split(maxsplit=2)
            if words[:1] == ["#include"]:
                own = re.fullmatch(rf'"({self.model}\w*\.h)"', " ".join(words[1:]))
                if not (own and (self.sources / own[1]).is_file()) and " ".join(words[1:]) not in _SYSTEM:
                    raise Refuted(f"a file that the proof does not know: {line.strip()}")
            elif words[:1] in (["#undef"], ["#pragma"]):
                raise Refuted(f"a line that the proof does not know: {line.strip()}")
            elif words[:1] == ["#define"]:
                name, value = words[1], words[2] if len(words) > 2 else ""
                own_name = name.removeprefix(self.model.upper()) if name.startswith(f"{self.model.upper()}_") else ""
                known = _FLASH.get(name) == value or (own_name == guard and not value)
                known = known or (own_name in _MARKS and _MARK.fullmatch(value) is not None)
                known = known or (own_name in _NUMBERS and re.fullmatch(r"\d+[UuLl]*", value) is not None)
                if not known:
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


def _uncommented(token: re.Match[str]) -> str:
    """Nothing of a comment, unless the compiler might end it elsewhere; all of text in quotes."""
    if not token[0].startswith("/"):
        return token[0]
    if _GOES_ON.search(token[0]):
        raise Refuted(f"a comment that may go on or end elsewhere: {token[0].strip()}")
    return ""


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
