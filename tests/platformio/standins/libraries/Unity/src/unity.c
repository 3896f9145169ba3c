/* Stand-in for ThrowTheSwitch's Unity: running tests and printing what PlatformIO's runner reads. See unity.h. */
#include "unity.h"

#include <setjmp.h>
#include <string.h>

#ifndef UNITY_OUTPUT_CHAR
#include <stdio.h>
#define UNITY_OUTPUT_CHAR(c) putchar(c)
#endif
#ifndef UNITY_OUTPUT_START
#define UNITY_OUTPUT_START()
#endif
#ifndef UNITY_OUTPUT_FLUSH
#define UNITY_OUTPUT_FLUSH()
#endif
#ifndef UNITY_OUTPUT_COMPLETE
#define UNITY_OUTPUT_COMPLETE()
#endif

typedef enum { RUNNING, PASSED, FAILED, IGNORED } Verdict;

static struct {
  const char *file;
  const char *name;
  int line;
  unsigned tests;
  unsigned failures;
  unsigned ignored;
  volatile Verdict verdict;
  jmp_buf leave;
} state;

/* ---- Printing ---- */

static void print(const char *text) {
  for (; *text != '\0'; ++text) {
    /* A line break within a message would break the line that PlatformIO parses. */
    if (*text == '\n') {
      print("\\n");
    } else if (*text != '\r') {
      UNITY_OUTPUT_CHAR(*text);
    }
  }
}

static void print_line_end(void) {
  UNITY_OUTPUT_CHAR('\n');
  UNITY_OUTPUT_FLUSH();
}

static void print_unsigned(UNITY_UINT value) {
  char digits[21];
  char *next = digits + sizeof(digits) - 1;
  *next = '\0';
  do {
    *--next = (char)('0' + (int)(value % 10));
    value /= 10;
  } while (value != 0);
  print(next);
}

static void print_signed(UNITY_INT value) {
  if (value < 0) {
    UNITY_OUTPUT_CHAR('-');
    print_unsigned((UNITY_UINT)0 - (UNITY_UINT)value);
  } else {
    print_unsigned((UNITY_UINT)value);
  }
}

static void print_hex(UNITY_UINT value, int digits) {
  print("0x");
  while (digits-- > 0) {
    UNITY_OUTPUT_CHAR("0123456789ABCDEF"[(value >> (4 * digits)) & 15]);
  }
}

/* Seven digits, as d.dddddde±dd: enough to tell two floats of a failed test apart. */
static void print_float(float value) {
  if (isnan(value)) {
    print("nan");
    return;
  }
  if (value < 0.0f) {
    UNITY_OUTPUT_CHAR('-');
    value = -value;
  }
  if (isinf(value)) {
    print("inf");
    return;
  }
  int exponent = 0;
  if (value > 0.0f) {
    for (; value >= 10.0f; ++exponent) {
      value /= 10.0f;
    }
    for (; value < 1.0f; --exponent) {
      value *= 10.0f;
    }
  }
  uint32_t scaled = (uint32_t)(value * 1000000.0f + 0.5f);
  if (scaled >= 10000000UL) {
    scaled /= 10;
    ++exponent;
  }
  print_unsigned(scaled / 1000000UL);
  UNITY_OUTPUT_CHAR('.');
  for (uint32_t unit = 100000UL; unit != 0; unit /= 10) {
    UNITY_OUTPUT_CHAR((char)('0' + (int)(scaled / unit % 10)));
  }
  UNITY_OUTPUT_CHAR('e');
  print_signed(exponent);
}

static void print_styled(UNITY_UINT value, UnityStyle style, int digits) {
  if (style == UNITY_AS_SIGNED) {
    print_signed((UNITY_INT)value);
  } else if (style == UNITY_AS_UNSIGNED) {
    print_unsigned(value);
  } else {
    print_hex(value, digits);
  }
}

/* file:line:name:VERDICT, the form that PlatformIO looks for. */
static void print_verdict(const char *verdict, int line) {
  print(state.file);
  UNITY_OUTPUT_CHAR(':');
  print_signed(line);
  UNITY_OUTPUT_CHAR(':');
  print(state.name);
  UNITY_OUTPUT_CHAR(':');
  print(verdict);
}

/* ---- Running ---- */

void UnityBegin(const char *file) {
  state.file = file;
  state.tests = state.failures = state.ignored = 0;
  UNITY_OUTPUT_START();
}

int UnityEnd(void) {
  UNITY_OUTPUT_CHAR('\n');
  print("-----------------------");
  print_line_end();
  print_unsigned(state.tests);
  print(" Tests ");
  print_unsigned(state.failures);
  print(" Failures ");
  print_unsigned(state.ignored);
  print(" Ignored ");
  print_line_end();
  print(state.failures == 0 ? "OK" : "FAIL");
  print_line_end();
  UNITY_OUTPUT_COMPLETE();
  return (int)state.failures;
}

