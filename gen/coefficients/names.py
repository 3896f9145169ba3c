"""Which names may become identifiers in the generated C++."""

from __future__ import annotations

import json
import re
from functools import cache
from importlib import resources

MAX_LENGTH = 24
NAME_PATTERN = "^[A-Za-z][A-Za-z0-9_]{0,23}$"


@cache
def reserved(kind: str) -> frozenset[str]:
    """Give the names that C++ or the headers have taken.

    Parameters
    ----------
    kind
        "keywords" (C++11 and GNU), "macros" (all of Arduino.h and the ATmega2560's headers that could be
        a name here), "taken" (functions, objects and types of the Arduino core and the C library, our own) or "library"
        (in small letters what the emitted library calls its own constants, behind the model's name: so does it call its
        components).
    """
    text = resources.files("gen").joinpath("schema/reserved-names.json").read_text(encoding="utf-8")
    return frozenset(json.loads(text)[kind])


def component_name_fault(name: str) -> str | None:
    """Say why a name that may be a model's or an alarm's cannot be a component's, or give None."""
    if name.lower() in reserved("library"):
        return f'"{name}" is what the emitted library calls a constant of its own; expected another name'
    return None


def name_fault(name: str) -> str | None:
    """Say why a name cannot be used, or give None.

    Parameters
    ----------
    name
        The name of a model, component or alarm.
    """
    rule = f"a letter, then letters, digits or underscores, at most {MAX_LENGTH} characters"
    if len(name) > MAX_LENGTH:
        return f'the name "{name[:MAX_LENGTH]}..." has {len(name)} characters; expected {rule}'
    if not re.fullmatch(NAME_PATTERN, name, re.ASCII) or name.endswith("\n"):
        return f"{json.dumps(name)} is not a C identifier; expected {rule}"
    if "__" in name:
        return f'"{name}" holds two underscores in a row, which C++ reserves; expected another name'
    if name in reserved("keywords"):
        return f'"{name}" is a keyword of C++; expected another name'
    if name in reserved("macros"):
        return f'"{name}" is a macro of the AVR or Arduino headers; expected another name'
    if name.lower() == "ambient":
        return f'"{name}" is reserved for the ambient temperature; expected another name'
    if name in reserved("taken"):
        return f'"{name}" is a name of the Arduino core, the C library or this tool; expected another name'
    return None
