"""The emitted C++ against the reference, word for word: on the host and on the emulated Mega."""

from __future__ import annotations

import subprocess
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import jinja2
import numpy as np
import pytest
from numpy.typing import NDArray

from gen.lowering.float32 import FloatComponent, Singles
from gen.reference.float32 import FloatStep
from gen.verify.avr.compile import build_elf, sizes, symbols
from gen.verify.avr.simulator import MAILBOX_FOLDER, MARKER_OVERHEAD, EmulatedMega
from tests.lowering.test_float32 import PWM, Run, lowered, simulate

TEMPLATES = Path(__file__).parents[2] / "templates"
WARNINGS = ("-std=gnu++11", "-Wall", "-Wextra", "-Wconversion", "-Werror")
COMPILERS = {
    "g++": ("g++", "-O2", "-ffp-contract=off"),
    "clang++": ("clang++", "-O2", "-ffp-contract=off"),
    "sanitised": ("g++", "-O1", "-ffp-contract=off", "-fsanitize=undefined,address", "-fno-sanitize-recover"),
}
#: Clamping the start compares floats; nothing else may.
STARTS_WITH_COMPARISONS = {"__cmpsf2"}
#: Cycles per sample at constant PWM, all four MY1016 components (issue 2).
GOAL_CYCLES = 2800

# One record: a flag (1 = PWM changed, 2 = start first, at the given rises), then rates and S of every component.
HARNESS = """\
#include "step.h"
#ifdef __AVR__
#include "mailbox.h"
#else
#include <stdio.h>
#endif
{% set floats = components | sum(attribute="order") + components | length %}
struct Input { uint32_t flag; float values[{{ floats }}]; float starts[{{ components | length }}]; };
struct State {
{%- for c in components %} m_State{{ c.order }} s{{ loop.index }};{% endfor %}
};
struct Coefficients {
{%- for c in components %} m_Rates{{ c.order }} r{{ loop.index }}; float steady{{ loop.index }};{% endfor %}
};
Input gen_input;
State gen_output;
static Coefficients now;

static void start() {
{%- for c in components %}
  m_{{ c.name }}_start(&gen_output.s{{ loop.index }}, gen_input.starts[{{ loop.index0 }}]);
  now.r{{ loop.index }} = m_Rates{{ c.order }}();
  now.steady{{ loop.index }} = 0.0f;
{%- endfor %}
}
{% for c in components %}{% set i = loop.index %}
static void stay{{ i }}() {
  for (uint8_t substep = 0; substep < {{ c.substeps }}; ++substep) {
    m_{{ c.name }}_constant(&gen_output.s{{ i }}, &now.r{{ i }});
  }
}
static void change{{ i }}(const float *values) {
  const m_Rates{{ c.order }} old = now.r{{ i }};
  const float oldSteady = now.steady{{ i }};
  memcpy(&now.r{{ i }}, values, sizeof now.r{{ i }});
  now.steady{{ i }} = values[{{ c.order }}];
  m_{{ c.name }}_changed(&gen_output.s{{ i }}, &old, &now.r{{ i }}, oldSteady, now.steady{{ i }});
  for (uint8_t substep = 1; substep < {{ c.substeps }}; ++substep) {
    m_{{ c.name }}_constant(&gen_output.s{{ i }}, &now.r{{ i }});
  }
}
{% endfor %}
static void step() {
  if (gen_input.flag == 2) { start(); }
  if (gen_input.flag == 0) {
{%- for c in components %} stay{{ loop.index }}();{% endfor %}
  } else {
{%- set at = namespace(place=0) %}
{%- for c in components %}
    change{{ loop.index }}(gen_input.values + {{ at.place }});
{%- set at.place = at.place + c.order + 1 %}{% endfor %}
  }
}

#ifdef __AVR__
int main() {
  for (;;) {
    GEN_MAILBOX_NEXT();
    step();
    GEN_MAILBOX_DONE();
  }
}
#else
int main() {
  while (fread(&gen_input, sizeof gen_input, 1, stdin) == 1) {
    step();
    fwrite(&gen_output, sizeof gen_output, 1, stdout);
    float rises[{{ components | length }}];
{%- for c in components %}{% set i = loop.index %}
    rises[{{ i - 1 }}] = m_{{ c.name }}_rise(&gen_output.s{{ i }}, now.steady{{ i }});
{%- endfor %}
    fwrite(rises, sizeof rises, 1, stdout);
  }
{%- if components | selectattr("saturates") | list %}
  fprintf(stderr, "%u", m_saturations);
{%- endif %}
  return 0;
}
#endif
"""


