"""The stand-in for Unity judges and words its assertions alike on this computer and on the emulated board."""

import shutil
from pathlib import Path

import pytest

from tests.platformio.environment import install, pio_test

SAMPLE = Path(__file__).parent / "sample"

# Statement, and the message of its failure (None where it passes).
ASSERTIONS: tuple[tuple[str, str | None], ...] = (
    ("TEST_ASSERT_TRUE(1 == 1);", None),
    ("TEST_ASSERT_TRUE(1 == 2);", "Expected TRUE Was FALSE"),
    ('TEST_ASSERT_TRUE_MESSAGE(1 == 2, "sums");', "Expected TRUE Was FALSE. sums"),
    ("TEST_ASSERT_FALSE(1 == 1);", "Expected FALSE Was TRUE"),
    ("TEST_ASSERT(false);", "Expression Evaluated To FALSE"),
    ("TEST_ASSERT_NOT_NULL(nullptr);", "Expected Non-NULL"),
    ("TEST_ASSERT_EQUAL(-3, -3);", None),
    ("TEST_ASSERT_EQUAL(-3, 4);", "Expected -3 Was 4"),
    ("TEST_ASSERT_EQUAL_INT8(0x7f, 0x180);", "Expected 127 Was -128"),
    ("TEST_ASSERT_EQUAL_INT32(INT32_MIN, INT32_MAX);", "Expected -2147483648 Was 2147483647"),
    ("TEST_ASSERT_EQUAL_UINT32(0, UINT32_MAX);", "Expected 0 Was 4294967295"),
    ('TEST_ASSERT_EQUAL_UINT32_MESSAGE(1, 2, "step 7");', "Expected 1 Was 2. step 7"),
    ("TEST_ASSERT_EQUAL_HEX32(0xDEADBEEFUL, 0xBEEFUL);", "Expected 0xDEADBEEF Was 0x0000BEEF"),
    ("TEST_ASSERT_EQUAL_HEX8(0x1ff, 0xff);", None),
    ("TEST_ASSERT_NOT_EQUAL(5, 5);", "Expected 5 to be not equal to 5"),
    ("TEST_ASSERT_GREATER_THAN(5, 6);", None),
    ("TEST_ASSERT_GREATER_THAN(6, 5);", "Expected 5 to be greater than 6"),
    ("TEST_ASSERT_LESS_OR_EQUAL_UINT32(4, 5);", "Expected 5 to be less or equal to 4"),
    ("TEST_ASSERT_INT32_WITHIN(10, INT32_MAX, INT32_MAX - 10);", None),
    (
        "TEST_ASSERT_INT32_WITHIN(9, INT32_MIN, INT32_MAX);",
        "Values Not Within Delta 9 Expected -2147483648 Was 2147483647",
    ),
    ("TEST_ASSERT_UINT32_WITHIN(1, 3, 5);", "Values Not Within Delta 1 Expected 3 Was 5"),
    ("TEST_ASSERT_EQUAL_MEMORY(ONE, ONE, sizeof(ONE));", None),
    ("TEST_ASSERT_EQUAL_MEMORY(ONE, TWO, 8);", "Memory Mismatch. Byte 4 Expected 0xFE Was 0xFD"),
    (
        "TEST_ASSERT_EQUAL_MEMORY(ONE, TWO, 0);",
        "You Asked Me To Compare Nothing, Which Was Pointless",
    ),
    ("TEST_ASSERT_EQUAL_INT32_ARRAY(ONE, TWO, 2);", "Element 1 Expected -2 Was -3"),
    ('TEST_ASSERT_EQUAL_INT32_ARRAY_MESSAGE(ONE, TWO, 2, "t");', "Element 1 Expected -2 Was -3. t"),
    ('TEST_ASSERT_EQUAL_STRING("cool", "warm");', "Expected 'cool' Was 'warm'"),
    ("TEST_ASSERT_FLOAT_WITHIN(0.25f, 20.0f, 20.25f);", None),
    ("TEST_ASSERT_FLOAT_WITHIN(0.25f, 20.0f, -20.5f);", "Expected 2.000000e1 Was -2.050000e1"),
    ("TEST_ASSERT_FLOAT_WITHIN(0.25f, 20.0f, NAN);", "Expected 2.000000e1 Was nan"),
    ("TEST_ASSERT_FLOAT_WITHIN(0.25f, INFINITY, 0.0625f);", "Expected inf Was 6.250000e-2"),
    ("TEST_ASSERT_EQUAL_FLOAT(1.0f, 1.000001f);", None),
    ("TEST_ASSERT_EQUAL_FLOAT(0.0f, 1.0f);", "Expected 0.000000e0 Was 1.000000e0"),
    ("TEST_ASSERT_FLOAT_IS_DETERMINATE(NAN);", "Expected Determinate Was nan"),
    ('TEST_FAIL_MESSAGE("on purpose");', "on purpose"),
    ('TEST_FAIL_MESSAGE("two\\nlines");', "two\\nlines"),
    ("TEST_FAIL();", ""),
    ("TEST_PASS(); TEST_FAIL();", None),
)


def program() -> str:
    """Return a test program with one case for each assertion, and one that is ignored."""
    cases = "".join(f"void case_{i}() {{ {code} }}\n" for i, (code, _) in enumerate(ASSERTIONS))
    runs = "".join(f"  RUN_TEST(case_{i});\n" for i in range(len(ASSERTIONS)))
    return f"""#include <math.h>
#include <unity.h>
static const int32_t ONE[] = {{-1, -2}};
static const int32_t TWO[] = {{-1, -3}};
{cases}
void ignored() {{ TEST_IGNORE_MESSAGE("later"); }}
static int run_tests() {{
  UNITY_BEGIN();
{runs}  RUN_TEST(ignored);
  return UNITY_END();
}}
#ifdef ARDUINO
#include <Arduino.h>
#include <avr/sleep.h>
void setup() {{
  run_tests();
  cli();
  sleep_enable();
  sleep_cpu();
}}
void loop() {{}}
#else
int main() {{
  run_tests();
}}
#endif
"""


@pytest.mark.parametrize("env", ["native", "simavr"])
def test_every_assertion(tmp_path: Path, env: str) -> None:
    project = Path(shutil.copytree(SAMPLE, tmp_path / "project"))
    (project / "test" / "test_model" / "test_main.cpp").write_text(program())
    result = pio_test(project, env, variables=install(tmp_path / "core", project))
    assert result.errors == ()
    *cases, ignored = result.cases
    assert (ignored.name, ignored.status) == ("ignored", "SKIPPED")
    end = "." if env == "simavr" else ""  # The emulator prints the end of a line as a full stop.
    for case, (code, message) in zip(cases, ASSERTIONS, strict=True):
        status = "PASSED" if message is None else "FAILED"
        assert (case.status, case.message) == (status, "" if message is None else message + end), code
