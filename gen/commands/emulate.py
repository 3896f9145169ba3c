"""`gen emulate`."""

from __future__ import annotations

import hashlib
import json
import sys
import tempfile
from contextlib import ExitStack
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from gen.commands.options import Finite
from gen.errors import CheckFailed, InputError
from gen.files import shown_name

if TYPE_CHECKING:
    from gen.avr.chip import Chip
    from gen.coefficients import Coefficients
    from gen.coefficients.wiring import Wiring
    from gen.emulate.board import Board
    from gen.emulate.scenario import Made, Scenario
    from gen.emulate.session import Event, Session
    from gen.record.profile import Profile

_PATH = click.Path(path_type=Path)
_SECONDS = Finite(min=0.0)

_EXAMPLE = (
    "Example:  gen emulate examples/my1016/coeffs.json --profile 0:153 --fault bearing --fault-start 3600 "
    "--out run.csv --json run.json --plot run.svg"
)


@click.command(short_help="Run the firmware on an emulated board with a simulated motor.", epilog=_EXAMPLE)
@click.argument("coefficients", metavar="COEFFS", type=_PATH)
@click.option("--arithmetic", type=click.Choice(["fixed", "float"]), default="fixed", show_default=True)
@click.option("--schedule", type=click.Choice(["table", "onboard"]), default="table", show_default=True)
@click.option("--elf", type=_PATH, help="Run this firmware (PlatformIO's firmware.elf) instead of building one.")
@click.option("--duration", type=Finite(min=1.0, max=1e6), default=10_800.0, show_default=True, help="s")
@click.option("--profile", metavar="FILE|TIME:PWM,...", default="0:153", show_default=True, help="PWM to command.")
@click.option(
    "--plant",
    metavar="rig|model|COEFFS",
    help="The motor: the simulated MY1016, this very model, or another coefficient file.  [default: rig if it has all "
    "parts that the board measures, else model]",
)
@click.option(
    "--fault",
    metavar="FAULT",
    help="Of the rig: bearing or brush. Of a model: heat:PART=+20%[@TIME] (or W, or K), path:A-B=-50%[@TIME]; several "
    "with commas.",
)
@click.option("--fault-start", type=_SECONDS, default=0.0, show_default=True, help="s")
@click.option("--fault-severity", type=Finite(0.0, 1.0), default=1.0, show_default=True)
@click.option(
    "--sensor-fault",
    metavar="CHANNEL:KIND:START:END[:SIZE_K]",
    multiple=True,
    help="KIND is open, all_0, all_1, stuck, spike, jump, noise or off; may be given several times.",
)
@click.option("--sensor-tolerance", type=Finite(min=0.0), default=1.1, show_default=True, help="Offsets, K.")
@click.option("--ambient", metavar="DEGC|FILE|TIME:DEGC,...", default="30", show_default=True)
@click.option("--load", metavar="NM|FILE|TIME:NM,...", default="0", show_default=True, help="Torque at the shaft.")
@click.option(
    "--channel",
    metavar="COLUMN=VALUE|FILE|TIME:VALUE,...",
    multiple=True,
    help="What the motor's surroundings do beside that, such as fan=1; may be given several times.",
)
@click.option(
    "--start",
    metavar="NAME=DEGC,...|PWM:SECONDS",
    help="Temperatures at the start, or what the motor has run before.  [default: ambient]",
)
@click.option("--button", metavar="TIME[:SECONDS]", multiple=True, help="Press the button.")
@click.option("--reset", metavar="TIME", type=_SECONDS, multiple=True, help="Press the board's reset button.")
@click.option("--power-cut", metavar="TIME[:SECONDS]", multiple=True, help="Take the board's power away.")
@click.option("--brown-out", metavar="TIME[:SECONDS]", multiple=True, help="Let the board's supply sag.")
@click.option("--send", metavar="TIME:TEXT", multiple=True, help="Send a line to the board.")
@click.option("--flood", metavar="TIME[:SECONDS]", multiple=True, help="Noise on the serial line without a pause.")
@click.option(
    "--clock", type=click.IntRange(0, 2**32 - 1), help="What millis() counts from; 4294960000 rolls over soon."
)
@click.option("--eeprom", type=_PATH, help="EEPROM image: loaded if it is there, saved at the end.")
@click.option(
    "--encoder",
    type=click.Choice(["batched", "true"]),
    default="batched",
    show_default=True,
    help="Pulses each at its own time, or a millisecond's together (faster; same number).",
)
@click.option("--pty", metavar="LINK", type=_PATH, help="Make LINK a serial port; the run begins when it is opened.")
@click.option(
    "--time-lapse",
    metavar="N",
    type=Finite(min=0.001),
    help="Simulated seconds in a second here.  [default: 1 with --pty, else as many as possible]",
)
@click.option("--seed", type=click.IntRange(min=0), default=0, show_default=True, help="Of the sensors' errors.")
@click.option("--out", type=_PATH, required=True, help="The run file to write.")
@click.option("--json", "json_file", type=_PATH, help="Write alarms, faults and counts as JSON.")
@click.option("--plot", type=_PATH, help="Draw the run, as gen plot does: FILE.html, FILE.svg or FILE.png.")
def emulate(coefficients: Path, out: Path, json_file: Path | None, plot: Path | None, **options: Any) -> None:  # noqa: ANN401
    """Run the firmware itself on an emulated Mega, or Uno, against a simulated motor.

    The firmware of the coefficient file is built as for the board and executed instruction by instruction; its
    thermocouples, encoder, drive, button, LED and serial line lead to a simulated motor: the MY1016, or a model. The
    run file holds what it printed. Time-lapse changes how fast one can watch, nothing else. Ctrl-C ends a run with
    what was simulated until then; exit status 130.
    """
    from gen.coefficients import load
    from gen.drawing.forms import form_of
    from gen.emulate.results import results_of, summary
    from gen.files import check_outputs, write_bytes
    from gen.interruption import EXIT_STATUS

    plant = () if options["plant"] in (None, "rig", "model") else (Path(options["plant"]),)
    if plot is not None:
        form_of(plot)
    # Each of these may be a number, a list of times or a file; a path that is no file is nobody's.
    courses = [Path(options[name]) for name in ("profile", "ambient", "load")]
    courses += [Path(told.partition("=")[2]) for told in options["channel"]]
    check_outputs((out, json_file, plot, options["eeprom"]), (coefficients, *plant, *courses))
    loaded = load(coefficients)
    wanted = _wanted(loaded, coefficients, options)

    # Slow to import: what is wrong with the file and the options was told before.

    with ExitStack() as stack:
        board = _board(loaded, coefficients, wanted, stack, options)
        session = _run(board, wanted, stack, options)
        if session.interrupted and not session.recorder.rows:
            raise KeyboardInterrupt
        results = results_of(loaded.document, board, session)
        found = summary(results, board, session, _settings(loaded, wanted.made, options))
        found["true_at_end_degC"] = {name: round(value, 3) for name, value in wanted.made.plant.temperatures.items()}
        if options["eeprom"] is not None:
            write_bytes(options["eeprom"], board.mega.eeprom.image)
        if not session.recorder.rows:
            raise CheckFailed("the firmware printed no row of a run file")
        title = _title(loaded, wanted.made, options)
        _write(session, found, title, (out, json_file, plot), [*_comments(found, options), *wanted.carried])
    _tell(found)
    if session.interrupted:
        click.echo(f"interrupted: {session.seconds:.0f} of {options['duration']:.0f} s are kept in {out}", err=True)
        sys.exit(EXIT_STATUS)


