"""What a model is said to err by in its own runs is what `gen simulate` gives for the file."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import gen
from gen.identification.logs.sources import read_sources
from gen.identification.network.data import make_network_data
from gen.identification.network.identify import identify_network
from gen.identification.network.telling.document import network_text
from gen.identification.network.telling.summary import Summary
from gen.identification.settings import Settings
from gen.runs import Run, write_run


def a_plate(start_degC: float, seed: int = 1) -> Run:
    """Five minutes of a plate about a heater, in a room that nobody measured; rows every 5 s, scatter of 0.5 K.

    The plate was warm before, and its heater is no warmer than it: another past than a file would expect.
    """
    random = np.random.default_rng(seed)
    time = 5.0 * np.arange(61.0)
    pwm = np.where((time >= 10.0) & (time < 240.0), 93, 0)
    plate = heater = start_degC
    shown = []
    for on in pwm > 0:
        shown.append(plate)
        for _ in range(50):
            flow = 0.6 * (heater - plate)
            heater += 0.1 * ((60.0 if on else 0.0) - flow) / 60.0
            plate += 0.1 * (flow - 0.15 * (plate - 21.0)) / 40.0
    read = np.round((np.array(shown) + random.normal(0.0, 0.5, time.size)) * 4.0) / 4.0
    return Run(time, pwm.astype(np.int64), {"plate": read}, comments={"drives": "heater"})


@pytest.mark.parametrize("start_degC", [24.0, 36.0, 50.0])
def test_of_one_run_it_is_what_simulate_gives(tmp_path: Path, start_degC: float) -> None:
    path, file = tmp_path / "run.csv", tmp_path / "plate.json"
    write_run(path, a_plate(start_degC))
    found = identify_network(make_network_data(read_sources([path]), None), lambda _: None)
    file.write_text(network_text(found, Settings("plate"))[0])
    run = gen.read_run(path)
    error = gen.simulate(gen.load(file), path)["plate_degC"].to_numpy() - run["plate_degC"].to_numpy()
    given = float(np.sqrt(np.mean(error**2)))
    assert float(Summary(found).rms_K[0, 0]) == pytest.approx(given, rel=0.1, abs=0.25)
