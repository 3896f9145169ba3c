"""Pictures that say which numbers they show."""

from __future__ import annotations

import hashlib
import io
import re
from dataclasses import dataclass
from pathlib import Path

import matplotlib
import numpy as np
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.figure import Figure

_TOLERANCE = 8e-3
"""By how much of its panel's range the mean of a curve may differ on another machine, where fits end elsewhere: one and
the same code differed by 5.2e-3 between two processors, at a model of the second heater."""


@dataclass(frozen=True)
class Told:
    """What a figure shows.

    Attributes
    ----------
    labels
        A digest of its titles, labels and of how many points each curve has.
    means
        Of each curve, as a share of its panel's range.
    """

    labels: str
    means: tuple[float, ...]

    def agrees(self, other: Told) -> bool:
        """Whether another figure shows the same, but for rounding."""
        if self.labels != other.labels or len(self.means) != len(other.means):
            return False
        return all(abs(a - b) <= _TOLERANCE for a, b in zip(self.means, other.means, strict=True))

    def __str__(self) -> str:
        return " ".join([self.labels, *(f"{mean:.4f}" for mean in self.means)])


def told(figure: Figure) -> Told:
    """What the figure shows."""
    labels: list[str] = []
    means: list[float] = []
    for axes in figure.axes:
        low, high = axes.get_ylim()
        labels += [axes.get_title(), axes.get_xlabel(), axes.get_ylabel()]
        for line in axes.get_lines():
            y = np.asarray(line.get_ydata(), dtype=np.float64)
            labels.append(f"{line.get_label()} {y.size}")
            means.append(float(((y[np.isfinite(y)] - low) / (high - low)).mean()))
    return Told(hashlib.sha256("\n".join(labels).encode()).hexdigest()[:16], tuple(means))


def write(figure: Figure, path: Path) -> None:
    """Write the picture, with what it shows as its description; the same bytes for the same figure."""
    FigureCanvasSVG(figure)
    buffer = io.StringIO()
    with matplotlib.rc_context({"svg.hashsalt": "gen", "svg.fonttype": "none"}):
        figure.savefig(buffer, format="svg", metadata={"Date": None, "Description": f"shows {told(figure)}"})
    path.write_text("\n".join(line.rstrip() for line in buffer.getvalue().splitlines()) + "\n", encoding="utf-8")


def shown(path: Path) -> Told:
    """What a picture says that it shows; nothing of one that does not say."""
    found = re.search(r"shows ([0-9a-f]{16})((?: -?[0-9.]+)*)", path.read_text(encoding="utf-8"))
    return Told(found[1], tuple(map(float, found[2].split()))) if found else Told("", ())
