"""Both faults against every row of the study's table, settled, without sensors."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gen.rig import Fault, Motor, MotorConfig
from gen.rig.config import FaultKind
from gen.rig.losses import Condition, Operation, heat
from gen.rig.parameters import my1016
from gen.rig.profiles import counts

PERCENT = (10, 20, 30, 40, 50, 60, 70, 80, 90, 100)
KINDS: tuple[FaultKind, ...] = ("bearing", "brush")


@cache
def settled(
    kind: FaultKind | None, severity: float = 1.0, percents: tuple[int, ...] = PERCENT
) -> dict[str, np.ndarray]:
    faults = () if kind is None else (Fault(kind, severity=severity),)
    rows = []
    for percent in percents:
        motor = Motor(MotorConfig(faults=faults, max_step_s=5.0))
        motor.step(counts(percent), 30_000.0)
        rows.append(motor.temperatures)
    return {name: np.array([row[name] for row in rows]) for name in ("brush", "casing", "bearing")}


def over_healthy(kind: FaultKind, part: str) -> dict[int, float]:
    return dict(zip(PERCENT, settled(kind)[part] - settled(None)[part], strict=True))


@pytest.mark.parametrize("percent", [10, 20, 30, 40, 50, 60, 70])
def test_bearing_fault_warms_the_brush_by_about_5_K_up_to_70_percent(percent: int) -> None:
    assert over_healthy("bearing", "brush")[percent] == pytest.approx(5.0, abs=1.0)


def test_bearing_fault_warms_the_brush_more_and_more_from_80_to_100_percent() -> None:
    brush = over_healthy("bearing", "brush")
    assert brush[70] < brush[80] < brush[90] < brush[100]
    assert brush[100] > 7.0


@pytest.mark.parametrize("percent", [10, 20, 30, 40])
def test_brush_fault_leaves_the_brush_like_healthy_up_to_40_percent(percent: int) -> None:
    assert over_healthy("brush", "brush")[percent] == pytest.approx(0.0, abs=1.1)  # one sensor's tolerance


def test_brush_fault_cools_the_brush_by_about_4_K_at_60_percent() -> None:
    assert over_healthy("brush", "brush")[60] == pytest.approx(-4.0, abs=1.0)


def test_brush_fault_warms_the_brush_at_high_speed() -> None:
    brush = over_healthy("brush", "brush")
    assert brush[90] > 1.1
    assert brush[100] > 3.0


@pytest.mark.parametrize("kind", KINDS)
def test_casing_is_more_than_5_K_over_healthy_from_30_percent_and_growing(kind: FaultKind) -> None:
    casing = [over_healthy(kind, "casing")[percent] for percent in PERCENT if percent >= 30]
    assert min(casing) > 5.0
    assert all(np.diff(casing) > 0.0)


def test_hottest_casing_is_75_degC_at_70_percent_with_the_bearing_fault() -> None:
    casing = settled("bearing")["casing"]
    assert PERCENT[int(np.argmax(casing))] == 70
    assert casing.max() == pytest.approx(75.0, abs=1.0)
    assert settled("brush")["casing"].max() < 76.0


def test_brush_at_70_percent_tells_the_faults_apart_and_full_speed_shows_both() -> None:
    assert over_healthy("bearing", "brush")[70] > 1.1
    assert over_healthy("brush", "brush")[70] < -1.1
    assert min(over_healthy(kind, "brush")[100] for kind in KINDS) > 3.0


def test_degreased_bearing_is_itself_the_part_that_warms_most() -> None:
    bearing, casing = over_healthy("bearing", "bearing"), over_healthy("bearing", "casing")
    assert all(bearing[percent] > casing[percent] for percent in PERCENT)


@pytest.mark.parametrize("kind", KINDS)
def test_half_a_fault_shows_about_half_of_it_on_the_casing(kind: FaultKind) -> None:
    some = (20, 60, 100)
    healthy = settled(None, percents=some)["casing"]
    half = settled(kind, 0.5, some)["casing"] - healthy
    whole = settled(kind, percents=some)["casing"] - healthy
    np.testing.assert_allclose(half, 0.5 * whole, rtol=0.1)


@pytest.mark.parametrize("kind", KINDS)
def test_fault_changes_nothing_before_it_starts_and_something_right_after(kind: FaultKind) -> None:
    healthy, broken = Motor(), Motor(MotorConfig(faults=(Fault(kind, start_s=600.0),)))
    for motor in (healthy, broken):
        motor.step(204, 600.0)
    np.testing.assert_array_equal(healthy.state, broken.state)
    for motor in (healthy, broken):
        motor.step(204, 60.0)
    assert np.abs(healthy.state - broken.state).max() > 0.01


def test_severity_ramps_up_and_kinds_add_up_to_one_at_most() -> None:
    config = MotorConfig(faults=(Fault("brush", 100.0, 0.8, ramp_s=100.0), Fault("brush", 150.0, 0.5)))
    assert [config.severity("brush", t) for t in (99.0, 125.0, 149.0, 1000.0)] == pytest.approx([0.0, 0.2, 0.392, 1.0])
    assert config.severity("bearing", 1000.0) == 0.0


def test_nonsense_is_refused() -> None:
    with pytest.raises(ValueError, match="bearing or brush"):
        Fault("gear")  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="severity"):
        Fault("brush", severity=1.5)


SPEED = st.floats(0.05, 1.0)


@given(speed=SPEED, severity=st.floats(0.0, 1.0), moved=st.floats(0.0, 0.3))
def test_where_heat_goes_does_not_change_how_much_there_is(speed: float, severity: float, moved: float) -> None:
    """Energy: what a fault's arcs and edge add is their own power, and shares only move it from node to node."""
    motor = my1016()
    now, ill = Operation(speed, duty=speed), Condition(brush_fault=severity, bearing_fault=severity)
    fault = motor.faults.brush

    def total(**changed: float) -> float:
        brush = fault.model_copy(update={k: v for k, v in changed.items() if hasattr(fault, k)})
        losses = motor.losses.model_copy(update={k: v for k, v in changed.items() if hasattr(motor.losses, k)})
        faults = motor.faults.model_copy(update={"brush": brush})
        return sum(heat(motor.model_copy(update={"faults": faults, "losses": losses}), now, ill).nodes)

    plain = total()
    for share in ("arc_in_casing", "brush_keeps", "ripple_in_brush", "ripple_in_magnet", "ripple_in_casing"):
        assert total(**{share: moved}) == pytest.approx(plain, rel=1e-9)
    added = severity * speed**fault.arc_exponent
    assert total(arc_W=fault.arc_W + 1.0) - plain == pytest.approx(added, abs=1e-9)
