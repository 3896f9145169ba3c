"""Judge every way by the same profiles and the exact solution."""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

from benchmarks.rivals.code.catalogue import RIVALS, Rival
from benchmarks.rivals.code.ours import FORMS, our_row
from benchmarks.rivals.code.profiles import LENGTH, profiles
from benchmarks.rivals.code.programs import Program
from benchmarks.rivals.code.row import Row, errors, held_and_changed
from benchmarks.rivals.missing import LibraryMissing
from gen.coefficients import Coefficients
from gen.emulate.firmware import cache_folder
from gen.model import ExactSolution
from gen.verification.profiles import Profile


def rows(coefficients: Coefficients, length: int = LENGTH, tell: Callable[[str], None] = lambda _: None) -> list[Row]:
    """Measure all rivals, then all forms of the emitted library.

    Parameters
    ----------
    coefficients
        The MY1016's.
    length
        Samples of each profile.
    tell
        Told what is being done.
    """
    profile = profiles(length)
    exact = ExactSolution(coefficients.model).simulate(profile.pwm)
    made = []
    for rival in RIVALS:
        tell(rival.title)
        made.append(rival_row(rival, coefficients, profile, exact))
    for form in FORMS:
        tell(f"gen {form}")
        made.append(our_row(form, coefficients, profile, exact))
    return made


def rival_row(rival: Rival, coefficients: Coefficients, profile: Profile, exact: dict[str, Any]) -> Row:
    """Measure one rival; one whose library is missing has a row that says so."""
    title = f"({rival.letter}) {rival.title}"
    with tempfile.TemporaryDirectory(prefix="rival-") as folder:
        try:
            program = Program(rival, coefficients.model, Path(folder))
        except LibraryMissing as error:
            return Row(title, rival.lacks, missing=str(error))
        board = program.on_board(profile, cache_folder())
        host = program.on_host(profile)
    held, change = held_and_changed(profile, board.cycles)
    return Row(
        title,
        rival.lacks,
        errors(program.rises_K(board.words), exact),
        None,
        held,
        change,
        board.size.flash,
        board.size.ram,
        board.stack_bytes,
        board.words.tobytes() == host.tobytes(),
    )
