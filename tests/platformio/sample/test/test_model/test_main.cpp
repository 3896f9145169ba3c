// Runs on the computer, on the emulated board and on a real one.
#include <demo_model.h>
#include <string.h>
#include <unity.h>

void test_first_step() {
  demo_model::Model model;
  TEST_ASSERT_EQUAL_INT32(255L * 4096L, model.step(255));
}

void test_settles() {
  demo_model::Model model;
  int32_t state = 0;
  for (int i = 0; i < 1000; ++i) {
    state = model.step(100);
  }
  TEST_ASSERT_INT32_WITHIN(16, 100L << 16, state);
  TEST_ASSERT_FLOAT_WITHIN(0.001f, 100.0f, static_cast<float>(state) / 65536.0f);
}

void test_is_deterministic() {
  demo_model::Model one;
  demo_model::Model two;
  int32_t a[8];
  int32_t b[8];
  for (uint8_t i = 0; i < 8; ++i) {
    a[i] = one.step(i);
    b[i] = two.step(i);
  }
  TEST_ASSERT_EQUAL_MEMORY(a, b, sizeof(a));
}

static int run_tests() {
  UNITY_BEGIN();
  RUN_TEST(test_first_step);
  RUN_TEST(test_settles);
  RUN_TEST(test_is_deterministic);
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
int main() {
  return run_tests();
}
#endif
