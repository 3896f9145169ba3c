"""What radiation carries beyond a conductance at a node that nobody measures: of the temperature that it begins at."""

from __future__ import annotations

import numpy as np

from gen.refinement.network.changing.excess import REFERENCE, excesses
from gen.replay import Inputs
from gen.runs import Run
from tests.examples import example

ROOM, WARM = 20.0, 60.0
SENSED = ("bearing", "brush", "magnet", "casing")


def beyond(degC: float) -> float:
    """(T^4 - T'^4) / (4 T0^3) less (T - T'), in kelvin."""
    one, room, reference = (each + 273.15 for each in (degC, ROOM, REFERENCE))
    return float((one**4 - room**4) / (4.0 * reference**3) - (one - room))


def test_a_hidden_winding_among_warm_parts_begins_as_warm_as_they_are() -> None:
    time = np.arange(0.0, 60.0, 1.0)
    even = np.ones(time.size)
    run = Run(time, np.zeros(time.size, dtype=np.int64), dict.fromkeys(SENSED, WARM * even), ROOM * even)
    inputs = Inputs(ROOM * even, ROOM * even, {"fan_percent": 0.0 * even}, dict.fromkeys(SENSED, WARM - ROOM))
    *measured, hidden = excesses(example("network"), run, inputs)
    assert all(np.allclose(each, beyond(WARM), atol=0.3) for each in measured)  # a sensor of the file is 0.3 K off
    assert beyond(WARM - 5.0) < hidden[0] < beyond(WARM + 1.0)
