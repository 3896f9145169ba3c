"""`gen fleet watch`."""

from __future__ import annotations

import click

from gen.commands.fleet.options import STORE, usual_jobs, workers_options
from gen.commands.options import Finite


@click.command(
    short_help="Tell what one motor shows from what all of them show.",
    epilog="Example:  gen fleet watch fleet --level 0.001",
)
@STORE
@workers_options
@click.option(
    "--level", type=Finite(1e-9, 0.5), default=0.01, show_default=True, help="False alarms a run of a healthy motor."
)
def watch(store: str, scheduler: str | None, jobs: int | None, level: float) -> None:
    """Hold each motor's newest run against its own model and the fleet's, and give each motor a state.

    What all motors show is missing in the model; what those of one label show (gen fleet add --label) is their batch;
    what one shows is that motor. Runs that a model was fitted to say
    nothing of it: identify with --until, and let newer runs be watched. Writes STORE/watch.json.
    """
    from gen.fleet.folder.store import Store

    place = Store(store)

    from gen.fleet.tasks.work import Workers
    from gen.fleet.watch import watch as run
    from gen.progress import progress_line

    with progress_line() as progress:
        found = run(place, level, Workers(usual_jobs(jobs), scheduler), progress)
    for line in (*found.common, *(batch.said for batch in found.batches)):
        click.echo(line)
    for motor in found.motors:
        if motor.state != "ok":
            click.echo(f"{motor.motor}: {motor.state}: {motor.said}")
    fine = sum(motor.state == "ok" for motor in found.motors)
    limit = "" if found.limit is None else f", limit {found.limit:.1f} standard deviations"
    click.echo(f"{store}: {fine} of {len(found.motors)} motor(s) ok{limit}")
