"""`gen check`."""

from __future__ import annotations

from pathlib import Path

import click

from gen.progress import progress_line


@click.command(
    short_help="Prove an emitted project's error bounds anew.",
    epilog="Example:  gen check firmware_out --coefficients examples/my1016/coeffs.json",
)
@click.argument("folder", type=click.Path(path_type=Path))
@click.option(
    "--coefficients",
    type=click.Path(path_type=Path),
    help="The coefficient file: its equations must be those of the certificate.",
)
def check(folder: Path, coefficients: Path | None) -> None:
    """Prove the error bounds of what `gen build` wrote into FOLDER, from its C++ and its certificate.json alone.

    Nothing of what chose the formats and bounds takes part. Fails at the first step that does not follow.
    """
    from gen.interface import check as run
    from gen.interface import load

    model = load(coefficients) if coefficients is not None else None
    with progress_line() as progress:
        found = run(folder, coefficients=model, progress=progress)
    for part in found.parts:
        click.echo(
            f"  {part.name}: proven, never more than {part.bound_K:.4g} K (as given out: {part.reading_K:.4g} K)"
        )
    for name in found.unproven:
        click.echo(f"  {name}: nothing is claimed")
    click.echo(f"{folder}: {found.inequalities} inequalities hold")
