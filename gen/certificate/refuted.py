"""What a failed check raises."""

from __future__ import annotations

from gen.errors import CheckFailed


class Refuted(CheckFailed):
    """A claim does not follow: the message says which step of the proof fails, and where."""