void UnityDefaultTestRun(UnityTestFunction function, const char *name, int line) {
  state.name = name;
  state.line = line;
  state.verdict = RUNNING;
  ++state.tests;
  if (setjmp(state.leave) == 0) {
    setUp();
    function();
  }
  if (setjmp(state.leave) == 0) {
    tearDown();
  }
  if (state.verdict == FAILED) {
    ++state.failures;
  } else if (state.verdict == IGNORED) {
    ++state.ignored;
  } else if (state.verdict == RUNNING) {
    print_verdict("PASS", state.line);
    print_line_end();
  }
}

/* Ends the line with the message, if any, and leaves the test. */
static void conclude(Verdict verdict, const char *separator, const char *message) {
  if (message != NULL) {
    print(separator);
    print(message);
  }
  print_line_end();
  state.verdict = verdict;
  longjmp(state.leave, 1);
}

/* Begins the line of a failure; a test that has failed does not fail again in tearDown. */
static void begin_failure(int line) {
  if (state.verdict == FAILED) {
    longjmp(state.leave, 1);
  }
  print_verdict("FAIL: ", line);
}

void UnityStandinFail(const char *reason, const char *message, int line) {
  begin_failure(line);
  if (reason != NULL) {
    print(reason);
  }
  conclude(FAILED, reason == NULL ? "" : ". ", message);
}

void UnityStandinIgnore(const char *message, int line) {
  print_verdict("IGNORE", line);
  conclude(IGNORED, ": ", message);
}

void UnityStandinPass(const char *message, int line) {
  print_verdict("PASS", line);
  conclude(PASSED, ": ", message);
}

void UnityStandinMessage(const char *message, int line) {
  print_verdict("INFO: ", line);
  print(message);
  print_line_end();
}

/* ---- Assertions ---- */

static const char *relation_text(UnityRelation relation) {
  switch (relation) {
    case UNITY_NE:
      return " to be not equal to ";
    case UNITY_LT:
      return " to be less than ";
    case UNITY_GT:
      return " to be greater than ";
    case UNITY_LE:
      return " to be less or equal to ";
    case UNITY_GE:
      return " to be greater or equal to ";
    default:
      return " Was ";
  }
}

static int relation_holds(UnityRelation relation, int order) {
  switch (relation) {
    case UNITY_NE:
      return order != 0;
    case UNITY_LT:
      return order < 0;
    case UNITY_GT:
      return order > 0;
    case UNITY_LE:
      return order <= 0;
    case UNITY_GE:
      return order >= 0;
    default:
      return order == 0;
  }
}

static void fail_relation(UNITY_UINT threshold, UNITY_UINT actual, UnityRelation relation, UnityStyle style, int digits,
                          const char *message, int line) {
  begin_failure(line);
  print("Expected ");
  print_styled(relation == UNITY_EQ ? threshold : actual, style, digits);
  print(relation_text(relation));
  print_styled(relation == UNITY_EQ ? actual : threshold, style, digits);
  conclude(FAILED, ". ", message);
}

void UnityStandinSigned(UNITY_INT threshold, UNITY_INT actual, UnityRelation relation, const char *message, int line) {
  if (!relation_holds(relation, (actual > threshold) - (actual < threshold))) {
    fail_relation((UNITY_UINT)threshold, (UNITY_UINT)actual, relation, UNITY_AS_SIGNED, 0, message, line);
  }
}

void UnityStandinUnsigned(UNITY_UINT threshold, UNITY_UINT actual, UnityRelation relation, UnityStyle style, int digits,
                          const char *message, int line) {
  if (!relation_holds(relation, (actual > threshold) - (actual < threshold))) {
    fail_relation(threshold, actual, relation, style, digits, message, line);
  }
}

static void fail_within(UNITY_UINT delta, UNITY_UINT expected, UNITY_UINT actual, UnityStyle style, int digits,
                        const char *message, int line) {
  begin_failure(line);
  print("Values Not Within Delta ");
  print_unsigned(delta);
  print(" Expected ");
  print_styled(expected, style, digits);
  print(" Was ");
  print_styled(actual, style, digits);
  conclude(FAILED, ". ", message);
}

void UnityStandinWithin(UNITY_UINT delta, UNITY_INT expected, UNITY_INT actual, const char *message, int line) {
  const UNITY_UINT distance = actual > expected ? (UNITY_UINT)actual - (UNITY_UINT)expected
                                                : (UNITY_UINT)expected - (UNITY_UINT)actual;
  if (distance > delta) {
    fail_within(delta, (UNITY_UINT)expected, (UNITY_UINT)actual, UNITY_AS_SIGNED, 0, message, line);
  }
}

