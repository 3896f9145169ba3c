"""The network in the coefficient file: each fault has its place, and what is written reads back the same."""

from __future__ import annotations

import copy
import json
from collections.abc import Sequence
from functools import reduce
from pathlib import Path
from typing import Any

import jsonschema
import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from gen.coefficients import Coefficients, dump, load, parse, transfer_functions_only
from gen.coefficients.schema import STORED
from gen.errors import InputError
from tests.coefficients.test_coefficients_errors import BASE, DELETE
from tests.examples import NETWORKS, ROOT, WITH_TRANSFER_FUNCTIONS

Path_ = tuple[str | int, ...]
TREE: dict[str, Any] = json.loads((Path(__file__).parent / "version2" / "network_every_key.json").read_text())
SCHEMA = jsonschema.Draft202012Validator(json.loads(STORED.read_text(encoding="utf-8")))

NODES, PATHS, HEATS, CHANNELS = (("network", key) for key in ("nodes", "paths", "heats", "channels"))
G = "conductance_W_per_K"


def changed(*changes: tuple[Path_, object]) -> dict[str, Any]:
    tree: Any = copy.deepcopy(TREE)
    for (*where, last), value in changes:
        holder = reduce(lambda node, step: node[step], where, tree)
        if value is DELETE:
            del holder[last]
        else:
            holder[last] = value
    return dict(tree)


def failure(tree: object) -> InputError:
    with pytest.raises(InputError) as caught:
        parse(json.dumps(tree).encode())
    return caught.value


def poly(*coefficients: float) -> dict[str, Any]:
    return {"poly": list(coefficients)}


def factor(**table: list[float]) -> dict[str, Any]:
    return {"channel": "fan_rpm", "table": table}


