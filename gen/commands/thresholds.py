"""`gen thresholds`."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import click

from gen.commands.options import COEFFICIENTS
from gen.errors import InputError

_PATH = click.Path(path_type=Path)


@click.command(
    epilog="Example:  gen thresholds identified.json --rules rules.json healthy_*.csv --out coeffs.json",
)
@COEFFICIENTS
@click.argument("runs", metavar="RUN...", nargs=-1, required=True, type=_PATH)
@click.option("--rules", type=_PATH, required=True, help="JSON: alarms without thresholds, and optionally the wiring.")
@click.option("--out", type=_PATH, required=True, help="The coefficient file to write.")
def thresholds(coefficients: Path, runs: tuple[Path, ...], rules: Path, out: Path) -> None:
    """Derive alarm thresholds from runs of the healthy motor that took no part in the identification.

    The runs should show all that is normal: cold and warm starts, every speed, changing speed, an ambient that
    moves, the usual load.
    The error bands in the written file are the healthy motor's; thresholds that the rules leave out lie a margin
    beyond.
    """
    from gen.coefficients import load, parse
    from gen.coefficients.jsontext import parse as parse_json
    from gen.files import check_writable, write_text
    from gen.runs import read_run
    from gen.thresholds.derive import complete, error_bands
    from gen.thresholds.healthy import compare

    check_writable(out)
    loaded = load(coefficients)
    wanted = _rules(parse_json(_read(rules)), rules)
    healthy = []
    for path in runs:
        run = read_run(path, loaded.model.component_names, ambient=loaded.model.ambient_channel or "ambient_degC")
        healthy.append(compare(loaded, run, str(path)))
    tree: dict[str, Any] = parse_json(_read(coefficients))
    tree |= {key: wanted[key] for key in ("name", "description", "wiring") if key in wanted}
    tree.setdefault("provenance", {"source": "gen thresholds"})["error"] = error_bands(loaded.document, healthy)
    try:
        tree["alarms"] = [complete(rule, loaded.document, healthy) for rule in wanted["alarms"]]
        text = json.dumps(tree, indent=1, ensure_ascii=False) + "\n"
        made = parse(text.encode())
    except InputError as error:
        raise InputError(error.message, file=error.file or str(rules), place=error.place) from error
    write_text(out, text)
    for rule in made.document.alarms:
        click.echo(f"{rule.name}: {rule.note or 'as written'}")
    for warning in made.warnings:
        click.echo(f"warning: {warning}", err=True)
    click.echo(f"{out}: {len(made.document.alarms)} rules from {len(healthy)} healthy runs")


def _read(path: Path) -> str:
    try:
        return path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        reason = error.strerror if isinstance(error, OSError) else "it is not UTF-8"
        raise InputError(f"cannot be read: {reason}", file=str(path)) from error


def _rules(tree: Any, path: Path) -> dict[str, Any]:  # noqa: ANN401
    if not isinstance(tree, dict) or not isinstance(tree.get("alarms"), list):
        raise InputError('expected an object with "alarms", a list of rules', file=str(path), place="$")
    if not all(isinstance(rule, dict) for rule in tree["alarms"]):
        raise InputError("expected a list of objects", file=str(path), place="$.alarms")
    return tree
