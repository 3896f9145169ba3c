"""Blocks of NULs in a text, as a card holds them where power was cut: out with the lines that they tear."""

from __future__ import annotations

import re

from gen.importing.table import Counted

_LEAST = 16
"""NULs in a row: a board that is reset sends a few, which are text in a number's field."""
_BLOCK = "\0" * _LEAST
_END = re.compile(r"(\r\n|\r|\n)")
_WORD = re.compile(r"\0+[^\W\d]")
_MOST_TORN = 0.5
"""Of what is no NUL: where more is torn, it is no text."""


def without_blocks(text: str) -> tuple[str, list[Counted]]:
    """A text without blocks of NULs and without the lines that they tear, which stay as empty ones.

    Parameters
    ----------
    text
        All of a file.

    Returns
    -------
    text, counted
        As it is, and nothing, of a text without such blocks, and of what is rather no text.
    """
    if _BLOCK not in text:
        return text, []
    lines = _END.split(text)  # and their ends between them
    blocks = [k for k in range(0, len(lines), 2) if _BLOCK in lines[k]]
    whole = blocks[0] == 0 and _WORD.match(lines[0])  # a file that begins with a block, before its header
    torn = [k for k in blocks if lines[k].strip("\0") and not (whole and k == 0)]
    if sum(len(lines[k].replace("\0", "")) for k in torn) > _MOST_TORN * (len(text) - text.count("\0")):
        return text, []
    for k in blocks:
        lines[k] = lines[k].lstrip("\0") if whole and k == 0 else ""
    counted = [
        Counted(what, len(found), f"line {found[0] // 2 + 1}")
        for what, found in (
            ("block of NULs, as where power was cut, taken out", blocks),
            ("line torn by a block of NULs, left out", torn),
        )
        if found
    ]
    return "".join(lines), counted
