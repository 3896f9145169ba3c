"""A text's lines, as all readers of text have them."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Lines:
    """A text's lines.

    Parameters
    ----------
    texts
        Without their ends, comments and empty lines.
    numbers
        Of each in the file.
    comments
        The comment lines, in order, without their marks.
    """

    texts: list[str]
    numbers: list[int]
    comments: list[str]
