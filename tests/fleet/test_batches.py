"""Motors of one label that differ together: told once, by how much, and none of them called faulty for it."""

from __future__ import annotations

import numpy as np
import pytest

from gen.fleet.alarm_thresholds import _different
from gen.fleet.folder.labels import Labels
from gen.fleet.folder.store import Store
from gen.fleet.report import pages_of
from gen.fleet.statistics.batches import FEWEST_ALIKE, groups_of
from gen.fleet.watch import read_watched
from tests.command import gen
from tests.fleet.conftest import MOTORS
from tests.fleet.made import run_of
from tests.fleet.test_judging import judged, products

MANY = 30
SHIFT = 1.5


def labelled(inside: int, **more: list[str]) -> list[Labels]:
    """The first motors of batch x, the others of batch y; what is given beside, motor by motor."""
    beside = [dict(zip(more, values, strict=True)) for values in zip(*more.values(), strict=True)] or [{}] * MANY
    return [{"batch": "x" if m < inside else "y", **beside[m]} for m in range(MANY)]


def test_a_batch_is_told_once_and_a_faulty_motor_of_it_beside() -> None:
    amounts = [{2: SHIFT} if m < 10 else {} for m in range(MANY)]
    amounts[3] |= {0: 3.0}
    fleet = [products(m, each) for m, each in enumerate(amounts)]
    found = judged(fleet, groups_of(labelled(10)), 0.01)
    (batch,) = found.batches
    assert batch.group.labels == ("batch=x",)
    assert batch.finding.place == 2
    assert batch.finding.amount == pytest.approx(SHIFT, abs=0.2)
    assert [m for m, own in enumerate(found.own) if own is not None] == [3]
    without = judged(fleet, (), 0.01)
    assert not without.batches
    assert {m for m, own in enumerate(without.own) if own is not None} > {3}  # healthy ones of the batch, called faulty


def test_of_two_suppliers_with_half_the_fleet_each_it_is_the_one_that_has_changed() -> None:
    fleet = [products(m, {1: -SHIFT} if m >= 15 else {}) for m in range(MANY)]
    (batch,) = judged(fleet, groups_of(labelled(15)), 0.01).batches
    assert batch.group.labels == ("batch=y",)
    assert batch.finding.amount == pytest.approx(-SHIFT, abs=0.2)


@pytest.mark.parametrize("share", [0.3, 0.5, 0.8])
def test_a_batch_is_its_own_label_however_large_it_is(share: float) -> None:
    others = ["y" if m % 2 else "z" for m in range(MANY)]
    labels: list[Labels] = [{"batch": "x" if m < share * MANY else others[m]} for m in range(MANY)]
    fleet = [products(m, {1: SHIFT} if labels[m]["batch"] == "x" else {}) for m in range(MANY)]
    found = judged(fleet, groups_of(labels), 0.01)
    (batch,) = found.batches
    assert batch.group.labels == ("batch=x",)
    assert batch.finding.amount == pytest.approx(SHIFT, abs=0.2)
    assert found.common is None
    assert not any(found.own)


def test_a_batch_that_lacks_what_all_others_show_is_told_beside_it() -> None:
    labels: list[Labels] = [{"batch": "x" if m < 8 else "yz"[m % 2]} for m in range(MANY)]
    found = judged([products(m, {} if m < 8 else {1: 2.0}) for m in range(MANY)], groups_of(labels), 0.01)
    assert found.common is not None
    assert found.common.amount == pytest.approx(2.0, abs=0.2)
    (batch,) = found.batches
    assert batch.group.labels == ("batch=x",)
    assert batch.finding.amount == pytest.approx(-2.0, abs=0.2)
    assert not any(found.own)


def test_a_supplier_of_whose_motors_half_are_of_the_batch_is_not_called_beside_it() -> None:
    supplier = ["A" if m < 12 or m > 27 else "B" for m in range(MANY)]
    fleet = [products(m, {2: SHIFT} if m < 8 else {}) for m in range(MANY)]
    found = judged(fleet, groups_of(labelled(8, supplier=supplier)), 0.01)
    assert [batch.group.labels for batch in found.batches] == [("batch=x",)]


def test_two_batches_that_differ_are_both_told() -> None:
    supplier = ["A" if m % 3 == 0 else "B" for m in range(MANY)]
    amounts = [({2: SHIFT} if m < 10 else {}) | ({0: -SHIFT} if m % 3 == 0 else {}) for m in range(MANY)]
    found = judged(
        [products(m, each) for m, each in enumerate(amounts)], groups_of(labelled(10, supplier=supplier)), 0.01
    )
    told = {batch.group.labels[0]: batch.finding.place for batch in found.batches}
    assert told == {"batch=x": 2, "supplier=A": 0}
    assert not any(found.own)


@pytest.mark.parametrize("motors", [8, 12, 30])
def test_fleets_without_a_batch_have_none_called(motors: int) -> None:
    rng, called, drawn = np.random.default_rng(motors), 0, 0
    for number in range(20):
        fleet = [products(1000 * number + m, {}, scatter=0.3) for m in range(motors)]
        for _ in range(10):
            labels = [{"a": str(rng.integers(2)), "b": str(rng.integers(5))} for _ in range(motors)]
            called += bool(judged(fleet, groups_of(labels), 0.05).batches)
            drawn += 1
    # One kind of model, so half of the level: 5 are expected at most, 14 or more have a chance of one in a thousand.
    assert called <= 13, drawn


def test_labels_that_name_the_same_motors_are_one_and_few_motors_none() -> None:
    few = FEWEST_ALIKE - 1
    labels = [{"a": "1", "b": "2"} if m < 10 else {"a": "3"} for m in range(MANY)]
    labels[0]["serial"] = "17"
    for m in range(few):
        labels[m]["c"] = "4"
    assert [group.labels for group in groups_of(labels)] == [("a=1", "b=2"), ("a=3",)]


def test_sensors_of_a_batch_that_read_too_much_are_told_from_end_to_end(fleet: Store) -> None:
    late = range(4)
    for number in range(MOTORS):
        rng = np.random.default_rng(1000 + number)
        heat, capacity = np.exp(rng.normal(0.0, 0.08, 2)).tolist()
        run = run_of(600 + number, heat=heat, capacity=capacity, offset=8.0 if number in late else 0.0, hours=3.0)
        fleet.add(f"m{number}", "2026-02-01", "later", run)
        said = ["--label", f"thermocouples={'2026-03' if number in late else '2025-11'}"]
        assert gen("fleet", "add", "--motor", f"m{number}", "--to", fleet.url, *said).returncode == 0
    done = gen("fleet", "watch", fleet.url, "--jobs", "1", "--level", "0.05")
    assert (done.returncode, done.stderr) == (0, "")
    watched = read_watched(fleet)
    assert watched is not None
    (batch,) = watched.batches
    assert batch.said in done.stdout
    assert (batch.labels, batch.changed) == (("thermocouples=2026-03",), True)
    assert batch.motors == tuple(f"m{number}" for number in late)
    assert "4 motors, together since they were identified: sensor differs of casing, by +" in batch.said
    assert not watched.common
    assert {state.state for state in watched.motors if state.motor != "short"} == {"ok"}
    assert _different(fleet) == set(batch.motors)  # their runs say nothing of a healthy motor's
    pages = pages_of(fleet)
    for page in ("index.html", "motors/m0.html"):
        assert batch.said in pages[page].replace("&#43;", "+")
    assert "thermocouples=2025-11" in pages["motors/m8.html"]
    assert batch.said not in pages["motors/m8.html"]
