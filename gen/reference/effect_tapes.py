"""Tapes as the board executes them, and the limits to which it holds their results."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gen.arrays import IntArray, SingleArray
from gen.lowering.effects.graph import Operand
from gen.lowering.effects.tape import Tape

Values = Mapping[Operand, IntArray]


def rounded(value: IntArray, shift: int) -> IntArray:
    """value 2^-shift, to nearest; halves upwards. A negative shift is exact."""
    if shift <= 0:
        return value << -shift
    return (value + (1 << (shift - 1))) >> shift


def evaluate(tape: Tape, operands: Values, row: IntArray) -> list[NDArray[Any]]:
    """Outputs of a tape: int64 with the outputs' formats, or float32.

    Parameters
    ----------
    tape
        What to execute.
    operands
        The board's whole numbers, shape (L,).
    row
        Row of the domain, shape (L,).
    """
    run = _fixed if tape.arithmetic == "fixed" else _single
    values = run(tape, operands, row)
    return [values[number] for number in tape.outputs]


def _fixed(tape: Tape, operands: Values, row: IntArray) -> list[IntArray]:
    values: list[IntArray] = []
    for step in tape.steps:
        a = [values[n] for n in step.args]
        match step.op:
            case "operand":
                assert step.operand is not None
                value = operands[step.operand]
            case "constant":
                value = np.full(row.shape, step.table[0], dtype=np.int64)
            case "row":
                value = np.asarray(step.table, dtype=np.int64)[row]
            case "mul":
                value = rounded(a[0] * a[1], step.shifts[0])
            case "neg":
                value = -a[0]
            case _:
                left, right = (rounded(x, s) for x, s in zip(a, step.shifts, strict=True))
                value = left + right if step.op == "add" else left - right
        values.append(value)
    return values


def _single(tape: Tape, operands: Values, row: IntArray) -> list[SingleArray]:
    values: list[SingleArray] = []
    for step in tape.steps:
        a = [values[n] for n in step.args]
        match step.op:
            case "operand":
                assert step.operand is not None
                value = operands[step.operand].astype(np.float32) * np.float32(2.0**-step.q)
            case "constant":
                value = np.full(row.shape, step.table[0], dtype=np.float32)
            case "row":
                value = np.asarray(step.table, dtype=np.float32)[row]
            case "mul":
                value = a[0] * a[1]
            case "neg":
                value = -a[0]
            case "add":
                value = a[0] + a[1]
            case _:
                value = a[0] - a[1]
        values.append(value)
    return values


class Counter:
    """How often each lane's values were held to their limits."""

    def __init__(self, lanes: int) -> None:
        self.count: IntArray = np.zeros(lanes, dtype=np.int64)

    def held(self, value: IntArray, low: int, high: int) -> IntArray:
        """The value within its limits, both included."""
        within = np.clip(value, low, high)
        self.count = self.count + (within != value)
        return np.asarray(within)

    def words(self, tape: Tape, number: int, value: NDArray[Any], bits: int, end: int) -> IntArray:
        """An output of a tape as words of 2^-bits, within +/- end."""
        if tape.arithmetic == "fixed":
            return self.held(rounded(value, tape.output_bits(number) - bits), -end, end)
        words, limit = value * np.float32(2.0**bits), np.float32(end)
        high, low = ~(words < limit), ~(words > -limit)
        self.count = self.count + (high | low)
        return np.where(high, end, np.where(low, -end, np.trunc(np.where(high | low, 0.0, words)))).astype(np.int64)
