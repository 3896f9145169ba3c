"""`gen fleet report`."""

from __future__ import annotations

from pathlib import Path

import click

from gen.commands.fleet.options import STORE


@click.command(
    short_help="Pages of all motors.",
    epilog="Example:  gen fleet report fleet --out pages",
)
@STORE
@click.option("--out", type=click.Path(path_type=Path), required=True, help="The folder for the pages.")
@click.option("--force", is_flag=True, help="Replace pages that were edited since.")
def report(store: str, out: Path, force: bool) -> None:
    """Write a page with every motor as a row, and one of each motor, of what `gen fleet watch` found last."""
    from gen.files import replace_folder
    from gen.fleet.folder.store import Store
    from gen.fleet.report import pages_of

    pages = pages_of(Store(store))
    replace_folder(out, pages, force=force)
    click.echo(f"{out / 'index.html'}: {len(pages) - 2} motor(s)")