def _write(
    session: Session,
    found: dict[str, Any],
    title: str,
    files: tuple[Path, Path | None, Path | None],
    comments: list[str],
) -> None:
    """Write run file, summary and picture; the run file first, which is what took the time."""
    from gen.files import write_bytes, write_text
    from gen.record.port import write_parts

    out, json_file, plot = files
    session.recorder.parts[0].comments += comments
    for path in write_parts(session.recorder, out):
        click.echo(f"{path}: {session.recorder.rows} rows")
    if json_file is not None:
        write_text(json_file, json.dumps(found, indent=1) + "\n")
    if plot is not None:
        write_bytes(plot, _drawn(session, title, plot))


def _drawn(session: Session, title: str, plot: Path) -> bytes:
    """What `gen plot` makes of the run, which may have been written to where it cannot be read again."""
    from gen.drawing.content import section_of
    from gen.drawing.forms import drawn, form_of
    from gen.record.port import write_parts

    with tempfile.TemporaryDirectory() as folder:
        parts = write_parts(session.recorder, Path(folder) / "run.csv")
        sections = [section_of(path, None) for path in parts]
    number = [f", part {k}" if len(parts) > 1 else "" for k in range(1, len(parts) + 1)]
    titled = [replace(one, title=f"{title}{which}") for one, which in zip(sections, number, strict=True)]
    return drawn(titled, form_of(plot))


