"""How cost grows: models of the wanted size, their cost on the emulated Mega, and the largest that a board holds."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.rivals.growth.boards import MOST, Board, held
from benchmarks.rivals.growth.measure import Grown, built, forget, measured
from benchmarks.rivals.growth.models import FULL_RISE_K, TERMS, components, network
from benchmarks.rivals.growth.table import boards_table, growth_table
from gen.errors import InputError
from gen.lowering.recursion.dynamics import dynamics


def grown(size: int, flash: int, ram: int, cycles: int, **other: str) -> Grown:
    return Grown("components", size, cycles, cycles, flash, ram, 1.0, 2.0, True, **other)


@pytest.mark.parametrize(("count", "order"), [(1, 1), (3, 2), (2, 4)])
def test_components_have_the_order_asked_for_and_settle_at_the_same_rise(count: int, order: int) -> None:
    model = components(count, order).model
    assert [part.order for part in model.components] == [order] * count
    for part in model.components:
        assert part.steady_rise([255]) == pytest.approx(FULL_RISE_K)
        assert np.all(np.roots(part.denominator([100])[0]).real < 0.0)


def test_a_network_has_the_nodes_asked_for_and_every_other_one_is_measured() -> None:
    made = network(5).model.network
    assert made is not None
    assert (len(made.nodes), len(made.sensed)) == (5, 3)


@pytest.mark.parametrize("terms", range(len(TERMS) + 1))
def test_a_network_has_the_terms_asked_for(terms: int) -> None:
    made = network(6, terms).model.network
    assert made is not None
    scaled = [bool(path.factors) for path in made.paths] + [bool(heat.factors) for heat in made.heats]
    warming = [heat.per_K != 0.0 for heat in made.heats]
    assert (sum(scaled) + sum(warming) + len(made.laws)) == terms


def test_a_second_component_takes_a_table_more_and_all_words_are_the_reference_s() -> None:
    one = measured("components", 1, components(1, 1), "table")
    two = measured("components", 2, components(2, 1), "table")
    assert one.equal and two.equal
    assert two.flash_bytes - one.flash_bytes >= 256 * 8  # two words of 32 bit for each |PWM|
    assert two.cycles_held > one.cycles_held > 0
    assert two.ram_bytes > one.ram_bytes > 0


def test_a_build_finds_nothing_that_an_earlier_one_has_kept() -> None:
    model = components(1, 2)
    forget()
    built(model, "table")
    kept = dynamics.cache_info().currsize
    forget()
    assert kept > 0
    assert dynamics.cache_info().currsize == 0


def test_a_table_that_the_compiler_does_not_take_is_told_as_refused() -> None:
    refused = measured("components", 16, components(16, 1), "table").refused
    assert refused is not None and "32768 bytes" in refused


def test_a_file_holds_so_many_nodes_and_components_and_no_more() -> None:
    for make in (network, lambda count: components(count, 1)):
        make(MOST)
        with pytest.raises(InputError):
            make(MOST + 1)


def test_the_largest_model_is_where_the_first_thing_runs_out() -> None:
    series = [grown(1, 5000, 40, 300), grown(2, 5000, 60, 400), grown(4, 6000, 100, 600)]
    free = Board("free", 6000 + 500 * 10, 100 + 20 * 3)
    assert held(free, series) == (7, "RAM")
    slow = Board("slow", 10**9, 10**9)
    assert held(slow, series, most=10**6) == (4 + (4_000_000 - 600) // 100, "cycles")
    assert held(slow, series) == (16, "a file holds no more")
    refused = grown(6, 0, 0, 0, refused="too large")
    assert held(free, [*series, refused]) == (5, "the table's 32 767 bytes")
    assert held(Board("small", 0, 0), series)[0] == 0


def test_times_are_multiples_of_the_first_row_s_verify_and_a_refusal_is_a_row() -> None:
    found = [grown(1, 5000, 40, 300), grown(2, 5500, 60, 400), grown(3, 0, 0, 0, refused="too large")]
    cells = [list(column.cells) for column in growth_table(found).columns]
    assert cells[6] == ["x 0.50", "x 0.50", ""]
    assert cells[8] == ["yes", "yes", "refused: too large"]
    assert [next(iter(column.cells)) for column in boards_table(found).columns] == [
        "components",
        "2 (the table's 32 767 bytes)",
        "2 (the table's 32 767 bytes)",
    ]
