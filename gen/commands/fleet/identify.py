"""`gen fleet identify`."""

from __future__ import annotations

import click

from gen.commands.fleet.options import STORE, usual_jobs, workers_options
from gen.commands.options import AMBIENT


@click.command(
    short_help="Identify all motors of a store together.",
    epilog="Example:  gen fleet identify fleet --until 2026-03-31 --jobs 4",
)
@STORE
@workers_options
@click.option("--until", metavar="YYYY-MM-DD", help="The last day whose runs take part.")
@click.option("--only-new", is_flag=True, help="Keep what the fleet shares; models only for motors that have none.")
@AMBIENT
@click.option("--max-hidden", type=click.IntRange(0, 3), default=3, show_default=True, help="Most hidden nodes.")
@click.option(
    "--scouts",
    type=click.IntRange(1, 20),
    default=3,
    show_default=True,
    help="Motors on which the network's form is chosen.",
)
def identify(
    store: str,
    scheduler: str | None,
    jobs: int | None,
    until: str | None,
    only_new: bool,
    ambient: float | None,
    max_hidden: int,
    scouts: int,
) -> None:
    """Identify one thermal network for all motors, and each motor's deviation from it.

    Writes a coefficient file for each motor, and one of their mean, into STORE/models. Runs that say a fault take no
    part. What was computed before is taken from the store.
    """
    from gen.fleet.folder.names import checked_day
    from gen.fleet.folder.store import Store

    if until is not None:
        checked_day(until)
    place = Store(store)

    from gen.fleet.identify import Options, identify_fleet
    from gen.fleet.tasks.work import Workers
    from gen.progress import progress_line

    options = Options(ambient, max_hidden, scouts, until, only_new)
    with progress_line() as progress:
        found = identify_fleet(place, options, Workers(usual_jobs(jobs), scheduler), progress)
    for line in found.lines:
        click.echo(line)
    for motor, reason in found.refused.items():
        click.echo(f"{motor}: no model: {reason}", err=True)
    errors = sorted(found.left_out_K.values())
    middle = f", {errors[len(errors) // 2]:.2f} K in the median on what was left out" if errors else ""
    click.echo(f"{store}: {len(errors)} model(s){middle}; {len(found.refused)} without")
