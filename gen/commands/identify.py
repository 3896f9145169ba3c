"""The command `gen identify`: parse, call, print; no logic."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Literal

import click

from gen.commands.options import AMBIENT, Finite, check_once
from gen.progress import progress_line

_FULL_PWM = 255
"""Of an 8-bit PWM; the model's own constant comes with numpy, for which the help would have to wait."""


@click.command(
    short_help="Identify a speed-scheduled model from measured runs.",
    epilog="Example:  gen identify cold_*.csv --out coeffs.json --report identification.html",
)
@click.argument("runs", metavar="RUN...", nargs=-1, required=True, type=click.Path(path_type=Path))
@click.option("--out", required=True, type=click.Path(path_type=Path), help="The coefficient file to write.")
@click.option("--json", "json_file", type=click.Path(path_type=Path), help="Write all that was found as JSON.")
@click.option("--report", type=click.Path(path_type=Path), help="Write an HTML report with plots.")
@click.option("--name", default="motor", show_default=True, help="The model's name.")
@AMBIENT
@click.option("--sample-time", type=Finite(0.001, 3600.0), default=0.25, show_default=True, help="The board's, s.")
@click.option(
    "--full-scale",
    type=click.IntRange(1, _FULL_PWM),
    default=_FULL_PWM,
    show_default=True,
    help="The count that is 100 %.",
)
@click.option("--rpm", type=Finite(1e-3), default=2650.0, show_default=True, help="Speed at full scale.")
@click.option(
    "--model",
    type=click.Choice(["auto", "parts", "network"]),
    default="auto",
    show_default=True,
    help="One thermal network for all parts, a transfer function for each, or (auto) a network that is good, else "
    "whichever of both errs less on runs left out.",
)
@click.option(
    "--max-hidden",
    type=click.IntRange(0, 3),
    default=3,
    show_default=True,
    help="Of a network: most nodes without a sensor.",
)
@click.option(
    "--heat",
    multiple=True,
    metavar="COLUMN",
    help="A measured column that heats the motor beside its PWM, such as current_A (by its square; COLUMN^1, COLUMN^2 "
    "say which); takes a network. The board has to measure it. May be given several times.",
)
@click.option(
    "--drives",
    type=click.Choice(["motor", "heater"]),
    help="What the input drives: a heater moves no air, and heats as the input goes (as the square of a current or a "
    "voltage); a network heeds it.  [default: what the runs say, else a motor]",
)
@click.option("--max-order", type=click.IntRange(1, 4), default=4, show_default=True)
def identify(
    runs: tuple[Path, ...],
    out: Path,
    json_file: Path | None,
    report: Path | None,
    name: str,
    ambient: float | None,
    sample_time: float,
    full_scale: int,
    rpm: float,
    max_order: int,
    model: Literal["auto", "parts", "network"],
    max_hidden: int,
    heat: tuple[str, ...],
    drives: Literal["motor", "heater"] | None,
) -> None:
    """Identify a speed-scheduled model from measured runs and write its coefficient file."""
    from gen.coefficients.names import name_fault
    from gen.coefficients.sample_time import milliseconds
    from gen.errors import InputError
    from gen.files import check_outputs, write_text
    from gen.interface import identify as run
    from gen.runs import check_head

    fault = name_fault(name)
    if fault:
        raise InputError(fault, place="--name")
    milliseconds(sample_time, "--sample-time")
    check_outputs((out, json_file, report), runs)
    check_once(runs)
    for path in runs:
        check_head(path)
    with progress_line() as progress:
        found = run(
            runs,
            name=name,
            ambient=ambient,
            sample_time=sample_time,
            full_scale=full_scale,
            rpm=rpm,
            max_order=max_order,
            model=model,
            max_hidden=max_hidden,
            heat=heat,
            drives=drives or "",
            progress=progress,
        )
        progress("report")
        page = found.html() if report is not None else ""
    found.model.save(out)
    if json_file is not None:
        write_text(json_file, json.dumps(found.details(), indent=1, allow_nan=False) + "\n")
    if report is not None:
        write_text(report, page)
    click.echo(found.text())
    for warning in found.model.warnings:
        click.echo(f"warning: {out}: {warning}", err=True)
    click.echo(f"{out}: {len(found.model.components)} component(s)")