void UnityStandinUnsignedWithin(UNITY_UINT delta, UNITY_UINT expected, UNITY_UINT actual, UnityStyle style, int digits,
                                const char *message, int line) {
  if ((actual > expected ? actual - expected : expected - actual) > delta) {
    fail_within(delta, expected, actual, style, digits, message, line);
  }
}

static UNITY_UINT load(const uint8_t *bytes, size_t width, UnityStyle style) {
  int8_t i8;
  int16_t i16;
  int32_t i32;
  switch (width) {
    case 1:
      memcpy(&i8, bytes, 1);
      return style == UNITY_AS_SIGNED ? (UNITY_UINT)(UNITY_INT)i8 : (UNITY_UINT)(uint8_t)i8;
    case 2:
      memcpy(&i16, bytes, 2);
      return style == UNITY_AS_SIGNED ? (UNITY_UINT)(UNITY_INT)i16 : (UNITY_UINT)(uint16_t)i16;
    default:
      memcpy(&i32, bytes, 4);
      return style == UNITY_AS_SIGNED ? (UNITY_UINT)(UNITY_INT)i32 : (UNITY_UINT)(uint32_t)i32;
  }
}

void UnityStandinArray(const void *expected, const void *actual, size_t count, size_t width, UnityStyle style,
                       const char *message, int line) {
  const uint8_t *e = (const uint8_t *)expected;
  const uint8_t *a = (const uint8_t *)actual;
  const int is_memory = width == 0;
  if (is_memory) {
    width = 1;
  }
  if (count == 0) {
    UnityStandinFail("You Asked Me To Compare Nothing, Which Was Pointless", message, line);
  }
  if (e == NULL || a == NULL) {
    UnityStandinFail("Expected And Actual Must Not Be NULL", message, line);
  }
  for (size_t i = 0; i < count; ++i, e += width, a += width) {
    if (memcmp(e, a, width) != 0) {
      begin_failure(line);
      print(is_memory ? "Memory Mismatch. Byte " : "Element ");
      print_unsigned((UNITY_UINT)i);
      print(" Expected ");
      print_styled(load(e, width, style), style, (int)(2 * width));
      print(" Was ");
      print_styled(load(a, width, style), style, (int)(2 * width));
      conclude(FAILED, ". ", message);
    }
  }
}

static int floats_close(float delta, float expected, float actual) {
  if (isnan(expected) || isnan(actual)) {
    return isnan(expected) && isnan(actual);
  }
  if (isinf(expected) || isinf(actual)) {
    return expected == actual;
  }
  if (delta < 0.0f) {
    delta = fabsf(expected) * 0.00001f;
  }
  return fabsf(actual - expected) <= delta;
}

static void print_floats(float expected, const char *between, float actual) {
  print("Expected ");
  print_float(expected);
  print(between);
  print_float(actual);
}

void UnityStandinFloatWithin(float delta, float expected, float actual, const char *message, int line) {
  if (!floats_close(delta, expected, actual)) {
    begin_failure(line);
    print_floats(expected, " Was ", actual);
    conclude(FAILED, ". ", message);
  }
}

void UnityStandinFloatArray(const float *expected, const float *actual, size_t count, const char *message, int line) {
  if (count == 0) {
    UnityStandinFail("You Asked Me To Compare Nothing, Which Was Pointless", message, line);
  }
  for (size_t i = 0; i < count; ++i) {
    if (!floats_close(-1.0f, expected[i], actual[i])) {
      begin_failure(line);
      print("Element ");
      print_unsigned((UNITY_UINT)i);
      print(" ");
      print_floats(expected[i], " Was ", actual[i]);
      conclude(FAILED, ". ", message);
    }
  }
}

void UnityStandinFloatRelation(float threshold, float actual, UnityRelation relation, const char *message, int line) {
  if (isnan(threshold) || isnan(actual) || !relation_holds(relation, (actual > threshold) - (actual < threshold))) {
    begin_failure(line);
    print_floats(actual, relation_text(relation), threshold);
    conclude(FAILED, ". ", message);
  }
}

void UnityStandinFloatIs(float actual, int wanted, const char *trait, const char *message, int line) {
  if (!wanted) {
    begin_failure(line);
    print("Expected ");
    print(trait);
    print(" Was ");
    print_float(actual);
    conclude(FAILED, ". ", message);
  }
}

void UnityStandinString(const char *expected, const char *actual, size_t limit, const char *message, int line) {
  int equal = expected == actual;
  if (expected != NULL && actual != NULL) {
    equal = limit == (size_t)-1 ? strcmp(expected, actual) == 0 : strncmp(expected, actual, limit) == 0;
  }
  if (!equal) {
    begin_failure(line);
    print("Expected '");
    print(expected == NULL ? "NULL" : expected);
    print("' Was '");
    print(actual == NULL ? "NULL" : actual);
    print("'");
    conclude(FAILED, ". ", message);
  }
}
