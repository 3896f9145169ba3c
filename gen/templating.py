"""The one Jinja environment: where the templates lie, and how they are filled."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import Literal

from jinja2 import Environment, FileSystemLoader, StrictUndefined

Room = Literal["project", "pages", "harness"]


def folder(room: Room) -> Path:
    """A room of the templates: beside the package in a checkout, inside it where a wheel is installed."""
    package = Path(__file__).parent
    installed = package / "templates"
    return (installed if installed.is_dir() else package.parent / "templates") / room


@cache
def environment(room: Room, *, own_line_breaks: bool = False) -> Environment:
    """The environment of a room, in which a name that the context lacks is an error; pages escape what they show.

    Parameters
    ----------
    room
        ``project`` (the emitted tree), ``pages`` (HTML) or ``harness`` (what `gen verify` compiles).
    own_line_breaks
        For templates that control every line break themselves, with ``{%-`` and ``-%}``.
    """
    return Environment(
        loader=FileSystemLoader(folder(room)),
        undefined=StrictUndefined,
        trim_blocks=not own_line_breaks,
        keep_trailing_newline=room != "pages",
        autoescape=room == "pages",
    )
