// The model against its reference vectors, word for word: on this computer, on the emulated board and on a real one.
#include <stdint.h>
#include <unity.h>

#include <my1016.h>
#include <my1016_model.h>
#include <my1016_platform.h>

#include "vectors.h"

void setUp(void) {}
void tearDown(void) {}

static uint16_t compared;

static void compare(uint32_t expected, uint32_t found) {
    TEST_ASSERT_EQUAL_HEX32(expected, found);
    ++compared;
}

// Compares every state word with the ones that the reference had after the same samples.
static void compare_state(const uint32_t *expected) {
    uint8_t next = 0;
    for (const my1016_A_State &state : my1016_model.state.a) {
        for (const my1016_Word &word : state.x) {
            compare(pgm_read_dword(&expected[next++]), word.lo);
            compare(pgm_read_dword(&expected[next++]), (uint32_t)word.hi);
        }
    }
    for (const my1016_B_State &state : my1016_model.state.b) {
        for (const my1016_Word &word : state.x) {
            compare(pgm_read_dword(&expected[next++]), word.lo);
            compare(pgm_read_dword(&expected[next++]), (uint32_t)word.hi);
        }
    }
    compare(pgm_read_dword(&expected[next++]), (uint32_t)my1016_model.state.ambient_mK);
    TEST_ASSERT_EQUAL_UINT8(VECTOR_WORDS, next);
}

static void start(int32_t rise_mK) {
    my1016_begin();
    for (uint8_t component = 0; component < MY1016_COMPONENTS; ++component) {
        my1016_start(component, rise_mK);
    }
}

static void test_reference_vectors(void) {
    compared = 0;
    start(VECTOR_START_MK);
    for (uint8_t segment = 0; segment < VECTOR_SEGMENTS; ++segment) {
        const int16_t pwm = (int16_t)pgm_read_word(&vector_pwm[segment]);
        const uint16_t samples = pgm_read_word(&vector_samples[segment]);
        for (uint16_t sample = 0; sample < samples; ++sample) {
            my1016_step(pwm);
        }
        compare_state(vector_words[segment]);
    }
    TEST_ASSERT_EQUAL_UINT16(VECTOR_SEGMENTS * VECTOR_WORDS, compared);
}

static void test_direction_does_not_matter(void) {
    int32_t forward[MY1016_COMPONENTS];
    start(0);
    for (uint8_t sample = 0; sample < 200; ++sample) {
        my1016_step(127);
    }
    for (uint8_t component = 0; component < MY1016_COMPONENTS; ++component) {
        forward[component] = my1016_rise_mK(component);
    }
    start(0);
    for (uint8_t sample = 0; sample < 200; ++sample) {
        my1016_step(-127);
    }
    for (uint8_t component = 0; component < MY1016_COMPONENTS; ++component) {
        TEST_ASSERT_EQUAL_INT32(forward[component], my1016_rise_mK(component));
    }
}

static void test_start_is_read_back(void) {
    start(20250L);
    for (uint8_t component = 0; component < MY1016_COMPONENTS; ++component) {
        TEST_ASSERT_EQUAL_INT32(20250L, my1016_rise_mK(component));
        TEST_ASSERT_EQUAL_INT32(20250L + 20000L, my1016_temperature_mC(component, 20000L));
    }
    TEST_ASSERT_EQUAL_UINT8(0, my1016_flags());
}

static void test_flags(void) {
    start(0);
    for (int16_t pwm = -255; pwm <= 255; ++pwm) {
        my1016_step(pwm);
        const int16_t magnitude = pwm < 0 ? (int16_t)-pwm : pwm;
        TEST_ASSERT_EQUAL_UINT8(magnitude < 51 || magnitude > 255, (my1016_flags() & MY1016_OUTSIDE_VALIDITY) != 0);
    }
    my1016_step(255 + 1);
    TEST_ASSERT_TRUE(my1016_flags() & MY1016_PWM_CLAMPED);
    my1016_step(255);
    TEST_ASSERT_FALSE(my1016_flags() & MY1016_PWM_CLAMPED);
    TEST_ASSERT_EQUAL_UINT16(0, my1016_saturations());
    my1016_start(0, 3000000L);
    TEST_ASSERT_TRUE(my1016_flags() & MY1016_START_CLAMPED);
}

static int run_tests(void) {
    UNITY_BEGIN();
    RUN_TEST(test_reference_vectors);
    RUN_TEST(test_direction_does_not_matter);
    RUN_TEST(test_start_is_read_back);
    RUN_TEST(test_flags);
    return UNITY_END();
}

#ifdef ARDUINO
#include <Arduino.h>
#include <avr/sleep.h>

void setup() {
    run_tests();
    // Sleep without interrupts: the emulator ends here, a real board stands still until its next reset.
    cli();
    sleep_enable();
    sleep_cpu();
}

void loop() {}
#else
int main() { return run_tests(); }
#endif
