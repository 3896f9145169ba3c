"""Runs the recursion's C++ on affine numbers, so that what it does follows from its own text.

Only what the emitted code is made of is understood: whole numbers, float32, words, one loop over equal runs. Anything
else is refuted rather than guessed.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from pycparser import c_ast

from gen.certificate.affine import Affine, Space
from gen.certificate.document import LOW_BITS
from gen.certificate.exact import Ratio, Ratios
from gen.certificate.primitives import Cell, primitive
from gen.certificate.refuted import Refuted
from gen.certificate.source import Project

_WHOLE = ("int32_t", "int64_t")


@dataclass
class State:
    """The words of one component, ``state->x``."""

    x: list[Cell]


@dataclass(frozen=True)
class Coefficients:
    """What a PWM brings, ``now``: R0 .. R[n-1] and S, shape (P,) each, and which symbol the ambient adds to S."""

    rates: Sequence[Ratios]
    steady: Ratios
    ambient: int | None = None


class _Returned(Exception):
    def __init__(self, value: Any) -> None:  # noqa: ANN401
        self.value = value


class Machine:
    """Runs functions of a project.

    Parameters
    ----------
    project
        Whose C++.
    arithmetic
        "fixed" or "float".
    space
        The symbols that numbers are made of.
    """

    def __init__(self, project: Project, arithmetic: str, space: Space) -> None:
        self._project, self._space = project, space
        self._low_bits = LOW_BITS[arithmetic]
        self._rate_kind = "uint32_t" if arithmetic == "fixed" else "float"
        self.runs = 1

    def word(self, value: Affine) -> Cell:
        """A state's word."""
        return Cell(value.as_kind("word"), self._low_bits)

    def call(self, name: str, *arguments: Any) -> Any:  # noqa: ANN401
        """Run a function of the C++, named without the prefix.

        Parameters
        ----------
        name
            ``A_increment`` or the like.
        *arguments
            Numbers, words, :class:`State` and :class:`Coefficients`.

        Raises
        ------
        Refuted
            If it does what is not understood, or what may overflow.
        """
        meaning = primitive(self._project.model, name, self._project.functions)
        if meaning is not None:
            return meaning(self._space, *arguments)
        tree = self._project.parsed(name)
        names = [parameter.name for parameter in tree.decl.type.args.params]
        if len(names) != len(arguments):
            raise Refuted(f"{self._project.model}_{name} takes other arguments than expected")
        variables: dict[str, Any] = dict(zip(names, arguments, strict=True))
        try:
            self._block(tree.body, variables)
        except _Returned as returned:
            return returned.value
        return None

    def _block(self, block: c_ast.Compound, variables: dict[str, Any]) -> None:
        for statement in block.block_items or []:
            self._statement(statement, variables)

    def _statement(self, node: c_ast.Node, variables: dict[str, Any]) -> None:
        match node:
            case c_ast.Decl(name=name, init=init, type=c_ast.TypeDecl(type=c_ast.IdentifierType(names=[kind]))):
                variables[name] = self._converted(self._initial(init, variables), kind)
            case c_ast.Assignment(op="=", lvalue=c_ast.ID(name=name), rvalue=value):
                kind = variables[name].kind
                variables[name] = self._converted(self._value(value, variables), kind)
            case c_ast.Return(expr=value):
                raise _Returned(self._value(value, variables))
            case c_ast.FuncCall():
                self._value(node, variables)
            case c_ast.For():
                self.runs = self._count(node)
                self._block(node.stmt, dict(variables))
            case _:
                raise Refuted(f"a statement that the proof does not know: {type(node).__name__}")

    def _initial(self, node: c_ast.Node, variables: dict[str, Any]) -> Any:  # noqa: ANN401
        match node:
            case c_ast.InitList(exprs=[c_ast.Constant(value="0"), c_ast.Constant(value="0")]):
                return self.word(self._space.number(0, "word"))
            case _:
                return self._value(node, variables)

    def _count(self, node: c_ast.For) -> int:
        """How often a loop over equal runs goes round: ``for (uint8_t part = 0; part < N; ++part)``."""
        match node:
            case c_ast.For(
                init=c_ast.DeclList(decls=[c_ast.Decl(name=name, init=c_ast.Constant(value="0"))]),
                cond=c_ast.BinaryOp(op="<", left=c_ast.ID(name=compared), right=c_ast.Constant(value=end)),
                next=c_ast.UnaryOp(op="++", expr=c_ast.ID(name=counted)),
            ) if name == compared == counted and end.isdecimal():
                return int(end)
        raise Refuted("a loop that the proof does not know")

    def _value(self, node: c_ast.Node, variables: dict[str, Any]) -> Any:  # noqa: ANN401
        space = self._space
        match node:
            case c_ast.Constant(type="int", value=text) if text.isdecimal():
                return space.number(int(text), "int32_t")
            case c_ast.Constant(type="float", value=text) if text.endswith("f"):
                return space.number(Ratio(float(np.float32(text[:-1]))), "float")
            case c_ast.ID(name=name) if name in variables:
                return variables[name]
            case c_ast.UnaryOp(op="&", expr=inner):
                return self._value(inner, variables)
            case c_ast.UnaryOp(op="-", expr=inner):
                return self._fitted(self._value(inner, variables).times(Ratio(-1)))
            case c_ast.Cast(to_type=c_ast.Typename(type=c_ast.TypeDecl(type=c_ast.IdentifierType(names=[kind])))):
                return self._converted(self._value(node.expr, variables), kind)
            case c_ast.BinaryOp(op=op, left=left, right=right):
                return self._binary(op, self._value(left, variables), self._value(right, variables))
            case c_ast.FuncCall(name=c_ast.ID(name=name), args=arguments):
                given = [self._value(argument, variables) for argument in (arguments.exprs if arguments else [])]
                return self.call(name.removeprefix(f"{self._project.model}_"), *given)
            case c_ast.ArrayRef(name=c_ast.StructRef(type="->"), subscript=c_ast.Constant(value=place)):
                return self._member(node.name, variables, int(place))
            case c_ast.StructRef(type="->"):
                return self._member(node, variables, None)
            case c_ast.StructRef(type=".", field=c_ast.ID(name="hi")):
                return self._value(node.name, variables).high(space)
        raise Refuted(f"an expression that the proof does not know: {type(node).__name__}")

    def _member(self, node: c_ast.StructRef, variables: dict[str, Any], place: int | None) -> Any:  # noqa: ANN401
        of, name = self._value(node.name, variables), node.field.name
        if isinstance(of, State) and name == "x" and place is not None and place < len(of.x):
            return of.x[place]
        if isinstance(of, Coefficients) and name == "rate" and place is not None and place < len(of.rates):
            return self._space.number(of.rates[place], self._rate_kind)
        if isinstance(of, Coefficients) and name == "steady" and place is None:
            steady = self._space.number(of.steady, "int32_t")
            if of.ambient is None:
                return steady
            return self._fitted(steady + self._space.symbol(of.ambient, "int32_t"))
        raise Refuted(f"a member that the proof does not know: {name}")

    def _binary(self, op: str, left: Affine, right: Affine) -> Affine:
        kinds = {left.kind, right.kind}
        if op == ">>" and right.known and left.kind in (*_WHOLE, "uint32_t"):
            return self._space.shifted(left, int(right.constant[0]))
        if kinds == {"float"}:
            return self._space.as_float(self._exactly(op, left, right))
        if kinds <= set(_WHOLE):
            kind = "int64_t" if "int64_t" in kinds else "int32_t"
            return self._fitted(self._exactly(op, left, right).as_kind(kind))
        raise Refuted(f"an operation that the proof does not know: {left.kind} {op} {right.kind}")

    def _exactly(self, op: str, left: Affine, right: Affine) -> Affine:
        match op:
            case "+":
                return left + right
            case "-":
                return left - right
            case "*" if right.known:
                return left.times(right.constant)
            case "*" if left.known:
                return right.times(left.constant)
        raise Refuted(f"an operation that the proof does not know: {op}")

    def _converted(self, value: Any, kind: str) -> Any:  # noqa: ANN401
        if isinstance(value, Cell):  # a copy: a variable that holds a word
            return Cell(value.value, value.low_bits)
        if kind == "float":
            return value if value.kind == "float" else self._space.as_float(value)
        if kind in _WHOLE and value.kind in (*_WHOLE, "uint32_t"):
            return self._fitted(value.as_kind(kind))
        raise Refuted(f"a conversion that the proof does not know: {value.kind} to {kind}")

    def _fitted(self, value: Affine) -> Affine:
        return self._space.fits(value)
