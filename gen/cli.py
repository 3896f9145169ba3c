"""The command line: its commands, and what their failures become."""

from __future__ import annotations

import os
import sys

import click

from gen import __version__
from gen.commands.build import build
from gen.commands.emulate import emulate
from gen.commands.identify import identify, study
from gen.commands.log import log
from gen.commands.refine import refine
from gen.commands.simulate import simulate
from gen.commands.thresholds import thresholds
from gen.commands.verify import verify
from gen.errors import CheckFailed, InputError

# The matrices are small: threads of the linear algebra library would only wait for each other. Set before numpy loads.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")


@click.group(context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(__version__, prog_name="gen")
def cli() -> None:
    """Turn identified motor-temperature coefficients into proven firmware for the Arduino Mega 2560."""


for command in (build, verify, simulate, emulate, log, identify, thresholds, study, refine):
    cli.add_command(command)


def main() -> None:
    """Run the command line; turn failures into one message and an exit status."""
    try:
        cli.main(standalone_mode=False)
    except click.exceptions.Abort:
        click.echo("interrupted", err=True)
        sys.exit(130)
    except click.ClickException as error:
        error.show()
        sys.exit(2)
    except click.exceptions.Exit as error:
        sys.exit(error.exit_code)
    except InputError as error:
        click.echo(f"error: {error}", err=True)
        sys.exit(2)
    except CheckFailed as error:
        click.echo(f"failed: {error}", err=True)
        sys.exit(1)
