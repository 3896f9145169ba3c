"""The command line: its commands, and what their failures become."""

from __future__ import annotations

import errno
import os
import signal
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import NoReturn

import click

from gen.commands.build import build
from gen.commands.check import check
from gen.commands.emulate import emulate
from gen.commands.fleet import fleet
from gen.commands.identify import identify
from gen.commands.importing import import_runs
from gen.commands.init import init
from gen.commands.live import live
from gen.commands.log import log
from gen.commands.plan import plan
from gen.commands.plot import plot
from gen.commands.refine import refine
from gen.commands.simulate import simulate
from gen.commands.thresholds import thresholds
from gen.commands.verify import verify
from gen.errors import CheckFailed, InputError

# The matrices are small: threads of the linear algebra library would only wait for each other. Set before numpy loads.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")


@click.group(context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(package_name="gen-thermal", prog_name="gen")
def cli() -> None:
    """Turn identified motor-temperature coefficients into proven firmware for the Arduino Mega 2560."""


for command in (
    build,
    verify,
    check,
    simulate,
    emulate,
    log,
    live,
    import_runs,
    identify,
    init,
    thresholds,
    refine,
    plan,
    plot,
    fleet,
):
    cli.add_command(command)


def main() -> None:
    """Run the command line; turn failures into one message and an exit status."""
    with _interruptible() as came:
        try:
            cli.main(standalone_mode=False)
        except (click.exceptions.Abort, KeyboardInterrupt):
            _interrupted(came)
        except click.exceptions.NoArgsIsHelpError as error:
            error.show()
            sys.exit(2)
        except click.ClickException as error:
            click.echo(f"error: {_one_line(_usage(error))}", err=True)
            sys.exit(2)
        except click.exceptions.Exit as error:
            sys.exit(error.exit_code)
        except InputError as error:
            click.echo(f"error: {_one_line(str(error))}", err=True)
            sys.exit(2)
        except CheckFailed as error:
            if came:
                _interrupted(came)
            click.echo(f"failed: {error}", err=True)
            sys.exit(1)
        except OSError as error:
            # Files have their own messages; what is left is the output itself, on a full disk.
            if came:
                _interrupted(came)
            if error.errno != errno.ENOSPC:
                raise
            click.echo(f"error: the output cannot be written: {error.strerror}", err=True)
            sys.exit(2)
        except Exception:
            # Compiled code may turn the interrupt into an error of its own: numpy does while it is being imported.
            if came:
                _interrupted(came)
            raise


@contextmanager
def _interruptible() -> Iterator[list[int]]:
    """Let a polite kill end a command as Ctrl-C does, so that it leaves no files; gives the signals that came."""
    came: list[int] = []

    def interrupt(number: int, _: object) -> None:
        came.append(number)
        raise KeyboardInterrupt

    before = {
        number: signal.signal(number, interrupt)
        for number in (signal.SIGINT, signal.SIGTERM)
        if signal.getsignal(number) not in (signal.SIG_IGN, None)
    }
    try:
        yield came
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def _interrupted(came: list[int]) -> NoReturn:
    click.echo("interrupted", err=True)
    sys.exit(128 + (came[0] if came else signal.SIGINT))


def _usage(error: click.ClickException) -> str:
    """What is wrong with the arguments, as all other messages have it: the place first; last where to read more."""
    said, context = error.format_message(), error.ctx if isinstance(error, click.UsageError) else None
    if isinstance(error, click.BadParameter) and not isinstance(error, click.MissingParameter):
        named = error.param_hint or (error.param.get_error_hint(context) if error.param and context else "")
        place = (named if isinstance(named, str) else ", ".join(named)).replace("'", "")
        said = f"{place}: {error.message}" if place else error.message
    said = " ".join(said.split()).rstrip(".")
    hint = f" ({context.command_path} --help)" if context is not None else ""
    return f"{said[:1].lower()}{said[1:]}{hint}"


def _one_line(text: str) -> str:
    """What a file held is quoted in messages: nothing in it may steer the terminal."""
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode("ascii") for c in text)
