"""A board holds 60 KB of tables: of a network with more, paths within the motor are made constant, and no more."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from gen.identification.network.fitting.fit import settle
from gen.identification.network.fitting.speed_laws import CONSTANT, WITHIN
from gen.identification.network.fitting.structure import Structure, full
from gen.identification.network.prune import MOST_TABLES, held_to_tables, tables_of
from gen.identification.network.search import Found
from tests.identification.network.held_then_rest import NAMES, numbers_about_the_prior, problem_of


def found_of(structure: Structure) -> Found:
    problem = problem_of(structure, 200, 3.0, 20.0)
    return Found(problem, settle(problem, numbers_about_the_prior(problem), 1), np.ones(len(NAMES)))


def test_paths_within_are_constant_until_a_board_holds_the_tables() -> None:
    """Seven nodes, natural convection, heat that grows: 21 paths of two tables each, and four for each node."""
    structure = replace(full(NAMES, 5), warmth=25.0, natural=40.0)
    assert tables_of(structure) == 2 * 21 + 4 * 7
    smaller = held_to_tables(found_of(structure))
    assert tables_of(smaller) == MOST_TABLES
    assert sum(law is CONSTANT for law in smaller.laws) == 5
    assert [law for law in smaller.laws if law not in (CONSTANT, WITHIN)] == [
        law for law in structure.laws if law is not WITHIN
    ]


def test_a_network_that_fits_is_left_alone() -> None:
    structure = replace(full(NAMES, 3), warmth=25.0)
    assert held_to_tables(found_of(structure)) is structure