# (what to change, to what, place, part of the message)
FORM: list[tuple[Path_, object, str, str]] = [
    (("network",), DELETE, "$", 'found neither, expected one of "components" and "network"'),
    (("network",), None, "$", "found neither"),
    (("network",), [], "$.network", "found a list of 0, expected an object"),
    (("components",), BASE["components"], "$", 'found both, expected one of "components" and "network"'),
    (
        ("effects",),
        [{"name": "drift", "component": "casing", "parameters": {"drift_K_per_h": 1.0}}],
        "$.effects",
        'no "effects"',
    ),
    (("ambient", "at_once"), False, "$.ambient.at_once", "acts through its paths"),
    (("accuracy", "unproven"), "saturate", "$.accuracy.unproven", "with a guarantee or not at all"),
    (NODES, [], "$.network.nodes", "found 0 entries, expected at least 1"),
    (NODES, DELETE, "$.network", 'missing key "nodes"'),
    (PATHS, [], "$.network.paths", "found 0 entries, expected at least 1"),
    (("network", "knots"), [], "$.network.knots", 'unknown key "knots"; did you mean "nodes"?'),
    (
        (*NODES, 0, "name"),
        "Casing",
        "$.network.nodes[2].name",
        '"casing" is taken by nodes[0] ("Casing"); expected names that differ',
    ),
    ((*NODES, 0, "name"), "ambient", "$.network.nodes[0].name", '"ambient" is reserved'),
    ((*NODES, 0, "name"), "win ding", "$.network.nodes[0].name", "win ding"),
    ((*NODES, 0, "capacity_J_per_K"), 0, "$.network.nodes[0].capacity_J_per_K", "expected at least 0.001"),
    ((*NODES, 0, "capacity_J_per_K"), -5, "$.network.nodes[0].capacity_J_per_K", "expected at least 0.001"),
    ((*NODES, 0, "capacity_J_per_K"), DELETE, "$.network.nodes[0]", 'missing key "capacity_J_per_K"'),
    ((*NODES, 1, "sensor", "lag_s"), -1, "$.network.nodes[1].sensor.lag_s", "expected at least 0"),
    ((*NODES, 1, "sensor", "offset_K"), "x", "$.network.nodes[1].sensor.offset_K", "expected a number"),
    ((*NODES, 1, "sensor", "lag"), 3, "$.network.nodes[1].sensor.lag", 'did you mean "lag_s"?'),
    ((*PATHS, 0, "between", 1), "rotor", "$.network.paths[0].between[1]", 'found "rotor", expected a node\'s name'),
    ((*PATHS, 0, "between", 1), "winding", "$.network.paths[0].between[1]", 'found "winding" twice'),
    ((*PATHS, 0, "between"), ["winding"], "$.network.paths[0].between", "found 1 entry, expected 2"),
    ((*PATHS, 1, "between"), ["casing", "winding"], "$.network.paths[1].between", "joins the same as paths[0]"),
    ((*PATHS, 5, "between"), ["casing", "ambient"], "$.network.paths[5].between", "joins the same as paths[4]"),
    ((*PATHS, 0, G), 3, f"$.network.paths[0].{G}", "found 3, expected a curve with exactly one of the keys"),
    ((*PATHS, 0, G), {}, f"$.network.paths[0].{G}", "found no key, expected a curve with exactly one of"),
    ((*PATHS, 0, G), {"powr": {}}, f"$.network.paths[0].{G}", 'did you mean "power"?'),
    ((*PATHS, 0, G), {"poly": [1], "exp1": [1, 0]}, f"$.network.paths[0].{G}", 'found "poly" and "exp1"'),
    ((*PATHS, 0, G), {"at_rest": 1}, f"$.network.paths[0].{G}", 'found "at_rest", expected a curve'),
    ((*PATHS, 0, G, "poly", 1), "a", f"$.network.paths[0].{G}.poly[1]", "expected a number"),
    ((*PATHS, 0, G, "at_rest"), -1, f"$.network.paths[0].{G}.at_rest", "expected at least 0"),
    ((*PATHS, 4, G, "power", "exponent"), 0, f"$.network.paths[4].{G}.power.exponent", "expected at least 0.05"),
    ((*PATHS, 4, G, "power", "forced"), -1, f"$.network.paths[4].{G}.power.forced", "expected at least 0"),
    ((*PATHS, 4, G, "power", "forced"), DELETE, f"$.network.paths[4].{G}.power", 'missing key "forced"'),
    ((*PATHS, 3, G, "table", "pwm", 1), 0, f"$.network.paths[3].{G}.table.pwm[1]", "strictly increasing PWM"),
    (
        (*PATHS, 4, "factors", 0, "channel"),
        "fan",
        "$.network.paths[4].factors[0].channel",
        'found "fan", expected a column of network.channels: "fan_rpm" or "current_A"',
    ),
    ((*PATHS, 4, "factors", 0), {"channel": "fan_rpm"}, "$.network.paths[4].factors[0]", 'one of "poly" and "table"'),
    ((*PATHS, 4, "factors", 0, "poly"), [1], "$.network.paths[4].factors[0]", 'one of "poly" and "table"'),
    (
        (*PATHS, 4, "factors", 0),
        factor(at=[0, 9, 9], value=[1, 1, 1]),
        "$.network.paths[4].factors[0].table.at[2]",
        "found 9 after 9, expected strictly increasing",
    ),
    (
        (*PATHS, 4, "factors", 0),
        factor(at=[0, 9], value=[1, 1, 1]),
        "$.network.paths[4].factors[0].table.value",
        "found 3 values, expected 2",
    ),
    (
        (*PATHS, 4, "factors", 0),
        factor(at=[0, 9], value=[1, -1]),
        "$.network.paths[4].factors[0].table.value[1]",
        "expected at least 0",
    ),
    (
        (*PATHS, 6, "factors", 0, "poly"),
        [1, 0, 0, 0, 0],
        "$.network.paths[6].factors[0].poly",
        "found 5 entries, expected at most 4",
    ),
    ((*HEATS, 0, "node"), "rotor", "$.network.heats[0].node", 'found "rotor", expected a node\'s name: "winding"'),
    ((*HEATS, 0, "node"), "ambient", "$.network.heats[0].node", 'found "ambient", expected a node\'s name'),
    ((*HEATS, 0, "per_K"), 1, "$.network.heats[0].per_K", "found 1, expected at most 0.1"),
    (
        (*HEATS, 0, "factors", 0, "channel"),
        "x",
        "$.network.heats[0].factors[0].channel",
        "a column of network.channels",
    ),
    ((*CHANNELS, 1, "column"), "fan_rpm", "$.network.channels[1].column", '"fan_rpm" is there already'),
    ((*CHANNELS, 0, "range"), [3000, 0], "$.network.channels[0].range", "expected the lower limit first"),
    ((*CHANNELS, 0, "range"), [0, 1e9], "$.network.channels[0].range", "expected values within +-2e6"),
    ((*CHANNELS, 0, "neutral"), -1, "$.network.channels[0].neutral", "found -1, expected it within the range"),
    ((*CHANNELS, 0, "column"), "fan rpm", "$.network.channels[0].column", "expected text of the pattern"),
    *(
        (
            CHANNELS,
            [*TREE["network"]["channels"], {"column": column, "range": [0, 1], "neutral": 0}],
            "$.network.channels[2].column",
            f'"{column}" is a column of a run with a meaning of its own',
        )
        for column in ("time_s", "room_degC", "casing_degC", "casing_model_degC", "alarms")
    ),
]

