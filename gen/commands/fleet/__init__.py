"""`gen fleet`: its commands, one file each."""

from __future__ import annotations

import click

from gen.commands.fleet.add import add
from gen.commands.fleet.identify import identify
from gen.commands.fleet.refine import refine
from gen.commands.fleet.report import report
from gen.commands.fleet.thresholds import thresholds
from gen.commands.fleet.watch import watch


@click.group(
    short_help="The same for many motors: keep their runs, identify, watch.",
    epilog="Example:  gen fleet add monday.csv --motor pump-17 --to fleet",
)
def fleet() -> None:
    """Keep the runs of many motors in one store, and work on all of them together."""


for command in (add, identify, refine, watch, thresholds, report):
    fleet.add_command(command)
