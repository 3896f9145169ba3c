"""`gen refine`."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING

import click

from gen.commands.options import check_files, check_once
from gen.progress import progress_line

if TYPE_CHECKING:
    from gen.refinement.network.refine import NetworkRefinement
    from gen.refinement.parts.refine import Refinement

_LISTS = ("--fit", "--test")
UNEXPLAINED = (
    "what it is these runs do not tell: log what else changes (current, supply, a fan), run 60 % again as when the "
    "model was made, or ask `gen plan` for the run that tells most; a motor that was rebuilt is identified anew"
)


class ListsOfFiles(click.Command):
    """Lets ``--fit a.csv b.csv`` stand for ``--fit a.csv --fit b.csv``."""

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Spell every file of a list out with its option."""
        spelt: list[str] = []
        option: str | None = None
        for position, argument in enumerate(args):
            if argument == "--":
                spelt += args[position:]
                break
            if argument in _LISTS:
                option = argument
                follows = args[position + 1 : position + 2]
                if not follows or (follows[0].startswith("-") and follows[0] != "-"):
                    raise click.BadOptionUsage(argument, f"Option '{argument}' requires at least one run file.", ctx)
                continue
            if argument.startswith("-") and argument != "-":
                option = None
            if option is not None:
                spelt += [option, argument]
            else:
                spelt.append(argument)
        return super().parse_args(ctx, spelt)


_FILE = click.Path(path_type=Path)


@click.command(
    cls=ListsOfFiles,
    short_help="Trace what a model misses to a physical effect.",
    epilog="Example:  gen refine coeffs.json --fit mon.csv tue.csv wed.csv --test thu.csv --out refined.json "
    "--report refined.html --json refined-summary.json",
)
@click.argument("coefficients", metavar="COEFFS", type=_FILE)
@click.option(
    "--fit", "fit_runs", metavar="RUN...", type=_FILE, multiple=True, required=True, help="Runs to learn from."
)
@click.option(
    "--test",
    "test_runs",
    metavar="RUN...",
    type=_FILE,
    multiple=True,
    required=True,
    help="Runs opened once, at the end.",
)
@click.option("--out", type=_FILE, required=True, help="The refined coefficient file.")
@click.option("--report", type=_FILE, help="Write the story with pictures, one HTML file.")
@click.option("--json", "json_file", type=_FILE, help="Write what was found as JSON.")
@click.option(
    "--accept-change",
    is_flag=True,
    help="Learn, too, what looks as if the motor had changed since, or what nothing explains.",
)
def refine(
    coefficients: Path,
    fit_runs: tuple[Path, ...],
    test_runs: tuple[Path, ...],
    out: Path,
    report: Path | None,
    json_file: Path | None,
    accept_change: bool,
) -> None:
    """Trace what a model misses in measured runs to a physical effect, and add it to the model.

    Verdicts: "explained" (what is left is near the sensors' noise), "partly explained", "nothing missing" and
    "unexplained". Where a file's transfer functions do not explain the runs and one network for the motor does, OUT
    holds that network. Where the test runs are missed by more than before by over 5 %, OUT holds the model as it was,
    unless with --accept-change.
    """
    from gen.files import check_outputs, write_text
    from gen.interface import load
    from gen.interface import refine as run

    check_outputs((out, report, json_file), (*fit_runs, *test_runs))
    check_outputs((report, json_file), (coefficients,))
    check_once(fit_runs)
    check_once(test_runs)
    check_files(coefficients, (*fit_runs, *test_runs))
    model = load(coefficients)
    with progress_line() as progress:
        refined = run(model, fit=fit_runs, test=test_runs, accept_change=accept_change, progress=progress)
    found = refined.found
    for warning in found.warnings:
        click.echo(f"warning: {warning}", err=True)
    page = refined.html() if report is not None else ""
    withheld = found.tests_worse and not accept_change
    write_text(out, model.text if withheld else found.text)
    if report is not None:
        write_text(report, page)
    if json_file is not None:
        write_text(json_file, json.dumps(found.summary(), indent=1) + "\n")
    _say(found)
    if withheld:
        click.echo(f"{out}: the model as it was; what was found makes the test runs worse")
        return
    held = "" if found.text != model.text or not found.effects else "; none of them is in it, see the warnings"
    click.echo(f"{out}: {len(found.effects)} effect(s) found{held}")


def _say(found: Refinement | NetworkRefinement) -> None:
    if lead := getattr(found, "lead", ""):
        click.echo(lead)
    click.echo(f"verdict: {found.verdict}")
    click.echo(f"  judged on what was left out in turn: {found.judged_on}")
    for effect in found.effects:
        numbers = ", ".join(
            f"{key} = {_short(value)}" for key, value in effect["parameters"].items() if value is not None
        )
        near = f", a part without a sensor near {' and '.join(effect['near'])}" if effect.get("near") else ""
        click.echo(f"  {effect['component']}{near}: {effect['name']} ({numbers})")
        if effect.get("changed"):
            held = "OUT holds it as --accept-change asks" if effect["written"] else "OUT does not hold it"
            click.echo(f"    this has changed since the file was made, or the file was wrong there; {held}")
            left = effect["evidence"]["left_out_rmse_K"]
            with_it, without = f"{left['after']:.2f} K", f"{left['before']:.2f} K"
            click.echo(f"    what was left out is predicted to {with_it} with it, to {without} without")
        for other in effect["evidence"]["lookalikes"]:
            click.echo(f"    could as well be {other['name']}; to tell: {other['told_apart_by']}")
    if not found.effects and found.summary().get("refitted"):
        click.echo("  no effect; numbers that the file left open were fitted anew")
    if found.verdict == "unexplained" and not found.effects and getattr(found, "missing", None) is None:
        click.echo(f"  {UNEXPLAINED}")
    for told in getattr(found, "planned", ()):
        click.echo(f"  {told.sentence}")
    before, after = found.before.summary(), found.after.summary()
    for key in ("fit", "test"):
        click.echo(
            f"  {key}: RMSE {before[key]['rmse_K']:.2f} -> {after[key]['rmse_K']:.2f} K, "
            f"worst {before[key]['max_abs_K']:.2f} -> {after[key]['max_abs_K']:.2f} K"
        )


def _short(value: object) -> str:
    """A parameter's value with as many digits as say something."""
    if isinstance(value, (list, tuple)):
        return f"[{', '.join(map(_short, value))}]"
    return f"{value:.4g}" if isinstance(value, float) else str(value)
