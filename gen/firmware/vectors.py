"""Reference vectors for the emitted project's own tests."""

from __future__ import annotations

from typing import TypedDict

import numpy as np

from gen.lowering.program import Program
from gen.reference.board import reference_of, state_names

_SEGMENTS = 24
_LONGEST = 90


class Segment(TypedDict):
    """A PWM that is held for so many samples, and the state words after them as literals."""

    pwm: int
    samples: int
    words: list[str]


class Vectors(TypedDict):
    """A run from rest at `start_mK`; `words` is how many state words each segment has."""

    start_mK: int
    segments: list[Segment]
    words: int


def reference_vectors(program: Program) -> Vectors:
    """A short PWM sequence with every kind of change in it, and the state words after each of its segments.

    Parameters
    ----------
    program
        What the board holds.
    """
    random = np.random.default_rng(1)
    scale = program.model.full_scale
    levels = [0, scale, 1, 0, scale // 2, -scale, *random.integers(-scale, scale + 1, _SEGMENTS - 6).tolist()]
    lengths = [3, 60, 1, 1, *random.integers(1, _LONGEST, _SEGMENTS - 4).tolist()]
    low = max(part.start_range_mK[0] for part in program.parts)
    high = min(part.start_range_mK[1] for part in program.parts)
    start = int(np.clip(20_250, low, high))
    model = reference_of(program, [start])
    names = state_names(program)
    segments: list[Segment] = []
    for pwm, samples in zip(levels, lengths, strict=True):
        for _ in range(samples):
            model.step(np.array([pwm], dtype=np.int64))
        record = model.record()[0]
        words = [f"0x{word:X}UL" for name in names for word in _halves(record[name])]
        segments.append({"pwm": pwm, "samples": samples, "words": words})
    return {"start_mK": start, "segments": segments, "words": len(segments[0]["words"])}


def _halves(word: np.generic) -> list[int]:
    """A word of up to 32 bits; one of 64 bits as its lower and its upper half."""
    value = int(word)
    parts = [value, value >> 32] if word.dtype.itemsize == 8 else [value]
    return [part & 0xFFFFFFFF for part in parts]
