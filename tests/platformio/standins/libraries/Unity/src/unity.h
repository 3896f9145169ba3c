/* Stand-in for ThrowTheSwitch's Unity, written for this project: a subset of the interface.
 *
 * As with the original and PlatformIO's defaults, integers are 64 bits wide where `long` is and 32 bits on AVR,
 * where the assertions for 64-bit integers do not exist; there are none for `double`.
 */
#ifndef UNITY_STANDIN_H
#define UNITY_STANDIN_H

#include <limits.h>
#include <math.h>
#include <stddef.h>
#include <stdint.h>

#ifdef UNITY_INCLUDE_CONFIG_H
#include "unity_config.h"
#endif

#if !defined(UNITY_SUPPORT_64) && LONG_MAX > 0x7fffffffL
#define UNITY_SUPPORT_64
#endif

#ifdef __cplusplus
extern "C" {
#endif

#ifdef UNITY_SUPPORT_64
typedef int64_t UNITY_INT;
typedef uint64_t UNITY_UINT;
#else
typedef int32_t UNITY_INT;
typedef uint32_t UNITY_UINT;
#endif

typedef void (*UnityTestFunction)(void);

/* Provided by the test; PlatformIO adds empty weak ones. */
void setUp(void);
void tearDown(void);

void UnityBegin(const char *file);
int UnityEnd(void);
void UnityDefaultTestRun(UnityTestFunction function, const char *name, int line);

#define UNITY_BEGIN() UnityBegin(__FILE__)
#define UNITY_END() UnityEnd()
#define RUN_TEST(function) UnityDefaultTestRun(function, #function, __LINE__)

/* ---- What the assertions call. `line` is the assertion's, `message` may be NULL. ---- */

typedef enum { UNITY_AS_SIGNED, UNITY_AS_UNSIGNED, UNITY_AS_HEX } UnityStyle;
typedef enum { UNITY_EQ, UNITY_NE, UNITY_LT, UNITY_GT, UNITY_LE, UNITY_GE } UnityRelation;

void UnityStandinFail(const char *reason, const char *message, int line);
void UnityStandinIgnore(const char *message, int line);
void UnityStandinPass(const char *message, int line);
void UnityStandinMessage(const char *message, int line);
void UnityStandinSigned(UNITY_INT threshold, UNITY_INT actual, UnityRelation relation, const char *message, int line);
void UnityStandinUnsigned(UNITY_UINT threshold, UNITY_UINT actual, UnityRelation relation, UnityStyle style, int digits,
                          const char *message, int line);
void UnityStandinWithin(UNITY_UINT delta, UNITY_INT expected, UNITY_INT actual, const char *message, int line);
void UnityStandinUnsignedWithin(UNITY_UINT delta, UNITY_UINT expected, UNITY_UINT actual, UnityStyle style, int digits,
                                const char *message, int line);
void UnityStandinArray(const void *expected, const void *actual, size_t count, size_t width, UnityStyle style,
                       const char *message, int line);
void UnityStandinFloatWithin(float delta, float expected, float actual, const char *message, int line);
void UnityStandinFloatArray(const float *expected, const float *actual, size_t count, const char *message, int line);
void UnityStandinFloatRelation(float threshold, float actual, UnityRelation relation, const char *message, int line);
void UnityStandinFloatIs(float actual, int wanted, const char *trait, const char *message, int line);
void UnityStandinString(const char *expected, const char *actual, size_t limit, const char *message, int line);

#ifdef __cplusplus
}
#endif

/* clang-format off */

/* ---- Ways to end a test ---- */
#define TEST_FAIL_MESSAGE(message)   UnityStandinFail(NULL, (message), __LINE__)
#define TEST_FAIL()                  TEST_FAIL_MESSAGE(NULL)
#define TEST_IGNORE_MESSAGE(message) UnityStandinIgnore((message), __LINE__)
#define TEST_IGNORE()                TEST_IGNORE_MESSAGE(NULL)
#define TEST_PASS_MESSAGE(message)   UnityStandinPass((message), __LINE__)
#define TEST_PASS()                  TEST_PASS_MESSAGE(NULL)
#define TEST_MESSAGE(message)        UnityStandinMessage((message), __LINE__)

