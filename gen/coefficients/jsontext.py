"""JSON, strictly: no duplicate keys, no NaN, no number beyond a float64; faults carry their place."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from gen.errors import InputError

Path = tuple[str | int, ...]


@dataclass(frozen=True)
class _Fault:
    """Stands in the parsed tree where a fault was found: the parser's hooks do not know the place."""

    message: str


def parse(text: str) -> Any:  # noqa: ANN401
    """Parse strictly.

    Parameters
    ----------
    text
        A JSON text; a byte order mark in front is let pass.

    Returns
    -------
    Any
        The value as Python objects.

    Raises
    ------
    InputError
        With line and column for broken syntax, with the JSON path for a duplicate key, a NaN or infinity,
        or a number that overflows.
    """
    try:
        tree = json.loads(
            text.removeprefix("\ufeff"),
            object_pairs_hook=_object,
            parse_constant=lambda name: _Fault(f"found {name}, expected a finite number"),
            parse_float=_float,
            parse_int=_int,
        )
    except json.JSONDecodeError as error:
        raise InputError(
            f"not valid JSON: {_lower_first(error.msg)}", place=f"line {error.lineno}, column {error.colno}"
        ) from error
    except RecursionError as error:
        raise InputError("not valid JSON for this tool: nested too deeply", place="$") from error
    for path, fault in _faults(tree, ()):
        raise InputError(fault.message, place=json_path(path))
    return tree


def json_path(path: Path) -> str:
    """Write a path as ``$.components[0].gain``; keys that are no identifiers in brackets."""
    parts = ["$"]
    for step in path:
        if isinstance(step, int):
            parts.append(f"[{step}]")
        elif step.isidentifier():
            parts.append(f".{step}")
        else:
            parts.append(f"[{json.dumps(step)}]")
    return "".join(parts)


def _object(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    result: dict[str, Any] = {}
    for key, value in pairs:
        twice = key in result
        result[key] = _Fault("this key appears twice in its object; expected it once") if twice else value
    return result


def _float(literal: str) -> float | _Fault:
    value = float(literal)
    if math.isinf(value):
        return _Fault(f"found {_short(literal)}, which overflows a 64-bit float; expected a finite number")
    return value


def _int(literal: str) -> int | _Fault:
    # More digits cannot be a sensible number here, and Python refuses to convert more than 4300 at all.
    if len(literal.lstrip("-")) > 308:
        return _Fault(f"found {_short(literal)}, which overflows a 64-bit float; expected a finite number")
    return int(literal)


def _short(literal: str) -> str:
    return literal if len(literal) <= 24 else f"{literal[:12]}... ({len(literal)} characters)"


def _faults(value: object, path: Path) -> Iterator[tuple[Path, _Fault]]:
    if isinstance(value, _Fault):
        yield path, value
    elif isinstance(value, dict):
        for key, item in value.items():
            yield from _faults(item, (*path, key))
    elif isinstance(value, list):
        for index, item in enumerate(value):
            yield from _faults(item, (*path, index))


def _lower_first(message: str) -> str:
    return message[:1].lower() + message[1:]
