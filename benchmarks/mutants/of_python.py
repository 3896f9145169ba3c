"""Defects of Python: Cosmic Ray's operators where they change what is computed."""

from __future__ import annotations

import ast
from collections.abc import Callable, Iterator
from functools import cache, partial
from pathlib import Path

import parso
from cosmic_ray.ast import ast_nodes
from cosmic_ray.mutating import MutationVisitor
from cosmic_ray.operators.operator import Operator
from cosmic_ray.plugins import get_operator

from benchmarks.mutants.defects import Mutant, changed

OPERATORS = (
    *(f"ReplaceBinaryOperator_{pair}" for pair in ("Add_Sub", "Sub_Add", "Mul_Div", "Div_Mul", "Mul_Add", "Pow_Mul")),
    *(f"ReplaceBinaryOperator_{pair}" for pair in ("FloorDiv_Mul", "Mod_FloorDiv", "RShift_LShift", "LShift_RShift")),
    *(f"ReplaceBinaryOperator_{pair}" for pair in ("BitOr_BitAnd", "BitAnd_BitOr", "BitXor_BitOr")),
    *(f"ReplaceComparisonOperator_{pair}" for pair in ("Lt_LtE", "LtE_Lt", "Gt_GtE", "GtE_Gt", "Eq_NotEq", "NotEq_Eq")),
    *(f"ReplaceComparisonOperator_{pair}" for pair in ("Lt_Gt", "Gt_Lt", "LtE_GtE", "GtE_LtE", "Is_IsNot", "IsNot_Is")),
    *("ReplaceUnaryOperator_Delete_USub", "ReplaceUnaryOperator_Delete_Not", "ReplaceTrueWithFalse"),
    *("ReplaceFalseWithTrue", "ReplaceAndWithOr", "ReplaceOrWithAnd", "NumberReplacer"),
)
"""One or two likely slips for each sign; Cosmic Ray's others mostly end in an exception at the first call."""

LOOKS = ("gen/pages/", "_charts.py", "_svg.py", "plot.py", "/page.py", "step_responses.py", "gen/rig/calibrate/")
"""Where numbers are widths, colours and places on a page; the rig's calibration is run by hand, beside no user."""


def mutants_of(path: Path, root: Path) -> list[Callable[[], Mutant | None]]:
    """All mutants of a module whose change is in code that runs: no annotations, no `frozen=True`, no bare `*`.

    Parameters
    ----------
    path, root
        The module and the repository.

    Returns
    -------
    list
        What makes each: to make them all takes minutes for a long module.
    """
    text = path.read_text(encoding="utf-8")
    name = path.relative_to(root).as_posix()
    dead = _declarations(text)
    tree = list(ast_nodes(parso.parse(text)))

    def make(label: str, operator: Operator, occurrence: int) -> Mutant | None:
        mutated = MutationVisitor.mutate_code(text, operator, occurrence)
        return changed(name, label, text, mutated) if mutated is not None else None

    return [
        partial(make, label, operator, occurrence)
        for label, operator in _operators()
        for occurrence, (node, start) in enumerate(
            (node, start) for node in tree for start, _ in operator.mutation_positions(node)
        )
        if not any(first <= start < last for first, last in dead) and not _marks_keywords(node)
    ]


def modules(root: Path) -> list[Path]:
    """The modules of ``gen/`` but for those that only draw."""
    files = sorted((root / "gen").rglob("*.py"))
    return [file for file in files if not any(part in file.relative_to(root).as_posix() for part in LOOKS)]


@cache
def _operators() -> tuple[tuple[str, Operator], ...]:
    return tuple((name, get_operator(f"core/{name}")()) for name in OPERATORS)


Place = tuple[int, int]


def _declarations(text: str) -> list[tuple[Place, Place]]:
    """Annotations and keywords of declarations, begin and end as (line, column)."""
    return [_span(node) for found in ast.walk(ast.parse(text)) for node in _not_run(found)]


def _marks_keywords(node: parso.tree.NodeOrLeaf) -> bool:
    """The `*` after which parameters have to be named: no product."""
    return node.parent is not None and node.parent.type == "parameters"


def _not_run(node: ast.AST) -> Iterator[ast.AST]:
    if isinstance(node, ast.AnnAssign | ast.arg) and node.annotation is not None:
        yield node.annotation
    if isinstance(node, ast.FunctionDef) and node.returns is not None:
        yield node.returns
    if isinstance(node, ast.keyword) and node.arg in ("frozen", "eq", "strict", "slots", "show_default"):
        yield node.value
    if isinstance(node, ast.Assign) and isinstance(node.value, ast.BinOp) and isinstance(node.value.op, ast.BitOr):
        yield node.value  # an alias of a union of types


def _span(node: ast.AST) -> tuple[Place, Place]:
    assert isinstance(node, ast.expr)
    return (node.lineno, node.col_offset), (node.end_lineno or node.lineno, node.end_col_offset or 0)
