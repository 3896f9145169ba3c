"""What a board prints, fed to a recorder piece by piece."""

from __future__ import annotations

from pathlib import Path

from gen.record import Recorder
from gen.runs import Run, read_run

HEAD = b"# model: my1016\r\n# reset: power\r\ntime_s,pwm,brush_degC,flags\r\n"


def record(*pieces: bytes, step_s: float = 1.0) -> Recorder:
    recorder = Recorder()
    for i, piece in enumerate(pieces):
        recorder.feed(piece, i * step_s)
    recorder.finish()
    return recorder


def reread(recorder: Recorder, folder: Path) -> Run:
    assert len(recorder.parts) == 1
    file = folder / "run.csv"
    file.write_text(recorder.parts[0].text(), encoding="utf-8")
    return read_run(file, ["brush"])
