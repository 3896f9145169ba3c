"""The LED read with a clock, against patterns made from what the emitted README says about them."""

from __future__ import annotations

import numpy as np
import pytest

from gen.emulate.wiring.led import read_led, shown_now
from gen.emulate.wiring.levels import Edges

SLOT_S = 0.032
CYCLES = 16_000_000


def flash(slots_on: int, slots_off: int, count: int = 1) -> list[tuple[int, int]]:
    return [(slots_on, slots_off)] * count


HEALTHY = flash(2, 62, 5)
ACTS = flash(32, 32, 4)
SENSOR = flash(2, 2, 30)


def alarm(number: int, rounds: int = 2) -> list[tuple[int, int]]:
    return (flash(8, 8, number - 1) + flash(8, 8 + 48)) * rounds


def observe(*parts: list[tuple[int, int]], jitter_s: float = 0.0) -> tuple[Edges, float, list[float]]:
    generator = np.random.default_rng(1)
    time_s, times, levels, starts = 1.0, [], [], []
    for part in parts:
        starts.append(time_s)
        for on, off in part:
            times += [time_s, time_s + on * SLOT_S]
            levels += [True, False]
            time_s += (on + off) * SLOT_S
    noisy = np.array(times) + generator.uniform(0.0, jitter_s, len(times))
    return Edges((noisy * CYCLES).astype(np.uint64), np.array(levels)), time_s, starts


@pytest.mark.parametrize("jitter_s", [0.0, 0.01])
def test_patterns_are_told_apart_and_dated(jitter_s: float) -> None:
    edges, end_s, starts = observe(HEALTHY, alarm(3), SENSOR, HEALTHY, alarm(1), jitter_s=jitter_s)
    seen = read_led(edges, end_s)
    assert [item.pattern for item in seen] == ["healthy", "alarm 3", "sensor", "healthy", "alarm 1"]
    for item, start_s in zip(seen, starts, strict=True):
        # The first flash behind a flicker might as well be its last.
        assert item.from_s == pytest.approx(start_s, abs=2.1 if item.pattern == "healthy" else 0.07)


def test_alarms_that_take_turns_are_told_each_time() -> None:
    edges, end_s, _ = observe(alarm(1, 1), alarm(4, 1), alarm(1, 1))
    assert [item.pattern for item in read_led(edges, end_s)] == ["alarm 1", "alarm 4", "alarm 1"]


def test_a_number_that_is_cut_short_by_the_end_is_not_told() -> None:
    edges, _, _ = observe(HEALTHY, alarm(5, 1))
    blinks = edges.seconds[edges.levels]
    cut = blinks[-3]
    keep = edges.seconds < cut
    seen = read_led(Edges(edges.cycles[keep], edges.levels[keep]), cut)
    assert [item.pattern for item in seen] == ["healthy"]


def test_a_dark_led() -> None:
    nothing = Edges(np.zeros(0, dtype=np.uint64), np.zeros(0, dtype=np.bool_))
    assert [item.pattern for item in read_led(nothing, 10.0)] == ["dark"]


def test_a_board_that_acts_is_told_from_an_alarm() -> None:
    edges, end_s, _ = observe(HEALTHY, ACTS, alarm(1))
    assert [item.pattern for item in read_led(edges, end_s)] == ["healthy", "acts", "alarm 1"]


def both(number: int, rounds: int = 2) -> list[tuple[int, int]]:
    """An alarm's number, and a flicker in its pause."""
    return (flash(8, 8, number) + flash(2, 2, 12)) * rounds


@pytest.mark.parametrize(
    ("parts", "expected"),
    [
        ([HEALTHY], ("healthy",)),
        ([SENSOR], ("sensor",)),
        ([ACTS], ("acts",)),
        ([HEALTHY, alarm(2)], ("alarm 2",)),
        ([alarm(2), HEALTHY], ("healthy",)),
        ([HEALTHY, alarm(1, 1), alarm(4, 1)], ("alarm 1", "alarm 4")),
        ([alarm(1, 1), alarm(4, 1), alarm(1, 1)], ("alarm 4", "alarm 1")),
        ([HEALTHY, both(3)], ("alarm 3", "sensor")),
        ([both(3), SENSOR], ("sensor",)),
        ([both(3), SENSOR, HEALTHY], ("healthy",)),
    ],
)
def test_what_it_says_now(parts: list[list[tuple[int, int]]], expected: tuple[str, ...]) -> None:
    edges, end_s, _ = observe(*parts)
    assert shown_now(edges, end_s) == expected


def test_a_flash_that_is_not_over_is_not_taken_for_a_shorter_one() -> None:
    """At every moment of a healthy flash, a blink or a held light, what was said before it is still said."""
    for part, last in ((HEALTHY, "healthy"), (alarm(2, 3), "alarm 2"), (ACTS, "acts")):
        edges, end_s, _ = observe(part)
        for now in np.arange(end_s - 3.0, end_s, 0.02):
            keep = edges.seconds <= now
            assert shown_now(Edges(edges.cycles[keep], edges.levels[keep]), now) == (last,), (last, now)


def test_a_light_that_does_not_change_is_lit_or_dark() -> None:
    lit = Edges(np.array([CYCLES], dtype=np.uint64), np.array([True]))
    assert shown_now(lit, 5.0) == ("lit",)
    edges, end_s, _ = observe(alarm(1))
    assert shown_now(edges, end_s + 3.0) == ("dark",)
