"""`gen import`."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Literal

import click

from gen.commands.options import Finite, check_once
from gen.errors import InputError
from gen.progress import progress_line

if TYPE_CHECKING:
    from gen.importing import Plan
    from gen.interface.importing import Import

_WIDTH = 140


@click.command(
    name="import",
    short_help="Turn what a logger wrote into run files.",
    epilog="Example:  gen import bench/*.csv --out runs --mapping bench.toml",
)
@click.argument("files", metavar="FILE...", nargs=-1, required=True, type=click.Path(path_type=Path))
@click.option("--out", required=True, type=click.Path(path_type=Path), help="The folder for the run files.")
@click.option(
    "--mapping", type=click.Path(path_type=Path), help="What each column is (TOML): read if it exists, else written."
)
@click.option("--time", metavar="COLUMN[,COLUMN]|SECONDS", default="", help="The time, or the interval of the rows.")
@click.option("--input", "drive", metavar="COLUMN|COUNTS", default="", help="What drives the motor: it becomes pwm.")
@click.option("--full-scale", type=Finite(0, min_open=True), help="The input's value that is 255 counts, in its unit.")
@click.option("--rest", type=Finite(), help="The input's value that is 0 counts, as 4 of 4 to 20 mA.  [default: 0]")
@click.option(
    "--drives",
    type=click.Choice(["motor", "heater"]),
    help="What the input drives, for `gen identify`: a heater moves no air.",
)
@click.option(
    "--column", "columns", metavar="OLD=NEW", multiple=True, help="A column's name in the run file; OLD= leaves it out."
)
@click.option(
    "--unit", "units", metavar="COLUMN=UNIT", multiple=True, help="degC, degF, K, s, ms, percent, mA, 0.25degC .."
)
@click.option("--decimal", type=click.Choice([",", "."]), help="The decimal mark.")
@click.option("--runs", metavar="COLUMN", default="", help="Which run a row belongs to: a run file for each value.")
@click.option("--split", is_flag=True, help="A run file for each stretch between gaps and resets of the clock.")
@click.option(
    "--gap", type=Finite(0, min_open=True), help="A gap's length, s.  [default: ten usual intervals, 60 at least]"
)
@click.option(
    "--duplicates",
    type=click.Choice(["first", "last", "mean", "spread"]),
    help="Of rows with one time: which to take, their mean, or to spread them until the next time.",
)
@click.option(
    "--series", metavar="NAMES[,VALUES]", default="", help="A row for each reading: each of the names becomes a column."
)
@click.option(
    "--sort", is_flag=True, help="Put rows in the order of their times: exports newest first, or in any order."
)
@click.option(
    "--zone",
    metavar="NAME",
    default="",
    help="The time zone of local times, as Europe/Berlin, where summer time changes.",
)
@click.option("--sheet", metavar="NAME", default="", help="Of a workbook, the only sheet to read.")
@click.option("--overwrite", is_flag=True, help="Replace run files of the same names.")
def import_runs(
    files: tuple[Path, ...],
    out: Path,
    mapping: Path | None,
    time: str,
    drive: str,
    full_scale: float | None,
    rest: float | None,
    drives: Literal["motor", "heater"] | None,
    columns: tuple[str, ...],
    units: tuple[str, ...],
    decimal: str | None,
    runs: str,
    split: bool,
    gap: float | None,
    duplicates: str | None,
    series: str,
    sort: bool,
    zone: str,
    sheet: str,
    overwrite: bool,
) -> None:
    """Turn what a logger wrote into run files: CSV of any dialect, serial captures, JSON lines, Excel, Parquet, MATLAB.

    What was guessed is shown with the reason; what is doubtful is refused with the option that settles it.
    """
    from gen.interface.importing import import_runs as run

    check_once(files)
    with progress_line() as progress:
        found = run(
            files,
            out,
            mapping=mapping,
            time=time,
            input=drive,
            full_scale=full_scale,
            rest=rest,
            drives=drives or "",
            columns=_pairs(columns, "--column", "OLD=NEW"),
            units=_pairs(units, "--unit", "COLUMN=UNIT"),
            decimal=decimal or "",
            runs=runs,
            duplicates=duplicates or "",
            series=series,
            sort=sort,
            zone=zone,
            sheet=sheet,
            split=split,
            gap=gap,
            overwrite=overwrite,
            seen=_show,
            progress=progress,
        )
    _tell(found)


def _pairs(given: Sequence[str], option: str, form: str) -> dict[str, str]:
    """Pairs by their last equals sign: a name of a log may hold some."""
    made: dict[str, str] = {}
    for text in given:
        name, sign, value = text.rpartition("=")
        if not sign or not name:
            raise InputError(f'found "{text}", expected {form}', place=option)
        made[name] = value.strip()
    return made


def _show(planned: Plan) -> None:
    """What each column is taken for, how sure that is, and why."""
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    console = Console()
    if not console.is_terminal:
        console = Console(width=_WIDTH)
    for decided in planned.decided:
        tables = decided.evidence.tables
        label = tables[0].label + (f" and {len(tables) - 1} more" if len(tables) > 1 else "")
        shown = Table(title=Text(label), title_justify="left", box=None, pad_edge=False)
        for head in ("in the log", "taken as", "sure", "why"):
            shown.add_column(head, overflow="fold")
        for guess in decided.guesses:
            sure = "said" if guess.confidence == 1.0 else f"{guess.confidence:.2f}"
            cells = (guess.subject, guess.taken, sure + (" ?" if guess.doubtful else ""), guess.why)
            shown.add_row(*(Text(_printable(cell)) for cell in cells))
        console.print(shown)


def _tell(found: Import) -> None:
    for what, row in found.counted().iterrows():
        click.echo(_printable(f"{row['file']}: {row['count']} x {what} (first: {row['first']})"))
    for note in found.notes:
        click.echo(_printable(note))
    for warning in found.warnings:
        click.echo(_printable(f"warning: {warning}"), err=True)
    if found.mapping is not None:
        click.echo(f"{found.mapping}: the mapping; --mapping {found.mapping} takes further logs without a guess")
    for path, rows in zip(found.runs, found.rows, strict=True):
        click.echo(f"{path}: {rows} rows")


def _printable(text: str) -> str:
    return "".join(c if c.isprintable() else "?" for c in text)
