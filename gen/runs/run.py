"""A run in memory."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, field

from gen.arrays import FloatArray, IntArray

AMBIENT = "ambient_degC"
EXPECTS = "expects"
"""Key of the comment in which a planned profile, and a run that followed it, says what it is to decide."""
STATUS = frozenset(["flags", "sensors", "alarms", "protection", "time_to_limit_s", "holdable_pwm"])
"""Columns in which a board speaks of itself."""


def board_columns(names: Collection[str]) -> set[str]:
    """Columns that a board adds on its own account: its model's temperatures and its status. They measure nothing."""
    models = {name for name in names if name.endswith("_model_degC") and name.replace("_model_", "_") in names}
    return models | (STATUS & set(names))


@dataclass(frozen=True, eq=False)
class Run:
    """One run.

    Parameters
    ----------
    time_s
        Strictly increasing, s, shape (N,), N >= 1.
    pwm
        Integer -255..255, shape (N,); acts from its row's time until the next row's.
    temps
        Measured temperature by component, degC, shape (N,) each; NaN where missing.
    ambient
        Measured ambient, degC, shape (N,), NaN where missing; None without such a column.
    extras
        Further columns by their full name.
    comments
        The comment lines; a line without a colon has an empty value.
    rows_in_file
        Rows of the file that it was read from, more than N when it was thinned; None for a run from elsewhere.
    doubted
        A sentence for each column of which readings were taken out, because no part can have shown them.
    """

    time_s: FloatArray
    pwm: IntArray
    temps: dict[str, FloatArray] = field(default_factory=dict)
    ambient: FloatArray | None = None
    extras: dict[str, FloatArray] = field(default_factory=dict)
    comments: dict[str, str] = field(default_factory=dict)
    rows_in_file: int | None = None
    doubted: tuple[str, ...] = ()

    def columns(self) -> dict[str, FloatArray | IntArray]:
        """Every column by the name that it has in a run file, in the file's order, shape (N,) each."""
        found: dict[str, FloatArray | IntArray] = {"time_s": self.time_s, "pwm": self.pwm}
        found |= {f"{name}_degC": values for name, values in self.temps.items()}
        if self.ambient is not None:
            found[AMBIENT] = self.ambient
        return {**found, **self.extras}

    @property
    def thinned(self) -> str:
        """Say how much of its file this run is, or nothing."""
        rows = self.time_s.size
        if self.rows_in_file is None or self.rows_in_file == rows:
            return ""
        return f"{self.rows_in_file} rows, of which {rows} are used: errors are of these"

    @property
    def left_out(self) -> str:
        """Say what of its file is not in this run, or nothing."""
        return "; ".join(filter(None, (self.thinned, *self.doubted)))
