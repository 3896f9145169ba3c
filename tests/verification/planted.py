"""What every planted fault shares: the library is lowered once, and its campaign runs on the reference once."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Protocol

from gen.arrays import RecordArray
from gen.coefficients import Coefficients, parse
from gen.firmware import render
from gen.firmware.context import LibraryContext, project_context
from gen.lowering.kinds import Arithmetic
from gen.lowering.lower import lower
from gen.lowering.program import Program
from gen.verification.compare import Mismatch, first_mismatch
from gen.verification.harness import Harness, HostHarness
from gen.verification.runners import Library, write_library


class Campaign(Protocol):
    """Inputs of any harness, and what its reference answers."""

    @property
    def inputs(self) -> RecordArray: ...

    @property
    def expected(self) -> RecordArray: ...


@dataclass(frozen=True, eq=False)
class Emitted:
    """A library's files, and what they come from."""

    coefficients: Coefficients
    program: Program
    context: LibraryContext
    files: Mapping[str, str]

    def written(self, folder: Path, end: str = "", fault: tuple[str, str] | None = None, most: int = 1) -> Library:
        """Write it, with a fault planted in the library's file that ends so: a text that stands there, replaced once.

        Parameters
        ----------
        most
            How often the text may stand there.
        """
        files = dict(self.files)
        if fault is not None:
            path = f"lib/{self.context.name}/src/{self.context.name}{end}"
            assert 1 <= files[path].count(fault[0]) <= most, "the fault has no place to stand"
            files[path] = files[path].replace(*fault, 1)
        return write_library(self.program, self.context, files, folder)


@cache
def emitted(text: str, arithmetic: Arithmetic) -> Emitted:
    """A coefficient file's library, with its schedules in a table."""
    coefficients = parse(text.encode())
    program = lower(coefficients, arithmetic, "table")
    context = project_context(coefficients, program, "coeffs.json")
    return Emitted(coefficients, program, context, render.library(context))


def difference(library: Library, harness: Harness, given: Campaign) -> Mismatch | None:
    """The first difference between a library compiled here and its reference."""
    harness.write(library)
    runner = HostHarness(library, harness, "g++ -O2", given.expected.dtype)
    return first_mismatch(given.expected, runner.run(given.inputs))