def emit(components: Sequence[FloatComponent], folder: Path) -> Path:
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(TEMPLATES), undefined=jinja2.StrictUndefined, keep_trailing_newline=True
    )
    context = {"name": "m", "components": components}
    step = environment.get_template("lib/model/src/step_float.h.j2").render(context)
    (folder / "step.h").write_text(step, encoding="utf-8")
    source = folder / "harness.cpp"
    source.write_text(environment.from_string(HARNESS).render(context), encoding="utf-8")
    return source


def profiles(rows: int, lanes: int, samples: int, seed: int) -> PWM:
    """Random levels each sample, toggling between the ends, and random blocks: in turns."""
    rng = np.random.default_rng(seed)
    made = [
        rng.integers(0, rows, samples),
        np.tile([0, rows - 1], samples // 2),
        np.repeat(rng.integers(0, rows, samples // 50), 50),
        np.full(samples, rows - 1),
    ]
    return np.stack([made[k % 4] for k in range(lanes)])


def records(components: Sequence[FloatComponent], rows: PWM, starts: Singles) -> NDArray[np.uint32]:
    """The harness's inputs, lane after lane."""
    flags = np.ones(rows.shape, dtype=np.uint32)
    flags[:, 1:] = rows[:, 1:] != rows[:, :-1]
    flags[:, 0] = 2
    columns = [flags.ravel()[:, None]]
    for component in components:
        values = np.column_stack([component.rates, component.steady]).astype(np.float32)
        columns.append(values[rows.ravel()].view(np.uint32))
    repeated = np.repeat(starts.view(np.uint32), rows.shape[1])[:, None]
    columns.extend([repeated] * len(components))
    return np.ascontiguousarray(np.hstack(columns))


def expected(components: Sequence[FloatComponent], rows: PWM, starts: Singles) -> tuple[list[Run], Words]:
    """The reference's runs and all words, lane after lane, shape (lanes * samples, words)."""
    runs = [simulate(component, rows, starts) for component in components]
    words = np.concatenate([run.words for run in runs], axis=2)
    return runs, np.swapaxes(words, 0, 1).reshape(-1, words.shape[2])


Words = NDArray[np.uint32]


def run_host(executable: Path, inputs: NDArray[np.uint32], width: int) -> tuple[Words, str]:
    done = subprocess.run([str(executable)], input=inputs.tobytes(), capture_output=True, check=True)
    return np.frombuffer(done.stdout, dtype=np.uint32).reshape(-1, width), done.stderr.decode()


def compile_host(source: Path, compiler: str) -> Path:
    executable = source.with_suffix(f".{compiler}")
    command = [*COMPILERS[compiler], *WARNINGS, f"-I{source.parent}", str(source), "-o", str(executable)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return executable


@pytest.mark.parametrize("compiler", list(COMPILERS))
@pytest.mark.parametrize("example", ["my1016", "two_mass"])
def test_host_computes_the_same_words(example: str, compiler: str, tmp_path: Path) -> None:
    components = lowered(example)
    starts = np.array([0.0, 57.123, -60.0, 159.99], dtype=np.float32)
    rows = profiles(len(components[0].steady), len(starts), 3000, seed=7)
    runs, words = expected(components, rows, starts)
    rises = np.stack([run.rises.T.ravel().view(np.uint32) for run in runs], axis=1)
    assert all(run.folds > 50 for run in runs)
    inputs = records(components, rows, starts)
    got, _ = run_host(compile_host(emit(components, tmp_path), compiler), inputs, words.shape[1] + rises.shape[1])
    assert np.array_equal(got, np.hstack([words, rises]))


def test_without_proof_words_are_limited_and_counted(tmp_path: Path) -> None:
    brush = lowered("my1016")[0]
    limits = (30.0, 1e-3, 2e-7)
    narrow = replace(brush, proof=None, limits=limits)
    starts = np.array([0.0, 0.0, 50.0, 0.0], dtype=np.float32)
    rows = profiles(len(brush.steady), len(starts), 4000, seed=3)
    runs, words = expected([narrow], rows, starts)
    assert runs[0].saturations > 100
    executable = compile_host(emit([narrow], tmp_path), "g++")
    got, counted = run_host(executable, records([narrow], rows, starts), words.shape[1] + 1)
    assert np.array_equal(got[:, :-1], words)
    assert int(counted) == min(runs[0].saturations, 0xFFFF)


@pytest.mark.parametrize("rise", [-61.0, 161.0])
def test_start_is_clamped_to_the_domain(rise: float) -> None:
    step = FloatStep(lowered("my1016")[0])
    state = step.start(np.array([rise], dtype=np.float32))
    assert step.rise(state, np.zeros(1, dtype=np.float32))[0] == np.clip(rise, -60.0, 160.0)


def test_start_keeps_every_bit_of_the_rise() -> None:
    rises = np.random.default_rng(0).uniform(-60.0, 160.0, 1000).astype(np.float32)
    step = FloatStep(lowered("my1016")[0])
    assert np.array_equal(step.rise(step.start(rises), np.zeros_like(rises)), rises)


def test_fold_is_exact() -> None:
    rng = np.random.default_rng(1)
    brush = lowered("my1016")[0]
    step = FloatStep(brush)
    threshold = brush.thresholds[2]
    grid = 2.0 ** (np.floor(np.log2(threshold)) - 7)
    high = (np.rint(rng.uniform(-1e-5, 1e-5, 2000) / grid) * grid).astype(np.float32)
    low = (rng.choice([-1.0, 1.0], 2000) * rng.uniform(threshold, 8.0 * threshold, 2000)).astype(np.float32)
    zero = np.zeros_like(high)
    state = [zero, zero, zero, zero, high, low, zero]
    step._fold_pair(state, 2)
    assert step.folds == 2000
    before, after = (pair[0].astype(np.float64) + pair[1] for pair in ((high, low), state[4:6]))
    assert np.array_equal(before, after)
    assert np.all(np.abs(state[5]) < threshold / 16.0)


def test_emulated_mega_computes_the_same_words_within_its_cycles(tmp_path: Path) -> None:
    components = lowered("my1016")
    starts = np.array([0.0, 20.0, 60.0, 0.0], dtype=np.float32)
    rows = profiles(len(components[0].steady), len(starts), 1500, seed=11)
    _, words = expected(components, rows, starts)
    inputs = records(components, rows, starts)
    elf = build_elf([emit(components, tmp_path)], [tmp_path, MAILBOX_FOLDER], tmp_path / "harness.elf")
    helpers = {symbol.name for symbol in symbols(elf)}
    assert not helpers & {"__divsf3", "__cmpsf2", "__fixsfsi", "__muldi3"} - STARTS_WITH_COMPARISONS
    with EmulatedMega(elf, tmp_path) as mega:
        outputs, cycles = mega.run_records(
            inputs,
            mega.sram_address("gen_input"),
            4 * inputs.shape[1],
            mega.sram_address("gen_output"),
            4 * words.shape[1],
            len(inputs),
            len(inputs) * 20_000,
        )
    assert np.array_equal(outputs.view(np.uint32), words)
    spent = cycles.astype(np.int64) - MARKER_OVERHEAD
    constant, changed = spent[inputs[:, 0] == 0], spent[inputs[:, 0] == 1]
    print(
        f"constant PWM: mean {constant.mean():.0f}, 99 % {np.percentile(constant, 99):.0f}, worst {constant.max()} "
        f"cycles; change: mean {changed.mean():.0f}, worst {changed.max()}; {sizes(elf)}"
    )
    assert constant.mean() < GOAL_CYCLES
