"""Runs the C++ of a network on forms (:mod:`gen.certificate.network.forms`): what it does follows from its own text.

Whole numbers of 8 to 64 bits, float32, arrays, pointers into them, loops of known length, functions: nothing is known
of what they are used for. Every number is held against its type, and what is not understood is refuted. On the AVR an
``int`` has 16 bits: a product or a sum of two numbers of at most 16 bits has to fit 16 of them.
"""

from __future__ import annotations

import operator
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from pycparser import c_ast

from gen.certificate.network.arithmetic import Arithmetic, Number
from gen.certificate.network.forms import Space
from gen.certificate.network.known import KnownTexts
from gen.certificate.network.memory import Cell, Flash, Model, Pointer, Told
from gen.certificate.network.single import single
from gen.certificate.network.source import Table, Unit
from gen.certificate.network.words import check_text
from gen.certificate.refuted import Refuted

_MOST_ROUNDS = 1024


class _Returned(Exception):
    def __init__(self, value: Any) -> None:  # noqa: ANN401
        self.value = value


class Machine:
    """Runs functions of one unit.

    Parameters
    ----------
    unit
        Whose functions.
    tables
        What lies in flash.
    space
        What numbers are made of.
    model
        In RAM.
    of_channel
        What a function of a channel's value alone gives, by the function's name and the channel.
    of_law
        What a function of numbers gives that puts another number where its last argument points to, both by the
        function's name and those numbers; None for one that is run.
    """

    def __init__(
        self,
        unit: Unit,
        tables: Mapping[str, Table],
        space: Space,
        model: Model,
        of_channel: Callable[[str, int], Number],
        of_law: Callable[[str, Sequence[Number]], tuple[Number, Number] | None] = lambda *_: None,
    ) -> None:
        self._unit, self._tables, self._space = unit, tables, space
        self._do = Arithmetic(space)
        self._known = KnownTexts(unit, space, self.call)
        self._model, self._of_channel, self._of_law = model, of_channel, of_law

    def call(self, name: str, *arguments: Any) -> Any:  # noqa: ANN401
        """Run a function.

        Raises
        ------
        Refuted
            If it does what is not understood, or what may overflow.
        """
        if len(arguments) == 1 and isinstance(arguments[0], Told):
            return self._of_channel(name, arguments[0].channel)
        known = self._known.of(name, arguments)
        if known is not None:
            return known(*arguments)
        *numbers, where = arguments or (None,)
        if numbers and isinstance(where, Pointer) and all(isinstance(one, Number) for one in numbers):
            made = self._of_law(name, numbers)
            if made is not None:
                where = self._within(where, 0)
                where.cells[where.at] = self._replaced(where.cells[where.at], "=", made[1])
                return made[0]
        tree = self._chosen(name, arguments)
        variables: dict[str, Any] = {}
        parameters = tree.decl.type.args.params if tree.decl.type.args is not None else []
        for parameter, value in zip(parameters, arguments, strict=False):
            if isinstance(value, Number):
                value = self._do.converted(value, self._kind(parameter.type))
            variables[parameter.name] = value
        try:
            self._block(tree.body, variables)
        except _Returned as returned:
            result = returned.value
            return self._do.converted(result, self._kind(tree.decl.type.type)) if isinstance(result, Number) else result
        return None

    def _chosen(self, name: str, arguments: Sequence[Any]) -> c_ast.FuncDef:
        """The function of a name that takes such arguments."""
        fitting = []
        for tree in self._unit.functions(name):
            given = tree.decl.type.args.params if tree.decl.type.args is not None else []
            given = [one for one in given if not isinstance(one, c_ast.Typename)]  # (void)
            fits = len(given) == len(arguments)
            for parameter, value in zip(given, arguments, strict=False):
                fits &= isinstance(parameter.type, c_ast.PtrDecl) == isinstance(value, Pointer)
            if fits:
                fitting.append((tree, given))
        if len(fitting) > 1:  # overloaded: then by the exact types
            fitting = [
                (tree, given)
                for tree, given in fitting
                if all(
                    isinstance(value, Number) and value.kind == self._kind(parameter.type)
                    for parameter, value in zip(given, arguments, strict=True)
                )
            ]
        if len(fitting) != 1:
            raise Refuted(f"{name} takes other arguments than expected")
        return fitting[0][0]

    def _kind(self, node: c_ast.Node) -> str | None:
        """The type that a declaration names; None for one of a template."""
        match node:
            case c_ast.TypeDecl(type=c_ast.IdentifierType(names=[name])) if name in self._unit.kinds:
                return self._unit.kinds[name]
            case c_ast.TypeDecl(type=c_ast.IdentifierType(names=[name])) if name in self._unit.templates:
                return None
        raise Refuted(f"a type that the proof does not know: {type(node).__name__}")

    # Statements.

    def _block(self, block: c_ast.Node, variables: dict[str, Any]) -> None:
        for statement in block.block_items or [] if isinstance(block, c_ast.Compound) else [block]:
            self._statement(statement, variables)

    def _statement(self, node: c_ast.Node, variables: dict[str, Any]) -> None:
        match node:
            case c_ast.Decl(name=name, storage=storage):
                if name in variables or storage:
                    raise Refuted(f"{name} is declared twice, or kept from sample to sample")
                variables[name] = self._declared(node, variables)
            case c_ast.Assignment(op=op, lvalue=place, rvalue=value):
                self._assign(op, place, self._value(value, variables), variables)
            case c_ast.Return(expr=value):
                raise _Returned(None if value is None else self._value(value, variables))
            case c_ast.FuncCall(name=c_ast.ID(name=name), args=c_ast.ExprList(exprs=[c_ast.ID(name=to), value])) if (
                name == f"{self._unit.model}_gather"
            ):
                check_text(self._unit.model, "gather", self._unit.texts.get(name, []))
                where = self._passed(to, variables)
                where.cells[where.at] = self._replaced(where.cells[where.at], "=", self._value(value, variables))
            case c_ast.FuncCall():
                self._value(node, variables)
            case c_ast.For():
                self._loop(node, variables)
            case c_ast.Cast(
                to_type=c_ast.Typename(type=c_ast.TypeDecl(type=c_ast.IdentifierType(names=["void"]))),
                expr=c_ast.ID(),  # a name alone: it is unused, and nothing is done
            ):
                return
            case _:
                raise Refuted(f"a statement that the proof does not know: {type(node).__name__}")

    def _declared(self, node: c_ast.Decl, variables: dict[str, Any]) -> Any:  # noqa: ANN401
        match node.type:
            case c_ast.ArrayDecl(type=inner, dim=length):
                kind, count = self._kind(inner), self._do.whole(self._value(length, variables))
                if node.init is None:
                    return [Number(kind or "", self._space.number(np.nan))] * count
                match node.init:
                    case c_ast.InitList(exprs=[c_ast.Constant(value="0" | "0.0f")]):
                        return [self._do.known(0.0, kind or "")] * count
                raise Refuted(f"{node.name} is not filled with zeros")
            case c_ast.PtrDecl():
                return self._value(node.init, variables)
            case _:
                kind = self._kind(node.type)
                if node.init is None:
                    return Number(kind or "", self._space.number(np.nan))
                return self._do.converted(self._value(node.init, variables), kind)

    def _loop(self, node: c_ast.For, variables: dict[str, Any]) -> None:
        """``for (uint8_t i = 0; i < N; ++i)``."""
        match node:
            case c_ast.For(
                init=c_ast.DeclList(decls=[c_ast.Decl(name=name) as first]),
                cond=c_ast.BinaryOp(op="<", left=c_ast.ID(name=compared), right=end),
                next=c_ast.UnaryOp(op="++", expr=c_ast.ID(name=counted)),
            ) if name == compared == counted and name not in variables:
                start = self._declared(first, variables)
                last = self._do.whole(self._value(end, variables))
                for count in range(self._do.whole(start), last):
                    if count - self._do.whole(start) >= _MOST_ROUNDS:
                        raise Refuted("a loop that goes round too often")
                    inner = {**variables, name: self._do.converted(self._do.known(float(count)), start.kind)}
                    self._block(node.stmt, inner)
                    if self._do.whole(inner[name]) != count:
                        raise Refuted("a loop that changes its own count")
                    for kept in variables:
                        variables[kept] = inner[kept]
            case _:
                raise Refuted("a loop that the proof does not know")

    def _assign(self, op: str, place: c_ast.Node, value: Any, variables: dict[str, Any]) -> None:  # noqa: ANN401
        match place:
            case c_ast.ID(name=name) if name in variables:
                variables[name] = self._replaced(variables[name], op, value)
            case c_ast.ArrayRef() | c_ast.UnaryOp(op="*"):
                where = self._place(place, variables)
                where.cells[where.at] = self._replaced(where.cells[where.at], op, value)
            case c_ast.StructRef(type=".", name=c_ast.ArrayRef() as of, field=c_ast.ID(name=("hi" | "lo") as half)):
                where = self._place(of, variables)
                self._put(where.cells[where.at], half, op, value)
            case _:
                raise Refuted(f"an assignment that the proof does not know: to {type(place).__name__}")

    def _replaced(self, old: Any, op: str, value: Any) -> Any:  # noqa: ANN401
        if op != "=":
            value = self._binary(op.removesuffix("="), old, value)
        if isinstance(old, Number) and isinstance(value, Number):
            return self._do.converted(value, old.kind)
        if isinstance(old, Pointer) and isinstance(value, Pointer):
            return value
        raise Refuted("an assignment of another type")

    def _put(self, cell: Any, half: str, op: str, value: Number) -> None:  # noqa: ANN401
        """``lo = 0`` and then ``hi = word``."""
        if not isinstance(cell, Cell) or op != "=":
            raise Refuted("an assignment that the proof does not know")
        if half == "lo":
            if self._do.whole(value) != 0:
                raise Refuted("a word's lower bits are not cleared")
            cell.form = None
        else:
            if cell.form is not None:
                raise Refuted("a word's lower bits are not cleared")
            cell.form = self._do.converted(value, "int32_t").form.times(2.0**cell.low_bits)

    # Expressions.

    def _value(self, node: c_ast.Node, variables: dict[str, Any]) -> Any:  # noqa: ANN401
        match node:
            case c_ast.Constant(type=kind, value=text):
                return self._literal(kind, text)
            case c_ast.ID(name=name):
                return self._named(name, variables)
            case c_ast.UnaryOp(op="-", expr=inner):
                return self._binary("-", self._do.known(0.0, "int16_t"), self._value(inner, variables))
            case c_ast.UnaryOp(op="&", expr=c_ast.ArrayRef() as inner):
                found = self._place(inner, variables)
                return found.cells[found.at] if isinstance(found.cells, Flash) else found
            case c_ast.Cast(to_type=c_ast.Typename(type=to)):
                return self._do.converted(self._value(node.expr, variables), self._kind(to))
            case c_ast.TernaryOp(cond=condition, iftrue=yes, iffalse=no):
                return self._value(yes if self._decided(condition, variables) else no, variables)
            case c_ast.BinaryOp(op=op, left=left, right=right):
                return self._binary(op, self._value(left, variables), self._value(right, variables))
            case c_ast.FuncCall(name=c_ast.ID(name=name), args=arguments):
                given = [self._value(one, variables) for one in (arguments.exprs if arguments else [])]
                return self._called(name, given)
            case c_ast.ArrayRef() | c_ast.UnaryOp(op="*"):
                found = self._place(node, variables)
                return found.cells[found.at]
            case c_ast.StructRef(type=".", name=of, field=c_ast.ID(name="T")) if self._is_state(of):
                return Pointer(self._model.T, 0)
            case c_ast.StructRef(type=".", name=of, field=c_ast.ID(name="hi")):
                return self._high(self._value(of, variables))
        raise Refuted(f"an expression that the proof does not know: {type(node).__name__}")

    def _decided(self, node: c_ast.Node, variables: dict[str, Any]) -> bool:
        """A comparison of numbers that are known."""
        match node:
            case c_ast.BinaryOp(op=("<" | ">" | "<=" | ">=" | "==" | "!=") as op, left=left, right=right):
                one, other = (self._do.whole(self._value(side, variables)) for side in (left, right))
                return bool(_COMPARISONS[op](one, other))
        raise Refuted("a condition that the proof does not know")

    def _is_state(self, node: c_ast.Node) -> bool:
        match node:
            case c_ast.StructRef(type=".", name=c_ast.ID(name=name), field=c_ast.ID(name="state")):
                return self._is_model(name)
        return False

    def _is_model(self, name: str) -> bool:
        return name == f"{self._unit.model}_model"

    def _named(self, name: str, variables: dict[str, Any]) -> Any:  # noqa: ANN401
        if name in variables:
            value = variables[name]
            return Pointer(value, 0) if isinstance(value, list) else value
        if name in self._unit.constants:
            value, kind = self._unit.constants[name]
            return self._do.fitted(self._do.known(float(value), kind))
        if name in self._tables:
            return Pointer(Flash(self._tables[name], self._space), 0)
        raise Refuted(f"a name that the proof does not know: {name}")

    def _literal(self, kind: str, text: str) -> Number:
        if kind == "float":
            return self._do.known(single(text), "float")
        digits = text.rstrip("uULl")
        suffix = text[len(digits) :]
        if not digits.isdecimal() or suffix not in ("", "u", "L", "UL"):
            raise Refuted(f"a number that the proof does not know: {text}")
        value = int(digits)
        plain = "int16_t" if value < 1 << 15 else "int32_t" if value < 1 << 31 else "int64_t"
        chosen = {"": plain, "u": "uint16_t", "L": "int32_t", "UL": "uint32_t"}[suffix]
        return self._do.fitted(self._do.known(float(value), chosen))

    def _called(self, name: str, given: list[Any]) -> Any:  # noqa: ANN401
        if name in _MADE and len(given) == 1:
            return self._do.converted(given[0], _MADE[name])
        if name.startswith("pgm_read_") and len(given) == 1 and isinstance(given[0], Number):
            kinds = {"byte": "uint8_t", "word": "uint16_t", "dword": "uint32_t", "float": "float"}
            if kinds.get(name.removeprefix("pgm_read_")) == given[0].kind:
                return given[0]
            raise Refuted(f"{name} reads a number of another type")
        return self.call(name, *given)

    def _place(self, node: c_ast.Node, variables: dict[str, Any]) -> Any:  # noqa: ANN401
        """A place in an array, in flash, or a channel."""
        match node:
            case c_ast.ArrayRef(
                name=c_ast.StructRef(type=".", name=c_ast.ID(name=of), field=c_ast.ID(name="channel")), subscript=index
            ) if self._is_model(of):
                return Pointer([Told(self._do.whole(self._value(index, variables)))], 0)
            case c_ast.ArrayRef(name=of, subscript=index):
                array, number = self._value(of, variables), self._value(index, variables)
                if isinstance(array, Pointer) and isinstance(array.cells, Flash) and array.at == 0:
                    return array.cells.place(number)
                return self._within(array, self._do.whole(number))
            case c_ast.UnaryOp(op="*", expr=c_ast.UnaryOp(op="p++", expr=c_ast.ID(name=name))):
                return self._passed(name, variables)
            case c_ast.UnaryOp(op="*", expr=inner):
                return self._within(self._value(inner, variables), 0)
        raise Refuted(f"a place that the proof does not know: {type(node).__name__}")

    def _passed(self, name: str, variables: dict[str, Any]) -> Pointer:
        """Where a pointer points to, which goes on to the next place."""
        found = self._within(variables.get(name), 0)
        variables[name] = Pointer(found.cells, found.at + 1)
        return found

    @staticmethod
    def _within(pointer: Any, further: int) -> Pointer:  # noqa: ANN401
        if not isinstance(pointer, Pointer) or not 0 <= pointer.at + further < len(pointer.cells):
            raise Refuted("a place outside of its array")
        return Pointer(pointer.cells, pointer.at + further)

    def _binary(self, op: str, left: Any, right: Any) -> Any:  # noqa: ANN401
        if isinstance(left, Pointer) and isinstance(right, Number) and op == "+":
            return Pointer(left.cells, left.at + self._do.whole(right))
        if not (isinstance(left, Number) and isinstance(right, Number)):
            raise Refuted(f"an operation that the proof does not know: {op}")
        return self._do.binary(op, left, right)

    def _high(self, cell: Any) -> Number:  # noqa: ANN401
        if not isinstance(cell, Cell) or cell.form is None:
            raise Refuted("a member that the proof does not know: hi")
        whole = self._do.shifted(">>", Number("int64_t", cell.form), cell.low_bits)
        return self._do.fitted(Number("int32_t", whole.form))


_MADE = {"INT32_C": "int32_t", "UINT32_C": "uint32_t", "INT64_C": "int64_t"}
_COMPARISONS = {
    "<": operator.lt,
    ">": operator.gt,
    "<=": operator.le,
    ">=": operator.ge,
    "==": operator.eq,
    "!=": operator.ne,
}
