"""Prove what the library has beside the model equal to its references: alarm rules, causes and actions, look ahead."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import partial
from typing import NamedTuple

from gen.arrays import RecordArray
from gen.lowering.alarms import LoweredRule
from gen.lowering.forecast import LoweredForecast
from gen.lowering.protection import LoweredProtection
from gen.verification.alarm_campaign import alarm_profile, campaign
from gen.verification.compare import Mismatch, first_mismatch
from gen.verification.forecast_campaign import forecast_campaign
from gen.verification.harness import AvrHarness, Harness, HostHarness
from gen.verification.protection_campaign import protection_campaign
from gen.verification.runners import Library

ALARMS = Harness("verify_alarms", "outputs and alarms")
PROTECTION = Harness("verify_protection", "protection")
#: More than any model's sample takes, its effects included.
_CYCLES_AHEAD = 150_000


class Compared(NamedTuple):
    """One target: its name, what the reference expects of it, and the first difference."""

    target: str
    expected: RecordArray
    mismatch: Mismatch | None


def compare_alarms(
    library: Library,
    rules: Sequence[LoweredRule],
    lanes: int,
    length: int,
    hosts: Sequence[str],
    *,
    board: bool,
) -> Iterator[Compared]:
    """Run the rules' campaign on each target.

    Parameters
    ----------
    library
        The emitted library, written to a folder.
    rules
        The lowered rules; without any, the temperatures alone are compared.
    lanes, length
        Of the campaign.
    hosts
        Which of :data:`gen.verification.runners.HOST_BUILDS` to run.
    board
        Whether to run the library's emulated board.
    """
    given = campaign(library.program, rules, alarm_profile(library.program, rules, lanes, length))
    yield from _compared(library, ALARMS, given.inputs, given.expected, hosts, board=board)


def compare_protection(
    library: Library,
    entries: Sequence[LoweredProtection],
    lanes: int,
    length: int,
    hosts: Sequence[str],
    *,
    board: bool,
) -> Iterator[Compared]:
    """Run the campaign of causes and actions on each target, as :func:`compare_alarms`; nothing without entries."""
    if entries:
        given = protection_campaign(library.program, entries, lanes, length)
        yield from _compared(library, PROTECTION, given.inputs, given.expected, hosts, board=board)


def forecast_harness(forecast: LoweredForecast) -> Harness:
    """The harnesses of a look ahead."""
    return Harness("verify_forecast", "look ahead", 400_000 + forecast.steps * _CYCLES_AHEAD)


def compare_forecast(
    library: Library,
    forecast: LoweredForecast | None,
    lanes: int,
    length: int,
    hosts: Sequence[str],
    *,
    board: bool,
) -> Iterator[Compared]:
    """Run the campaign of the look ahead on each target, as :func:`compare_alarms`; nothing where there is none."""
    if forecast is not None:
        given = forecast_campaign(library.program, forecast, lanes, length)
        yield from _compared(library, forecast_harness(forecast), given.inputs, given.expected, hosts, board=board)


def _compared(
    library: Library, harness: Harness, inputs: RecordArray, expected: RecordArray, hosts: Sequence[str], *, board: bool
) -> Iterator[Compared]:
    harness.write(library)
    kind = expected.dtype
    runners: list[Callable[[], HostHarness | AvrHarness]] = [
        partial(HostHarness, library, harness, name, kind) for name in hosts
    ]
    if board:
        runners.append(partial(AvrHarness, library, harness, library.folder / "cache", kind))
    for make in runners:
        runner = make()
        yield Compared(runner.name, expected, first_mismatch(expected, runner.run(inputs)))
