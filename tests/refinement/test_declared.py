"""Whether a file's declared error holds in runs: means within its band at their PWM, and what is said of that."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from gen.coefficients import load
from gen.refinement.declared import Held, held
from gen.runs import Run
from tests.examples import ROOT

MODEL = load(ROOT / "examples" / "my1016_rig" / "network.json")
SPEEDS = (102, 204)


def band(part: str, pwm: int) -> tuple[float, float]:
    """What the file declares, K."""
    provenance = MODEL.document.provenance
    assert provenance is not None
    return next(
        one.model_minus_measured_K
        for one in provenance.error
        if one.component == part and one.pwm[0] <= pwm <= one.pwm[1]
    )


def missed(share: float) -> tuple[Run, dict[str, np.ndarray]]:
    """An hour at two speeds whose casing the file gives too warm by a share of what it declares at most."""
    time = np.arange(3600.0)
    pwm = np.repeat(SPEEDS, 1800)
    measured = np.full(time.size, 40.0)
    off = np.array([share * band("casing", int(speed))[1] for speed in pwm])
    noise = np.where(np.arange(time.size) % 2, 1.0, -1.0)
    return Run(time, pwm, {"casing": measured + noise}), {"casing": measured + off}


def test_means_within_the_band_of_their_own_speed_hold_whatever_single_readings_scatter() -> None:
    made = held(MODEL, *missed(0.9))
    assert made.inside == made.of >= 60
    assert "holds in these runs" in made.sentence
    beyond = held(MODEL, *missed(1.1))
    assert (beyond.inside, beyond.of) == (0, made.of)
    assert beyond.sentence == ""


def test_what_was_not_read_or_not_declared_does_not_count() -> None:
    run, shown = missed(0.9)
    half = np.where(run.time_s < 1800.0, run.temps["casing"], np.nan)
    assert held(MODEL, replace(run, temps={"casing": half}), shown).of == pytest.approx(30, abs=1)
    stranger = replace(run, temps={"stranger": run.temps["casing"]})
    assert held(MODEL, stranger, {"stranger": shown["casing"]}) == Held()
    assert Held().sentence == ""


def test_one_in_twenty_may_be_beyond() -> None:
    assert Held(95, 100).sentence
    assert not Held(94, 100).sentence