# What the numbers mean, which no single one says.
MEANING: list[tuple[Path_, object, str, str]] = [
    (
        (*PATHS, 5, G),
        poly(-0.25),
        f"$.network.paths[5].{G}",
        "found -0.25 at PWM 0, expected a finite value of 0 or more",
    ),
    ((*PATHS, 5, G), poly(-0.01, 1.005), f"$.network.paths[5].{G}", "at PWM 101, expected"),
    ((*PATHS, 5, G), {"exp1": [1, 9]}, f"$.network.paths[5].{G}", "found inf at PWM 79"),
    ((*HEATS, 1, "power_W"), poly(-1), "$.network.heats[1].power_W", "found -1 at PWM 0"),
    (
        (*PATHS, 6, "factors", 0, "poly"),
        [-1e-3, 1],
        "$.network.paths[6].factors[0]",
        "the factor is -2 at fan_rpm = 3000; expected none below 0 in the channel's range",
    ),
    (  # 0 at both ends of -4..12, below between them
        (*HEATS, 0, "factors", 0, "poly"),
        [1, -8, -48],
        "$.network.heats[0].factors[0]",
        "the factor is -64 at current_A = 4",
    ),
    (
        (*NODES, 5),
        {"name": "flange", "capacity_J_per_K": 9},
        "$.network.nodes[5]",
        'heat of "flange" has no way to the ambient at PWM 0; expected a path with a conductance above 0',
    ),
    (
        (*NODES, 0, "capacity_J_per_K"),
        3,
        "$.network.nodes[0].capacity_J_per_K",
        '"winding" follows its neighbours with',
    ),
    ((*NODES, 1, "sensor", "lag_s"), 4.9, "$.network.nodes[1].sensor.lag_s", "found 4.9, expected 0 or at least 5"),
    ((*HEATS, 0, "per_K"), 0.05, "$.network", 'runs away at PWM 0: heat at or near "winding" grows faster'),
    ((*HEATS, 0, "power_W"), poly(400), "$.network", "runs away at PWM"),
    ((*HEATS, 1, "power_W"), poly(90_000), "$.network", "settles"),
]


@pytest.mark.parametrize(("where", "value", "place", "message"), FORM)
def test_a_fault_of_form_is_said_with_its_place(where: Path_, value: object, place: str, message: str) -> None:
    error = failure(changed((where, value)))
    assert error.place == place
    assert message in error.message