/* ---- Truth ---- */
#define UNITY_STANDIN_CHECK(holds, reason, message) \
  do { if (!(holds)) { UnityStandinFail((reason), (message), __LINE__); } } while (0)

#define TEST_ASSERT_MESSAGE(c, m)          UNITY_STANDIN_CHECK(c, "Expression Evaluated To FALSE", m)
#define TEST_ASSERT_TRUE_MESSAGE(c, m)     UNITY_STANDIN_CHECK(c, "Expected TRUE Was FALSE", m)
#define TEST_ASSERT_FALSE_MESSAGE(c, m)    UNITY_STANDIN_CHECK(!(c), "Expected FALSE Was TRUE", m)
#define TEST_ASSERT_UNLESS_MESSAGE(c, m)   UNITY_STANDIN_CHECK(!(c), "Expression Evaluated To TRUE", m)
#define TEST_ASSERT_NULL_MESSAGE(p, m)     UNITY_STANDIN_CHECK((p) == NULL, "Expected NULL", m)
#define TEST_ASSERT_NOT_NULL_MESSAGE(p, m) UNITY_STANDIN_CHECK((p) != NULL, "Expected Non-NULL", m)

#define TEST_ASSERT(c)          TEST_ASSERT_MESSAGE(c, NULL)
#define TEST_ASSERT_TRUE(c)     TEST_ASSERT_TRUE_MESSAGE(c, NULL)
#define TEST_ASSERT_FALSE(c)    TEST_ASSERT_FALSE_MESSAGE(c, NULL)
#define TEST_ASSERT_UNLESS(c)   TEST_ASSERT_UNLESS_MESSAGE(c, NULL)
#define TEST_ASSERT_NULL(p)     TEST_ASSERT_NULL_MESSAGE(p, NULL)
#define TEST_ASSERT_NOT_NULL(p) TEST_ASSERT_NOT_NULL_MESSAGE(p, NULL)

/* ---- Integers: S signed, U unsigned, H hexadecimal; each value is first cast to the type in the name ---- */
#define UNITY_S(type, relation, e, a, m) \
  UnityStandinSigned((UNITY_INT)(type)(e), (UNITY_INT)(type)(a), relation, (m), __LINE__)
#define UNITY_U(type, relation, e, a, m) \
  UnityStandinUnsigned((UNITY_UINT)(type)(e), (UNITY_UINT)(type)(a), relation, UNITY_AS_UNSIGNED, 0, (m), __LINE__)
#define UNITY_H(type, relation, e, a, m) \
  UnityStandinUnsigned((UNITY_UINT)(type)(e), (UNITY_UINT)(type)(a), relation, UNITY_AS_HEX, (int)(2 * sizeof(type)), \
                       (m), __LINE__)

