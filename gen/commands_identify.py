"""The commands `gen identify` and `gen study`: parse, call, print; no logic."""

from __future__ import annotations

from pathlib import Path

import click


@click.command(epilog="Example:  gen study examples/my1016/study.json")
@click.argument("tables", type=click.Path(path_type=Path), default=Path("examples/my1016/study.json"))
def study(tables: Path) -> None:
    """Compute the source study's tables again, beside the printed values.

    TABLES holds the study's numbers  [default: examples/my1016/study.json].
    """
    from gen.study.tables import read_study
    from gen.study.text import reproduction

    click.echo(reproduction(read_study(tables)))
