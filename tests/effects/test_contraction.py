"""What runs away is refused and what fades is built: held against equations written by hand, not against the condition.

Parts of constant poles, so that their own rate is known without the code's help: order 1 with rate r settles at S, and
its heat is r S. Courses are integrated by scipy, growth is read off eigenvalues of matrices that stand here.
"""

from __future__ import annotations

import json
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner
from scipy.integrate import solve_ivp

from gen.arrays import FloatArray
from gen.cli import cli
from gen.coefficients import Coefficients, load, parse
from gen.errors import CheckFailed, InputError
from gen.lowering.effects import lower_effects
from gen.lowering.effects.contraction import Contraction, contraction
from gen.lowering.lower import lower
from gen.model import ThermalModel
from gen.model.effects import Applied, Moment
from gen.model.effects.gains import contracts, gains, largest_loop
from gen.model.effects.runaway import domain_of
from gen.model.effects.spans import Span
from gen.model.extended import ExtendedSolution, own_rate
from gen.verification.held import HeldSolution
from tests.effects.cases import CASES, case, effect, lowered
from tests.examples import ROOT, WITH_TRANSFER_FUNCTIONS

Entry = dict[str, Any]
TS = 0.25


def part(name: str, settles_K: float, *rates: float) -> Entry:
    """A part of constant poles that settles so high at PWM 255."""
    gain = settles_K * float(np.prod(rates)) / 255.0
    poles = [{"real": {"poly": [-rate]}} for rate in rates]
    return {"name": name, "order": len(rates), "gain": {"poly": [gain]}, "poles": poles}


def document(parts: list[Entry], effects: list[Entry], **more: object) -> dict[str, Any]:
    return {
        "format": "gen-coefficients",
        "version": 1,
        "name": "made",
        "sample_time_s": TS,
        "input": {"name": "pwm", "full_scale": 255, "nominal_speed_rpm": 3000},
        "ambient": {"fixed_degC": 20.0},
        "validity": {"pwm": [0, 255], "outside": "hold"},
        "domain": {"pwm": [0, 255], "ambient_degC": [0.0, 40.0], "temperature_degC": [0.0, 150.0]},
        "accuracy": {"fixed_limit_K": 1e-5, "float_limit_K": 1e-3},
        "components": parts,
        "effects": effects,
        **more,
    }


def read(parts: list[Entry], effects: list[Entry], **more: Any) -> Coefficients:  # noqa: ANN401
    return parse(json.dumps(document(parts, effects, **more)).encode())


def loss(name: str, per_K: float) -> Entry:
    return effect("temperature_dependent_loss", name, coefficient_per_K=per_K)


def heated(name: str, source: str, per_s: float, **more: object) -> Entry:
    return effect("coupling", name, source=source, conductance_per_s=per_s, exchange=False, **more)


# ---- slopes: ranges of the equations against the equations ----


@pytest.mark.parametrize("label", [label for label in CASES if not label.startswith("all")])
def test_no_slope_lies_outside_of_its_range(label: str) -> None:
    """Differences of each effect's own numbers, at points drawn from the ranges, one rise moved at a time."""
    made = case(label)
    domain = domain_of(made.model, made.effects, {})
    parts = {p.component.name: p for p in gains(made.model, made.effects, domain)}
    random = np.random.default_rng(5)
    for applied in made.effects:
        if not applied.effect.heats:
            continue
        share = next(s for s in parts[applied.component].shares if s.applied is applied)
        for _ in range(40):
            row = int(random.integers(0, 256))
            names = made.model.component_names
            rises = {name: float(random.uniform(-40.0, 400.0)) for name in names}
            point = {c: float(random.uniform(*ends)) for c, ends in domain.channels.items()}
            ambient, reverse = float(random.uniform(*domain.ambient)), float(random.integers(0, 2))
            tau = applied.effect.own_tau(applied.values)
            for name in names:
                step = 1e-3
                ends = [
                    _heat(made.model, applied, row, rises | {name: rises[name] + moved}, point, ambient, reverse)
                    for moved in (-step, step)
                ]
                slope = (ends[1] - ends[0]) / (2.0 * step)
                close = 1e-6 * max(abs(slope), 1e-6) + 1e-9 * max(map(abs, ends))
                if tau is not None:
                    assert abs(slope) * tau <= share.apart.get(name, np.zeros(256))[row] + close * tau
                elif name == applied.component:
                    assert share.own[0][row] - close <= slope <= share.own[1][row] + close
                else:
                    assert abs(slope) <= share.others.get(name, np.zeros(256))[row] + close


