"""`gen plot`."""

from __future__ import annotations

from pathlib import Path

import click

from gen.commands.options import check_files, check_once

_PATH = click.Path(path_type=Path)


@click.command(
    short_help="Draw runs: temperatures, model, residual, alarms.",
    epilog="Example:  gen plot run1.csv run2.csv --model coeffs.json --out runs.html",
)
@click.argument("runs", metavar="RUN...", nargs=-1, required=True, type=_PATH)
@click.option("--model", metavar="COEFFS", type=_PATH, help="Show this model beside what was measured.")
@click.option(
    "--out",
    type=_PATH,
    help="FILE.html to zoom into, FILE.svg or FILE.png to print.  [default: the first RUN with .html]",
)
def plot(runs: tuple[Path, ...], model: Path | None, out: Path | None) -> None:
    """Draw what was measured, PWM and channels, with the alarms and faults that a run file names.

    With --model also the model's temperatures (those of `gen simulate --arithmetic exact`), measured minus model, where
    the file's alarm rules begin, and the alarms that they raise on these measurements. Without it, those of the board
    where it wrote the run.
    """
    from gen.drawing.forms import drawn, form_of
    from gen.files import check_outputs, write_bytes

    target = out or runs[0].with_suffix(".html")
    form = form_of(target)
    check_outputs((target,), (*runs, *([model] if model is not None else [])))
    check_once(runs)
    coefficients = None
    if model is not None:
        check_files(model, runs)
        from gen.coefficients import load

        coefficients = load(model)
    else:
        from gen.runs import check_head

        for path in runs:
            check_head(path)
    for path in runs:
        if path.is_file():  # a pipe can be read only once
            from gen.runs import check_run

            check_run(path)

    # Slow to import: what is wrong with a file was told before.
    from gen.drawing.content import section_of
    from gen.progress import progress_line

    with progress_line() as progress:
        sections = []
        for path in runs:
            progress(f"{path}: reading")
            sections.append(section_of(path, coefficients))
        progress(f"{target}: drawing")
        write_bytes(target, drawn(sections, form))
    for section in sections:
        for note in section.notes:
            click.echo(f"{section.title}: {note}")
    click.echo(f"{target}: {len(sections)} run{'s' if len(sections) > 1 else ''} drawn")
