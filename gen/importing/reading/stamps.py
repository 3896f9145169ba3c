"""Lines and keys that are a time and nothing else: they head what is behind them."""

from __future__ import annotations

import re

from gen.importing.clock import is_time

_LONGEST_STAMP = 60
AROUND = " -=*#<>[](){}|:"
"""What stands around a time that heads a round."""
_EPOCH = re.compile(r"1\d{9}(?:\.\d+)?|1\d{12}", re.ASCII)
"""Since 1970, in s or ms."""


def is_stamp(text: str) -> bool:
    """Whether a line or a key is a time, and nothing else.

    Parameters
    ----------
    text
        It.
    """
    plain = text.strip(AROUND)
    return len(plain) <= _LONGEST_STAMP and (is_time(plain) or bool(_EPOCH.fullmatch(plain)))