def _heat(
    model: ThermalModel,
    applied: Applied,
    row: int,
    rises: dict[str, float],
    channels: dict[str, float],
    ambient: float,
    reverse: float,
) -> float:
    component = model.component(applied.component)
    m: Any = Moment()
    m.count, m.pwm = np.float64(row), np.float64(row / model.full_scale)
    m.rate = own_rate(component)[row]
    m.heat = m.rate * component.steady_rise([row])[0]
    m.standstill, m.reverse = float(row == 0), reverse
    m.ambient = m.measured_ambient = ambient
    m.rise = rises[component.name]
    m.others = {name: rise for name, rise in rises.items() if name != component.name}
    m.channels, m.inner = channels, 0.5
    p = applied.values
    return float(applied.effect.heat(p, m) + applied.effect.per_rise(p, m) * m.rise)


def test_a_span_is_what_its_operations_come_to() -> None:
    random = np.random.default_rng(1)
    for _ in range(300):
        low = random.uniform(-5.0, 5.0, 2)
        high = low + random.uniform(0.0, 4.0, 2)
        spans = [Span(a, b, {name: (1.0, 1.0)}) for a, b, name in zip(low, high, "xy", strict=True)]
        x, y = (float(random.uniform(a, b)) for a, b in zip(low, high, strict=True))

        def formula(x: Any, y: Any) -> Any:  # noqa: ANN401
            return 3.0 * x * y - (x - y / 2.0) ** 4 + x**3 - (1.0 - y) * (1.0 - y) + 2.0

        whole = formula(*spans)
        assert whole.low <= formula(x, y) <= whole.high
        for name, moved in (("x", (1e-5, 0.0)), ("y", (0.0, 1e-5))):
            slope = (formula(x + moved[0], y + moved[1]) - formula(x - moved[0], y - moved[1])) / 2e-5
            assert whole.slope(name)[0] - 1e-4 <= slope <= whole.slope(name)[1] + 1e-4


def test_a_span_is_not_divided_by() -> None:
    with pytest.raises(TypeError):
        1.0 / Span(1.0, 2.0)  # type: ignore[operator]
    with pytest.raises(TypeError):
        Span(1.0, 2.0) / Span(1.0, 2.0)


def test_loops_and_what_only_passes_through() -> None:
    chain = np.array([[0.0, 9.0, 9.0], [0.0, 0.0, 9.0], [0.0, 0.0, 0.0]])
    assert largest_loop(chain) == 0.0 and contracts(chain)
    ring = np.array([[0.0, 0.0, 0.5], [4.0, 0.0, 0.0], [0.0, 0.49, 0.0]])
    assert largest_loop(ring) == pytest.approx(0.98 ** (1 / 3)) and contracts(ring)
    assert not contracts(ring * 1.01)
    assert not contracts(np.array([[np.inf]])) and largest_loop(np.array([[np.inf]])) == np.inf


# ---- a loss that grows with the temperature ----


@pytest.mark.parametrize(("rises_K", "per_K"), [(5000.0, 0.02), (200.0, 0.0052), (60.0, 0.017)])
def test_a_loss_that_outgrows_the_cooling_is_refused_where_it_stands(
    tmp_path: Path, rises_K: float, per_K: float
) -> None:
    path, out = tmp_path / "coeffs.json", tmp_path / "out"
    path.write_text(json.dumps(document([part("iron", rises_K, 1e-3)], [loss("iron", per_K)])))
    run = tmp_path / "run.csv"
    run.write_text("time_s,pwm\n0,255\n4000,255\n")
    for arguments in (["build", path, "--out", out], ["simulate", path, run, "--out", out], ["verify", path]):
        done = CliRunner().invoke(cli, [str(argument) for argument in arguments])
        assert isinstance(done.exception, InputError)  # exit status 2, with this line
        line = str(done.exception)
        assert line.startswith(f"{path}: $.effects[0]: ") and "\n" not in line
        assert f"{per_K * rises_K:.3g} times" in line and "at PWM 255" in line
        assert not out.exists()