#define TEST_ASSERT_EQUAL_MESSAGE(e, a, m)         UNITY_S(UNITY_INT, UNITY_EQ, e, a, m)
#define TEST_ASSERT_EQUAL_INT_MESSAGE(e, a, m)     UNITY_S(UNITY_INT, UNITY_EQ, e, a, m)
#define TEST_ASSERT_EQUAL_INT8_MESSAGE(e, a, m)    UNITY_S(int8_t, UNITY_EQ, e, a, m)
#define TEST_ASSERT_EQUAL_INT16_MESSAGE(e, a, m)   UNITY_S(int16_t, UNITY_EQ, e, a, m)
#define TEST_ASSERT_EQUAL_INT32_MESSAGE(e, a, m)   UNITY_S(int32_t, UNITY_EQ, e, a, m)
#define TEST_ASSERT_EQUAL_UINT_MESSAGE(e, a, m)    UNITY_U(UNITY_UINT, UNITY_EQ, e, a, m)
#define TEST_ASSERT_EQUAL_UINT8_MESSAGE(e, a, m)   UNITY_U(uint8_t, UNITY_EQ, e, a, m)
#define TEST_ASSERT_EQUAL_UINT16_MESSAGE(e, a, m)  UNITY_U(uint16_t, UNITY_EQ, e, a, m)
#define TEST_ASSERT_EQUAL_UINT32_MESSAGE(e, a, m)  UNITY_U(uint32_t, UNITY_EQ, e, a, m)
#define TEST_ASSERT_EQUAL_size_t_MESSAGE(e, a, m)  UNITY_U(size_t, UNITY_EQ, e, a, m)
#define TEST_ASSERT_EQUAL_HEX_MESSAGE(e, a, m)     UNITY_H(UNITY_UINT, UNITY_EQ, e, a, m)
#define TEST_ASSERT_EQUAL_HEX8_MESSAGE(e, a, m)    UNITY_H(uint8_t, UNITY_EQ, e, a, m)
#define TEST_ASSERT_EQUAL_HEX16_MESSAGE(e, a, m)   UNITY_H(uint16_t, UNITY_EQ, e, a, m)
#define TEST_ASSERT_EQUAL_HEX32_MESSAGE(e, a, m)   UNITY_H(uint32_t, UNITY_EQ, e, a, m)
#define TEST_ASSERT_EQUAL_PTR_MESSAGE(e, a, m)     UNITY_H(uintptr_t, UNITY_EQ, e, a, m)
#define TEST_ASSERT_NOT_EQUAL_MESSAGE(e, a, m)     UNITY_S(UNITY_INT, UNITY_NE, e, a, m)
#define TEST_ASSERT_NOT_EQUAL_INT_MESSAGE(e, a, m) UNITY_S(UNITY_INT, UNITY_NE, e, a, m)

#define TEST_ASSERT_EQUAL(e, a)         TEST_ASSERT_EQUAL_MESSAGE(e, a, NULL)
#define TEST_ASSERT_EQUAL_INT(e, a)     TEST_ASSERT_EQUAL_INT_MESSAGE(e, a, NULL)
#define TEST_ASSERT_EQUAL_INT8(e, a)    TEST_ASSERT_EQUAL_INT8_MESSAGE(e, a, NULL)
#define TEST_ASSERT_EQUAL_INT16(e, a)   TEST_ASSERT_EQUAL_INT16_MESSAGE(e, a, NULL)
#define TEST_ASSERT_EQUAL_INT32(e, a)   TEST_ASSERT_EQUAL_INT32_MESSAGE(e, a, NULL)
#define TEST_ASSERT_EQUAL_UINT(e, a)    TEST_ASSERT_EQUAL_UINT_MESSAGE(e, a, NULL)
#define TEST_ASSERT_EQUAL_UINT8(e, a)   TEST_ASSERT_EQUAL_UINT8_MESSAGE(e, a, NULL)
#define TEST_ASSERT_EQUAL_UINT16(e, a)  TEST_ASSERT_EQUAL_UINT16_MESSAGE(e, a, NULL)
#define TEST_ASSERT_EQUAL_UINT32(e, a)  TEST_ASSERT_EQUAL_UINT32_MESSAGE(e, a, NULL)
#define TEST_ASSERT_EQUAL_size_t(e, a)  TEST_ASSERT_EQUAL_size_t_MESSAGE(e, a, NULL)
#define TEST_ASSERT_EQUAL_HEX(e, a)     TEST_ASSERT_EQUAL_HEX_MESSAGE(e, a, NULL)
#define TEST_ASSERT_EQUAL_HEX8(e, a)    TEST_ASSERT_EQUAL_HEX8_MESSAGE(e, a, NULL)
#define TEST_ASSERT_EQUAL_HEX16(e, a)   TEST_ASSERT_EQUAL_HEX16_MESSAGE(e, a, NULL)
#define TEST_ASSERT_EQUAL_HEX32(e, a)   TEST_ASSERT_EQUAL_HEX32_MESSAGE(e, a, NULL)
#define TEST_ASSERT_EQUAL_PTR(e, a)     TEST_ASSERT_EQUAL_PTR_MESSAGE(e, a, NULL)
#define TEST_ASSERT_NOT_EQUAL(e, a)     TEST_ASSERT_NOT_EQUAL_MESSAGE(e, a, NULL)
#define TEST_ASSERT_NOT_EQUAL_INT(e, a) TEST_ASSERT_NOT_EQUAL_INT_MESSAGE(e, a, NULL)

