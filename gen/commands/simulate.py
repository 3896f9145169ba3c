"""`gen simulate`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Literal

import click

from gen.commands.options import COEFFICIENTS, check_files

if TYPE_CHECKING:
    from gen.lowering.kinds import Arithmetic
    from gen.reference.simulate import Start


@click.command(
    short_help="Run the model, exactly or as on the board, on a run file.",
    epilog="Example:  gen simulate examples/my1016/coeffs.json run.csv --arithmetic fixed --out model.csv",
)
@COEFFICIENTS
@click.argument("run", type=click.Path(path_type=Path))
@click.option("--arithmetic", type=click.Choice(["exact", "fixed", "float"]), default="exact", show_default=True)
@click.option("--start", type=click.Choice(["auto", "ambient", "measured"]), default="auto", show_default=True)
@click.option("--out", type=click.Path(path_type=Path), help="The CSV to write.  [default: RUN with .model.csv]")
def simulate(
    coefficients: Path,
    run: Path,
    arithmetic: Arithmetic | Literal["exact"],
    start: Start,
    out: Path | None,
) -> None:
    """Run the reference simulator on a run file and write the model's temperatures at the run's own times."""
    from gen.files import check_outputs
    from gen.interface import load
    from gen.interface import simulate as simulated
    from gen.runs import write_columns

    target = out or run.with_suffix(".model.csv")
    check_outputs((target,), (coefficients, run))
    check_files(coefficients, [run])
    model = load(coefficients)
    frame = simulated(
        model, run, arithmetic, start=start, warn=lambda warning: click.echo(f"warning: {warning}", err=True)
    ).reset_index()
    columns = {str(name): frame[name].to_numpy() for name in frame.columns}
    write_columns(target, columns, {"model": model.name, "arithmetic": arithmetic})
    click.echo(f"{target}: {len(frame)} rows")