@pytest.mark.parametrize(("where", "value", "place", "message"), MEANING)
def test_a_fault_of_meaning_is_said_with_its_place(where: Path_, value: object, place: str, message: str) -> None:
    tree = copy.deepcopy(TREE)
    if where == (*NODES, 5):
        tree["network"]["nodes"].append(value)
    else:
        tree = changed((where, value))
    error = failure(tree)
    assert error.place == place
    assert message in error.message


def test_the_schema_takes_the_file_and_rejects_what_it_can_express() -> None:
    """Not what relates one part to another."""
    assert SCHEMA.is_valid(TREE)
    assert SCHEMA.is_valid(BASE | {"version": 2, "network": None})
    related = {'one of "poly" and "table"', 'no "effects"', "with a guarantee", "is taken", "win ding", "twice"}
    related |= {"joins the same", "expected a node's name", "a column of", "strictly increasing", "values, expected"}
    related |= {"is there already", "is reserved", "lower limit first", "within", "through its paths"}
    for where, value, _, message in FORM:
        if not any(part in message for part in related):
            assert not SCHEMA.is_valid(changed((where, value))), (where, value)


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
    for per_K, expected in ((-0.01, "140 degC"), (0.04, "-10 degC"), (0.0039, None)):
        heat = {"node": "a", "power_W": poly(1), "per_K": per_K, "reference_degC": 25}
        warnings = parse(json.dumps(bare({"a": 500.0}, [(("a", "ambient"), poly(1))], [heat])).encode()).warnings
        said = [f'$.network.heats[0].per_K: the heat of "a" is negative at {expected}, inside the domain']
        assert [warning.rsplit(":", 1)[0] for warning in warnings] == (said if expected else [])


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


# Networks made at random: what is written reads back as the same.

small = st.floats(0.0, 3.0, allow_nan=False)
at_rest = st.fixed_dictionaries({}, optional={"at_rest": small | st.none()})
tables = st.lists(st.integers(0, 200), min_size=2, max_size=5, unique=True).flatmap(
    lambda pwm: st.fixed_dictionaries(
        {
            "pwm": st.just(sorted(pwm)),
            "value": st.lists(small, min_size=len(pwm), max_size=len(pwm)),
            "interpolation": st.sampled_from(["pchip", "linear"]),
        }
    )
)
laws = st.fixed_dictionaries({"constant": small, "forced": small, "exponent": st.floats(0.1, 3.0)})
shapes = st.one_of(
    st.lists(st.floats(0.0, 1e-3), min_size=1, max_size=3).map(lambda c: {"poly": c}),
    st.tuples(small, st.floats(-0.02, 0.005)).map(lambda c: {"exp1": list(c)}),
    st.tuples(small, st.floats(-0.02, 0.005), small, st.floats(-0.02, 0.005)).map(lambda c: {"exp2": list(c)}),
    tables.map(lambda t: {"table": t}),
    laws.map(lambda p: {"power": p}),
)
curves = st.builds(lambda shape, rest: shape | rest, shapes, at_rest)
columns = st.lists(st.sampled_from(["fan_rpm", "current_A", "load_Nm", "flow"]), unique=True, max_size=3)
grids = st.lists(st.integers(-50, 50), min_size=2, max_size=5, unique=True).flatmap(
    lambda at: st.fixed_dictionaries(
        {"at": st.just(sorted(at)), "value": st.lists(st.floats(0.5, 2.0), min_size=len(at), max_size=len(at))}
    )
)


def factors(names: Sequence[str]) -> st.SearchStrategy[list[Any]]:
    if not names:
        return st.just([])
    channel = st.sampled_from(names).map(lambda name: {"channel": name})
    scaled = st.lists(st.floats(0.0, 1e-4), min_size=0, max_size=3).map(lambda c: {"poly": [*c, 1.0]})
    return st.lists(st.builds(lambda c, f: c | f, channel, scaled | grids.map(lambda t: {"table": t})), max_size=2)


