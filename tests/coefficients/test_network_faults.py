"""Each fault of a network in the coefficient file is said with its place."""

from __future__ import annotations

import copy
import json

import pytest

from gen.coefficients import parse
from tests.coefficients.network_tree import (
    CHANNELS,
    HEATS,
    NODES,
    PATHS,
    SCHEMA,
    TREE,
    G,
    Path_,
    changed,
    factor,
    failure,
    poly,
)
from tests.coefficients.test_coefficients_errors import BASE, DELETE

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
    ((*NODES, 1, "sensor", "gain_error"), -0.9, "$.network.nodes[1].sensor.gain_error", "expected a number over -0.9"),
    ((*NODES, 1, "sensor", "gain_error"), 2.1, "$.network.nodes[1].sensor.gain_error", "expected at most 2"),
    ((*NODES, 1, "sensor", "gain_about"), "room", "$.network.nodes[1].sensor.gain_about", "ambient"),
    ((*NODES, 1, "sensor", "lag"), 3, "$.network.nodes[1].sensor.lag", 'did you mean "lag_s"?'),
    ((*PATHS, 0, "between", 1), "rotor", "$.network.paths[0].between[1]", 'found "rotor", expected a node\'s name'),
    ((*PATHS, 0, "between", 1), "winding", "$.network.paths[0].between[1]", 'found "winding" twice'),
    ((*PATHS, 0, "between"), ["winding"], "$.network.paths[0].between", "found 1 entry, expected 2"),
    ((*PATHS, 1, "between"), ["casing", "winding"], "$.network.paths[1].between", "joins the same as paths[0]"),
    (
        (*PATHS, 5),
        TREE["network"]["paths"][4],
        "$.network.paths[5].between",
        "joins the same as paths[4]; expected one path of a kind",
    ),
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
    ((*CHANNELS, 0, "range"), [0, 4e-4], "$.network.channels[0].range", "expected values a thousandth apart at least"),
    (
        (*PATHS, 4, "factors", 0),
        factor(at=[0, 9, 9.0004], value=[1, 1, 1]),
        "$.network.paths[4].factors[0].table.at[2]",
        "found 9.0004 after 9, expected values a thousandth apart at least",
    ),
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


def test_a_channel_may_have_a_path_of_its_own_beside_another() -> None:
    """A fan cools a surface of its own, whatever else leads from there to the ambient."""
    fan = {"channel": "fan_rpm", "poly": [1e-3, 0]}
    beside = {"between": ["ambient", "mount"], G: {"poly": [0.1]}, "factors": [fan]}
    network = parse(json.dumps(changed(((*PATHS, 7), beside))).encode()).model.network
    assert network is not None
    assert [path.label for path in network.paths[5::2]] == ["mount - ambient", "mount - ambient, by fan_rpm"]


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


def test_ambient_and_channels_count_to_the_thousandth_as_a_board_is_told_them() -> None:
    """The exact solution that a board is held against is that of what the board can be told."""
    tree = changed(((*PATHS, 4, "factors", 0), factor(at=[0, 33.33333, 100], value=[1, 3, 2])))
    tree["ambient"]["fixed_degC"] = 22.44174
    tree["network"]["channels"][0] |= {"range": [0.00049, 3000.0004], "neutral": 0.0015}
    found = parse(json.dumps(tree).encode())
    network = found.model.network
    assert network is not None
    assert found.model.ambient_fixed == 22.442
    assert (network.channels[0].low, network.channels[0].high, network.channels[0].neutral) == (0.0, 3000.0, 0.002)
    assert network.paths[4].factors[0].at == (0.0, 33.333, 100.0)
    assert not any("steps over the range" in said for said in found.warnings)


def test_a_part_may_not_be_called_what_the_library_calls_its_own() -> None:
    """A flag of the model is NAME_SATURATED, and so would the part's number be; a hidden node has none."""
    sensed = next(node["name"] for node in TREE["network"]["nodes"] if "sensor" in node)
    error = failure(json.loads(json.dumps(TREE).replace(f'"{sensed}"', '"Saturated"')))
    assert '"Saturated" is what the emitted library calls a constant of its own' in error.message


def test_a_channel_that_a_board_is_told_in_few_steps_is_said() -> None:
    tree = changed(((*CHANNELS, 0, "range"), [0, 0.01]))
    tree["network"]["channels"][0]["neutral"] = 0.0
    found = parse(json.dumps(tree).encode())
    assert any("which are 10 steps over the range: write it in a smaller unit" in said for said in found.warnings)


def test_the_schema_takes_the_file_and_rejects_what_it_can_express() -> None:
    """Not what relates one part to another."""
    assert SCHEMA.is_valid(TREE)
    assert SCHEMA.is_valid(BASE | {"version": 2, "network": None})
    related = {'one of "poly" and "table"', 'no "effects"', "with a guarantee", "is taken", "win ding", "twice"}
    related |= {"joins the same", "expected a node's name", "a column of", "strictly increasing", "values, expected"}
    related |= {
        "is there already",
        "is reserved",
        "lower limit first",
        "within",
        "through its paths",
        "a thousandth apart",
    }
    for where, value, _, message in FORM:
        if not any(part in message for part in related):
            assert not SCHEMA.is_valid(changed((where, value))), (where, value)


@pytest.mark.parametrize(("watts_per_K", "runs_away"), [(0.39, False), (0.41, True)])
def test_natural_convection_counts_as_it_is_where_both_ends_are_alike(watts_per_K: float, *, runs_away: bool) -> None:
    """There it takes least: 0.4 W of what 1 K more of the casing makes, though 1.6 W of it at 60 K above the room."""
    tree = copy.deepcopy(TREE)
    convection = {"between": ["casing", "ambient"], G: poly(1.0), "convection": poly(0.01, 0.4)}
    heat = {"node": "casing", "power_W": poly(10.0), "per_K": watts_per_K / 10.0}
    nodes = [{"name": "casing", "capacity_J_per_K": 1500.0, "sensor": {}}]
    tree["network"] = {"nodes": nodes, "paths": [convection], "heats": [heat]}
    if runs_away:
        assert "runs away at PWM 0" in failure(tree).message
    else:
        parse(json.dumps(tree).encode())
