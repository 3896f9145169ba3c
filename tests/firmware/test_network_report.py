"""The network's picture: every node and path is in it, in marks and in words, and nothing lies outside."""

from __future__ import annotations

import re
from xml.etree import ElementTree

import pytest

from gen.firmware.network_report import curve_charts, drawing, network_constants, state_words, tabulated
from gen.lowering.lower import lower
from gen.pages.network_drawing import HEIGHT, WIDTH, DrawnNode, DrawnPath, network_svg
from tests.examples import NETWORKS, example


@pytest.mark.parametrize("name", NETWORKS)
def test_every_node_path_and_heat_is_drawn_and_said(name: str) -> None:
    program = lower(example(name), "fixed", "table")
    network = program.model.network
    assert network is not None
    tree = ElementTree.fromstring(drawing(program))
    marks = [mark for mark in tree if mark.tag == "circle" and "node" in mark.get("class", "")]
    assert len(marks) == len(network.nodes)
    assert sum("hidden" in mark.get("class", "") for mark in marks) == len(network.hidden)
    ways = [mark for mark in tree if mark.tag == "path"]
    assert len(ways) == len(network.paths)
    assert sum("out" in way.get("class", "") for way in ways) == sum(path.second is None for path in network.paths)
    said = tree.findtext("desc") or ""
    shown = {text.text for text in tree.iter("text")}
    for node in network.nodes:
        assert node.name in shown
        assert node.name in said
    assert len(re.findall(r"W/K", said)) == len(network.paths)
    for mark in marks:
        assert 0.0 < float(mark.get("cx", "0")) < WIDTH
        assert 0.0 < float(mark.get("cy", "0")) < HEIGHT


def test_a_thicker_line_conducts_more_and_what_is_not_determined_is_grey() -> None:
    nodes = [DrawnNode(name, sensed=True, sure=name != "c") for name in "abcd"]
    paths = [DrawnPath(0, 1, 4.0), DrawnPath(1, 2, 1.0, sure=False), DrawnPath(2, 3, 0.01), DrawnPath(0, None, 2.0)]
    tree = ElementTree.fromstring(network_svg("x", "A <network> & more", nodes, paths))
    widths = [float(mark.get("stroke-width", "0")) for mark in tree if mark.tag == "path"]
    assert widths == sorted(widths)
    assert widths[-1] > 2.0 * widths[0]
    assert sum("unsure" in mark.get("class", "") for mark in tree) == 2
    assert "b to c: 1 W/K, not determined." in (tree.findtext("desc") or "")
    assert tree.findtext("title") == "A <network> & more"


@pytest.mark.parametrize("name", NETWORKS)
def test_the_tables_name_every_constant_with_its_place_in_the_file(name: str) -> None:
    program = lower(example(name), "fixed", "table")
    assert program.network is not None
    rows = network_constants(program)
    states = program.network.states
    constant = [term.constant for state in states for term in state.terms]
    constant += [heat.constant for state in states for heat in state.heats]
    assert len(rows) >= len(constant)
    assert all(row[4].startswith("$.network") for row in rows)
    assert len(state_words(program.network)) == len(program.network.states)
    varying = constant.count(False)
    lines = tabulated(program).splitlines()
    assert len(lines) == 257
    assert {len(line.split()) for line in lines[1:]} == {1 + varying}
    assert curve_charts(program)
