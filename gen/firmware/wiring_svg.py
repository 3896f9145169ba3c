"""The wiring diagram of a project: the board's pins on the left, what is connected to them on the right."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from html import escape

from gen.firmware.sketch.device import DeviceContext
from gen.firmware.sketch.pin import Pin

_ROW = 20
_GAP = 20
_TOP = 56
_BOARD_X, _BOARD_WIDTH = 24, 150
_LANES_X, _LANE = 196, 13
_DEVICE_WIDTH = 250
_COLOURS = ("#1f6fb4", "#c2410c", "#15803d", "#7e22ce", "#0f766e", "#a16207", "#be185d")
_SUPPLY = {"5 V": "#dc2626", "GND": "#1b1f24"}
"""Where a terminal goes that is on no numbered pin, and the colour of the wire."""
_WAYS = {"forward": "forward", "reverse": "reverse"}
_SIGNED = {"PWM": "pwm", "DIR": "direction"}
"""Terminals of the two kinds of motor driver, and the keys of their lines."""
_STYLE = (
    "text{font:12px sans-serif;fill:#1b1f24}.title{font-weight:bold}.small{font-size:10px;fill:#57606a}"
    ".box{fill:#f6f8fa;stroke:#57606a}.wire{fill:none;stroke-width:1.6}"
)


@dataclass(frozen=True)
class Terminal:
    """One terminal of a device: its name and the pin that it goes to (or "5 V", "GND")."""

    name: str
    to: str


@dataclass(frozen=True)
class Part:
    """A device on the right."""

    title: str
    terminals: tuple[Terminal, ...]


def parts(device: DeviceContext) -> list[Part]:
    """What is connected, from top to bottom.

    Parameters
    ----------
    device
        What :func:`gen.firmware.sketch.device.device_context` made.
    """
    found: list[Part] = []
    for chip in device["chips"]:
        if chip["analog"] is not None:
            ends = ("5 V", "GND") if chip["to_supply"] else ("GND", "5 V")
            titles = (f"NTC: {chip['channel']}", f"{chip['series']} ohm, for {chip['channel']}")
            middle = Terminal("1", chip["analog"]["label"])
            found += [Part(title, (middle, Terminal("2", end))) for title, end in zip(titles, ends, strict=True)]
            continue
        signals = [Terminal(key.upper(), pin["label"]) for key, pin in chip["lines"].items()]
        supply = [Terminal("VCC", "5 V"), Terminal("GND", "GND")]
        found.append(Part(f"{chip['converter']}: {chip['channel']}", (*signals, *supply)))
    for channel in device["channels"]:
        title = f"{channel['column']}: {'0..5 V' if channel['analog'] else 'contact'}"
        found.append(
            Part(title, (Terminal("OUT" if channel["analog"] else "1", channel["label"]), Terminal("GND", "GND")))
        )
    if device["encoder"]:
        pulses = Terminal("pulses", device["encoder"]["label"])
        found.append(Part("Encoder", (pulses, Terminal("VCC", "5 V"), Terminal("GND", "GND"))))
    drive, observe = device["drive"], device["observe"]
    if drive:
        title, keys = ("Motor driver", _SIGNED) if drive["pwm"] else ("Motor driver: PWM in", _WAYS)
        pins = {"forward": drive["forward"], "reverse": drive["reverse"], "pwm": drive["pwm"]}
        pins["direction"] = drive["direction"]
        found.append(Part(title, _inputs(keys, pins)))
    if observe:
        pins = {"forward": observe["forward"], "reverse": observe["reverse"]}
        found.append(Part("Other controller: PWM", _inputs(_WAYS, pins)))
    if device["relay"] is not None:
        inputs = (Terminal("IN", device["relay"]["label"]), Terminal("VCC", "5 V"), Terminal("GND", "GND"))
        found.append(Part("Relay of the motor's supply", inputs))
    if device["led"] is not None:
        title = "LED" if device["led"] == 13 else "LED with 330 ohm"
        found.append(
            Part(f"{title} (on the board)" if device["led"] == 13 else title, (Terminal("+", str(device["led"])),))
        )
    if device["button"] is not None:
        found.append(Part("Button", (Terminal("1", device["board"].label(device["button"])), Terminal("2", "GND"))))
    return found


def _inputs(keys: Mapping[str, str], pins: Mapping[str, Pin | None]) -> tuple[Terminal, ...]:
    """Terminals of what is wired, by their names, and ground."""
    wired = {name: pin for name, key in keys.items() if (pin := pins[key]) is not None}
    return (*(Terminal(name, pin["label"]) for name, pin in wired.items()), Terminal("GND", "GND"))


def wiring_svg(title: str, device: DeviceContext) -> str:
    """Draw the diagram as SVG; pins that several devices share, 5 V and GND have one wire with a dot at each branch.

    Parameters
    ----------
    title
        Its heading.
    device
        What :func:`gen.firmware.sketch.device.device_context` made.
    """
    devices = parts(device)
    ends = dict.fromkeys(t.to for part in devices for t in part.terminals)
    pins = [to for to in ends if _is_pin(to)]
    wired = [*pins, *(to for to in _SUPPLY if to in ends)]
    device_x = _LANES_X + _LANE * (len(wired) + 2)
    heights = _places(devices)
    board_rows = {pin: _TOP + _ROW * (index + 2) for index, pin in enumerate([*pins, *_SUPPLY])}
    bottom = max([*board_rows.values(), *(y for y, _, _ in heights)]) + 2 * _ROW
    width = device_x + _DEVICE_WIDTH + 24
    lines = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {bottom}" width="{width}" height="{bottom}">',
        f"<title>{escape(title)}</title><style>{_STYLE}</style>",
        f'<rect width="{width}" height="{bottom}" fill="white"/>',
        f'<text class="title" x="{_BOARD_X}" y="28">{escape(title)}</text>',
        *_board(device["board"].title, board_rows),
        *_wires(wired, board_rows, heights, device_x),
        *_devices(devices, heights, device_x),
        "</svg>",
    ]
    return "\n".join(lines) + "\n"


def _is_pin(to: str) -> bool:
    return to not in _SUPPLY


def _places(devices: list[Part]) -> list[tuple[int, Part, Terminal]]:
    """Every terminal with its height, from top to bottom."""
    found, y = [], _TOP + _ROW // 2  # halfway between the board's rows, so that no two wires lie on one line
    for part in devices:
        y += _ROW
        for terminal in part.terminals:
            y += _ROW
            found.append((y, part, terminal))
        y += _GAP
    return found


def _board(title: str, rows: dict[str, int]) -> Iterator[str]:
    height = max(rows.values()) - _TOP + _ROW
    yield f'<rect class="box" x="{_BOARD_X}" y="{_TOP}" width="{_BOARD_WIDTH}" height="{height}" rx="6"/>'
    yield f'<text class="title" x="{_BOARD_X + 10}" y="{_TOP + 18}">{title}</text>'
    for pin, y in rows.items():
        yield f'<text x="{_BOARD_X + _BOARD_WIDTH - 8}" y="{y + 4}" text-anchor="end">{pin}</text>'


def _wires(
    wired: list[str], rows: dict[str, int], terminals: list[tuple[int, Part, Terminal]], device_x: int
) -> Iterator[str]:
    start = _BOARD_X + _BOARD_WIDTH
    for index, pin in enumerate(wired):
        lane, colour = _LANES_X + _LANE * (index + 1), _SUPPLY.get(pin, _COLOURS[index % len(_COLOURS)])
        ends = [y for y, _, terminal in terminals if terminal.to == pin]
        heights = [rows[pin], *ends]
        path = f"M{start} {rows[pin]}H{lane}M{lane} {min(heights)}V{max(heights)}"
        path += "".join(f"M{lane} {y}H{device_x}" for y in ends)
        yield f'<path class="wire" stroke="{colour}" d="{path}"/>'
        for y in heights[1:] if len(ends) > 1 else ():
            yield f'<circle cx="{lane}" cy="{y}" r="3" fill="{colour}"/>'


def _devices(devices: list[Part], terminals: list[tuple[int, Part, Terminal]], x: int) -> Iterator[str]:
    place = iter(terminals)
    for part in devices:
        own = [next(place) for _ in part.terminals]
        top, height = own[0][0] - 2 * _ROW + 4, _ROW * (len(own) + 1) + 8
        yield f'<rect class="box" x="{x}" y="{top}" width="{_DEVICE_WIDTH}" height="{height}" rx="6"/>'
        yield f'<text class="title" x="{x + 10}" y="{top + 17}">{escape(part.title)}</text>'
        for y, _, terminal in own:
            note = f"to pin {terminal.to}" if _is_pin(terminal.to) else f"to {terminal.to}"
            yield f'<text x="{x + 10}" y="{y + 4}">{escape(terminal.name)}</text>'
            yield f'<text class="small" x="{x + 100}" y="{y + 4}">{note}</text>'
