"""Pictures that say which numbers they show."""

from __future__ import annotations

import hashlib
import io
import re
from pathlib import Path

import matplotlib
import numpy as np
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.figure import Figure

_DIGITS = 3


def digest(figure: Figure) -> str:
    """What the figure shows: curves to three digits of their panel's range, and every label.

    Rounding errors of another machine do not count; they could only where a value lies just between two digits, so
    sums over a curve are taken, not its points.
    """
    told: list[str] = []
    for axes in figure.axes:
        low, high = axes.get_ylim()
        told += [axes.get_title(), axes.get_xlabel(), axes.get_ylabel()]
        for line in axes.get_lines():
            y = np.asarray(line.get_ydata(), dtype=np.float64)
            share = (y[np.isfinite(y)] - low) / (high - low)
            told.append(f"{line.get_label()} {y.size} {np.round(share.mean(), _DIGITS):.{_DIGITS}f}")
    return hashlib.sha256("\n".join(told).encode()).hexdigest()[:16]


def write(figure: Figure, path: Path) -> None:
    """Write the picture, with its digest as its description; the same bytes for the same figure."""
    FigureCanvasSVG(figure)
    buffer = io.StringIO()
    with matplotlib.rc_context({"svg.hashsalt": "gen", "svg.fonttype": "none"}):
        figure.savefig(buffer, format="svg", metadata={"Date": None, "Description": f"shows {digest(figure)}"})
    path.write_text("\n".join(line.rstrip() for line in buffer.getvalue().splitlines()) + "\n", encoding="utf-8")


def shown(path: Path) -> str:
    """The digest that a picture carries; empty without one."""
    found = re.search(r"shows ([0-9a-f]{16})", path.read_text(encoding="utf-8"))
    return found[1] if found else ""