#ifdef UNITY_SUPPORT_64
#define TEST_ASSERT_EQUAL_INT64_MESSAGE(e, a, m)  UNITY_S(int64_t, UNITY_EQ, e, a, m)
#define TEST_ASSERT_EQUAL_UINT64_MESSAGE(e, a, m) UNITY_U(uint64_t, UNITY_EQ, e, a, m)
#define TEST_ASSERT_EQUAL_HEX64_MESSAGE(e, a, m)  UNITY_H(uint64_t, UNITY_EQ, e, a, m)
#define TEST_ASSERT_EQUAL_INT64(e, a)             TEST_ASSERT_EQUAL_INT64_MESSAGE(e, a, NULL)
#define TEST_ASSERT_EQUAL_UINT64(e, a)            TEST_ASSERT_EQUAL_UINT64_MESSAGE(e, a, NULL)
#define TEST_ASSERT_EQUAL_HEX64(e, a)             TEST_ASSERT_EQUAL_HEX64_MESSAGE(e, a, NULL)
#endif

/* ---- Order: the actual value stands in the stated relation to the threshold ---- */
#define TEST_ASSERT_GREATER_THAN_MESSAGE(t, a, m)           UNITY_S(UNITY_INT, UNITY_GT, t, a, m)
#define TEST_ASSERT_LESS_THAN_MESSAGE(t, a, m)              UNITY_S(UNITY_INT, UNITY_LT, t, a, m)
#define TEST_ASSERT_GREATER_OR_EQUAL_MESSAGE(t, a, m)       UNITY_S(UNITY_INT, UNITY_GE, t, a, m)
#define TEST_ASSERT_LESS_OR_EQUAL_MESSAGE(t, a, m)          UNITY_S(UNITY_INT, UNITY_LE, t, a, m)
#define TEST_ASSERT_GREATER_THAN_INT32_MESSAGE(t, a, m)     UNITY_S(int32_t, UNITY_GT, t, a, m)
#define TEST_ASSERT_LESS_THAN_INT32_MESSAGE(t, a, m)        UNITY_S(int32_t, UNITY_LT, t, a, m)
#define TEST_ASSERT_GREATER_OR_EQUAL_INT32_MESSAGE(t, a, m) UNITY_S(int32_t, UNITY_GE, t, a, m)
#define TEST_ASSERT_LESS_OR_EQUAL_INT32_MESSAGE(t, a, m)    UNITY_S(int32_t, UNITY_LE, t, a, m)
#define TEST_ASSERT_GREATER_THAN_UINT32_MESSAGE(t, a, m)     UNITY_U(uint32_t, UNITY_GT, t, a, m)
#define TEST_ASSERT_LESS_THAN_UINT32_MESSAGE(t, a, m)        UNITY_U(uint32_t, UNITY_LT, t, a, m)
#define TEST_ASSERT_GREATER_OR_EQUAL_UINT32_MESSAGE(t, a, m) UNITY_U(uint32_t, UNITY_GE, t, a, m)
#define TEST_ASSERT_LESS_OR_EQUAL_UINT32_MESSAGE(t, a, m)    UNITY_U(uint32_t, UNITY_LE, t, a, m)

