"""`gen fleet refine`."""

from __future__ import annotations

import click

from gen.commands.fleet.options import STORE, usual_jobs, workers_options


@click.command(
    short_help="Find what all motors show and their models lack.",
    epilog="Example:  gen fleet refine fleet --scouts 12",
)
@STORE
@workers_options
@click.option(
    "--scouts",
    type=click.IntRange(6, 100),
    default=8,
    show_default=True,
    help="Motors on which effects are searched.",
)
def refine(store: str, scheduler: str | None, jobs: int | None, scouts: int) -> None:
    """Find effects that all motors show beside their models, and add them to each motor's coefficient file.

    Searches in runs that are newer than the models. What one motor shows alone is that motor, and is not learnt: see
    gen fleet watch. Writes coefficient files into STORE/refined, which all other commands use from then on; a later
    `gen fleet identify` begins anew.
    """
    from gen.fleet.folder.store import Store

    place = Store(store)

    import numpy as np

    from gen.fleet.refine import refine_fleet
    from gen.fleet.tasks.work import Workers
    from gen.progress import progress_line

    with progress_line() as progress:
        found = refine_fleet(place, scouts, Workers(usual_jobs(jobs), scheduler), progress)
    for motor, reason in found.refused.items():
        click.echo(f"{motor}: {reason}", err=True)
    for effect in found.common:
        click.echo(f"in common: {effect.said}")
    if not found.refined:
        click.echo(f"{store}: no effect is in common that files can hold; their models stay as they were identified")
        return
    said = ""
    if found.error_K:
        before, after = np.median(list(found.error_K.values()), axis=0)
        said = f"; {before:.2f} -> {after:.2f} K in the median of {len(found.error_K)} motors' newer runs"
    click.echo(f"{store}: {len(found.refined)} model(s) refined{said}")
