"""The onboard schedule, step for step as the board computes it (:mod:`gen.lowering.onboard.tape`)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gen.arrays import IntArray
from gen.lowering.onboard.tape import GUARD_BITS, OnboardComponent, Step
from gen.model.dynamics import MAX_PWM


class RangeError(ArithmeticError):
    """A step leaves its word: the tape is wrong."""


def mul_shift(a: IntArray, b: IntArray, shift: int) -> IntArray:
    """Bits 32-shift and up of a b without the product of the lowest bytes, to nearest; b >= 0, shift 0..7."""
    product = a * b - (a & 0xFF) * (b & 0xFF)
    result: IntArray = (product + (1 << (31 - shift))) >> (32 - shift)
    return result


def mul_byte(a: IntArray, x: IntArray, shift: int) -> IntArray:
    """a x / 2^(8-shift) to nearest, x 0..255, shift 0..8."""
    result: IntArray = (a * x * (1 << shift) + 128) >> 8
    return result


def wrapped(value: IntArray) -> IntArray:
    """Modulo 2^32, as a signed number."""
    result: IntArray = ((value + (1 << 31)) & 0xFFFFFFFF) - (1 << 31)
    return result


def divide(a: IntArray, b: IntArray, shift: int, *, rounded: bool) -> IntArray:
    """a 2^shift / b, to nearest (ties away from zero) or towards zero.

    Raises
    ------
    RangeError
        If a quotient does not fit 31 bits.
    """
    if b.size and (b.min() <= 0 or b.max() >= 1 << 32):
        raise RangeError("the divisor is not positive, or has more than 32 bits")
    divisor = b.astype(np.uint64)
    quotient, rest = np.divmod(np.abs(a).astype(np.uint64), divisor)
    for bits in (*[31] * (shift // 31), shift % 31):  # the rest has 32 bits, and 63 with those
        digits, rest = np.divmod(rest << np.uint64(bits), divisor)
        quotient = (quotient << np.uint64(bits)) + digits
        _check_quotient(quotient)
    if rounded:
        quotient = quotient + (rest >= divisor - rest)
    _check_quotient(quotient)
    magnitude = quotient.astype(np.int64)
    return np.where(a < 0, -magnitude, magnitude)


def _check_quotient(quotient: NDArray[np.uint64]) -> None:
    if quotient.size and quotient.max() >= 1 << 31:
        raise RangeError("a quotient has more than 31 bits")


def power_series(coefficients: Sequence[float] | IntArray, u: IntArray) -> IntArray:
    """Horner's rule in 40 bits, u 0..255 in units of 2^-8; the result has 8 bits less.

    Coefficients are numbers, or arrays of one number for each u.

    Raises
    ------
    RangeError
        If a coefficient or a sum does not fit 40 bits.
    """
    for coefficient in coefficients:
        if np.min(coefficient) < -(1 << 39) or np.max(coefficient) >= 1 << 39:
            raise RangeError("a coefficient of a power series has more than 40 bits")
    first, *others = (np.asarray(c).astype(np.int64) for c in coefficients)
    total: IntArray = np.broadcast_to(first, u.shape)
    for coefficient in others:
        total = (total * u >> 8) + coefficient
        if total.size and (total.min() < -(1 << 39) or total.max() >= (1 << 39) - (1 << (GUARD_BITS - 1))):
            raise RangeError("a power series leaves its 40 bits")
    result: IntArray = (total + (1 << (GUARD_BITS - 1))) >> GUARD_BITS
    return result


def evaluate(
    component: OnboardComponent, pwm: IntArray, tables: Mapping[int, IntArray] | None = None
) -> tuple[NDArray[Any], NDArray[Any]]:
    """Run the tape.

    Parameters
    ----------
    component
        What to run.
    pwm
        |PWM| within the component's domain, shape (m,).
    tables
        By a step's number, tables to take in place of its own, one for each PWM, shape (entries, m); fixed only.

    Returns
    -------
    rates, steady
        Shapes (m, n) and (m,): int64 in the layout's formats, or float32.

    Raises
    ------
    RangeError
        If a word of the fixed tape would overflow (never within the domain).
    """
    x = np.asarray(pwm, dtype=np.int64)
    if x.size and (x.min() < component.domain[0] or x.max() > component.domain[1]):
        raise ValueError(f"|PWM| is {component.domain[0]}..{component.domain[1]}")
    tables = tables or {}
    values: list[NDArray[Any]] = []
    for number, step in enumerate(component.steps):
        args = [values[a] for a in step.args]
        if step.op in ("input", "segment", "local"):
            values.append(_whole_number(step, x, args))
        elif component.arithmetic == "float":
            values.append(_float_step(step, x, args))
        else:
            table = np.array(step.table, dtype=np.int64) if number not in tables else tables[number]
            value = _fixed_step(step, table, x, args)
            _check(value, step)
            values.append(value)
    return np.stack([values[r] for r in component.rates], axis=1), values[component.steady]


def _check(value: IntArray, step: Step) -> None:
    low, high = (0, 1 << 32) if step.unsigned else (-(1 << 31), 1 << 31)
    if value.size and (value.min() < low or value.max() >= high):
        raise RangeError(f"{step.op} ({step.label.text}) leaves its 32 bits")


def _whole_number(step: Step, x: IntArray, args: list[IntArray]) -> IntArray:
    knots = np.array(step.table, dtype=np.int64)
    if step.op == "input":
        return np.clip(x, knots[0], knots[1])
    if step.op == "segment":
        return np.clip(np.searchsorted(knots, args[0], side="right") - 1, 0, len(knots) - 2)
    held: IntArray = np.clip(args[0], knots[0], knots[-1]) - knots[args[1]]
    return held


def _fixed_step(step: Step, table: IntArray, x: IntArray, args: list[IntArray]) -> IntArray:
    """One step with a table, of shape (entries,) or (entries, m)."""
    match step.op:
        case "constant":
            return np.full(x.shape, table[0])
        case "row":
            result = table[args[0]] if table.ndim == 1 else table[args[0], np.arange(len(x))]
        case "power_series":
            result = power_series(table, MAX_PWM - args[0] if step.shift else args[0])
        case "times":
            result = mul_byte(args[0], args[1], step.shift)
        case "mul" | "mul_modulo":
            if np.any(args[1] < 0) or np.any(args[0] >= 1 << 31):
                raise RangeError("mul takes an int32 and a uint32")
            result = mul_shift(args[0], args[1], step.shift)
            result = wrapped(result) if step.op == "mul_modulo" else result
        case "mul_signed" | "mul_signed_modulo":
            result = mul_shift(np.where(args[1] < 0, -args[0], args[0]), np.abs(args[1]), step.shift)
            result = wrapped(result) if step.op == "mul_signed_modulo" else result
        case "div" | "div_signed":
            if step.op == "div" and np.any(args[0] < 0):
                raise RangeError("div takes what is not negative")
            result = divide(args[0], args[1], step.shift, rounded=step.round)
        case "add" | "sub" | "add_modulo" | "sub_modulo":
            result = _sum(step, args[0], args[1])
        case "neg":
            result = -args[0]
        case "shr" | "floor" | "shl":
            result = _shifted(step, args[0])
        case "positive_outside":
            outside = (args[1] < table[0]) | (args[1] > table[1])
            result = np.where(outside & (args[0] < 0), 0, args[0])
        case _:
            raise ValueError(f"no step {step.op}")
    return result


def _shifted(step: Step, a: IntArray) -> IntArray:
    """To the right to nearest or rounded down, or to the left."""
    if step.op == "shl":
        return a << step.shift
    return a >> step.shift if step.op == "floor" else ((a >> (step.shift - 1)) + 1) >> 1


def _sum(step: Step, a: IntArray, b: IntArray) -> IntArray:
    """A sum or difference, modulo 2^32 where the step says so."""
    result = a - b if step.op.startswith("sub") else a + b
    if not step.op.endswith("modulo"):
        return result
    return result & 0xFFFFFFFF if step.unsigned else wrapped(result)


def _float_step(step: Step, x: IntArray, args: list[NDArray[Any]]) -> NDArray[Any]:
    single = np.float32
    table = np.array(step.table, dtype=single)
    match step.op:
        case "constant":
            result = np.full(x.shape, table[0])
        case "row":
            result = table[args[0]]
        case "exponential":
            result = table[args[0] >> 4] * table[16 + (args[0] & 15)]
        case "times":
            result = args[0] * args[1].astype(single)
        case "scale":
            result = args[0] * table[0]
        case "mul" | "mul_modulo":
            result = args[0] * args[1]
        case "div":
            result = args[0] / args[1]
        case "add":
            result = args[0] + args[1]
        case "sub":
            result = args[0] - args[1]
        case "neg":
            result = -args[0]
        case "positive_outside":
            outside = (args[1] < step.table[0]) | (args[1] > step.table[1])
            result = np.where(outside & np.signbit(args[0]), single(0), args[0])
        case _:
            raise ValueError(f"no step {step.op}")
    return result