#define TEST_ASSERT_GREATER_THAN(t, a)           TEST_ASSERT_GREATER_THAN_MESSAGE(t, a, NULL)
#define TEST_ASSERT_LESS_THAN(t, a)              TEST_ASSERT_LESS_THAN_MESSAGE(t, a, NULL)
#define TEST_ASSERT_GREATER_OR_EQUAL(t, a)       TEST_ASSERT_GREATER_OR_EQUAL_MESSAGE(t, a, NULL)
#define TEST_ASSERT_LESS_OR_EQUAL(t, a)          TEST_ASSERT_LESS_OR_EQUAL_MESSAGE(t, a, NULL)
#define TEST_ASSERT_GREATER_THAN_INT32(t, a)     TEST_ASSERT_GREATER_THAN_INT32_MESSAGE(t, a, NULL)
#define TEST_ASSERT_LESS_THAN_INT32(t, a)        TEST_ASSERT_LESS_THAN_INT32_MESSAGE(t, a, NULL)
#define TEST_ASSERT_GREATER_OR_EQUAL_INT32(t, a) TEST_ASSERT_GREATER_OR_EQUAL_INT32_MESSAGE(t, a, NULL)
#define TEST_ASSERT_LESS_OR_EQUAL_INT32(t, a)    TEST_ASSERT_LESS_OR_EQUAL_INT32_MESSAGE(t, a, NULL)
#define TEST_ASSERT_GREATER_THAN_UINT32(t, a)     TEST_ASSERT_GREATER_THAN_UINT32_MESSAGE(t, a, NULL)
#define TEST_ASSERT_LESS_THAN_UINT32(t, a)        TEST_ASSERT_LESS_THAN_UINT32_MESSAGE(t, a, NULL)
#define TEST_ASSERT_GREATER_OR_EQUAL_UINT32(t, a) TEST_ASSERT_GREATER_OR_EQUAL_UINT32_MESSAGE(t, a, NULL)
#define TEST_ASSERT_LESS_OR_EQUAL_UINT32(t, a)    TEST_ASSERT_LESS_OR_EQUAL_UINT32_MESSAGE(t, a, NULL)

/* ---- Closeness ---- */
#define UNITY_S_WITHIN(type, utype, d, e, a, m) \
  UnityStandinWithin((UNITY_UINT)(utype)(d), (UNITY_INT)(type)(e), (UNITY_INT)(type)(a), (m), __LINE__)
#define UNITY_U_WITHIN(type, style, digits, d, e, a, m) \
  UnityStandinUnsignedWithin((UNITY_UINT)(type)(d), (UNITY_UINT)(type)(e), (UNITY_UINT)(type)(a), style, digits, (m), \
                             __LINE__)

#define TEST_ASSERT_INT_WITHIN_MESSAGE(d, e, a, m)    UNITY_S_WITHIN(UNITY_INT, UNITY_UINT, d, e, a, m)
#define TEST_ASSERT_INT16_WITHIN_MESSAGE(d, e, a, m)  UNITY_S_WITHIN(int16_t, uint16_t, d, e, a, m)
#define TEST_ASSERT_INT32_WITHIN_MESSAGE(d, e, a, m)  UNITY_S_WITHIN(int32_t, uint32_t, d, e, a, m)
#define TEST_ASSERT_UINT_WITHIN_MESSAGE(d, e, a, m)   UNITY_U_WITHIN(UNITY_UINT, UNITY_AS_UNSIGNED, 0, d, e, a, m)
#define TEST_ASSERT_UINT16_WITHIN_MESSAGE(d, e, a, m) UNITY_U_WITHIN(uint16_t, UNITY_AS_UNSIGNED, 0, d, e, a, m)
#define TEST_ASSERT_UINT32_WITHIN_MESSAGE(d, e, a, m) UNITY_U_WITHIN(uint32_t, UNITY_AS_UNSIGNED, 0, d, e, a, m)
#define TEST_ASSERT_HEX32_WITHIN_MESSAGE(d, e, a, m)  UNITY_U_WITHIN(uint32_t, UNITY_AS_HEX, 8, d, e, a, m)

#define TEST_ASSERT_INT_WITHIN(d, e, a)    TEST_ASSERT_INT_WITHIN_MESSAGE(d, e, a, NULL)
#define TEST_ASSERT_INT16_WITHIN(d, e, a)  TEST_ASSERT_INT16_WITHIN_MESSAGE(d, e, a, NULL)
#define TEST_ASSERT_INT32_WITHIN(d, e, a)  TEST_ASSERT_INT32_WITHIN_MESSAGE(d, e, a, NULL)
#define TEST_ASSERT_UINT_WITHIN(d, e, a)   TEST_ASSERT_UINT_WITHIN_MESSAGE(d, e, a, NULL)
#define TEST_ASSERT_UINT16_WITHIN(d, e, a) TEST_ASSERT_UINT16_WITHIN_MESSAGE(d, e, a, NULL)
#define TEST_ASSERT_UINT32_WITHIN(d, e, a) TEST_ASSERT_UINT32_WITHIN_MESSAGE(d, e, a, NULL)
#define TEST_ASSERT_HEX32_WITHIN(d, e, a)  TEST_ASSERT_HEX32_WITHIN_MESSAGE(d, e, a, NULL)

