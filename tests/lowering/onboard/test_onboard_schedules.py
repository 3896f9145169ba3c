"""The onboard schedules of the examples: equality of words, accuracy, proven bound, cost."""

from __future__ import annotations

import json
from dataclasses import replace
from decimal import Decimal
from pathlib import Path

import numpy as np
import pytest

from gen.arrays import FloatArray
from gen.coefficients.reader import parse
from gen.errors import CheckFailed
from gen.lowering import lower as lowering
from gen.lowering.fixed import formats
from gen.lowering.fixed import lower as fixed_lowering
from gen.lowering.kinds import Arithmetic
from gen.lowering.lower import lower
from gen.lowering.onboard import OnboardComponent, compile_component, steady_excess
from gen.lowering.onboard.evaluate import RangeError, evaluate
from gen.lowering.onboard.graph import Graph
from gen.lowering.onboard.sources import schedule_node
from gen.lowering.onboard.tape import GUARD_BITS
from gen.lowering.recursion import bounds, increments
from gen.lowering.recursion.dynamics import TOWARDS_SETTLED, dynamics
from gen.model import ExponentialSum, Polynomial
from gen.model.dynamics import Pole
from tests.campaign import FULL
from tests.lowering.onboard import harness
from tests.lowering.onboard.harness import PWM
from tests.model.examples import model

EXAMPLES_FOLDER = Path(__file__).parents[3] / "examples"
EXAMPLES = ("my1016", "two_mass", "my1016_averaged")
ARITHMETICS: tuple[Arithmetic, ...] = ("fixed", "float")
#: Cycles of a PWM change: the goal of 15 000 less the step's own 1 300.
MOST_CYCLES = {("my1016", "fixed"): 13_700}
#: Bytes of the schedules' code and tables, helpers included: the goal of 5 120 less what the step itself needs.
MOST_FLASH = {("my1016", "fixed"): 3_150, ("my1016", "float"): 3_550}


@pytest.mark.parametrize("arithmetic", ARITHMETICS)
@pytest.mark.parametrize("example", EXAMPLES)
def test_every_input_gives_the_same_words_everywhere(example: str, arithmetic: Arithmetic, tmp_path: Path) -> None:
    components = harness.compiled(example, arithmetic)
    want = harness.words([evaluate(c, PWM) for c in components])
    sources = harness.write(tmp_path, components)
    for compiler in ("g++", "clang++"):
        for extra in ((), ("-fsanitize=undefined", "-fno-sanitize-recover")):
            np.testing.assert_array_equal(harness.host_words(sources, compiler, extra), want)
    got, cycles = harness.mega_words(sources, tmp_path)
    np.testing.assert_array_equal(got, want)
    assert cycles.max() <= MOST_CYCLES.get((example, arithmetic), 20_000)
    if (example, arithmetic) in MOST_FLASH:
        assert harness.flash_bytes(sources) <= MOST_FLASH[example, arithmetic]


@pytest.mark.parametrize("example", EXAMPLES)
def test_fixed_rates_and_steady_rises_are_accurate(example: str) -> None:
    for component, exact in zip(harness.compiled(example, "fixed"), harness.exact(example), strict=True):
        assert component.layout is not None
        rates, steady = evaluate(component, PWM)
        bits = np.array(component.layout.rate_fraction_bits)
        resolution = 0.5 / (exact.rates * 2.0**bits)
        assert np.all(np.abs(rates * 2.0**-bits / exact.rates - 1.0) <= resolution + 1.3e-8)
        assert steady_excess(steady, exact.steady, component.layout).max() <= 4.0
        assert np.abs((steady + 0.5) * component.layout.high_lsb[0] - exact.steady).max() <= 1.5e-6


@pytest.mark.parametrize("example", EXAMPLES)
def test_float_rates_and_steady_rises_are_accurate(example: str) -> None:
    for component, exact in zip(harness.compiled(example, "float"), harness.exact(example), strict=True):
        rates, steady = evaluate(component, PWM)
        assert rates.dtype == steady.dtype == np.float32
        assert np.abs(rates / exact.rates - 1.0).max() <= 4e-6
        assert np.abs(steady - exact.steady).max() <= 1e-4