@dataclass(frozen=True)
class _Wanted:
    """What the options ask for; all faults in them have been found when it is made."""

    wiring: Wiring
    made: Made
    profile: Profile
    carried: list[str]
    events: list[Event]
    image: bytes | None


def _wanted(loaded: Coefficients, coefficients: Path, options: dict[str, Any]) -> _Wanted:
    from gen.avr.chip import BOARDS
    from gen.emulate.options import check_profile, parse_events
    from gen.emulate.scenario import make_plant
    from gen.record.profile import carried_comments, parse_profile

    wiring = loaded.document.wiring
    if wiring is None or not wiring.thermocouples:
        raise InputError("has no thermocouples: there is nothing to emulate", file=str(coefficients), place="$.wiring")
    if options["elf"] is not None and not options["elf"].is_file():
        raise InputError("there is no such file; expected a firmware for the board", file=str(options["elf"]))
    profile = parse_profile(options["profile"])
    check_profile(profile, options["duration"])
    names = ("button", "reset", "power_cut", "brown_out", "send", "flood")
    events = parse_events(options["duration"], **{name: options[name] for name in names})
    made = make_plant(_scenario(options), loaded, coefficients)
    carried = carried_comments(options["profile"])
    return _Wanted(wiring, made, profile, carried, events, _eeprom_image(options["eeprom"], BOARDS[wiring.board]))


def _scenario(options: dict[str, Any]) -> Scenario:
    from gen.emulate.scenario import Scenario

    alike = ("plant", "fault", "fault_start", "fault_severity", "sensor_tolerance", "ambient", "load", "start", "seed")
    return Scenario(
        sensor_faults=options["sensor_fault"],
        channels=options["channel"],
        **{name: options[name] for name in alike},
    )


def _board(
    loaded: Coefficients, coefficients: Path, wanted: _Wanted, stack: ExitStack, options: dict[str, Any]
) -> Board:
    from gen.emulate.board import Board
    from gen.emulate.firmware import build_firmware, cache_folder

    cache = cache_folder()
    elf: Path | None = options["elf"]
    if elf is None:
        elf = build_firmware(loaded, options["arithmetic"], options["schedule"], shown_name(coefficients), cache).elf
    options["elf_sha256"] = hashlib.sha256(elf.read_bytes()).hexdigest()
    board = Board(elf, cache, wanted.wiring, wanted.made.plant, encoder=options["encoder"])
    stack.callback(board.close)
    if wanted.image is not None:
        board.mega.eeprom.image = wanted.image
    if options["clock"] is not None:
        board.mega.start_clock_at(options["clock"])
    return board


def _run(board: Board, wanted: _Wanted, stack: ExitStack, options: dict[str, Any]) -> Session:
    from gen.emulate.progress import run_progress
    from gen.emulate.session import run_session
    from gen.emulate.terminal import PseudoTerminal
    from gen.interruption import interruption

    pace: float | None = options["time_lapse"]
    terminal = None
    if options["pty"] is not None:
        terminal = stack.enter_context(PseudoTerminal(options["pty"]))
        pace = pace or 1.0
        click.echo(f"{options['pty']}: waiting until it is opened (it leads to {terminal.name})", err=True)
        terminal.wait()
    # Held until everything is written: a second Ctrl-C must not lose what the first one kept.
    interrupted = stack.enter_context(interruption()).is_set
    with run_progress(options["duration"]) as progress:
        session = run_session(
            board,
            options["duration"],
            profile=wanted.profile,
            events=wanted.events,
            terminal=terminal,
            pace=pace,
            progress=progress,
            interrupted=interrupted,
        )
    if terminal is not None:
        terminal.drain(given_up=interrupted)
    return session


