"""The command `gen live`."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING

import click

from gen.commands.options import Finite
from gen.errors import InputError
from gen.files import shown_name

if TYPE_CHECKING:
    from gen.coefficients import Coefficients
    from gen.live.emulated import EmulatedSource
    from gen.live.source import Source
    from gen.live.view import View

_PATH = click.Path(path_type=Path)
_PORT = 8765
_RUN = ".csv"
"""No port is called so: a run file that is not there is no port to look for."""


@click.command(
    short_help="Show a motor that runs as a local web page.",
    epilog="Example:  gen live --emulate examples/my1016_rig/coeffs.json --time-lapse 20 --profile 0:153 --out run.csv",
)
@click.argument("source", metavar="[PORT|RUN]", required=False)
@click.option(
    "--emulate", "emulated", metavar="COEFFS", type=_PATH, help="Run this file's firmware on an emulated Mega."
)
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
@click.option("--out", type=_PATH, help="The run file to record to.")
@click.option(
    "--listen",
    metavar="[HOST:]PORT",
    default=str(_PORT),
    show_default=True,
    help="Where; another host than 127.0.0.1 lets other computers in that know the token. 0: any free port.",
)
@click.option("--browser/--no-browser", default=None, help="Open the page.  [default: on a terminal]")
def live(
    source: str | None,
    emulated: Path | None,
    model: Path | None,
    plant: str | None,
    profile: str,
    ambient: float,
    time_lapse: float,
    baud: int,
    out: Path | None,
    listen: str,
    browser: bool | None,
) -> None:
    """Show a board on a serial PORT, an emulated one, or a RUN file, as a web page on this computer.

    Measured and modelled temperatures with their bands, PWM, speed, alarms, sensors, rows lost. Commands go to the
    board only while the page is armed. Ctrl-C ends it, and writes the run file.
    """
    from gen.coefficients import load
    from gen.files import check_outputs

    if (source is None) == (emulated is None):
        raise click.UsageError("expected a port or a run file, or --emulate COEFFS")
    host, port = _address(listen)
    run = Path(source) if source is not None and (Path(source).is_file() or source.endswith(_RUN)) else None
    check_outputs((out,), [path for path in (run, emulated, model) if path is not None])
    known = load(path) if (path := emulated or model) is not None else None
    if run is not None:
        from gen.runs import check_head

        check_head(run)

    from gen.live.serve import serve

    made: Source
    if emulated is not None:
        assert known is not None
        made = _emulated(known, emulated, plant, profile, ambient, time_lapse)
    elif run is not None:
        from gen.live.replay import ReplaySource

        made = ReplaySource(run, known, time_lapse, _view(known))
    else:
        from gen.live.port import PortSource

        made = PortSource(str(source), baud, _view(known))

    def ready(url: str) -> None:
        click.echo(f"{url}\n  Ctrl-C ends it", err=True)
        if browser or (browser is None and sys.stderr.isatty()):
            click.launch(url)

    for path in serve(made, host, port, out, ready):
        click.echo(f"{path}: written, {made.view.recorder.rows} rows in all")


def _view(known: Coefficients | None) -> View:
    """What rows that came from elsewhere are shown in."""
    from gen.live.heat import HeatFromRows
    from gen.live.known import Known, known_of
    from gen.live.view import View

    return View(Known()) if known is None else View(known_of(known), HeatFromRows(known))


def _emulated(
    known: Coefficients, file: Path, plant: str | None, profile: str, ambient: float, pace: float
) -> EmulatedSource:
    from gen.emulate.board import Board
    from gen.emulate.firmware import build_firmware, cache_folder
    from gen.emulate.scenario import Scenario, make_plant
    from gen.live.emulated import EmulatedSource, heat_of
    from gen.live.known import known_of
    from gen.live.view import View
    from gen.record.profile import parse_profile

    wiring = known.document.wiring
    if wiring is None or not wiring.thermocouples:
        raise InputError("has no thermocouples: there is nothing to emulate", file=str(file), place="$.wiring")
    steps = parse_profile(profile) if profile else ()
    made = make_plant(Scenario(plant=plant, ambient=str(ambient)), known, file)
    cache = cache_folder()
    elf = build_firmware(known, "fixed", "table", shown_name(file), cache).elf
    board = Board(elf, cache, wiring, made.plant, encoder="batched")
    channels = tuple(chip.channel for chip in wiring.thermocouples)
    view = View(known_of(known), heat_of(known, board))
    return EmulatedSource(
        known.name, board, made.plant, channels, made.plant.typical_faults, pace, steps, view, ambient
    )


def _address(text: str) -> tuple[str, int]:
    host, _, port = text.rpartition(":")
    if not port.isascii() or not port.isdigit() or int(port) > 65535:
        raise InputError(f'found "{text}", expected PORT or HOST:PORT', place="--listen")
    return host.strip("[]") or "127.0.0.1", int(port)
