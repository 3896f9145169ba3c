"""``python -m gen.rig.calibrate``: fit the motor, print how well it meets the study's numbers."""

from __future__ import annotations

import json
from pathlib import Path

import click

from gen.errors import InputError
from gen.files import write_text
from gen.rig.calibrate.document import fill
from gen.rig.calibrate.fit import calibrate
from gen.rig.calibrate.report import print_tables
from gen.rig.calibrate.targets import load
from gen.rig.calibrate.unknowns import motor
from gen.rig.parameters import my1016

ABOUT = (
    "The simulated MY1016: written by `python -m gen.rig.calibrate --write`, which fits it to targets.json. "
    "Units stand in the names; speeds are fractions of the rated speed."
)


@click.command()
@click.option("--write", is_flag=True, help="Fit anew (2 to 3 minutes) and write gen/rig/my1016.json.")
@click.option("--doc", type=click.Path(path_type=Path), help="Renew the tables in this Markdown file.")
def main(write: bool, doc: Path | None) -> None:
    """Compare the simulated motor with the study; fit it anew on request.

    Example: python -m gen.rig.calibrate --doc docs/rig.md
    """
    try:
        _run(write, doc)
    except InputError as error:
        click.echo(f"Error: {error}", err=True)
        raise SystemExit(2) from error


def _run(write: bool, doc: Path | None) -> None:
    targets = load()
    parameters = my1016()
    if write:
        parameters = motor(calibrate(targets), digits=4, about=ABOUT)
        path = Path(__file__).parents[1] / "my1016.json"
        write_text(path, json.dumps(parameters.model_dump(exclude_defaults=True), indent=2) + "\n")
    print_tables(parameters, targets)
    if doc:
        fill(doc, parameters, targets)


if __name__ == "__main__":
    main()