def _eeprom_image(path: Path | None, chip: Chip) -> bytes | None:
    if path is None or not path.exists():
        return None
    try:
        image = path.read_bytes()
    except OSError as error:
        raise InputError(f"cannot be read: {error.strerror}", file=str(path)) from error
    if len(image) != chip.eeprom_bytes:
        raise InputError(
            f"has {len(image)} bytes, expected the {chip.eeprom_bytes} of an {chip.name}'s EEPROM", file=str(path)
        )
    return image


def _settings(loaded: Coefficients, made: Made, options: dict[str, Any]) -> dict[str, Any]:
    from gen.version import __version__

    kept = {name: value for name, value in options.items() if value not in (None, ()) and not isinstance(value, Path)}
    return {
        "tool": f"gen {__version__}",
        "model": loaded.name,
        "coefficients_sha256": loaded.sha256,
        "plant": made.about,
        "motor_fault": made.fault,
        "sensor_offsets_K": {name: round(offset, 3) for name, offset in made.offsets_K.items()},
        "settings": kept,
    }


def _title(loaded: Coefficients, made: Made, options: dict[str, Any]) -> str:
    fault = "healthy motor" if made.fault == "none" else f"fault: {made.fault}"
    return f"{loaded.name}, {fault}, PWM {options['profile']}"


def _comments(found: dict[str, Any], options: dict[str, Any]) -> list[str]:
    ended = f"after {found['seconds']:.2f} of {options['duration']:.12g} s"
    return [
        *([f"# interrupted: {ended}"] if found["interrupted"] else []),
        f"# emulated: {found['tool']}, encoder {options['encoder']}, seed {options['seed']}",
        f"# plant: {found['plant']}",
        f"# motor_fault: {found['motor_fault']}",
        f"# power_on: {-found['time_zero_s']:.2f} s",
        f"# elf_sha256: {options['elf_sha256']}",
    ]


def _tell(found: dict[str, Any]) -> None:
    from gen.emulate.results import Acted, Alarm
    from gen.reference.sensors import SensorCode

    click.echo(f"  plant: {found['plant']}")
    offsets = ", ".join(f"{name} {offset:+.2f} K" for name, offset in found["sensor_offsets_K"].items())
    click.echo(f"  sensors read beside what is there: {offsets} (--sensor-tolerance)")
    click.echo(
        f"  {found['seconds']:.0f} s in {found['wall_s']:.1f} s; {found['garbled_lines']} garbled lines, "
        f"{len(found['restarts_s'])} restarts"
    )
    for written in found["alarms"]:
        alarm = Alarm(**written)
        led = f", on the LED at {alarm.led_s:.1f} s" if alarm.led_s is not None else ""
        end = f", ended at {alarm.ended_s:.1f} s" if alarm.ended_s is not None else ""
        click.echo(f"  alarm {alarm.rule} at {alarm.raised_s:.1f} s{led}{end}")
    if not found["alarms"]:
        click.echo("  no alarm")
    for written in found["acted"]:
        acted = Acted(**written)
        end = f", ended at {acted.to_s:.1f} s" if acted.to_s is not None else ""
        click.echo(f"  protection {acted.cause} at {acted.from_s:.1f} s{end}")
    for item in found["disbelieved"]:
        why = SensorCode(int(item["code"])).name.lower()
        end = f"{item['to_s']:.1f} s" if item["to_s"] is not None else "the end"
        click.echo(
            f"  {item['channel']} not believed ({why}, code {item['code']}) from {item['from_s']:.1f} s to {end}"
        )
