"""A run file played back as if its board ran now, with the model's temperatures where the file has none."""

from __future__ import annotations

import re
import time
from pathlib import Path
from typing import Any

import numpy as np

from gen.arrays import FloatArray
from gen.coefficients import Coefficients
from gen.live.control import Control, checked
from gen.live.pace import Pace
from gen.live.source import Source
from gen.live.view import View
from gen.reference.simulate import simulate_run
from gen.replay import read_for
from gen.runs import Run, read_run

_NAP_S = 0.05
_CODES = "sensors"


class ReplaySource(Source):
    """A run file.

    Parameters
    ----------
    path
        The file.
    model
        What to show beside it; None: what the file holds.
    pace
        Seconds of the run in a second here.
    view
        Where the rows go.
    leads
        Whether the pace is one of its controls: of those that share it one is enough.

    Raises
    ------
    InputError
        When the file is no run, or the model lacks a column in it.
    """

    takes_commands = False

    def __init__(self, path: Path, model: Coefficients | None, pace: Pace, view: View, *, leads: bool = True) -> None:
        super().__init__("replay", path.name, view)
        run = read_run(path) if model is None else read_for(model, path)
        self._columns = {_word(name): values for name, values in run.columns().items()}
        if model is not None:
            self._columns |= _modelled(model, run, str(path))
        self._comments = run.comments
        self._pace, self._controls = pace, [pace.control] if leads else []

    def controls(self) -> list[Control]:
        """See :meth:`Source.controls`."""
        return self._controls

    def change(self, name: str, value: Any) -> None:  # noqa: ANN401
        """See :meth:`Source.change`."""
        known = next((control for control in self._controls if control.name == name), None)
        if known is None:
            super().change(name, value)
        else:
            self._pace.speed = float(checked(known, value))
            self._controls = [self._pace.control]

    def run(self) -> None:
        """See :meth:`Source.run`."""
        self.connected, self.link = True, "playing"
        comments = [f"# {key}: {text}" for key, text in self._comments.items()]
        head = "\n".join([*comments, ",".join(self._columns), ""])
        self.view.feed(head.encode("ascii", "replace"), 0.0)
        times, digits = self._columns["time_s"], len(self.view.known.channels)
        shown, now_s, last = 0, float(times[0]), time.monotonic()
        while shown < times.size and not self.stopped.is_set():
            now = time.monotonic()
            now_s, last = now_s + (now - last) * self._pace.speed, now
            until = int(np.searchsorted(times, now_s, side="right"))
            for place in range(shown, until):  # each at its own time: the run's clock is the recorder's
                self.view.feed(_row(self._columns, place, digits).encode(), float(times[place]))
            shown = until
            self.stopped.wait(_NAP_S)
        self.link = "came to its end"


def _modelled(model: Coefficients, run: Run, file: str) -> dict[str, FloatArray]:
    """The model's temperatures by the columns that a board would have for them."""
    columns = simulate_run(model, run, "exact", "auto", file)
    names = [name for name in model.model.component_names if f"{name}_model_degC" not in run.extras]
    return {f"{name}_model_degC": np.asarray(columns[f"{name}_degC"], dtype=np.float64) for name in names}


def _word(name: str) -> str:
    """A column's name as a board could have it: what a person called a column may be any text."""
    return re.sub(r"^(?=\d)|\W", "_", name, flags=re.ASCII)


def _row(columns: dict[str, Any], place: int, digits: int) -> str:
    """A row as a board prints it; of the sensors' codes, which a run file has as a number, with all `digits`."""
    fields = []
    for name, values in columns.items():
        value = values[place]
        whole = name in ("pwm", "flags", "alarms", "protection", _CODES)
        text = "" if np.isnan(value) else str(int(value)) if whole else f"{value:.9g}"
        fields.append(text.zfill(digits) if name == _CODES else text)
    return ",".join(fields) + "\n"
