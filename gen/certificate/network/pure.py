"""That functions which are run on their inputs give the same whatever was called before.

They, and all that they call, name nothing but what they are called with, what they declare, constants and each other.
"""

from __future__ import annotations

import re
from collections.abc import Iterable

from pycparser import c_ast

from gen.certificate.network.source import Unit
from gen.certificate.refuted import Refuted

RUN_ON_INPUTS = ("degrees", "magnitude", "pwm_flags", "thousandths_of", "read_more", "over_base", "shown_more")
"""Functions of the interface that are run on what they may be called with, and not read."""
_FROM_FLASH = {"memcpy_P", *(f"pgm_read_{kind}" for kind in ("byte", "word", "dword", "float"))}
_LITERALS = {"INT32_C", "UINT32_C", "INT64_C", "UINT64_C"}
#: Constants of a file: no pointer, which could be turned to something else.
_CONSTANT = re.compile(r"^(?:extern |static )?const (?:\w+ )*?(\w+) ?(?:\[[^\]]*\])*(?: PROGMEM)? ?[={;]", re.M)
_ENUM = re.compile(r"\benum\s*(?::\s*\w+\s*)?\{([^}]*)\}")


def check_pure(unit: Unit, names: Iterable[str]) -> None:
    """Make sure that functions, and all that they call, depend on what they are called with alone.

    Parameters
    ----------
    unit
        The file that they are in.
    names
        Of the functions; one that is not there is no matter of this.

    Raises
    ------
    Refuted
        If one names anything else of the file, keeps something, or calls what is not in the file.
    """
    constants = {*_CONSTANT.findall(unit.text), "true", "false"}
    for block in _ENUM.findall(unit.text):
        constants |= {entry.partition("=")[0].strip() for entry in block.split(",")}
    seen: set[str] = set()
    left = [name for name in names if name in unit.texts]
    while left:
        name = left.pop()
        if name not in seen:
            seen.add(name)
            for function in unit.functions(name):
                named = _Named()
                named.visit(function)
                left += sorted(named.called & set(unit.texts))
                known = named.own | constants | set(unit.kinds)
                if named.keeps or named.read - known or named.called - set(unit.texts) - _FROM_FLASH - _LITERALS:
                    raise Refuted(f"{name} depends on more than what it is called with")


class _Named(c_ast.NodeVisitor):  # type: ignore[misc]
    """What a function names.

    Attributes
    ----------
    own
        Its parameters and what it declares.
    read
        Names of values.
    called
        Of functions.
    keeps
        Whether it declares something that outlives a call.
    """

    def __init__(self) -> None:
        self.own: set[str] = set()
        self.read: set[str] = set()
        self.called: set[str] = set()
        self.keeps = False

    def visit_Decl(self, node: c_ast.Decl) -> None:
        """Take a declaration down."""
        self.own.add(node.name)
        self.keeps = self.keeps or bool({"static", "extern", "register"} & set(node.storage))
        self.generic_visit(node)

    def visit_FuncCall(self, node: c_ast.FuncCall) -> None:
        """Take a call down; what is called by something else than a name is no name that is known."""
        self.called.add(node.name.name if isinstance(node.name, c_ast.ID) else "")
        if node.args is not None:
            self.visit(node.args)

    def visit_StructRef(self, node: c_ast.StructRef) -> None:
        """A member is what it is a member of."""
        self.visit(node.name)

    def visit_ID(self, node: c_ast.ID) -> None:
        """Take a name down."""
        self.read.add(node.name)
