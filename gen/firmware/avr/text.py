"""Inline assembly as lines of a C++ string."""

from __future__ import annotations

from dataclasses import dataclass, field

_WIDTH = 116


@dataclass
class AsmText:
    """Lines of a C++ string: a comment for each group of instructions.

    Attributes
    ----------
    prefix
        What the names of the library's macros begin with.
    lines
        What the template prints.
    """

    prefix: str = ""
    lines: list[str] = field(default_factory=list)

    def group(self, comment: str, *code: str) -> None:
        """Add instructions under a comment; either may be empty."""
        if comment:
            self.lines.append(f"        // {comment}")
        row = '        "'
        for instruction in code:
            piece = f"{instruction}\\n\\t"
            if len(row) + len(piece) > _WIDTH:
                self.lines.append(row + '"')
                row = '        "'
            row += piece
        if code:
            self.lines.append(row + '"')
