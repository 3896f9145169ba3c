"""`gen fleet add`."""

from __future__ import annotations

import math
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING

import click

from gen.commands.options import check_once

if TYPE_CHECKING:
    from gen.runs import Run


@click.command(
    short_help="Keep runs of a motor in a store.",
    epilog="Example:  gen fleet add monday.csv --motor pump-17 --to fleet --label supplier=A --label sensors=2026-03",
)
@click.argument("runs", metavar="[RUN...]", nargs=-1, type=click.Path(path_type=Path))
@click.option("--motor", metavar="ID", required=True, help="Whose runs they are.")
@click.option("--to", "store", metavar="STORE", required=True, help="A folder, or a URL that fsspec takes.")
@click.option(
    "--day",
    metavar="YYYY-MM-DD",
    help="When.  [default: of the first row by the run's comment `started`, else when its file was written]",
)
@click.option(
    "--label",
    "labels",
    metavar="KEY=VALUE",
    multiple=True,
    help="What else is known of the motor, in the place of its KEY's value before; may be given with no run.",
)
def add(runs: tuple[Path, ...], motor: str, store: str, day: str | None, labels: tuple[str, ...]) -> None:
    """Keep run files of one motor in a store, as Parquet by motor and day.

    The same run a second time is left as it is. All files are checked before the first is written. A label is the
    motor's from then on, whatever the day of the runs: gen fleet watch tells whether the motors of one label differ
    together from the others. KEY= takes a label away.
    """
    from gen.errors import InputError
    from gen.fleet.folder.labels import add_labels, parse_labels
    from gen.fleet.folder.names import checked_day, checked_motor, said_day
    from gen.runs import check_head, check_run, read_run

    if not runs and not labels:
        raise InputError("nothing to add; expected runs or --label", place="RUN")
    checked_motor(motor)
    wanted = parse_labels(labels)
    if day is not None:
        checked_day(day)
    check_once(runs)
    for path in runs:
        check_head(path)
    piped = {path: read_run(path) for path in runs if not path.is_file()}  # a pipe can be read only once
    for path in runs:
        if not (_measured(piped[path]) if path in piped else check_run(path).parts):
            message = "found no reading of any part; expected a column <component>_degC with readings"
            raise InputError(message, file=str(path))

    from gen.fleet.folder.store import Store

    target = Store(store)
    if not runs and not target.runs(motor):
        raise InputError(f"{motor} has no runs there; expected a motor that has, or runs", file=store)
    for line in add_labels(target, motor, wanted) if wanted else []:
        click.echo(f"{motor}: {line}")
    for path in runs:
        run = piped.get(path) or read_run(path)
        when = day or said_day(run.comments, float(run.time_s[0])) or _written(path)
        kept, new = target.add(motor, when, path.stem, run)
        click.echo(f"{path}: {kept.path if new else f'already there, {kept.path}'}")


def _measured(run: Run) -> bool:
    """Whether there is a reading of any part."""
    return any(any(map(math.isfinite, values.tolist())) for values in run.temps.values())


def _written(path: Path) -> str:
    return datetime.fromtimestamp(path.stat().st_mtime, UTC).date().isoformat()
