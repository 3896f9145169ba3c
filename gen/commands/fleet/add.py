"""`gen fleet add`."""

from __future__ import annotations

from datetime import UTC, datetime
from pathlib import Path

import click

from gen.commands.options import check_once


@click.command(
    short_help="Keep runs of a motor in a store.",
    epilog="Example:  gen fleet add monday.csv tuesday.csv --motor pump-17 --to fleet --day 2026-03-02",
)
@click.argument("runs", metavar="RUN...", nargs=-1, required=True, type=click.Path(path_type=Path))
@click.option("--motor", metavar="ID", required=True, help="Whose runs they are.")
@click.option("--to", "store", metavar="STORE", required=True, help="A folder, or a URL that fsspec takes.")
@click.option(
    "--day", metavar="YYYY-MM-DD", help="When.  [default: the run's comment `started`, else when its file was written]"
)
def add(runs: tuple[Path, ...], motor: str, store: str, day: str | None) -> None:
    """Keep run files of one motor in a store, as Parquet by motor and day.

    The same run a second time is left as it is. All files are checked before the first is written.
    """
    from gen.fleet.names import checked_day, checked_motor, said_day
    from gen.runs import check_head, check_run, read_run

    checked_motor(motor)
    if day is not None:
        checked_day(day)
    check_once(runs)
    for path in runs:
        check_head(path)
    for path in runs:
        if path.is_file():  # a pipe can be read only once
            check_run(path)

    from gen.fleet.store import Store

    target = Store(store)
    for path in runs:
        run = read_run(path)
        when = day or said_day(run.comments) or _written(path)
        kept, new = target.add(motor, when, path.stem, run)
        click.echo(f"{path}: {kept.path if new else f'already there, {kept.path}'}")


def _written(path: Path) -> str:
    return datetime.fromtimestamp(path.stat().st_mtime, UTC).date().isoformat()
