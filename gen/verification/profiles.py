"""PWM profiles that try to break the code: lanes of equal length, each with its own start temperature."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from gen.arrays import IntArray, RecordArray
from gen.lowering.effects.program import Channel
from gen.model import ThermalModel

_BEYOND = 0.05
"""Share of a channel's range by which a campaign leaves it."""


def record_type(channels: int) -> np.dtype[np.void]:
    """A lane's record as both harnesses read it, with so many channels of the effects."""
    told = [("channels", "<i4", (channels,))] if channels else []
    return np.dtype([("op", "u1"), ("pwm", "<i2"), ("start_mK", "<i4"), *told])


@dataclass(frozen=True)
class Profile:
    """Lanes to run.

    Attributes
    ----------
    pwm
        Shape (L, N), -255..255.
    start_mK
        Rise of every component at the start of each lane, shape (L,), in thousandths of a kelvin.
    channels
        What the effects are told before the start and before each sample, in thousandths, shape (L, N + 1, channels);
        None without effects.
    """

    pwm: IntArray
    start_mK: IntArray
    channels: IntArray | None = None

    @property
    def samples(self) -> int:
        """How many samples all lanes have together."""
        return int(self.pwm.size)

    def as_json(self, lane: int, columns: Sequence[str]) -> dict[str, Any]:
        """One lane, so that it can be run again: what the channels say stands before the start and each sample."""
        made: dict[str, Any] = {"start_mK": int(self.start_mK[lane]), "pwm": self.pwm[lane].tolist()}
        if self.channels is not None:
            made["channels"] = dict(zip(columns, self.channels[lane].T.tolist(), strict=True))
        return made

    def records(self) -> RecordArray:
        """All lanes one behind the other, each led by its start, as the harnesses read them."""
        lanes, length = self.pwm.shape
        count = 0 if self.channels is None else self.channels.shape[2]
        records = np.zeros((lanes, length + 1), dtype=record_type(count))
        if self.channels is not None:
            records["channels"] = self.channels
        records["op"][:, 0] = 1
        records["start_mK"][:, 0] = self.start_mK
        records["pwm"][:, 1:] = self.pwm
        return records.reshape(-1)


def campaign(model: ThermalModel, lanes: int, length: int, seed: int = 2026) -> Profile:
    """Random and adversarial lanes.

    Steps, staircases, toggling between two levels at every sample, a new random level at every sample, ramps through
    all levels, full speed and standstill in turn; starts from cold, from the domain's ends, and from beyond them.
    """
    random = np.random.default_rng(seed)
    scale = model.full_scale
    kinds = (_held, _staircase, _toggling, _noise, _ramp, _bursts)
    pwm = np.stack([kinds[lane % len(kinds)](random, scale, length) for lane in range(lanes)])
    low = round((model.domain_temperature[0] - model.domain_ambient[1]) * 1000)
    high = round((model.domain_temperature[1] - model.domain_ambient[0]) * 1000)
    start = random.integers(low, high + 1, lanes)
    corners = [0, low, high, 25_250, low - 5_000, high + 1, 0, 61_999]
    start[: min(lanes, len(corners))] = corners[:lanes]
    return Profile(pwm.astype(np.int64), start.astype(np.int64))


def with_channels(profile: Profile, channels: Sequence[Channel], seed: int = 17) -> Profile:
    """The profile with values for every channel, some beyond their ranges.

    Lanes hold a value for long, jump between the ends at every sample, draw anew at every sample, or stay neutral.
    """
    if not channels:
        return profile
    random = np.random.default_rng(seed)
    lanes, length = profile.pwm.shape
    made = np.zeros((lanes, length + 1, len(channels)), dtype=np.int64)
    for number, channel in enumerate(channels):
        beyond = int((channel.high - channel.low) * _BEYOND) + 1
        for lane in range(lanes):
            match (lane + number) % 4:
                case 0:
                    hold = int(random.integers(20, 800))
                    values = np.repeat(random.integers(channel.low, channel.high + 1, length // hold + 1), hold)
                case 1:
                    values = np.tile([channel.low, channel.high], length // 2 + 1)
                case 2:
                    values = random.integers(channel.low - beyond, channel.high + beyond + 1, length + 1)
                case _:
                    values = np.full(length + 1, channel.neutral)
            made[lane, :, number] = np.resize(values, length + 1)
    return replace(profile, channels=made)


def every_command(model: ThermalModel) -> Profile:
    """One lane through all commands -full_scale..full_scale, from cold."""
    scale = model.full_scale
    return Profile(np.arange(-scale, scale + 1, dtype=np.int64)[None, :], np.zeros(1, dtype=np.int64))


def _held(random: np.random.Generator, scale: int, length: int) -> IntArray:
    return np.repeat(random.integers(0, scale + 1, 1), length)


def _staircase(random: np.random.Generator, scale: int, length: int) -> IntArray:
    hold = int(random.integers(40, max(41, length // 4)))
    levels = random.integers(-scale, scale + 1, length // hold + 1)
    return np.repeat(levels, hold)[:length]


def _toggling(random: np.random.Generator, scale: int, length: int) -> IntArray:
    levels = np.array([0, scale]) if random.integers(2) else random.integers(0, scale + 1, 2)
    return np.tile(np.repeat(levels, random.integers(1, 4)), length)[:length]


def _noise(random: np.random.Generator, scale: int, length: int) -> IntArray:
    return random.integers(-scale, scale + 1, length)


def _ramp(random: np.random.Generator, scale: int, length: int) -> IntArray:
    up = np.arange(-scale, scale + 1)
    return np.tile(np.concatenate([up, up[::-1]]), length // (2 * up.size) + 1)[:length]


def _bursts(random: np.random.Generator, scale: int, length: int) -> IntArray:
    on = np.full(int(random.integers(100, 2000)), scale)
    off = np.zeros(int(random.integers(100, 2000)), dtype=np.int64)
    return np.tile(np.concatenate([on, off]), length // 200 + 1)[:length]
