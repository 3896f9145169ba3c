"""Functions are compiled where machine code can be kept, and where it cannot."""

from __future__ import annotations

import numpy as np

from gen.compiled import compiled
from gen.identification.network.fitting.marching import excess_of


def test_without_a_place_for_machine_code_functions_are_compiled_all_the_same() -> None:
    """What no file holds has no place: as in an archive, or where nothing can be written."""
    made: dict[str, object] = {}
    exec("def twice(x):\n    return 2.0 * x\n", made)
    twice = made["twice"]
    assert callable(twice)
    assert compiled(twice)(21.0) == 42.0


def test_a_number_alone_gives_what_the_same_number_in_an_array_does() -> None:
    """One formula is compiled for numbers and is numpy's for arrays."""
    factors, differences = np.array([2e-6, -4e-4, 0.03, 0.4]), np.linspace(-150.0, 150.0, 61)
    of_arrays = excess_of(differences, factors, 90.0)
    of_numbers = [compiled(excess_of)(each, factors, 90.0) for each in differences]
    np.testing.assert_allclose(of_numbers, of_arrays, rtol=1e-13)
