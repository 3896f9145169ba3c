"""``python -m docs.figures``: draw every picture and fill in every figure of the docs that a command computes."""

from __future__ import annotations

import json
import os
from collections.abc import Callable
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import click
from matplotlib.figure import Figure

from docs.figures import measured, my1016, readme, rig
from docs.figures.picture import write
from gen.files import write_text
from gen.rig.calibrate.document import fill
from gen.rig.calibrate.targets import load
from gen.rig.parameters import my1016 as simulated_motor

DOCS = Path(__file__).parents[1]
PICTURES: dict[str, Callable[[], Figure]] = {
    "my1016.svg": my1016.figure,
    "rig.svg": rig.figure,
    "identify_measured.svg": measured.figure,
}


@click.command()
@click.option(
    "--verification",
    type=click.Path(path_type=Path, exists=True),
    help="What `gen verify examples/my1016/coeffs.json --json` wrote, for the README.  [default: verify now]",
)
def main(verification: Path | None) -> None:
    """Draw every picture and fill in every figure of the docs that a command computes."""
    for name, figure in PICTURES.items():
        click.echo(f"docs/{name}")
        write(figure(), DOCS / name)
    click.echo("docs/rig.md")
    fill(DOCS / "rig.md", simulated_motor(), load())
    click.echo("README.md")
    if verification is None:
        import gen

        found = gen.verify(gen.load(readme.COEFFICIENTS), compilers=("g++", "clang++"))
        found.check()
        record = found.details()
    else:
        record = json.loads(verification.read_text(encoding="utf-8"))
    write_text(readme.README, readme.filled(readme.README.read_text(encoding="utf-8"), record))


if __name__ == "__main__":
    main()
