"""`gen fleet thresholds`."""

from __future__ import annotations

from pathlib import Path

import click

from gen.commands.fleet.options import STORE, usual_jobs, workers_options
from gen.commands.options import Finite


@click.command(
    short_help="Alarm thresholds of each motor from the whole fleet's healthy runs.",
    epilog="Example:  gen fleet thresholds fleet --rules rules.json",
)
@STORE
@workers_options
@click.option(
    "--rules", type=click.Path(path_type=Path), required=True, help="JSON: alarms without thresholds, perhaps wiring."
)
@click.option(
    "--hours-per-false-alarm",
    type=Finite(1.0, 1e6),
    default=1000.0,
    show_default=True,
    help="Of rules on missing heat, each: wanted mean time between two false alarms, h.",
)
def thresholds(store: str, scheduler: str | None, jobs: int | None, rules: Path, hours_per_false_alarm: float) -> None:
    """Derive each motor's alarm thresholds from its own healthy runs and those of others.

    Runs that the models were fitted to take no part, nor motors that `gen fleet watch` called different. Writes
    coefficient files with alarms into STORE/thresholds.
    """
    from gen.errors import InputError
    from gen.fleet.folder.store import Store

    place = Store(store)
    if not rules.is_file():
        raise InputError("there is no such file; expected alarm rules", file=str(rules))

    from gen.fleet.alarm_thresholds import derive_all
    from gen.fleet.tasks.work import Workers
    from gen.progress import progress_line

    with progress_line() as progress:
        found = derive_all(place, rules, hours_per_false_alarm, Workers(usual_jobs(jobs), scheduler), progress)
    for motor, notes in found.notes.items():
        for note in notes:
            click.echo(f"{motor}: {note}")
    for motor, reason in found.refused.items():
        click.echo(f"{motor}: no thresholds: {reason}", err=True)
    click.echo(f"{store}: thresholds of {len(found.own)} motor(s); {len(found.refused)} without")
