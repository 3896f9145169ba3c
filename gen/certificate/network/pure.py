"""That functions which are run on their inputs give the same whatever was called before: they read no variable."""

from __future__ import annotations

import re
from collections.abc import Iterable

from gen.certificate.network.source import KINDS, Unit
from gen.certificate.refuted import Refuted

#: Words that stand before a parenthesis and call nothing, and what reads constants in flash.
_NO_CALLS = {"if", "for", "while", "switch", "return", "sizeof", "memcpy_P", "INT32_C", "UINT32_C", "INT64_C", *KINDS}
_FLASH = re.compile(r"pgm_read_(?:byte|word|dword|float)")
_CALL = re.compile(r"\b(\w+)\s*\(")
_CAST = re.compile(r"\bstatic_cast<\w+>\(")
_NO_VARIABLE = ("typedef", "struct", "enum", "template", "using", "static_assert", "#")
_NAME = re.compile(r"(\w+)\s*(?:\[[^\]]*\]\s*)*(?:PROGMEM\s*)?(?:=|$)")


def check_pure(unit: Unit, names: Iterable[str]) -> None:
    """Make sure that functions, and all that they call, depend on what they are called with alone.

    Parameters
    ----------
    unit
        The file that they are in.
    names
        Of the functions; one that is not there is no matter of this.

    Raises
    ------
    Refuted
        If one names a variable of the file, keeps one of its own, or calls what is not in the file.
    """
    changing = _variables(unit.text)
    seen: set[str] = set()
    left = [name for name in names if name in unit.texts]
    while left:
        name = left.pop()
        if name in seen:
            continue
        seen.add(name)
        for text in unit.texts[name]:
            body = _CAST.sub("(", text[text.index("{") :])
            words = set(re.findall(r"\w+", body))
            if words & (changing | {"static", "asm", "__asm__", "volatile", "goto"}):
                raise Refuted(f"{name} depends on more than what it is called with")
            for called in _CALL.findall(body):
                if called in unit.texts:
                    left.append(called)
                elif called not in _NO_CALLS and not _FLASH.fullmatch(called):
                    raise Refuted(f"{name} calls {called}, which the proof does not know")


def _variables(text: str) -> set[str]:
    """Names of a file's variables that are no constants."""
    found: set[str] = set()
    for statement in _outside(text.replace('extern "C" {', " ")).split(";"):
        plain = " ".join(line for line in statement.splitlines() if not line.lstrip().startswith("#")).strip()
        plain = re.sub(r'^(?:(?:extern|static|inline|"C")\s+)*', "", plain)
        if not plain or plain.startswith((*_NO_VARIABLE, "const ")) or "(" in plain.split("=")[0]:
            continue
        name = _NAME.search(plain)
        if name is None:
            raise Refuted(f"a line that the proof does not know: {plain}")
        found.add(name[1])
    return found


def _outside(text: str) -> str:
    """What stands outside of all braces; where a function's ended a statement ends."""
    kept, depth = [], 0
    for character in text:
        depth = max(0, depth + {"{": 1, "}": -1}.get(character, 0))
        if depth == 0:
            kept.append(";" if character == "}" else character)
    return "".join(kept)