def test_the_limit_is_where_the_hand_written_course_ceases_to_fade() -> None:
    """E' = r S alpha (B + E) - r E over ten time constants of what is left, from two starts."""
    rate, settles_K = 1e-3, 150.0
    for share, fades in ((0.9, True), (0.999, True), (1.001, False), (1.1, False)):
        span = 10.0 / (rate * abs(1.0 - share))

        def slope(t: float, e: FloatArray, start: float, share: float) -> FloatArray:
            base = settles_K + (start - settles_K) * np.exp(-rate * t)
            return np.asarray(rate * (share * (base + e) - e))

        ends = [
            solve_ivp(slope, (0.0, span), [0.0], args=(start, share), rtol=1e-10, atol=1e-8).y[0, -1]
            for start in (0.0, 100.0)
        ]
        assert (abs(ends[1] - ends[0]) < 1.0) == fades
        try:
            read([part("iron", settles_K, rate)], [loss("iron", share / settles_K)])
        except InputError as error:
            assert not fades and error.place == "$.effects[0]"
        else:
            assert fades


def test_what_is_allowed_simulates_to_the_rise_that_the_formula_gives() -> None:
    """S / (1 - alpha S), which a part with a share of 0.9 reaches only after ten times its time constant."""
    made = read([part("iron", 150.0, 1e-3)], [loss("iron", 0.9 / 150.0)])
    shown = _exact(made, hours=30.0, pwm=255)["iron"]
    assert shown[-1] - 20.0 == pytest.approx(150.0 / (1.0 - 0.9), rel=1e-4)


def _exact(
    made: Coefficients, hours: float, pwm: int, channels: dict[str, float] | None = None
) -> dict[str, FloatArray]:
    time = np.arange(0.0, hours * 3600.0, 30.0)
    warm = np.full(time.size, 20.0)
    held = {name: np.full(time.size, value) for name, value in (channels or {}).items()}
    solution = ExtendedSolution(made.model, made.effects, finest_s=5.0)
    return solution.simulate_times(time, np.full(time.size, pwm), warm, warm, held, {})


# ---- parts that heat each other, and several effects at once ----


def test_random_loops_are_refused_where_the_matrix_of_the_equations_says_so() -> None:
    """Parts of order 1 and constant rates: M of T' = M T + .. has no eigenvalue of 0 or more at PWM 255 or 0."""
    random = np.random.default_rng(17)
    verdicts = {True: 0, False: 0}
    for _ in range(120):
        count = int(random.integers(1, 5))
        names = ["one", "two", "three", "four"][:count]
        rates = 10.0 ** random.uniform(-3.5, -2.0, count)
        settles = random.uniform(20.0, 140.0, count)
        hot, cold = np.diag(-rates), np.diag(-rates)
        effects: list[Entry] = []
        for i, name in enumerate(names):
            if random.random() < 0.6:
                per_K = float(np.clip(random.uniform(-0.5, 0.9) / settles[i], -0.02, 0.02))
                effects.append(loss(name, per_K))
                hot[i, i] += rates[i] * settles[i] * per_K
            for j, other in enumerate(names):
                if i == j or random.random() < 0.5:
                    continue
                k, exchange = float(rates[i] * random.uniform(0.0, 3.0)), bool(random.random() < 0.3)
                effects.append(effect("coupling", name, source=other, conductance_per_s=k, exchange=exchange))
                for matrix in (hot, cold):
                    matrix[i, j] += k
                    matrix[i, i] -= k if exchange else 0.0
        growth = max(float(np.linalg.eigvals(matrix).real.max()) for matrix in (hot, cold))
        if abs(growth) < 1e-3 * rates.min():
            continue  # on the edge: float64's business
        try:
            read([part(n, s, r) for n, s, r in zip(names, settles, rates, strict=True)], effects)
        except InputError as error:
            assert growth > 0.0, (effects, growth)
            assert error.place is not None and error.place.startswith("$.effects[")
        else:
            assert growth < 0.0, (effects, growth)
        verdicts[growth < 0.0] += 1
    assert min(verdicts.values()) > 15  # else it says little


