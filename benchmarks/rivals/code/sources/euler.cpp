// (a) The straightforward sketch: the study's functions with exp() and one forward Euler step, at every sample.
#include "rival.h"
#include "study.h"

static float slope, curvature; // of the brush, K/s and K/s^2

void rival_begin() {
    slope = curvature = 0.0f;
    for (uint8_t i = 0; i < RIVAL_PARTS; ++i) {
        rival_rise[i] = 0.0f;
    }
}

void rival_step(int16_t pwm) {
    const float u = rival_magnitude(pwm);
    Study s;
    study_of(u, s);
    const float third = s.brush_gain * u - s.a2 * curvature - s.a1 * slope - s.a0 * rival_rise[0];
    rival_rise[0] += TS * slope;
    slope += TS * curvature;
    curvature += TS * third;
    for (uint8_t i = 0; i < 3; ++i) {
        rival_rise[i + 1] += TS * (s.gain[i] * u - s.a[i] * rival_rise[i + 1]);
    }
}
