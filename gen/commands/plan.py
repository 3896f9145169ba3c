"""`gen plan`."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING

import click

from gen.commands.options import COEFFICIENTS, Finite, check_files, check_once
from gen.progress import progress_line

if TYPE_CHECKING:
    from gen.interface import Plan

_PATH = click.Path(path_type=Path)


@click.command(
    short_help="Plan the run that would tell most.",
    epilog="Example:  gen plan motor.json mon.csv tue.csv --hours 3 --out next.csv --limit-degC 95",
)
@COEFFICIENTS
@click.argument("runs", metavar="RUN...", type=_PATH, nargs=-1, required=True)
@click.option("--hours", type=Finite(min=0.5, max=48.0), required=True, help="Length of the run.")
@click.option("--out", type=_PATH, required=True, help="The profile to write; gen emulate and gen log take it.")
@click.option("--json", "json_file", type=_PATH, help="Write what is expected as JSON.")
@click.option("--max-pwm", type=click.IntRange(1, 255), help="Greatest |PWM|.  [default: the file's]")
@click.option("--limit-degC", type=Finite(), help="Greatest temperature of any part.  [default: the file's domain]")
@click.option(
    "--margin-K",
    type=Finite(min=0.0),
    default=3.0,
    show_default=True,
    help="How far predictions stay below every limit, over-temperature alarms included.",
)
@click.option("--ambient-degC", type=Finite(), help="Of the room.  [default: as in the runs]")
@click.option(
    "--reverse/--no-reverse",
    default=None,
    help="Whether it may turn backwards.  [default: where a run did, and it matters]",
)
@click.option("--seed", type=click.IntRange(min=0), default=0, show_default=True, help="Of the search.")
def plan(
    coefficients: Path,
    runs: tuple[Path, ...],
    hours: float,
    out: Path,
    json_file: Path | None,
    max_pwm: int | None,
    limit_degc: float | None,
    margin_k: float,
    ambient_degc: float | None,
    reverse: bool | None,
    seed: int,
) -> None:
    """Plan the run that would tell most of what the runs so far have left open.

    COEFFS holds a network, and RUNs are those that gen refine would be given with --fit. Where several effects explain
    them as well, the planned run is the one under which these differ most; where one is left, the one that narrows its
    intervals most. It begins with all parts as warm as the room.
    """
    from gen.files import check_outputs, write_text
    from gen.interface import load
    from gen.interface import plan as run

    check_outputs((out, json_file), (coefficients, *runs))
    check_once(runs)
    check_files(coefficients, runs)
    model = load(coefficients)
    with progress_line() as progress:
        made = run(
            model,
            runs,
            hours=hours,
            max_pwm=max_pwm,
            limit_degC=limit_degc,
            margin_K=margin_k,
            ambient_degC=ambient_degc,
            reverse=reverse,
            seed=seed,
            progress=progress,
        )
    for warning in made.warnings:
        click.echo(f"warning: {warning}", err=True)
    made.save(out)
    if json_file is not None:
        write_text(json_file, json.dumps(made.details(), indent=1) + "\n")
    _say(made, out)


def _say(made: Plan, out: Path) -> None:
    found = made.found
    for one in found.lines():
        click.echo(one)
    click.echo(f"{out}: {len(found.holds)} holds, {sum(seconds for _, seconds in found.holds) / 3600.0:g} h")
