"""A loss that grows with temperature, written into a file whose heats grow already: the sum of what was fitted."""

from __future__ import annotations

import numpy as np
import pytest

from gen.coefficients.network import HeatEntry, NetworkEntry, NodeEntry, PathEntry, PolyCurve, SensorEntry
from gen.coefficients.network_curves import values_of
from gen.refinement.network.changing.draft import Draft
from gen.refinement.network.changing.writer import NetworkWriter


@pytest.mark.parametrize(("already", "since"), [(0.0, 25.0), (0.004, 21.0), (-0.003, 30.0)])
def test_what_is_written_is_what_was_fitted(already: float, since: float) -> None:
    watts, more, reference = 8.0, 0.007, 40.0
    draft = Draft(np.array([50.0]), 1, 0)
    draft.warm(0, np.array([watts]), already, since, [])
    draft.grow(0, np.array([more]), reference, [])
    heat = HeatEntry(node="a", power_W=PolyCurve(poly=(watts,)), per_K=already, reference_degC=since)
    path = PathEntry(between=("a", "ambient"), conductance_W_per_K=PolyCurve(poly=(0.2,)))
    entry = NetworkEntry(
        nodes=(NodeEntry(name="a", capacity_J_per_K=50.0, sensor=SensorEntry()),), paths=(path,), heats=(heat,)
    )
    writer = NetworkWriter(entry, 255, {}, 0.25)
    writer.grows("a", more, reference)
    (written,) = writer.entry.heats
    power = values_of(written.power_W, np.array([200]), 255)[0][0]
    for degC in (0.0, 25.0, 90.0):
        fitted = draft.heat.value[0, 0] + draft.growth.value[0, 0] * degC
        shown = power * (1.0 + written.per_K * (degC - written.reference_degC))
        assert shown == pytest.approx(fitted, rel=1e-4)