def test_a_loop_through_states_with_time_constants_of_their_own() -> None:
    """E' = k T_other - E/tau: what comes back in the steady state is the product of k tau."""
    parts = [part("one", 100.0, 1e-3), part("two", 80.0, 2e-3)]
    for product, fades in ((0.95, True), (1.05, False)):
        effects = [heated("one", "two", 1e-3, tau_s=900.0), heated("two", "one", product / 0.9 / 500.0, tau_s=500.0)]
        try:
            read(parts, effects)
        except InputError as error:
            assert not fades and "heat each other" in error.message
        else:
            assert fades


def test_effects_that_are_harmless_alone_are_refused_together() -> None:
    parts = [part("one", 100.0, 1e-3), part("two", 80.0, 2e-3)]
    loop = [heated("one", "two", 0.7e-3), heated("two", "one", 1.4e-3)]
    growing = [loss("one", 0.006)]
    read(parts, loop)
    read(parts, growing)
    with pytest.raises(InputError, match=r'"one" and "two" heat each other: .*1\.11 K come back, at PWM 255') as caught:
        read(parts, [*growing, *loop])
    assert caught.value.place == "$.effects[1]"


def test_a_part_that_a_loop_warms_is_none_of_it() -> None:
    """A third part takes more than any of them, and gives nothing back."""
    parts = [part("three", 50.0, 1e-3), part("one", 100.0, 1e-3), part("two", 80.0, 2e-3)]
    loop = [heated("one", "two", 1.1e-3), heated("two", "one", 2.2e-3)]
    with pytest.raises(InputError, match=r': "one" and "two" heat each other: .*1\.1 K come back') as caught:
        read(parts, [heated("three", "one", 5e-3), *loop])
    assert caught.value.place in ("$.effects[1]", "$.effects[2]")


def test_coupled_parts_near_the_limit_settle_and_are_right() -> None:
    """A loop gain of 0.98: forty rounds from part to part, which once were all, leave kelvins."""
    parts = [part("one", 50.0, 1e-3), part("two", 50.0, 1e-3)]
    made = read(parts, [heated("one", "two", 0.98e-3), heated("two", "one", 0.98e-3)])
    shown = _exact(made, hours=40.0, pwm=255)

    def slope(t: float, y: FloatArray) -> list[float]:
        base = 50.0 * -np.expm1(-1e-3 * t)
        return [-1e-3 * y[0] + 0.98e-3 * (base + y[1]), -1e-3 * y[1] + 0.98e-3 * (base + y[0])]

    end = 40.0 * 3600.0 - 30.0
    added = solve_ivp(slope, (0.0, end), [0.0, 0.0], rtol=1e-10, atol=1e-8).y[:, -1]
    for i, name in enumerate(("one", "two")):
        assert shown[name][-1] == pytest.approx(20.0 + 50.0 * -np.expm1(-1e-3 * end) + added[i], abs=0.01)


def test_a_run_with_a_channel_beyond_its_range_does_not_diverge_silently(tmp_path: Path) -> None:
    """Air that blows backwards heats: -3 units of it more than the part sheds."""
    made = document([part("iron", 100.0, 1e-3)], [effect("airflow", "iron", channel="fan", cooling_per_s=1e-3)])
    path, run, out = (tmp_path / name for name in ("coeffs.json", "run.csv", "out.csv"))
    path.write_text(json.dumps(made))
    run.write_text("time_s,pwm,fan\n" + "".join(f"{t},255,-3\n" for t in range(0, 20_000, 20)))
    done = CliRunner().invoke(cli, ["simulate", str(path), str(run), "--out", str(out)])
    assert isinstance(done.exception, CheckFailed)  # exit status 1
    assert str(done.exception).endswith("grows without end in this run (docs/effects.md)")
    assert not out.exists()


