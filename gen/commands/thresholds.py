"""`gen thresholds`."""

from __future__ import annotations

from pathlib import Path

import click

from gen.commands.options import COEFFICIENTS, check_files, check_once
from gen.errors import InputError

_PATH = click.Path(path_type=Path)


@click.command(
    short_help="Derive alarm thresholds from runs of the healthy motor.",
    epilog="Example:  gen thresholds identified.json --rules rules.json healthy_*.csv --out coeffs.json",
)
@COEFFICIENTS
@click.argument("runs", metavar="RUN...", nargs=-1, required=True, type=_PATH)
@click.option("--rules", type=_PATH, required=True, help="JSON: alarms without thresholds, and optionally the wiring.")
@click.option(
    "--hours-per-false-alarm",
    type=click.FloatRange(1.0, 1e6),
    default=1000.0,
    show_default=True,
    help="Of rules on missing heat, each: wanted mean time between two false alarms, h.",
)
@click.option("--out", type=_PATH, required=True, help="The coefficient file to write.")
def thresholds(
    coefficients: Path, runs: tuple[Path, ...], rules: Path, hours_per_false_alarm: float, out: Path
) -> None:
    """Derive alarm thresholds from runs of the healthy motor that took no part in the identification.

    The runs should show all that is normal: cold and warm starts, every speed, changing speed, an ambient that
    moves, the usual load.
    The error bands in the written file are the healthy motor's; thresholds that the rules leave out lie a margin
    beyond.
    """
    from gen.coefficients import load, parse, with_rules
    from gen.coefficients.rules import read_rules
    from gen.files import check_outputs, write_text
    from gen.runs import check_run

    check_outputs((out,), (*runs, rules))
    check_once(runs)
    check_files(coefficients, runs)
    loaded = load(coefficients)
    wanted = read_rules(rules, loaded.model.component_names)
    for path in runs:
        if path.is_file():  # a pipe can be read only once
            check_run(path)

    # Slow to import: what is wrong with a file was told before.
    from gen.firmware.alarm_text import alarm_texts, told_sleeping
    from gen.replay import read_for
    from gen.thresholds.derive import complete, error_bands
    from gen.thresholds.healthy import compare

    healthy = []
    for path in runs:
        run = read_for(loaded, path)
        healthy.append(compare(loaded, run, str(path)))
    bands = error_bands(loaded.document, healthy)
    alarms = []
    try:
        for number, rule in enumerate(wanted.alarms):
            try:
                alarms.append(complete(rule, loaded, healthy, hours_per_false_alarm))
            except InputError as error:
                raise InputError(error.message, place=f"$.alarms[{number}]") from error
        text = with_rules(coefficients.read_text(encoding="utf-8"), wanted, alarms, bands, source="gen thresholds")
        made = parse(text.encode())
    except InputError as error:
        raise InputError(error.message, file=error.file or str(rules), place=error.place) from error
    write_text(out, text)
    provenance = loaded.document.provenance
    learnt = {Path(name).name for name in provenance.data} if provenance is not None else set()
    for path in runs:
        if path.name in learnt:
            click.echo(
                f"warning: {path}: a run of this name taught the model ($.provenance.data); on it the model is better "
                "than on others, and thresholds come out too narrow",
                err=True,
            )
    for alarm in made.document.alarms:
        click.echo(f"{alarm.name}: {alarm.note or 'as written'}")
    for warning in made.warnings:
        click.echo(f"warning: {warning}", err=True)
    if asleep := told_sleeping(alarm_texts(made)):
        click.echo(asleep)
    click.echo(f"{out}: {len(made.document.alarms)} rules from {len(healthy)} healthy runs")
