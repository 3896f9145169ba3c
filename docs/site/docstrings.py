"""For the reference: docstrings' roles, which Markdown does not know, and entries that share a description."""

from __future__ import annotations

import re
from typing import Any

import griffe

_ROLE = re.compile(r":(?:attr|class|data|exc|func|meth|mod):`~?([^`]+)`")
_SEVERAL = re.compile(r"^(\w+(?:, \w+)+)\n((?:    .*\n?)+)", re.MULTILINE)
"""Parameters or attributes that share a description: their names, then indented lines."""


def _each(entry: re.Match[str]) -> str:
    """An entry for each name, so that each gets its own type."""
    description = entry[2].rstrip("\n")
    return "".join(f"{name}\n{description}\n" for name in entry[1].split(", "))


class Docstrings(griffe.Extension):
    """Turns :func:`name` into `name`, and ``a, b`` with one description into two entries."""

    def on_object(self, *, obj: griffe.Object, **kwargs: Any) -> None:  # noqa: ANN401
        """Called for each object once its docstring is known."""
        if obj.docstring is not None:
            obj.docstring.value = _SEVERAL.sub(_each, _ROLE.sub(r"`\1`", obj.docstring.value))
