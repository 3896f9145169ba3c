"""`gen log`."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import click

from gen.commands.options import Finite
from gen.errors import CheckFailed

if TYPE_CHECKING:
    from gen.record.port import Recording


@click.command(epilog="Example:  gen log /dev/ttyACM0 --out run.csv --profile 0:153,10800:0 --duration 14400")
@click.argument("port")
@click.option("--out", type=click.Path(path_type=Path), required=True, help="The run file to write.")
@click.option("--baud", type=click.IntRange(min=300), default=115200, show_default=True)
@click.option("--duration", type=Finite(min=0, min_open=True), help="Seconds.  [default: until Ctrl-C]")
@click.option("--profile", metavar="FILE|TIME:PWM,...", help="PWM to command meanwhile, in s and counts.")
def log(port: str, out: Path, baud: int, duration: float | None, profile: str | None) -> None:
    """Record the board's serial output as a run file.

    Rows are kept as printed; comment lines move to the front; garbled lines become comments and are counted. When the
    board restarts, the recording goes on in the same file. The file is written at the end, or on Ctrl-C with what came
    until then; so it is when an emulated board (gen emulate --pty) has come to its end.

    With --profile the motor is armed before its first PWM other than 0, and not again after the board has restarted.
    """
    from gen.files import check_outputs
    from gen.record.port import record_port, refused, write_parts
    from gen.record.profile import carried_comments, parse_profile

    steps = parse_profile(profile) if profile is not None else ()
    carried = carried_comments(profile)
    check_outputs((out,), (Path(profile),) if profile is not None else ())
    with _progress() as progress:
        recording = record_port(port, baud=baud, duration_s=duration, profile=steps, progress=progress)
    recorder = recording.recorder
    if not recorder.rows:
        came = f"; {recorder.unheaded} lines came without a header" if recorder.unheaded else ""
        raise CheckFailed(f"{port}: no row came in {recording.seconds:.0f} s, nothing written{came}")
    recorder.parts[0].comments += carried
    restarts = sum(len(part.restarts) for part in recorder.parts)
    for path, part in zip(write_parts(recorder, out), recorder.parts, strict=True):
        click.echo(f"{path}: {len(part.rows)} rows")
    click.echo(f"  {recorder.garbled} garbled lines, {restarts} restarts, {recorder.unheaded} lines before the header")
    if steps and refused(recorder):
        click.echo(
            f"warning: the board refused to drive the motor {refused(recorder)} times: it was not armed", err=True
        )
    if recording.closed:
        click.echo(f"  the line was closed after {recording.seconds:.0f} s")
    if recording.lost:
        raise CheckFailed(f"{port}: the port was lost after {recording.seconds:.0f} s: {recording.lost}")


@contextmanager
def _progress() -> Iterator[Callable[[Recording], None]]:
    """How many rows there are, on a terminal only."""
    from rich.console import Console

    console = Console(stderr=True)
    if not console.is_terminal:
        yield lambda _: None
        return
    with console.status("waiting for the header") as status:
        yield lambda now: status.update(
            f"{now.recorder.rows} rows in {now.seconds:.0f} s, {now.recorder.garbled} garbled; Ctrl-C ends"
            if now.recorder.headers
            else "waiting for the header"
        )
