"""A thermal network as a picture: nodes on a circle, the ambient in its middle, paths as thick as they conduct.

Inline SVG like :mod:`gen.pages.charts`, coloured by the page's style sheet.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations
from math import cos, hypot, pi, sin, sqrt
from statistics import median

from markupsafe import Markup, escape

WIDTH, HEIGHT = 560.0, 430.0
_RADIUS_X, _RADIUS_Y, _NODE = 165.0, 150.0, 13.0
_THINNEST, _THICKEST = 1.0, 9.0
MOST_OF_MEDIAN = 30.0
"""Conductance over the median from which on a path is as thick as any."""
_ROUNDS = 40
_AROUND = 110.0
"""How far a path's bend lies beside the room, twice."""

Point = tuple[float, float]


@dataclass(frozen=True)
class DrawnNode:
    """A node.

    Attributes
    ----------
    name
        Its name.
    sensed
        Whether it has a sensor; a hidden one is drawn with a broken line.
    heat
        What heats it, W; 0 for nothing.
    sure
        Whether the runs determine its capacity and heat; else it is grey.
    added
        Whether it was not there before, or is not what it was.
    """

    name: str
    sensed: bool
    heat: float = 0.0
    sure: bool = True
    added: bool = False


@dataclass(frozen=True)
class DrawnPath:
    """A path between two nodes by their positions, or from one to the ambient (None).

    Attributes
    ----------
    first, second
        The ends.
    conductance
        W/K, above 0.
    sure
        Whether the runs determine it; else it is grey.
    added
        Whether it was not there before, or is not what it was.
    """

    first: int
    second: int | None
    conductance: float
    sure: bool = True
    added: bool = False


def network_svg(
    identifier: str,
    title: str,
    nodes: Sequence[DrawnNode],
    paths: Sequence[DrawnPath],
    arranged_by: Sequence[DrawnPath] | None = None,
) -> Markup:
    """Draw a network.

    Parameters
    ----------
    identifier
        Unique on the page.
    title
        What is shown, and at which speed.
    nodes, paths
        Of the network.
    arranged_by
        Paths that say which nodes are neighbours, so that several pictures have one arrangement; its own by default.
    """
    places = _places(nodes, paths if arranged_by is None else arranged_by)
    every = [path.conductance for path in paths] or [1.0]
    # One that conducts far more than the others would leave nothing to see of these.
    largest = min(max(every), MOST_OF_MEDIAN * median(every))
    head = [
        f'<svg viewBox="0 0 {WIDTH:.0f} {HEIGHT:.0f}" role="img" class="network" '
        f'aria-labelledby="{identifier}-title {identifier}-desc">',
        f'<title id="{identifier}-title">{escape(title)}</title>',
        f'<desc id="{identifier}-desc">{escape(_described(nodes, paths))}</desc>',
        _text(0.0, 14.0, title, "chart-title"),
    ]
    lines = [_path(path, places, largest) for path in sorted(paths, key=lambda path: path.conductance)]
    marks = [mark for node, place in zip(nodes, places, strict=True) for mark in _node(node, place)]
    centre = _centre()
    room = [
        f'<circle class="room" cx="{centre[0]:.1f}" cy="{centre[1]:.1f}" r="{_NODE * 1.7:.1f}"/>',
        _text(centre[0], centre[1] + 4.0, "room", "tick middle"),
    ]
    return Markup("\n".join([*head, *lines, *room, *marks, "</svg>"]))


def _centre() -> Point:
    return WIDTH / 2.0, HEIGHT / 2.0 + 10.0


