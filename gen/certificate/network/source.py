"""The emitted C++ of a network as syntax trees of plain C, function by function: what is compiled where no AVR is.

Only what is called is parsed, and what is not understood is refused there.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from pycparser import c_ast, c_parser

from gen.arrays import FloatArray
from gen.certificate.network.single import single
from gen.certificate.refuted import Refuted
from gen.certificate.source import Project, spaced

KINDS = {
    "int8_t": "signed char",
    "uint8_t": "unsigned char",
    "int16_t": "short",
    "uint16_t": "unsigned short",
    "int32_t": "int",
    "uint32_t": "unsigned",
    "int64_t": "long long",
    "uint64_t": "unsigned long long",
}
_FUNCTION = re.compile(r"^([A-Za-z_][\w \*&]*?[ \*])(\w+)\(([^;{}()]*)\)\s*\{", re.M)
_NOT_C = re.compile(
    r'\b(?:static|inline|extern|template\s*<\s*typename\s+\w+\s*>|[A-Z0-9_]+_(?:ONE_COPY|SMALL|UNUSED))\b|"C"'
)
#: Lines of the preprocessor that leave everything where it is; which macros there may be is another question.
_HARMLESS = re.compile(
    r"#\s*(?:include\b.*|define\b.*|endif\b.*|else\b.*|ifndef \w+|ifdef __cplusplus|if defined\(__GNUC__\))\s*"
)
_TEMPLATE = re.compile(r"template\s*<\s*typename\s+(\w+)\s*>")
_ENUM = re.compile(r"\benum\s*(?::\s*(\w+)\s*)?\{([^}]*)\}")
#: A function with a number in angle brackets takes that number first.
_NUMBERED = re.compile(r"template\s*<\s*(uint8_t\s+\w+)\s*>\s*([\w\s]*?\b\w+)\(")
_NUMBER = re.compile(r"\b(\w+)<(\d+)>\(")
_TYPEDEF = re.compile(r"\btypedef\s+(\w+)\s+(\w+)\s*;")
_TABLE = re.compile(r"^const (uint(?:8|16|32)_t|float) (\w+)\[(\d+)\] PROGMEM = \{([^}]*)\};", re.M)
_CAST = re.compile(r"static_cast<(\w+)>\(")
#: Files that are no part of a sample.
_OTHERS = ("_alarms", "_effects")


@dataclass(frozen=True)
class Table:
    """Numbers in flash.

    Attributes
    ----------
    kind
        Their type.
    values
        Exact, as float64.
    """

    kind: str
    values: FloatArray


class Unit:
    """One file of the C++ with everything that it includes.

    Parameters
    ----------
    project
        Whose.
    name
        What follows the model's name in the file's.

    Raises
    ------
    Refuted
        If a macro could make another text of it.
    """

    def __init__(self, project: Project, name: str) -> None:
        self.model = project.model
        project.check_macros()
        headers = [
            path.name.removeprefix(self.model)
            for path in sorted(project.sources.glob(f"{self.model}*.h"))
            if not path.name.removeprefix(self.model).startswith(_OTHERS)
        ]
        if (project.sources / f"{self.model}_accumulator.cpp").is_file():
            headers.append("_accumulator.cpp")  # one function, which floats are added with
        text = "\n".join(project.text(part) for part in (*headers, name))
        self._text = _NUMBER.sub(r"\1(\2, ", _NUMBERED.sub(r"\2(\1, ", text))
        self._parsed: dict[str, list[c_ast.FuncDef]] = {}
        for line in self._text.splitlines():
            if line.lstrip().startswith("#") and not _HARMLESS.fullmatch(line.strip()):
                raise Refuted(f"a line that the proof does not know: {line.strip()}")

    @property
    def text(self) -> str:
        """All of it, without comments."""
        return self._text

    @cached_property
    def constants(self) -> dict[str, tuple[int, str]]:
        """The enumerators and their types, those of the unit's own after those of its headers.

        Raises
        ------
        Refuted
            If one is there twice.
        """
        found = {"false": (0, "uint8_t"), "true": (1, "uint8_t")}
        names: set[str] = set(found)
        for kind, block in _ENUM.findall(self._text):
            following: int | None = 0
            for entry in filter(None, (part.strip() for part in block.split(","))):
                name, _, value = (part.strip() for part in entry.partition("="))
                if value:
                    digits = value.removesuffix("UL").removesuffix("u")
                    following = int(digits) if digits.isdecimal() else found.get(value, (None, ""))[0]
                if name in names:
                    raise Refuted(f"an enumerator is there twice: {name}")
                names.add(name)
                if following is not None:  # flags, in hexadecimal, are of no use here
                    found[name], following = (following, kind or "int16_t"), following + 1
        return found

    @cached_property
    def kinds(self) -> dict[str, str]:
        """What names of types stand for; an ``int`` has 16 bits on the AVR."""
        found = {**{kind: kind for kind in (*KINDS, "float")}, "int": "int16_t", "bool": "uint8_t"}
        for kind, name in _TYPEDEF.findall(self._text):
            if name in found or kind not in found:
                raise Refuted(f"a type that the proof does not know: {kind} as {name}")
            found[name] = found[kind]
        return found

    @cached_property
    def templates(self) -> set[str]:
        """Names that stand for any type."""
        return set(_TEMPLATE.findall(self._text))

    @cached_property
    def texts(self) -> dict[str, list[str]]:
        """The functions' texts by name, spaces made one; several where the name is overloaded."""
        found: dict[str, list[str]] = {}
        text = _TEMPLATE.sub("", self._text)
        for match in _FUNCTION.finditer(text):
            found.setdefault(match[2], []).append(spaced(match[0][:-1] + braced(text, match.end() - 1)))
        return found

    def functions(self, name: str) -> list[c_ast.FuncDef]:
        """The syntax trees of the functions of a name.

        Raises
        ------
        Refuted
            If there is none, or it is not written as plain C.
        """
        if name not in self._parsed:
            if name not in self.texts:
                raise Refuted(f"the C++ has no function {name}")
            self._parsed[name] = [self._tree(name, text) for text in self.texts[name]]
        return self._parsed[name]

    def _tree(self, name: str, text: str) -> c_ast.FuncDef:
        records = set(re.findall(r"\bstruct (\w+)", self._text))
        types = [f"typedef {plain} {kind};" for kind, plain in KINDS.items()]
        types += [f"typedef int {kind};" for kind in sorted({*self.kinds, *self.templates} - {*KINDS, "float", "int"})]
        types += [f"typedef struct {record} {record};" for record in sorted(records)]
        head, brace, body = text.partition("{")
        plain = _CAST.sub(r"(\1)(", f"{_NOT_C.sub('', head)}{brace}{body}")
        try:
            found = c_parser.CParser().parse(f"{' '.join(types)} {plain}").ext[-1]
        except Exception as error:  # the parser has exceptions of its own, by version
            raise Refuted(f"{name} is not written as expected: {error}") from error
        if not isinstance(found, c_ast.FuncDef):
            raise Refuted(f"{name} is not written as expected")
        return found


def tables(project: Project) -> dict[str, Table]:
    """What lies in flash, by name.

    Raises
    ------
    Refuted
        If a number is not one of its type.
    """
    found: dict[str, Table] = {}
    for kind, name, count, body in _TABLE.findall(project.text("_schedule.cpp")):
        words = [word.strip() for word in body.split(",") if word.strip()]
        if len(words) != int(count) or name in found:
            raise Refuted(f"{name} does not hold {count} numbers, or is there twice")
        values = [single(word) if kind == "float" else _whole(word, int(kind[4:-2])) for word in words]
        found[name] = Table(kind, np.array(values, dtype=np.float64))
    return found


def _whole(word: str, bits: int) -> float:
    digits = word.removesuffix("UL").removesuffix("u")
    if not digits.isdecimal() or int(digits) >= 1 << bits:
        raise Refuted(f"{word} is no number of {bits} bits")
    return float(int(digits))


def braced(text: str, start: int) -> str:
    """What stands from one brace to its own.

    Raises
    ------
    Refuted
        If there is none.
    """
    depth = 0
    for place in range(start, len(text)):
        depth += {"{": 1, "}": -1}.get(text[place], 0)
        if depth == 0:
            return text[start : place + 1]
    raise Refuted("a function of the C++ does not end")
