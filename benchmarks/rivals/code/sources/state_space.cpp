// (g) python-control's discretisation of each part, x = Ad x + Bd u with y the first state, in one generic loop.
#include "rival.h"

#define MOST 3

#include "state_space_table.h" // BRUSH_A[256][9], BRUSH_B[256][3], OTHERS_A[3][256][1], OTHERS_B[3][256][1]

static float brush[3];

static void advance(const float *a, const float *b, float *x, uint8_t order, float u) {
    float next[MOST];
    for (uint8_t row = 0; row < order; ++row) {
        float sum = pgm_read_float(b++) * u;
        for (uint8_t column = 0; column < order; ++column) {
            sum += pgm_read_float(a++) * x[column];
        }
        next[row] = sum;
    }
    for (uint8_t row = 0; row < order; ++row) {
        x[row] = next[row];
    }
}

void rival_begin() {
    for (uint8_t i = 0; i < 3; ++i) {
        brush[i] = 0.0f;
    }
    for (uint8_t i = 0; i < RIVAL_PARTS; ++i) {
        rival_rise[i] = 0.0f;
    }
}

void rival_step(int16_t pwm) {
    const int16_t magnitude = rival_magnitude(pwm);
    const float u = magnitude;
    advance(BRUSH_A[magnitude], BRUSH_B[magnitude], brush, 3, u);
    rival_rise[0] = brush[0];
    for (uint8_t i = 0; i < 3; ++i) {
        advance(OTHERS_A[i][magnitude], OTHERS_B[i][magnitude], &rival_rise[i + 1], 1, u);
    }
}