@pytest.mark.parametrize("place", range(4))
def test_my1016_is_proven_within_its_limit_with_the_boards_own_coefficients(place: int) -> None:
    component = harness.compiled("my1016", "fixed")[place]
    exact = harness.exact("my1016")[place]
    assert component.layout is not None
    recursion, ranges = harness.ranges("my1016", place)
    rates, steady = evaluate(component, PWM)
    excess = steady_excess(steady, exact.steady, component.layout)
    q_error, chain_error = formats.rounding(component.layout, exact.rates)
    board = increments.from_rates(rates * 2.0 ** -np.array(component.layout.rate_fraction_bits))
    bound = bounds.worst_error(
        recursion,
        exact,
        ranges,
        changed_c=board - exact.c,
        q_error=q_error + exact.c[:, 0] * excess * component.layout.high_lsb[0],
        chain_error=np.tile(chain_error, (len(q_error), 1)),
        start_error=component.layout.high_lsb[0],
        carry_error=formats.carry_error(component.layout, float(q_error.max())) if exact.order > 1 else 0.0,
    )
    assert bound is not None
    assert bound.bound_K + component.layout.high_lsb[0] <= harness.LIMIT_K


def synthetic(order: int) -> tuple[OnboardComponent, FloatArray]:
    """Complex poles that are no pairs, mixed with real ones; negative and constant schedules."""
    base = model("two_mass")
    slow = Polynomial((-1e-8, -3e-6, -0.0006))
    poles = (
        Pole(ExponentialSum(((-0.002, 0.003), (-0.0005, -0.004))), Polynomial((2e-6, 0.0007))),
        Pole(ExponentialSum(((-0.0021, 0.0031),)), Polynomial((-2.1e-6, -0.0008))),
        Pole(slow, Polynomial((1e-6, 0.0001))),
        Pole(Polynomial((-0.011,)), Polynomial((-1.1e-6, -0.0001))),
    )[:order]
    template = base.component("housing")
    component = replace(
        template,
        order=order,
        poles=poles if order > 1 else (Pole(slow),),
        gain=Polynomial((1e-9 * 0.003**order, 1e-3 * 0.003**order)),
        outside="extrapolate",
    )
    odd = replace(base, components=(component,), sample_time=0.3)
    exact = dynamics(odd, component, 1)
    return compile_component(odd, component, "float", None, 1), exact.rates


@pytest.mark.parametrize("order", [1, 2, 3, 4])
def test_any_order_and_unpaired_complex_poles_compile(order: int) -> None:
    component, exact = synthetic(order)
    rates, _ = evaluate(component, PWM)
    assert np.abs(rates / exact - 1.0).max() <= 5e-6


def test_at_standstill_outside_of_a_validity_from_1_on_a_negative_gain_is_0_on_the_board_too(tmp_path: Path) -> None:
    """In float 0 times a negative gain would be -0, other words than those that were proven."""
    base = model("two_mass")
    component = replace(
        base.component("housing"),
        order=1,
        poles=(Pole(Polynomial((-3e-6, -0.0006))),),
        gain=Polynomial((3e-8, -2e-6)),  # negative up to PWM 66
        outside="extrapolate",
        negative_gain="zero",
        validity=(1, 200),
    )
    compiled = compile_component(replace(base, components=(component,)), component, "float", None, 1)
    rates, steady = evaluate(compiled, PWM)
    assert (steady[0], np.signbit(steady[0]), steady[1] < 0.0) == (0.0, False, True)
    found = harness.host_words(harness.write(tmp_path, (compiled,)), "g++", ())
    np.testing.assert_array_equal(found, harness.words([(rates, steady)]))


def test_inputs_outside_the_domain_are_refused() -> None:
    component = harness.compiled("my1016", "fixed")[0]
    with pytest.raises(ValueError, match=r"0\.\.255"):
        evaluate(component, np.array([256]))


def test_a_tape_that_overflows_is_noticed() -> None:
    component = harness.compiled("my1016", "fixed")[0]
    place = next(i for i, s in enumerate(component.steps) if s.op == "times")
    steps = list(component.steps)
    steps[place] = replace(steps[place], shift=steps[place].shift + 4)
    with pytest.raises(RangeError):
        evaluate(replace(component, steps=tuple(steps)), PWM)


def near(schedule: dict[str, list[float]], random: np.random.Generator) -> dict[str, list[float]]:
    """A schedule with every coefficient changed by up to 1 %."""
    return {key: [v * (1.0 + 0.01 * random.uniform(-1.0, 1.0)) for v in values] for key, values in schedule.items()}