/* ---- Blocks ---- */
#define UNITY_ARRAY(type, style, e, a, n, m) \
  UnityStandinArray((e), (a), (size_t)(n), sizeof(type), style, (m), __LINE__)

#define TEST_ASSERT_EQUAL_MEMORY_MESSAGE(e, a, n, m) \
  UnityStandinArray((e), (a), (size_t)(n), 0, UNITY_AS_HEX, (m), __LINE__)
#define TEST_ASSERT_EQUAL_INT8_ARRAY_MESSAGE(e, a, n, m)   UNITY_ARRAY(int8_t, UNITY_AS_SIGNED, e, a, n, m)
#define TEST_ASSERT_EQUAL_INT16_ARRAY_MESSAGE(e, a, n, m)  UNITY_ARRAY(int16_t, UNITY_AS_SIGNED, e, a, n, m)
#define TEST_ASSERT_EQUAL_INT32_ARRAY_MESSAGE(e, a, n, m)  UNITY_ARRAY(int32_t, UNITY_AS_SIGNED, e, a, n, m)
#define TEST_ASSERT_EQUAL_UINT8_ARRAY_MESSAGE(e, a, n, m)  UNITY_ARRAY(uint8_t, UNITY_AS_UNSIGNED, e, a, n, m)
#define TEST_ASSERT_EQUAL_UINT16_ARRAY_MESSAGE(e, a, n, m) UNITY_ARRAY(uint16_t, UNITY_AS_UNSIGNED, e, a, n, m)
#define TEST_ASSERT_EQUAL_UINT32_ARRAY_MESSAGE(e, a, n, m) UNITY_ARRAY(uint32_t, UNITY_AS_UNSIGNED, e, a, n, m)
#define TEST_ASSERT_EQUAL_HEX8_ARRAY_MESSAGE(e, a, n, m)   UNITY_ARRAY(uint8_t, UNITY_AS_HEX, e, a, n, m)
#define TEST_ASSERT_EQUAL_HEX32_ARRAY_MESSAGE(e, a, n, m)  UNITY_ARRAY(uint32_t, UNITY_AS_HEX, e, a, n, m)
#define TEST_ASSERT_EQUAL_FLOAT_ARRAY_MESSAGE(e, a, n, m)  UnityStandinFloatArray((e), (a), (size_t)(n), (m), __LINE__)
#define TEST_ASSERT_EQUAL_STRING_MESSAGE(e, a, m)          UnityStandinString((e), (a), (size_t)-1, (m), __LINE__)
#define TEST_ASSERT_EQUAL_STRING_LEN_MESSAGE(e, a, n, m)   UnityStandinString((e), (a), (size_t)(n), (m), __LINE__)