# ---- higher orders, and PWM that switches ----


def test_cooling_that_comes_too_late_is_refused_by_build() -> None:
    """Order 4 with equal poles p has the gain margin 4: roots of (s + p)^4 + K p^4."""
    rate = 4e-3
    parts = [part("iron", 100.0, rate, rate, rate, rate)]
    own = rate / 4.0  # A(0)/A'(0)
    for gain, swings in ((3.5, False), (4.5, True)):
        polynomial = np.poly([-rate] * 4) + np.array([0.0, 0.0, 0.0, 0.0, gain * rate**4])
        assert (np.roots(polynomial).real.max() > 0.0) == swings
        made = read(
            parts,
            [effect("airflow", "iron", channel="fan", cooling_per_s=gain * own)],
            wiring={"channels": [{"column": "fan", "contact_pin": 30}]},
        )
        base = lower(read(parts, []), "float", "table")
        if swings:
            with pytest.raises(
                CheckFailed, match=r'^\$\.effects\[0\]: "iron", of order 4, swings up at PWM 0: .* 4\.5 '
            ):
                lower_effects(made, "float", base.components)
        else:
            program = lower_effects(made, "float", base.components)
            assert program is not None and program.contraction.unproven == ("iron",)


def test_cooling_that_is_too_fast_for_the_sample_time_is_refused_by_build() -> None:
    made = read(
        [part("iron", 100.0, 1e-3)],
        [effect("airflow", "iron", channel="fan", cooling_per_s=0.1)],
        sample_time_s=5.0,
    )
    with pytest.raises(
        CheckFailed, match=r'^\$\.effects\[0\]: "iron" follows with 2 1/s at PWM 0; expected at most 0\.2'
    ):
        lower(made, "float", "table")


@pytest.mark.parametrize("name", WITH_TRANSFER_FUNCTIONS)
def test_every_example_is_proven_to_contract(name: str) -> None:
    made = load(ROOT / "examples" / name / "coeffs.json")
    found = contraction(made.model, made.effects, domain_of(made.model, made.effects, {"fan": (0.0, 1.0)}))
    assert isinstance(found, Contraction) and found.unproven == ()


@pytest.mark.parametrize("label", CASES)
def test_every_planted_effect_is_built(label: str) -> None:
    effects = lowered(label, "float").effects
    assert effects is not None
    assert effects.contraction.loop_gain < 1.0
    described = effects.describe()["contraction"]
    assert described["unproven"] == list(effects.contraction.unproven)


PROVEN = [
    "temperature_dependent_loss",
    "temperature_dependent_loss, order 2 and 4",
    "standstill_cooling, order 3",
    "schedule_error, order 3",
    "several",
]


@pytest.mark.parametrize("label", PROVEN)
def test_what_is_proven_comes_together_however_the_pwm_switches(label: str) -> None:
    """Two courses from 0 and 120 K, PWM that jumps at random (quickly and slowly): the difference fades."""
    made = case(label)
    effects = lowered(label, "float").effects
    assert effects is not None and effects.contraction.unproven == ()
    coarse = ThermalModel(**{**vars(made.model), "sample_time": 4.0})
    random = np.random.default_rng(3)
    length = 12_000
    pwm = np.empty(length, dtype=np.int64)
    edges = [0, *np.cumsum(random.choice([1, 3, 40, 600], 2000)), length]
    for a, b in pairwise(edges):
        pwm[a:b] = random.choice([0, 30, 77, 128, 200, 255])
    shown = {name: np.array([0.0, 120.0]) for name in made.model.component_names}
    course = HeldSolution(coarse, made.effects, shown, np.full(2, 30.0))
    channels = {c.column: (c.low / 1000.0, c.high / 1000.0) for c in effects.channels[1:]}
    for count in pwm:
        told = {column: np.full(2, random.uniform(*ends)) for column, ends in channels.items()}
        course.step(np.full(2, count), np.full(2, 30.0), told)
    ends = course.shown()
    named = {a.component for a in made.effects}
    for index, name in enumerate(made.model.component_names):
        if name in named:
            assert abs(ends[index, 1] - ends[index, 0]) < 2.0