def _places(nodes: Sequence[DrawnNode], paths: Sequence[DrawnPath]) -> list[Point]:
    """Places on the circle; those that conduct much between them are neighbours, as far as swapping two brings it."""
    count = len(nodes)
    circle = [
        (_centre()[0] + _RADIUS_X * sin(2.0 * pi * k / count), _centre()[1] - _RADIUS_Y * cos(2.0 * pi * k / count))
        for k in range(count)
    ]
    order = list(range(count))

    def length(order: list[int]) -> float:
        ends = ((path.conductance, order[path.first], order[path.second]) for path in paths if path.second is not None)
        return sum(g * hypot(circle[a][0] - circle[b][0], circle[a][1] - circle[b][1]) for g, a, b in ends)

    best = length(order)
    for _ in range(_ROUNDS):
        before = best
        for a, b in combinations(range(count), 2):
            tried = order.copy()
            tried[a], tried[b] = tried[b], tried[a]
            now = length(tried)
            if now < best * (1.0 - 1e-9):
                order, best = tried, now
        if best == before:
            break
    return [circle[place] for place in order]


def _path(path: DrawnPath, places: Sequence[Point], largest: float) -> str:
    (x1, y1), (x2, y2) = places[path.first], _centre() if path.second is None else places[path.second]
    width = _THINNEST + (_THICKEST - _THINNEST) * sqrt(min(path.conductance / largest, 1.0))
    kind = "way" if path.sure else "way unsure"
    if path.second is None:
        kind += " out"
    kind += " added" if path.added else ""
    label = f"{path.conductance:.3g} W/K"
    bend = "L" if path.second is None else _bend((x1, y1), (x2, y2))
    return (
        f'<path class="{kind}" stroke-width="{width:.1f}" d="M{x1:.1f} {y1:.1f}{bend} {x2:.1f} {y2:.1f}">'
        f"<title>{label}</title></path>"
    )


def _bend(one: Point, other: Point) -> str:
    """Straight, or round the room in the middle where it would run through it."""
    centre = _centre()
    x, y = (one[0] + other[0]) / 2.0, (one[1] + other[1]) / 2.0
    if hypot(x - centre[0], y - centre[1]) > 3.0 * _NODE:
        return "L"
    dx, dy = other[0] - one[0], other[1] - one[1]
    side = 1.0 if (x - centre[0]) * -dy + (y - centre[1]) * dx >= 0.0 else -1.0
    away = side * _AROUND / hypot(dx, dy)
    return f"Q{x - dy * away:.1f} {y + dx * away:.1f}"


def _node(node: DrawnNode, place: Point) -> list[str]:
    x, y = place
    kind = f"node{'' if node.sensed else ' hidden'}{'' if node.sure else ' unsure'}{' added' if node.added else ''}"
    centre = _centre()
    away = hypot(x - centre[0], y - centre[1])
    ox, oy = (x - centre[0]) / away, (y - centre[1]) / away
    anchor = "middle" if abs(ox) < 0.3 else "end" if ox < 0.0 else "start"
    text_x, text_y = x + ox * (_NODE + 8.0), y + oy * (_NODE + 14.0) + 4.0
    if node.heat > 0.0 and oy < -0.5:  # its second line lies between the name and the node
        text_y -= 14.0
    marks = [
        f'<circle class="{kind}" cx="{x:.1f}" cy="{y:.1f}" r="{_NODE:.1f}"/>',
        _text(text_x, text_y, node.name, f"chart-title {anchor}"),
    ]
    if node.heat > 0.0:
        marks.append(_text(text_x, text_y + 14.0, f"{node.heat:.3g} W", f"heat {anchor}"))
    return marks


def _described(nodes: Sequence[DrawnNode], paths: Sequence[DrawnPath]) -> str:
    """The same in words, for those who do not see it."""
    sentences = []
    for path in sorted(paths, key=lambda path: -path.conductance):
        other = "the room" if path.second is None else nodes[path.second].name
        sure = "" if path.sure else ", not determined"
        sentences.append(f"{nodes[path.first].name} to {other}: {path.conductance:.3g} W/K{sure}.")
    sentences += [f"{node.name} is heated by {node.heat:.3g} W." for node in nodes if node.heat > 0.0]
    return " ".join(sentences)


def _text(x: float, y: float, text: str, kind: str) -> str:
    return f'<text class="{kind}" x="{x:.1f}" y="{y:.1f}">{escape(text)}</text>'
