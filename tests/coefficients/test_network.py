"""What a network in the coefficient file means: ways out, runaways, time constants, warnings, examples."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from gen.coefficients import Coefficients, load, parse, transfer_functions_only
from gen.errors import InputError
from tests.coefficients.network_tree import (
    SCHEMA,
    TREE,
    G,
    changed,
    failure,
    poly,
)
from tests.examples import NETWORKS, ROOT, WITH_TRANSFER_FUNCTIONS


def bare(nodes: dict[str, float], paths: list[Any], heats: list[Any], **network: Any) -> dict[str, Any]:  # noqa: ANN401
    """A file with no more than a network needs; the first node is measured."""
    keys = ("format", "version", "name", "sample_time_s", "input", "ambient", "domain", "validity")
    entries = [{"name": name, "capacity_J_per_K": capacity} for name, capacity in nodes.items()]
    return {key: TREE[key] for key in keys} | {
        "network": {
            "nodes": [entries[0] | {"sensor": {}}, *entries[1:]],
            "paths": [{"between": list(ends), G: curve} | (more[0] if more else {}) for ends, curve, *more in paths],
            "heats": heats,
            **network,
        }
    }


def test_heat_without_a_way_out_at_some_speeds_only_is_said_with_the_speed() -> None:
    cooled = {"table": {"pwm": [30, 40], "value": [1.0, 0.0], "interpolation": "linear"}}
    error = failure(bare({"a": 500.0, "b": 500.0}, [("ab", poly(1)), (("b", "ambient"), cooled)], []))
    assert (error.place, error.message.split(";")[0]) == (
        "$.network.nodes[0]",
        'heat of "a" has no way to the ambient at PWM 40',
    )


def test_heat_whose_only_way_out_a_channel_can_shut_is_refused() -> None:
    fan = {"column": "fan_rpm", "range": [0, 3000], "neutral": 3000}
    shut = {"factors": [{"channel": "fan_rpm", "poly": [1e-3, 0]}]}
    error = failure(bare({"a": 500.0}, [(("a", "ambient"), poly(1), shut)], [], channels=[fan]))
    assert (error.place, "also where its factors are smallest" in error.message) == ("$.network.nodes[0]", True)


def test_nothing_is_measured() -> None:
    tree = bare({"a": 500.0}, [(("a", "ambient"), poly(1))], [])
    del tree["network"]["nodes"][0]["sensor"]
    error = failure(tree)
    assert (error.place, error.message) == ("$.network.nodes", 'no node has a "sensor"; expected one that is measured')


def test_the_smallest_network_is_taken() -> None:
    loaded = parse(json.dumps(bare({"a": 500.0}, [(("a", "ambient"), poly(1))], [])).encode())
    assert loaded.model.component_names == ("a",)
    assert loaded.warnings == ()


#: Conductance of a path that a fan scales by 1..2, W/K: heat that grows by 0.02 of 40 W for each kelvin needs 0.8 W/K.
BALANCE = [(0.81, 40.0, True), (0.79, 40.0, False), (0.81, 42.0, False)]


@pytest.mark.parametrize(("conductance", "power", "taken"), BALANCE)
@pytest.mark.parametrize("where", ["low", "middle"])
def test_a_runaway_that_only_some_value_of_a_channel_brings_is_found(
    conductance: float, power: float, taken: bool, where: str
) -> None:
    """Also where it is neither neutral nor an end of the range, by exact bounds of the factor."""
    channel = {"column": "fan_rpm", "range": [0, 3000], "neutral": 3000}
    scale = [1.0, 1.5, 2.0] if where == "low" else [2.0, 1.0, 2.0]
    fan = {"factors": [{"channel": "fan_rpm", "table": {"at": [0, 1500, 3000], "value": scale}}]}
    heat = {"node": "a", "power_W": poly(power), "per_K": 0.02}
    tree = bare({"a": 500.0}, [(("a", "ambient"), poly(conductance), fan)], [heat], channels=[channel])
    if taken:
        assert parse(json.dumps(tree).encode()).model.network is not None
    else:
        assert "runs away" in failure(tree).message


def test_what_balances_exactly_runs_away_too() -> None:
    """G = P per_K at PWM 128 alone: a singular system is no traceback."""
    cooled = {"table": {"pwm": [0, 128, 200], "value": [2.0, 0.5, 2.0], "interpolation": "linear"}}
    heat = {"node": "a", "power_W": poly(50), "per_K": 0.01}
    error = failure(bare({"a": 500.0}, [(("a", "ambient"), cooled)], [heat]))
    assert "runs away at PWM 128" in error.message


def test_a_factor_that_speeds_a_node_up_counts_for_its_time_constant() -> None:
    channel = {"column": "fan_rpm", "range": [0, 3000], "neutral": 0}
    for most, taken in ((9.9, True), (10.1, False)):
        fan = {"factors": [{"channel": "fan_rpm", "table": {"at": [0, 3000], "value": [1.0, most]}}]}
        tree = bare({"a": 50.0}, [(("a", "ambient"), poly(1), fan)], [], channels=[channel])
        if taken:  # 50 J/K over 9.9 W/K is 5.05 s, ten samples are 5 s
            parse(json.dumps(tree).encode())
        else:
            error = failure(tree)
            assert error.place == "$.network.nodes[0].capacity_J_per_K"
            assert "with a time constant of 4.95 s" in error.message


@pytest.mark.parametrize(("least", "taken"), [(0.5, True), (0.3, False)])
def test_heat_that_shrinks_with_temperature_counts_where_a_channel_makes_it_least(least: float, taken: bool) -> None:
    """60 W that grow by 0.02/K beside 50 W that shrink by 0.01/K: 0.85 W/K carry them off with 0.7 of the latter."""
    fan = {"column": "fan_rpm", "range": [0, 3000], "neutral": 3000}
    table = {"at": [0, 3000], "value": [least + 0.3, 1.0]}
    shrinks = {"node": "a", "power_W": poly(50), "per_K": -0.01, "factors": [{"channel": "fan_rpm", "table": table}]}
    grows = {"node": "a", "power_W": poly(60), "per_K": 0.02}
    tree = bare({"a": 500.0}, [(("a", "ambient"), poly(0.85))], [grows, shrinks], channels=[fan])
    if taken:
        parse(json.dumps(tree).encode())
    else:
        assert "runs away" in failure(tree).message


@pytest.mark.parametrize(("most", "taken"), [(1.0, True), (3.0, False)])
def test_heat_that_shrinks_with_temperature_speeds_its_node_up(most: float, taken: bool) -> None:
    """50 J/K over 9.9 W/K and 1 W or 3 W that shrink by 0.09/K: 5.004 s or 4.92 s, where ten samples are 5 s."""
    fan = {"column": "fan_rpm", "range": [0, 3000], "neutral": 0}
    table = {"at": [0, 3000], "value": [0.0, most]}
    shrinks = {"node": "a", "power_W": poly(1), "per_K": -0.09, "factors": [{"channel": "fan_rpm", "table": table}]}
    tree = bare({"a": 50.0}, [(("a", "ambient"), poly(9.9))], [shrinks], channels=[fan])
    if taken:
        parse(json.dumps(tree).encode())
    else:
        assert failure(tree).place == "$.network.nodes[0].capacity_J_per_K"


def test_heat_that_grows_with_temperature_slows_its_node_down_only_where_it_acts() -> None:
    """50 J/K over 10.2 W/K are 4.9 s; 10 W that grow by 0.09/K would make it 5.4 s, but a channel may shut them off."""
    fan = {"column": "fan_rpm", "range": [0, 3000], "neutral": 3000}
    for least, taken in ((0.9, True), (0.0, False)):
        table = {"at": [0, 3000], "value": [least, 1.0]}
        grows = {"node": "a", "power_W": poly(10), "per_K": 0.09, "factors": [{"channel": "fan_rpm", "table": table}]}
        tree = bare({"a": 50.0}, [(("a", "ambient"), poly(10.2))], [grows], channels=[fan])
        if taken:
            parse(json.dumps(tree).encode())
        else:
            assert failure(tree).place == "$.network.nodes[0].capacity_J_per_K"


def test_a_table_that_does_not_cover_the_validity_range_is_warned_of() -> None:
    short = {"table": {"pwm": [60, 200], "value": [1, 2], "interpolation": "linear"}}
    tree = bare({"a": 500.0}, [(("a", "ambient"), short)], [{"node": "a", "power_W": short}])
    assert [warning.split(":")[0] for warning in parse(json.dumps(tree).encode()).warnings] == [
        f"$.network.paths[0].{G}",
        "$.network.heats[0].power_W",
    ]


def test_a_heat_that_would_cool_in_the_domain_is_warned_of() -> None:
    for per_K, expected in ((-0.01, (125, 140)), (0.04, (0, -10)), (0.0039, None)):
        heat = {"node": "a", "power_W": poly(1), "per_K": per_K, "reference_degC": 25}
        warnings = parse(json.dumps(bare({"a": 500.0}, [(("a", "ambient"), poly(1))], [heat])).encode()).warnings
        told = [warning.rsplit(":", 1)[0] for warning in warnings]
        if expected is None:
            assert told == []
            continue
        none, worst = expected
        where = f"is none at {none} degC and negative at {worst} degC, inside the domain"
        assert told == [f'$.network.heats[0].per_K: the heat of "a" {where}']


def test_what_is_outside_of_the_validity_range_is_held_or_continued() -> None:
    for outside, low, high in (("hold", 20.0, 190.0), ("extrapolate", 0.0, 200.0)):
        network = parse(json.dumps(changed((("validity", "outside"), outside))).encode()).model.network
        assert network is not None
        poly_of = [path.curve for path in network.paths].index(network.paths[0].curve)
        found = network.conductances[:, poly_of]
        assert found[0] == 0.55  # at rest
        assert found[1] == pytest.approx(1e-5 * max(low, 1.0) ** 2 + 0.002 * max(low, 1.0) + 0.6)
        assert found[200] == pytest.approx(1e-5 * high**2 + 0.002 * high + 0.6)


def test_the_network_means_what_the_page_says() -> None:
    loaded = load(Path(__file__).parent / "version2" / "network_every_key.json")
    network = loaded.model.network
    assert network is not None
    assert loaded.model.components == ()
    assert loaded.model.component_names == ("bearing", "casing", "cover")
    assert loaded.document.component_names == ["bearing", "casing", "cover"]
    assert [node.name for node in network.hidden] == ["winding", "mount"]
    assert [path.second for path in network.paths].count(None) == 3
    assert network.held == (20, 190)
    m, a, f = network.matrices(np.array([100]), {"fan_rpm": 2000.0, "current_A": 3.0})
    # The cover: 240 J/K, to the ambient and to the casing (exp1 0.4), heated by 4 W (100 / 200)^2.
    outward = (0.05 + 0.2 * 0.5**1.5) * (2e-11 * 8e9 - 1e-7 * 4e6 + 5e-4 * 2000 + 1) * (1 - 0.1 * 7 / 16)
    assert a[0, 4] == pytest.approx(outward / 240)
    assert m[0, 4] == pytest.approx([0, 0, 0.4 / 240, 0, -(outward + 0.4) / 240])
    assert f[0, 4] == pytest.approx(4 * 0.25 / 240)
    # The winding: 120 J/K, heated by 0.4 W/A^2 (3 A)^2 (1 + 0.0039 (T - 20)).
    assert f[0, 0] == pytest.approx(3.6 * (1 - 0.0039 * 20) / 120)


def test_alarms_wiring_and_provenance_know_the_sensed_nodes_by_name() -> None:
    rule = {"name": "hot", "kind": "over_temperature", "component": "casing", "limit_degC": 90}
    chip = {"channel": "casing", "cs": 29, "sck": 31, "so": 33}
    band = {"component": "cover", "pwm": [0, 200], "model_minus_measured_K": [-1, 1]}
    more = {
        "alarms": [rule],
        "wiring": {"thermocouples": [chip]},
        "provenance": {"source": "a test", "error": [band], "fit": {"bearing": {"rms_K": 0.1}}},
    }
    assert parse(json.dumps(TREE | more).encode()).document.alarms[0].component == "casing"
    for part, place in (
        ({"alarms": [rule | {"component": "winding"}]}, "$.alarms[0].component"),
        ({"wiring": {"thermocouples": [chip | {"channel": "winding"}]}}, "$.wiring.thermocouples[0].channel"),
        ({"provenance": {"source": "a", "error": [band | {"component": "mount"}]}}, "$.provenance.error[0].component"),
        ({"provenance": {"source": "a", "fit": {"mount": {"rms_K": 1}}}}, "$.provenance.fit.mount"),
    ):
        error = failure(TREE | part)
        assert error.place == place
        assert 'expected the name of a component: "bearing", "casing"' in error.message


@pytest.mark.parametrize("name", NETWORKS)
def test_an_example_is_valid_by_the_published_schema(name: str) -> None:
    raw = (ROOT / "examples" / name / "coeffs.json").read_text(encoding="utf-8")
    SCHEMA.validate(json.loads(raw))
    assert parse(raw.encode()).warnings == ()


def test_every_example_is_of_one_kind_or_the_other() -> None:
    def loaded(name: str) -> Coefficients:
        return load(ROOT / "examples" / name / "coeffs.json")

    assert all(loaded(name).model.network is not None for name in NETWORKS)
    assert all(loaded(name).model.components for name in WITH_TRANSFER_FUNCTIONS)
    transfer_functions_only(loaded("two_mass"), "this")
    with pytest.raises(InputError) as caught:
        transfer_functions_only(loaded("two_nodes"), "this", "a.json")
    assert str(caught.value) == (
        "a.json: $.network: this takes transfer functions only, and this is a network (docs/format.md)"
    )
