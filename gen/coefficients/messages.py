"""From pydantic's list of errors to the one message that a person needs."""

from __future__ import annotations

import difflib
import json
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any

from pydantic import ValidationError
from pydantic_core import ErrorDetails

from gen.coefficients import alarms, network, schedule
from gen.coefficients.base import listed
from gen.coefficients.jsontext import Path, json_path
from gen.errors import InputError

_TYPES = {
    "float_type": "a number",
    "int_type": "a whole number",
    "int_from_float": "a whole number",
    "string_type": "text in quotes",
    "tuple_type": "a list [...]",
    "list_type": "a list [...]",
    "dict_type": "an object {...}",
    "model_type": "an object {...}",
    "model_attributes_type": "an object {...}",
    "bool_type": "true or false",
}

_LIMITS: dict[str, Callable[[dict[str, Any]], str]] = {
    "greater_than": lambda c: f"a number over {c['gt']:g}",
    "greater_than_equal": lambda c: f"at least {c['ge']:g}",
    "less_than": lambda c: f"a number under {c['lt']:g}",
    "less_than_equal": lambda c: f"at most {c['le']:g}",
    "finite_number": lambda c: "a finite number",
    "literal_error": lambda c: str(c["expected"]).replace("'", '"'),
    "string_pattern_mismatch": lambda c: f"text of the pattern {c['pattern']}",
    "string_too_long": lambda c: f"at most {c['max_length']} characters",
}


def first_fault(error: ValidationError) -> InputError:
    """Turn the first error into an InputError with its JSON path.

    Parameters
    ----------
    error
        What pydantic raised.
    """
    message, path = explained(error)
    return InputError(message, place=json_path(path))


@contextmanager
def building() -> Iterator[None]:
    """Say of a document that is built in Python what is wrong with it, as reading it would.

    Raises
    ------
    InputError
        Its place begins with the part that was being built ("ErrorBand.pwm"), or is the JSON path of the whole.
    """
    try:
        yield
    except ValidationError as error:
        fault = first_fault(error)
        place = (fault.place or "$").removeprefix("$")
        root = "$" if error.title == "Document" else error.title
        raise InputError(fault.message, place=root + place) from error


def explained(error: ValidationError) -> tuple[str, Path]:
    """Say of the first error what was found and what was expected, and where.

    Parameters
    ----------
    error
        What pydantic raised.
    """
    details = error.errors(include_url=False)
    first = details[0]
    path = [step for step in first["loc"] if not (isinstance(step, str) and step.startswith("tag:"))]
    context: dict[str, Any] = dict(first.get("ctx") or {})
    kind = first["type"]
    if kind == "gen":
        return str(context["message"]), (*path, *context["at"])
    if kind == "missing" and isinstance(path[-1], int):
        expected = 1 + max(int(d["loc"][-1]) for d in details if d["loc"][:-1] == first["loc"][:-1])
        found = len(first["input"])
        return f"found {_entries(found)}, expected {expected}", tuple(path[:-1])
    if kind == "missing":
        return f'missing key "{path[-1]}"', tuple(path[:-1])
    return _message(first, context), tuple(path)


def _message(first: ErrorDetails, context: dict[str, Any]) -> str:
    kind, value = first["type"], first["input"]
    if kind == "schedule":
        return _of_a_kind(value, "a schedule", schedule.KINDS)
    if kind == "curve":
        return _of_a_kind(value, "a curve", network.CURVES)
    if kind == "alarm":
        return _alarm(value)
    if kind == "value_error":
        return str(context["error"])
    if kind in ("too_short", "too_long"):
        limit = f"at least {context['min_length']}" if kind == "too_short" else f"at most {context['max_length']}"
        return f"found {_entries(len(value))}, expected {limit}"
    if kind in _TYPES:
        return f"found {described(value)}, expected {_TYPES[kind]}"
    if kind in _LIMITS:
        return f"found {described(value)}, expected {_LIMITS[kind](context)}"
    return f"found {described(value)}: {first['msg']}"


def _of_a_kind(value: object, what: str, kinds: Sequence[str]) -> str:
    expected = f"{what} with exactly one of the keys {listed(list(kinds))}"
    if not isinstance(value, dict):
        return f"found {described(value)}, expected {expected}"
    keys = listed([str(key) for key in value], "and") if value else "no key"
    near = difflib.get_close_matches(str(next(iter(value), "")), kinds, n=1)
    hint = f'; did you mean "{near[0]}"?' if len(value) == 1 and near else ""
    return f"found {keys}, expected {expected}{hint}"


def _alarm(value: object) -> str:
    if not isinstance(value, dict):
        return f"found {described(value)}, expected an alarm rule {{...}}"
    if "kind" not in value:
        return f'missing key "kind"; expected {listed(list(alarms.KINDS))}'
    return f"found the kind {described(value['kind'])}, expected {listed(list(alarms.KINDS))}"


def _entries(count: int) -> str:
    return "1 entry" if count == 1 else f"{count} entries"


def described(value: object) -> str:
    """Describe a JSON value in a few words."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if value is None:
        return "null"
    if isinstance(value, str):
        text = json.dumps(value, ensure_ascii=False)
        return "the text " + (text if len(text) <= 40 else f'{text[:36]}..."')
    if isinstance(value, (int, float)):
        return f"{value}"
    if isinstance(value, dict):
        return "an object"
    return f"a list of {len(value)}" if isinstance(value, (list, tuple)) else type(value).__name__
