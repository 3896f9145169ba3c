"""The command `gen live`."""

from __future__ import annotations

import sys
from pathlib import Path

import click

from gen.commands.options import Finite
from gen.errors import InputError

_PATH = click.Path(path_type=Path)
_PORT = 8765
_RUN = ".csv"
"""No port is called so: a run file that is not there is no port to look for."""
_MOST = 2


@click.command(
    short_help="Show a motor that runs as a local web page.",
    epilog="Example:  gen live --emulate examples/my1016_rig/coeffs.json --time-lapse 20 --profile 0:153 --beside",
)
@click.argument("given", metavar="[PORT|RUN]...", nargs=-1)
@click.option(
    "--emulate", "emulated", metavar="COEFFS", type=_PATH, help="Run this file's firmware on an emulated Mega."
)
@click.option("--beside", is_flag=True, help="Of an emulated board: the same a second time, with faults of its own.")
@click.option(
    "--model", metavar="COEFFS", type=_PATH, help="Of a port or a run: names of its alarms, bands, the model."
)
@click.option("--plant", metavar="rig|model|COEFFS", help="Of an emulated board: its motor, as in gen emulate.")
@click.option("--profile", metavar="FILE|TIME:PWM,...", default="", help="Of an emulated board: PWM to begin with.")
@click.option(
    "--ambient", type=Finite(-40.0, 80.0), default=30.0, show_default=True, help="Of an emulated motor, degC."
)
@click.option(
    "--time-lapse", type=Finite(0.1, 1000.0), default=1.0, show_default=True, help="Of a run or an emulated one."
)
@click.option("--baud", type=click.IntRange(min=300), default=115200, show_default=True, help="Of a port.")
@click.option("--out", "outs", type=_PATH, multiple=True, help="The run file to record to; of two motors, twice.")
@click.option(
    "--listen",
    metavar="[HOST:]PORT",
    default=str(_PORT),
    show_default=True,
    help="Where; another host than 127.0.0.1 lets other computers in that know the token. 0: any free port.",
)
@click.option("--browser/--no-browser", default=None, help="Open the page.  [default: on a terminal]")
def live(
    given: tuple[str, ...],
    emulated: Path | None,
    beside: bool,
    model: Path | None,
    plant: str | None,
    profile: str,
    ambient: float,
    time_lapse: float,
    baud: int,
    outs: tuple[Path, ...],
    listen: str,
    browser: bool | None,
) -> None:
    """Show a board on a serial PORT, an emulated one, or a RUN file, as a web page on this computer; or two of them.

    Measured and modelled temperatures with their bands, PWM, speed, missing heat, alarms, LED and relay, sensors, rows
    lost. Commands go to the board only while the page is armed. Ctrl-C ends it, and writes the run files.
    """
    from gen.coefficients import load
    from gen.files import check_outputs

    count = len(given) + (1 + beside if emulated is not None else 0)
    _check_count(count, beside and emulated is None, outs)
    host, port = _address(listen)
    sources = [Path(name) if Path(name).is_file() or name.endswith(_RUN) else name for name in given]
    runs = [name for name in sources if isinstance(name, Path)]
    check_outputs(outs, [path for path in (*runs, emulated, model) if path is not None])
    known, own = (load(path) if path is not None else None for path in (model, emulated))
    if runs:
        from gen.runs import check_head

        for run in runs:
            check_head(run)

    from gen.live.making import Emulation, make_sources
    from gen.live.serve import Recorded, serve

    emulations = []
    if emulated is not None and own is not None:
        emulations = [Emulation(own, emulated, plant, ambient, profile)] * (1 + beside)
    made = make_sources(sources, known, emulations, time_lapse, baud)
    motors = [Recorded(source, outs[place] if outs else None) for place, source in enumerate(made)]

    def ready(url: str) -> None:
        click.echo(f"{url}\n  Ctrl-C ends it", err=True)
        if browser or (browser is None and sys.stderr.isatty()):
            click.launch(url)

    for motor, written in zip(motors, serve(motors, host, port, ready), strict=True):
        for path in written:
            click.echo(f"{path}: written, {motor.source.view.recorder.rows} rows in all")


def _check_count(count: int, alone: bool, outs: tuple[Path, ...]) -> None:
    """Refuse none, more than fit, and run files that are not one for each.

    Raises
    ------
    UsageError
        With what was expected.
    """
    if alone:
        raise click.UsageError("--beside is of an emulated board: expected --emulate COEFFS")
    if not 0 < count <= _MOST:
        raise click.UsageError("expected a port or a run file, or --emulate COEFFS; two of them at most")
    if outs and len(outs) != count:
        raise click.UsageError(f"expected --out as often as there are motors, {count}; found it {len(outs)} times")


def _address(text: str) -> tuple[str, int]:
    host, _, port = text.rpartition(":")
    if not port.isascii() or not port.isdigit() or int(port) > 65535:
        raise InputError(f'found "{text}", expected PORT or HOST:PORT', place="--listen")
    return host.strip("[]") or "127.0.0.1", int(port)
