"""What a board has printed so far, as a page shows it: rows as numbers, alarms and sensors by name, lines as text."""

from __future__ import annotations

import math
import re
import threading
from array import array
from collections import deque
from collections.abc import Sequence
from typing import Any

import numpy as np

from gen.drawing.thinning import line
from gen.live.heat import Heat
from gen.live.known import Known
from gen.record import Recorder
from gen.reference.sensors import SensorCode
from gen.runs.run import STATUS, board_columns

Row = list[float | None]

_KEPT_LINES = 60
_EVENT = re.compile(r"#\s*event:\s*(\S+)\s+(.*)")
_GARBLED = "# garbled:"
_MODEL = "_model_degC"
DRAWN = frozenset(["time_to_limit_s", "holdable_pwm"])
"""What a board says of itself and is a curve all the same."""


class View:
    """Rows under the present header, and what stands around them. Fed by one thread, asked by others.

    Parameters
    ----------
    known
        What the coefficient file says.
    heat
        Knows the sums of its rules on missing heat, which no row holds.

    Attributes
    ----------
    recorder
        The same as a run file.
    """

    def __init__(self, known: Known, heat: Heat | None = None) -> None:
        self.known, self.heat = known, heat
        self.recorder = Recorder()
        self._lock = threading.Lock()
        self._values = array("d")  # row by row; of days of rows a list of lists would be ten times as large
        self._count, self._width = 0, 1
        self._last: dict[str, float | None] = {}
        self._sensors = ""
        self._parts = 0
        self._read = 0  # comments of the present part that were looked at
        self._notes: list[str] = []
        self._lines: deque[str] = deque(maxlen=_KEPT_LINES)
        self._numbered = 0  # lines so far

    def feed(self, data: bytes, at_s: float) -> None:
        """Take what came from the board, cut anywhere, at a time of the reader's own clock, s."""
        with self._lock:
            self.recorder.feed(data, at_s)
            self._take()

    def say(self, text: str) -> None:
        """Add a line of this program's own to those that came."""
        with self._lock:
            self._say(text)

    def note(self, key: str, value: str) -> None:
        """Write a comment into this part of the run file, and those after it: what nobody could learn from its rows."""
        with self._lock:
            self._notes.append(f"# {key}: {value}")
            if self.recorder.parts:
                self.recorder.parts[-1].comments.append(self._notes[-1])

    def text(self) -> str:
        """The present part as a run file; empty before the first header."""
        with self._lock:
            return self.recorder.parts[-1].text() if self.recorder.parts else ""

    @property
    def part(self) -> int:
        """Number of the present header's part, 1 for the first; 0 before it."""
        return self._parts

    def columns(self) -> list[str]:
        """Names of the present rows' columns, the bands' and missing heat's with them."""
        with self._lock:
            return self._columns()

    def since(self, row: int, most: int | None = None) -> list[Row]:
        """Rows of the present part from this number on, no more than `most`; None for what is missing."""
        with self._lock:
            width = self._width
            end = self._count if most is None else min(self._count, row + most)
            values = self._values[row * width : end * width]
        known = [None if math.isnan(value) else value for value in values]
        return [known[start : start + width] for start in range(0, len(known), width)]

    def history(self, most: int) -> dict[str, Any]:
        """Curves of all rows so far.

        Parameters
        ----------
        most
            No curve has more points; each stretch keeps its lowest and its highest.

        Returns
        -------
        dict
            ``part``, ``next`` (number of the first row that is not in it), ``columns``, and ``curves``: by column its
            times, s, and its values.
        """
        with self._lock:
            part, columns, rows = self._parts, self._columns(), self._count
            table = np.array(self._values, dtype=np.float64).reshape(rows, self._width)
        curves = {}
        for place, name in enumerate(columns):
            if place and name not in STATUS - DRAWN and rows:
                x, y = line(table[:, 0], table[:, place], most)
                curves[name] = [x.tolist(), [None if np.isnan(value) else value for value in y.tolist()]]
        return {"part": part, "next": rows, "columns": columns, "curves": curves}

    def last(self) -> tuple[dict[str, float | None], str]:
        """The last row by its columns, and its sensors' codes, a digit each; empty before there is one."""
        with self._lock:
            return dict(self._last), self._sensors if "sensors" in self._last else ""

    def status(self) -> dict[str, Any]:
        """What holds now: alarms, sensors, counts, the last lines."""
        with self._lock:
            last = self._last
            return {
                "alarms": _named(last.get("alarms"), self.known.rules, "rule"),
                "acts": _named(last.get("protection"), self.known.causes, "cause"),
                "flags": int(last.get("flags") or 0),
                "sensors": self._believed(),
                "rows": self.recorder.rows,
                "garbled": self.recorder.garbled + (0 if self._parts else self.recorder.unheaded),
                "restarts": sum(len(part.restarts) for part in self.recorder.parts),
                "lines": list(self._lines),
                "numbered": self._numbered,
            }

    # ---- under the lock ----

    def _take(self) -> None:
        parts = self.recorder.parts
        if not parts:
            return
        if len(parts) != self._parts:
            for new in parts[self._parts :]:
                new.comments += self._notes
            self._parts, self._read, self._count, self._last = len(parts), 0, 0, {}
            self._values, self._width = array("d"), len(self._columns())
        part = parts[-1]
        for text in part.comments[self._read :]:
            self._say(_shown(text))
        self._read = len(part.comments)
        names = part.columns
        for text in part.rows[self._count :]:
            row = self._row(names, text.split(","))
            self._values.extend(math.nan if value is None else value for value in row)
            self._last = dict(zip(names, row, strict=False))
            self._count += 1

    def _row(self, names: Sequence[str], fields: Sequence[str]) -> Row:
        row: Row = []
        for name, value in zip(names, fields, strict=True):
            if name == "sensors":
                self._sensors = value
            number = float(value) if value else math.nan
            row.append(number if math.isfinite(number) else None)
        row += [end for component in self._banded(names) for end in self._band(component, names, row)]
        return row if self.heat is None else row + self.heat.take(dict(zip(names, row, strict=False)))

    def _columns(self) -> list[str]:
        if not self.recorder.parts:
            return []
        names = self.recorder.parts[-1].columns
        heat = [rule.column for rule in self.heat.rules] if self.heat is not None else []
        return [*names, *(f"{name}_{end}" for name in self._banded(names) for end in ("low", "high")), *heat]

    def _banded(self, names: Sequence[str]) -> list[str]:
        own = [name.removesuffix(_MODEL) for name in names if name in board_columns(names) and name.endswith(_MODEL)]
        return [name for name in own if name in self.known.bands]

    def _band(self, component: str, names: Sequence[str], row: Row) -> Row:
        """Where the measured temperature of a motor is expected that is as good as those that were identified."""
        model, pwm = row[names.index(component + _MODEL)], row[names.index("pwm")]
        count = abs(int(pwm or 0))
        for first, last, low, high in self.known.bands[component]:
            if model is not None and first <= count <= last:
                return [model - high, model - low]
        return [None, None]

    def _believed(self) -> list[dict[str, str]]:
        """Each thermocouple with what the board says of its last sample."""
        found = []
        for place, digit in enumerate(self._sensors):
            channel = self.known.channels[place] if place < len(self.known.channels) else f"sensor {place + 1}"
            code = int(digit) if digit.isdigit() else int(SensorCode.UNREAD)
            found.append({"channel": channel, "state": SensorCode(code).name.lower()})
        return found

    def _say(self, text: str) -> None:
        self._lines.append(text)
        self._numbered += 1


def _named(mask: float | None, names: Sequence[str], what: str) -> list[str]:
    """What the bits of a mask stand for."""
    bits = int(mask or 0) & 0xFFFFFFFF
    return [names[bit] if bit < len(names) else f"{what} {bit + 1}" for bit in range(32) if bits >> bit & 1]


def _shown(text: str) -> str:
    """A comment line in the words of the page."""
    event = _EVENT.fullmatch(text)
    if event:
        return f"{event[1]} s: {event[2]}"
    if text.startswith(_GARBLED):
        return f"no row: {text.removeprefix(_GARBLED).strip()}"
    return text.removeprefix("#").strip()
