"""What identification and refinement have in common: what they tell while they work, and their report."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from pathlib import Path

Progress = Callable[[str], None]


def silent(_: str) -> None:
    """Say nothing."""


class Reported(ABC):
    """What can be written as a report."""

    @abstractmethod
    def html(self) -> str:
        """The report as one HTML page."""

    def report(self, path: Path | str) -> None:
        """Write the report.

        Raises
        ------
        InputError
            If it cannot be written.
        """
        from gen.files import write_text

        write_text(Path(path), self.html())
