"""What is drawn of one run: panels of curves over one axis of time, and a bar for each alarm and fault."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Literal

from gen.arrays import FloatArray

Role = Literal["measured", "model", "band", "held"]

_LONGEST = 48
_LETTERS = 17
"""Of one line of a label, along an axis of a panel of weight 1."""
_MOST_LINES = 6
"""Of a label; what is longer than these is cut."""
_UNITS = ((180.0, "s", 1.0), (7200.0, "min", 60.0), (float("inf"), "h", 3600.0))
"""Up to which length of a run, s: the axis's unit, and how many seconds it has."""


@dataclass(frozen=True, eq=False)
class Curve:
    """One quantity over time, with all its values.

    Attributes
    ----------
    name
        For people: a part's name, or a column's.
    role
        ``measured``, ``model``, ``band`` (a rule's threshold) or ``held`` (PWM, until the next row).
    colour
        Place in the palette; parts have one each, in all panels. None: ink.
    values
        Shape (N,), NaN where there is none.
    """

    name: str
    role: Role
    colour: int | None
    values: FloatArray

    @property
    def is_held(self) -> bool:
        """Whether a value holds until the next row."""
        return self.role in ("band", "held")


@dataclass(frozen=True)
class Panel:
    """Curves over one vertical axis.

    Attributes
    ----------
    label
        Of the axis, with the unit.
    curves
        The last one on top.
    weight
        Its height, relative to the others'.
    zero
        Whether a line marks zero.
    """

    label: str
    curves: tuple[Curve, ...]
    weight: float
    zero: bool = False

    @property
    def label_lines(self) -> tuple[str, ...]:
        """The label in as many lines as its axis needs: parted at spaces and after underscores, else anywhere."""
        most = int(self.weight * _LETTERS)
        made = [""]
        for piece in re.findall(r"[^\s_]+_*\s*|[\s_]+", self.label):
            if made[-1] and len(made[-1]) + len(piece.rstrip()) > most:
                made.append("")
            made[-1] += piece
            while len(made[-1].rstrip()) > most:
                made[-1:] = [made[-1][:most], made[-1][most:]]
        lines = [line.strip() for line in made]
        if len(lines) > _MOST_LINES:
            lines[_MOST_LINES - 1 :] = [f"{lines[_MOST_LINES - 1][: most - 1]}…"]
        return tuple(lines)


@dataclass(frozen=True)
class Bar:
    """A stretch of time with a name: an alarm or a fault.

    Attributes
    ----------
    name
        What it is; bars of one name share a row.
    kind
        ``recorded`` by the board, ``derived`` from the file's rules, or a declared ``fault``.
    from_s, to_s
        Times of the run, s.
    """

    name: str
    kind: Literal["recorded", "derived", "fault"]
    from_s: float
    to_s: float


@dataclass(frozen=True, eq=False)
class Section:
    """One run.

    Attributes
    ----------
    title
        The run's name.
    notes
        Sentences on what is shown and what is missing.
    time_s
        Shape (N,), of all curves.
    panels
        From the top down.
    bars
        In the order of their rows.
    parts
        Name and place in the palette of everything that has a colour of its own, for the legend.
    """

    title: str
    notes: tuple[str, ...]
    time_s: FloatArray
    panels: tuple[Panel, ...]
    bars: tuple[Bar, ...]
    parts: tuple[tuple[str, int], ...]

    @property
    def unit(self) -> tuple[str, float]:
        """Unit of the axis of time, and how many seconds it has."""
        length_s = float(self.time_s[-1] - self.time_s[0])
        return next((unit, seconds) for most_s, unit, seconds in _UNITS if length_s <= most_s)

    @property
    def rows(self) -> tuple[str, ...]:
        """Names of the bars' rows, in order."""
        return tuple(dict.fromkeys(bar.name for bar in self.bars))


def shown(text: str) -> str:
    """A name from a file as it can be shown anywhere: of one line, without control characters, not too long."""
    plain = "".join(c if c.isprintable() else "\N{REPLACEMENT CHARACTER}" for c in text)
    return plain if len(plain) <= _LONGEST else f"{plain[: _LONGEST - 1]}…"