#define TEST_ASSERT_EQUAL_MEMORY(e, a, n)       TEST_ASSERT_EQUAL_MEMORY_MESSAGE(e, a, n, NULL)
#define TEST_ASSERT_EQUAL_INT8_ARRAY(e, a, n)   TEST_ASSERT_EQUAL_INT8_ARRAY_MESSAGE(e, a, n, NULL)
#define TEST_ASSERT_EQUAL_INT16_ARRAY(e, a, n)  TEST_ASSERT_EQUAL_INT16_ARRAY_MESSAGE(e, a, n, NULL)
#define TEST_ASSERT_EQUAL_INT32_ARRAY(e, a, n)  TEST_ASSERT_EQUAL_INT32_ARRAY_MESSAGE(e, a, n, NULL)
#define TEST_ASSERT_EQUAL_UINT8_ARRAY(e, a, n)  TEST_ASSERT_EQUAL_UINT8_ARRAY_MESSAGE(e, a, n, NULL)
#define TEST_ASSERT_EQUAL_UINT16_ARRAY(e, a, n) TEST_ASSERT_EQUAL_UINT16_ARRAY_MESSAGE(e, a, n, NULL)
#define TEST_ASSERT_EQUAL_UINT32_ARRAY(e, a, n) TEST_ASSERT_EQUAL_UINT32_ARRAY_MESSAGE(e, a, n, NULL)
#define TEST_ASSERT_EQUAL_HEX8_ARRAY(e, a, n)   TEST_ASSERT_EQUAL_HEX8_ARRAY_MESSAGE(e, a, n, NULL)
#define TEST_ASSERT_EQUAL_HEX32_ARRAY(e, a, n)  TEST_ASSERT_EQUAL_HEX32_ARRAY_MESSAGE(e, a, n, NULL)
#define TEST_ASSERT_EQUAL_FLOAT_ARRAY(e, a, n)  TEST_ASSERT_EQUAL_FLOAT_ARRAY_MESSAGE(e, a, n, NULL)
#define TEST_ASSERT_EQUAL_STRING(e, a)          TEST_ASSERT_EQUAL_STRING_MESSAGE(e, a, NULL)
#define TEST_ASSERT_EQUAL_STRING_LEN(e, a, n)   TEST_ASSERT_EQUAL_STRING_LEN_MESSAGE(e, a, n, NULL)

/* ---- float. EQUAL means equal to five digits, as in the original: compare bits with HEX32 or MEMORY. ---- */
#define TEST_ASSERT_FLOAT_WITHIN_MESSAGE(d, e, a, m) \
  UnityStandinFloatWithin((float)(d), (float)(e), (float)(a), (m), __LINE__)
#define TEST_ASSERT_EQUAL_FLOAT_MESSAGE(e, a, m) \
  UnityStandinFloatWithin(-1.0f, (float)(e), (float)(a), (m), __LINE__)
#define TEST_ASSERT_GREATER_THAN_FLOAT_MESSAGE(t, a, m) \
  UnityStandinFloatRelation((float)(t), (float)(a), UNITY_GT, (m), __LINE__)
#define TEST_ASSERT_LESS_THAN_FLOAT_MESSAGE(t, a, m) \
  UnityStandinFloatRelation((float)(t), (float)(a), UNITY_LT, (m), __LINE__)
#define TEST_ASSERT_FLOAT_IS_NAN_MESSAGE(a, m) \
  UnityStandinFloatIs((float)(a), isnan((float)(a)) != 0, "NaN", (m), __LINE__)
#define TEST_ASSERT_FLOAT_IS_INF_MESSAGE(a, m) \
  UnityStandinFloatIs((float)(a), isinf((float)(a)) != 0 && (float)(a) > 0.0f, "Infinity", (m), __LINE__)
#define TEST_ASSERT_FLOAT_IS_DETERMINATE_MESSAGE(a, m) \
  UnityStandinFloatIs((float)(a), isfinite((float)(a)) != 0, "Determinate", (m), __LINE__)

#define TEST_ASSERT_FLOAT_WITHIN(d, e, a)       TEST_ASSERT_FLOAT_WITHIN_MESSAGE(d, e, a, NULL)
#define TEST_ASSERT_EQUAL_FLOAT(e, a)           TEST_ASSERT_EQUAL_FLOAT_MESSAGE(e, a, NULL)
#define TEST_ASSERT_GREATER_THAN_FLOAT(t, a)    TEST_ASSERT_GREATER_THAN_FLOAT_MESSAGE(t, a, NULL)
#define TEST_ASSERT_LESS_THAN_FLOAT(t, a)       TEST_ASSERT_LESS_THAN_FLOAT_MESSAGE(t, a, NULL)
#define TEST_ASSERT_FLOAT_IS_NAN(a)             TEST_ASSERT_FLOAT_IS_NAN_MESSAGE(a, NULL)
#define TEST_ASSERT_FLOAT_IS_INF(a)             TEST_ASSERT_FLOAT_IS_INF_MESSAGE(a, NULL)
#define TEST_ASSERT_FLOAT_IS_DETERMINATE(a)     TEST_ASSERT_FLOAT_IS_DETERMINATE_MESSAGE(a, NULL)

/* clang-format on */

#endif
