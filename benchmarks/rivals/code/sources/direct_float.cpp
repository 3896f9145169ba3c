// (c) The difference equation in direct form: float32, zero-order-hold coefficients in a table for each |PWM|.
#include "rival.h"

struct Third {
    float a[3], b[3];
};
struct First {
    float a, b;
};
#include "direct_float_table.h" // BRUSH[256], OTHERS[256][3]

static float y[3], u[3]; // the brush's last outputs and inputs, newest first

void rival_begin() {
    for (uint8_t i = 0; i < 3; ++i) {
        y[i] = u[i] = 0.0f;
    }
    for (uint8_t i = 0; i < RIVAL_PARTS; ++i) {
        rival_rise[i] = 0.0f;
    }
}

void rival_step(int16_t pwm) {
    const int16_t magnitude = rival_magnitude(pwm);
    u[2] = u[1];
    u[1] = u[0];
    u[0] = magnitude;
    const Third *row = &BRUSH[magnitude];
    float sum = 0.0f;
    for (uint8_t k = 0; k < 3; ++k) {
        sum += pgm_read_float(&row->b[k]) * u[k] - pgm_read_float(&row->a[k]) * y[k];
    }
    y[2] = y[1];
    y[1] = y[0];
    y[0] = rival_rise[0] = sum;
    for (uint8_t i = 0; i < 3; ++i) {
        const First *other = &OTHERS[magnitude][i];
        rival_rise[i + 1] = pgm_read_float(&other->b) * u[0] - pgm_read_float(&other->a) * rival_rise[i + 1];
    }
}