@st.composite
def networks(draw: st.DrawFn) -> dict[str, Any]:
    """Connected networks with their last node tied to the ambient, and what else comes."""
    names = [f"part{k}" for k in range(draw(st.integers(1, 6)))]
    channels: list[dict[str, Any]] = [
        {"column": name, "range": [low, low + width], "neutral": low + width}
        for name in draw(columns)
        for low, width in [draw(st.tuples(st.integers(0, 50), st.integers(1, 50)))]
    ]
    with_factors = st.fixed_dictionaries({}, optional={"factors": factors([str(c["column"]) for c in channels])})
    sensor = st.fixed_dictionaries({}, optional={"offset_K": st.floats(-5, 5), "lag_s": st.just(0) | st.floats(5, 60)})
    about = st.fixed_dictionaries({}, optional={"description": st.text(max_size=9), "sensor": st.none() | sensor})
    nodes = [{"name": n, "capacity_J_per_K": draw(st.floats(2e3, 5e3))} | draw(about) for n in names]
    nodes[draw(st.integers(0, len(names) - 1))]["sensor"] = draw(sensor)
    tree = [(name, draw(st.sampled_from([*names[k + 1 :], "ambient"]))) for k, name in enumerate(names)]
    pairs = [(one, other) for k, one in enumerate(names) for other in [*names[k + 1 :], "ambient"]]
    others = [pair for pair in draw(st.lists(st.sampled_from(pairs), unique=True, max_size=4)) if pair not in tree]
    paths = [{"between": list(ends), G: {"poly": [draw(st.floats(0.1, 3.0))]}} | draw(with_factors) for ends in tree]
    paths += [{"between": draw(st.permutations(ends)), G: draw(curves)} | draw(with_factors) for ends in others]
    warm = st.fixed_dictionaries({}, optional={"per_K": st.floats(-1e-3, 1e-3), "reference_degC": st.floats(0, 40)})
    heats = [
        {"node": draw(st.sampled_from(names)), "power_W": draw(curves)} | draw(with_factors) | draw(warm)
        for _ in range(draw(st.integers(0, 3)))
    ]
    bare = draw(st.sampled_from([True, False]))  # an empty list may be left out
    return {"nodes": nodes, "paths": paths} | {
        key: part for key, part in (("channels", channels), ("heats", heats)) if part or not bare
    }


@settings(max_examples=150, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(networks())
def test_a_network_survives_writing_and_reading(network: dict[str, Any]) -> None:
    tree = TREE | {"network": network}
    SCHEMA.validate(tree)
    try:
        loaded = parse(json.dumps(tree).encode())
    except InputError as error:  # heat and cooling are drawn apart from each other
        assert any(said in error.message for said in ("runs away", "settles", "follows its neighbours"))
        return
    text = dump(loaded.document)
    again = parse(text.encode())
    assert again.document == loaded.document
    assert again.model == loaded.model
    assert dump(again.document) == text
    said = json.loads(text)["network"]
    assert [node["name"] for node in said["nodes"]] == [node["name"] for node in network["nodes"]]
    assert [path["between"] for path in said["paths"]] == [path["between"] for path in network["paths"]]


json_values = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False, allow_infinity=False) | st.text(),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=5), inner, max_size=3),
    max_leaves=6,
)


def places(node: object, path: Path_ = ()) -> list[Path_]:
    items = node.items() if isinstance(node, dict) else enumerate(node) if isinstance(node, list) else ()
    below = [place for key, value in items for place in places(value, (*path, key))]
    return ([path] if path else []) + below


@settings(max_examples=300, deadline=None)
@given(st.sampled_from([place for place in places(TREE) if place[0] == "network"]), json_values)
def test_anything_anywhere_is_taken_or_named(where: Path_, value: object) -> None:
    """Whatever stands anywhere, the file loads or one InputError with a place says why not."""
    try:
        parse(json.dumps(changed((where, value))).encode())
    except InputError as error:
        assert error.place
        assert error.message
