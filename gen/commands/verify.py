"""`gen verify`."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Literal

import click

from gen.commands.options import COEFFICIENTS, combination
from gen.errors import CheckFailed
from gen.progress import progress_line

if TYPE_CHECKING:
    from gen.lowering.kinds import Arithmetic, ScheduleKind
    from gen.verification.verify import Target


@click.command(
    short_help="Prove the generated C++ equal to the reference.",
    epilog="Example:  gen verify examples/my1016/coeffs.json --target all --json verification.json",
)
@COEFFICIENTS
@combination(default_all=True)
@click.option("--target", type=click.Choice(["host", "avr", "all"]), default="all", show_default=True)
@click.option("--json", "json_file", type=click.Path(path_type=Path), help="Write what was found as JSON.")
@click.option(
    "--scale", type=click.FloatRange(0.001, 10.0), default=1.0, help="Share of the full campaign.", hidden=True
)
def verify(
    coefficients: Path,
    arithmetic: Arithmetic | Literal["all"],
    schedule: ScheduleKind | Literal["all"],
    target: Target,
    json_file: Path | None,
    scale: float,
) -> None:
    """Prove the generated C++ equal to the reference, bit for bit, and measure error and cost."""
    from gen.coefficients import load
    from gen.files import check_outputs, write_text
    from gen.verification.report import print_results
    from gen.verification.verify import summary
    from gen.verification.verify import verify as run

    loaded = load(coefficients)
    check_outputs((json_file,), (coefficients,))
    arithmetics: tuple[Arithmetic, ...] = ("fixed", "float") if arithmetic == "all" else (arithmetic,)
    schedules: tuple[ScheduleKind, ...] = ("table", "onboard") if schedule == "all" else (schedule,)
    with progress_line() as progress:
        results = run(loaded, arithmetics, schedules, target, progress=progress, scale=scale)
    found = summary(loaded, results)
    if json_file is not None:
        write_text(json_file, json.dumps(found, indent=1) + "\n")
    print_results(results)
    if found["differing"]:
        raise CheckFailed(f"{found['differing']} of {found['words']} words differ")
    exceeded = [f"{result.label}, {sentence}" for result in results for sentence in result.exceeded]
    if exceeded:
        raise CheckFailed(exceeded[0])
    click.echo(f"equal: {found['samples']} samples, {found['words']} words, none differs")
