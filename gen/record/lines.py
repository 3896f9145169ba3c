"""From the bytes of a serial line to run files: header, rows, comments, and what came through garbled.

A board prints comment lines, a header and rows, and comment lines (events) between the rows. A run file has all its
comments first; so the rows are kept as they came, byte for byte, and the comments move to the front. When the board
starts again in mid-run it prints its header again and its time starts at 0: the recording goes on in the same file,
with the board's time shifted to the recorder's clock, and says so in a comment. Only a header with other columns
(another firmware) begins a new part, which is a file of its own.

A time that was damaged on the line may still read as a time, and one that is too late would make garbled lines of all
the rows after it, since the board's time only rises. So a row that the recorder's own clock does not allow yet is held
back until the next row agrees with it, as after a true jump of the board's clock, or comes before it.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, field

from gen.runs.head import NUMBER

_NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_]*", re.ASCII)
_EVENT = re.compile(r"#\s*event:\s*(\d+(?:\.\d+)?)\s+(.*)", re.ASCII)
_LONGEST_LINE = 4096
_KEPT_GARBLED = 100
_FULL_PWM = 255
_SLACK_S = 1.0
"""A row may be ahead of the recorder's clock by so much: what a damaged time that is let through costs in rows."""
_UNEVEN = 2.0
"""And by so many times what the row before was ahead: an emulated board may run many times faster than the clock."""


@dataclass
class Part:
    """Rows under one header.

    Parameters
    ----------
    columns
        The header's names.
    comments
        Comment lines, each with its ``#``, in the order in which they came.
    rows
        Row lines without their line ends. They stand as the board printed them, but for the time after a restart.
    restarts
        Time in this file, s, at which the board's time 0 lies, for each restart.
    garbled
        Lines that were no row, comment or header.
    """

    columns: tuple[str, ...]
    comments: list[str] = field(default_factory=list)
    rows: list[str] = field(default_factory=list)
    restarts: list[float] = field(default_factory=list)
    garbled: int = 0

    def text(self) -> str:
        """The part as a run file."""
        notes = [f"# garbled_lines: {self.garbled}"] if self.garbled else []
        lines = [*self.comments, *notes, ",".join(self.columns), *self.rows]
        return "".join(f"{line}\n" for line in lines)


@dataclass(frozen=True)
class _Row:
    """A row as printed, its fields, its time in the file, and when it came by the recorder's clock."""

    text: str
    fields: tuple[str, ...]
    time_s: float
    at_s: float