@pytest.mark.parametrize("seed", [s for s in range(1, 12) if FULL or s in (1, 4)])
def test_a_motor_like_the_my1016_is_proven_within_its_limit_too(seed: int) -> None:
    """With seed 4, R0 and R1 just exceed the powers of two that they stay below in the MY1016."""
    random = np.random.default_rng(seed)
    tree = json.loads((EXAMPLES_FOLDER / "my1016" / "coeffs.json").read_text(encoding="utf-8"))
    brush = tree["components"][0]
    first, second, third = brush["poles"]
    brush["gain"] = near(brush["gain"], random)
    first["real"], first["imag"] = near(first["real"], random), near(first["imag"], random)
    second["real"], second["imag"] = near(second["real"], random), {"poly": [-v for v in first["imag"]["poly"]]}
    third["real"] = near(third["real"], random)
    program = lower(parse(json.dumps(tree).encode()), "fixed", "onboard")  # raises if a bound exceeds the limit
    assert program.components[0].proof is not None
    assert not program.saturates


@pytest.mark.parametrize(("limit", "table_keeps_it"), [(6.2e-6, True), (1e-7, False)])
def test_a_bound_beyond_the_limit_names_the_table_only_where_that_helps(limit: float, table_keeps_it: bool) -> None:
    document = json.loads((EXAMPLES_FOLDER / "two_mass" / "coeffs.json").read_text())
    document["accuracy"] = {"fixed_limit_K": limit}
    with pytest.raises(CheckFailed, match=r"the guaranteed error bound .* exceeds") as failure:
        lower(parse(json.dumps(document).encode()), "fixed", "onboard")
    assert ("--schedule table" in str(failure.value)) == table_keeps_it


@pytest.mark.parametrize(
    ("tolerance", "said"),
    [
        (
            None,
            {
                "-(pole): term 1": "$.real.exp2[0..1]",
                "-(pole): term 2": "$.real.exp2[2..3]",
                "gain: coefficient 0": "$.gain.poly[0]",
                "gain: coefficient 1": "$.gain.poly[1]",
                "gain: coefficient 2": "$.gain.poly[2]",
            },
        ),
        (1e-6, {"-(pole): as a polynomial": "$.real.exp2[0..3]", "gain": "$.gain.poly[0..2]"}),
    ],
)
def test_comments_name_the_entries_of_the_file_that_a_line_comes_from(
    tolerance: float | None, said: dict[str, str]
) -> None:
    graph = Graph(np.arange(0, 256))
    pole, gain = ExponentialSum(((-0.5, -0.01), (-2.0, 0.003))), Polynomial((1e-4, -0.01, -1.0))
    schedule_node(graph, pole, graph.input(), Decimal(1), "$.real", "pole", tolerance=tolerance)
    schedule_node(graph, gain, graph.input(), Decimal(1), "$.gain", "gain", tolerance=tolerance)
    found = {label.text: label.path for label in graph.labels.values()}
    assert {text: path for text, path in found.items() if "[" in path} == said


def test_tuning_that_makes_the_bound_worse_is_not_taken(monkeypatch: pytest.MonkeyPatch) -> None:
    """It looks at the rates alone; the steady rise goes through the same constants."""
    the_model = model("my1016")
    component, lowered = the_model.components[0], harness.lowered("my1016")[0]
    monkeypatch.setattr(fixed_lowering, "TARGET_K", 0.0)  # no bound is good enough: every component is tuned

    def spoiled(tape: OnboardComponent, *_: object) -> OnboardComponent:
        place = next(i for i, step in enumerate(tape.steps) if step.op == "power_series")
        table = tape.steps[place].table
        worse = replace(tape.steps[place], table=(*table[:-1], table[-1] + 3 * 2**GUARD_BITS))
        return replace(tape, steps=(*tape.steps[:place], worse, *tape.steps[place + 1 :]))

    bounds_K = {}
    for name, tuning in (("left", lambda tape, *_: tape), ("spoiled", spoiled)):
        monkeypatch.setattr(lowering, "tuned", tuning)
        found, _ = lowering._onboard(the_model, component, lowered, harness.LIMIT_K, TOWARDS_SETTLED[0])
        assert found.proof is not None
        bounds_K[name] = found.proof.bound_K
    assert bounds_K["spoiled"] == bounds_K["left"]
