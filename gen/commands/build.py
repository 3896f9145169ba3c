"""`gen build`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from gen.commands.options import COEFFICIENTS, combination

if TYPE_CHECKING:
    from gen.lowering.kinds import Arithmetic, ScheduleKind
    from gen.lowering.program import Program


@click.command(
    short_help="Write the PlatformIO project for a coefficient file.",
    epilog="Example:  gen build examples/my1016/coeffs.json --out firmware_out",
)
@COEFFICIENTS
@click.option("--out", type=click.Path(path_type=Path), default=Path("firmware_out"), show_default=True)
@click.option(
    "--verification",
    type=click.Path(path_type=Path),
    help="What `gen verify --json` wrote: its verdict goes into the report. Default: the one in --out.",
)
@click.option("--force", is_flag=True, help="Replace files in --out even if they were edited since gen wrote them.")
@combination(default_all=False)
def build(
    coefficients: Path,
    out: Path,
    verification: Path | None,
    force: bool,
    arithmetic: Arithmetic,
    schedule: ScheduleKind,
) -> None:
    """Write the complete PlatformIO project for a coefficient file."""
    from gen.interface import build as run
    from gen.interface import load

    model = load(coefficients)  # before what is slow to import: a fault in the file is told at once

    from gen.firmware.alarm_text import alarm_texts, told_sleeping

    made = run(
        model,
        out,
        arithmetic=arithmetic,
        schedule=schedule,
        verification=verification,
        force=force,
        warn=lambda warning: click.echo(f"warning: {coefficients}: {warning}", err=True),
    )
    click.echo(f"{out}: {model.name}, arithmetic {arithmetic}, schedule {schedule}")
    for line in _guarantees(made.program):
        click.echo(f"  {line}")
    if asleep := told_sleeping(alarm_texts(model.coefficients)):
        click.echo(f"  {asleep}")
    unproven = [component.name for component in made.program.parts if component.saturates]
    if unproven:
        click.echo(f"NO GUARANTEE for {', '.join(unproven)}: as $.accuracy.unproven asks, built without a proof")


def _guarantees(program: Program) -> list[str]:
    """A line for each component: what is proven of it."""
    from gen.firmware.contexts.components import bound_text

    changed = {part.name for part in program.effects.components} if program.effects is not None else set()
    lines = []
    for component in program.parts:
        name = component.name + (", baseline" if component.name in changed else "")
        if component.proof is None:
            why = f"no error bound proven ({component.unproven})"
            lines.append(f"{name}: {why}; every addition saturates instead of wrapping round")
        else:
            lines.append(f"{name}: never more than {bound_text(component)} from the exact solution")
        if component.name in changed:
            lines.append(f"{component.name}, with effects: bound not proven, `gen verify` measures the error")
        if program.effects is not None and component.name in program.effects.contraction.unproven:
            lines.append(f"{component.name}, with effects: settles at each PWM held; not proven while it changes")
    return lines