class Recorder:
    """Sorts what a board prints; feed it bytes as they come.

    Attributes
    ----------
    parts
        What has been recorded, a `Part` for each set of columns.
    unheaded
        Lines that came before any header and so could not be understood.
    headers
        Headers seen.
    """

    def __init__(self) -> None:
        self.parts: list[Part] = []
        self.unheaded = 0
        self.headers = 0
        self._open = b""
        self._skipping = False
        self._pending: list[str] = []  # comments since the last row or header
        self._shift_s: float | None = None  # from the board's time to the file's; None: not restarted
        self._header_at_s: float | None = None  # recorder's clock, since the last row
        self._last_s = 0.0  # the last row's time in the file
        self._last_at_s = 0.0  # and by the recorder's clock
        self._begin = (0.0, 0.0)  # a time in the file, and the recorder's clock then: the last row's, or the header's
        self._ahead_s = 0.0  # how much the last row's time had gained on the recorder's clock
        self._held: _Row | None = None  # a row that is ahead of the recorder's clock

    @property
    def rows(self) -> int:
        """Rows recorded, over all parts."""
        return sum(len(part.rows) for part in self.parts)

    @property
    def garbled(self) -> int:
        """Garbled lines, over all parts."""
        return sum(part.garbled for part in self.parts)

    def feed(self, data: bytes, at_s: float) -> None:
        """Take bytes.

        Parameters
        ----------
        data
            What came, cut anywhere.
        at_s
            When, by the recorder's own clock, s; it bridges the board's restarts.
        """
        *lines, self._open = (self._open + data).split(b"\n")
        if len(self._open) > _LONGEST_LINE:
            lines.append(self._open)
            self._open, self._skipping = b"", True
            self._line(lines.pop(), at_s)
        for line in lines:
            if self._skipping:  # the rest of a line that was too long
                self._skipping = False
                continue
            self._line(line, at_s)

    def finish(self) -> None:
        """Take what came last: a line without its end may be cut short, so that it does not count as a row."""
        self._open = b""
        self._settle()
        self._keep_pending(header=False)

    # ---- lines ----

    def _line(self, raw: bytes, at_s: float) -> None:
        raw = raw.rstrip(b"\r")
        if not raw.strip():
            return
        try:
            text = raw.decode("ascii")
        except UnicodeDecodeError:
            text = ""
        if not text.isprintable():
            text = ""
        fields = tuple(text.split(","))
        if fields[:2] == ("time_s", "pwm") and len(set(fields)) == len(fields) and all(map(_NAME.fullmatch, fields)):
            self._header(fields, at_s)
        elif text.startswith("#"):
            self._pending.append(text)
            if self.parts and self._header_at_s is None and _EVENT.fullmatch(text):
                self._keep_pending(header=False)
        elif not self.parts:
            self.unheaded += 1
        elif text and self._is_row(fields):
            self._row(text, fields, at_s)
        else:
            self._garbled(raw)

    def _header(self, columns: tuple[str, ...], at_s: float) -> None:
        self.headers += 1
        self._settle()
        if not self.parts or self.parts[-1].columns != columns:
            pending, self._pending = self._pending, []
            self.parts.append(Part(columns, comments=pending))
            self._shift_s = None
            self._begin, self._ahead_s = (0.0, at_s), 0.0
        elif not self.parts[-1].rows:
            self._keep_pending(header=False)
            self._begin = (0.0, at_s)
        elif any(re.match(r"#\s*reset\s*:", line) for line in self._pending):
            self._restart(at_s)
        else:
            self._keep_pending(header=False)  # perhaps asked for: the next row's time will tell
        self._header_at_s = at_s

    def _restart(self, header_at_s: float) -> None:
        """Let the board's time go on from the recorder's clock; its 0 is about when the board prints its header."""
        self._settle()
        passed = max(header_at_s - self._last_at_s, 0.001)
        self._shift_s = round(self._last_s + passed, 3)
        self._begin, self._ahead_s = (self._shift_s, header_at_s), 0.0
        self.parts[-1].restarts.append(self._shift_s)
        self.parts[-1].comments.append(f"# restart: {self._shift_s:.3f} s is the board's new time 0")
        self._keep_pending(header=True)

    def _keep_pending(self, *, header: bool) -> None:
        """Move the comments that wait for their place into the part."""
        if not self.parts:
            return
        part = self.parts[-1]
        for line in self._pending:
            event = _EVENT.fullmatch(line)
            if event and self._shift_s is not None:
                line = f"# event: {float(event[1]) + self._shift_s:.3f} {event[2]}"
            elif header and not event:
                if line in part.comments:
                    continue
                line = f"# after_restart: {line.removeprefix('#').strip()}"
            elif not event and line in part.comments:
                continue
            part.comments.append(line)
        self._pending.clear()

    def _is_row(self, fields: tuple[str, ...]) -> bool:
        if len(fields) != len(self.parts[-1].columns):
            return False
        time_s, pwm = fields[:2]
        whole = re.fullmatch(r"-?\d{1,3}", pwm, re.ASCII) is not None and abs(int(pwm)) <= _FULL_PWM
        return (
            whole
            and NUMBER.fullmatch(time_s) is not None
            and math.isfinite(float(time_s))
            and all(not text or NUMBER.fullmatch(text) for text in fields)
        )

    def _row(self, text: str, fields: tuple[str, ...], at_s: float) -> None:
        part = self.parts[-1]
        time_s = float(fields[0]) + (self._shift_s or 0.0)
        if part.rows and time_s <= self._last_s and self._header_at_s is not None:
            self._restart(self._header_at_s)
            time_s = float(fields[0]) + (self._shift_s or 0.0)
        if part.rows and time_s <= self._last_s:
            self._garbled(text.encode())
            return
        row = _Row(text, fields, time_s, at_s)
        held, self._held = self._held, None
        if held is not None:
            if held.time_s < time_s and self._agrees(held, row):
                self._keep(held)
            else:
                self._garbled(held.text.encode())
        if self._ahead(row) > max(_SLACK_S, _UNEVEN * self._ahead_s):
            self._held = row
        else:
            self._keep(row)

    def _agrees(self, held: _Row, row: _Row) -> bool:
        """Whether a later row speaks for the one that is held back.

        For a part's first row any does: how long the board had run before is not known. Rows that are all as much
        ahead come from a clock that is faster than the recorder's.
        """
        ahead_s = _ahead((held.time_s, held.at_s), row)
        return not self.parts[-1].rows or ahead_s <= max(_SLACK_S, self._ahead(held))

    def _ahead(self, row: _Row) -> float:
        return _ahead(self._begin, row)

    def _keep(self, row: _Row) -> None:
        self._keep_pending(header=False)
        self._ahead_s = self._ahead(row) if self.parts[-1].rows else 0.0
        shifted = self._shift_s is not None
        self.parts[-1].rows.append(",".join((f"{row.time_s:.3f}", *row.fields[1:])) if shifted else row.text)
        self._begin = self._last_s, self._last_at_s = row.time_s, row.at_s
        self._header_at_s = None

    def _settle(self) -> None:
        """End the wait of a row that is held back: no row will agree with it any more.

        The only row of a part is kept all the same: the board may have run for long before its recording began.
        """
        held, self._held = self._held, None
        if held is not None and self.parts[-1].rows:
            self._garbled(held.text.encode())
        elif held is not None:
            self._keep(held)

    def _garbled(self, raw: bytes) -> None:
        part = self.parts[-1]
        part.garbled += 1
        if part.garbled <= _KEPT_GARBLED:
            shown = raw[:200].decode("ascii", "backslashreplace")
            shown = "".join(c if c.isprintable() else f"\\x{ord(c):02x}" for c in shown)
            part.comments.append(f"# garbled: after {self._last_s:.3f} s: {shown}")


def _ahead(begin: tuple[float, float], row: _Row) -> float:
    """How much more time has passed by the board's clock than by the recorder's, s."""
    return row.time_s - begin[0] - (row.at_s - begin[1])
