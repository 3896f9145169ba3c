// (b) The same with the coefficients kept until PWM changes.
#include "rival.h"
#include "study.h"

static float slope, curvature; // of the brush, K/s and K/s^2
static Study s;
static float drive[RIVAL_PARTS]; // gain times |PWM|
static int16_t known;            // the |PWM| that they are of

void rival_begin() {
    slope = curvature = 0.0f;
    known = -1;
    for (uint8_t i = 0; i < RIVAL_PARTS; ++i) {
        rival_rise[i] = 0.0f;
    }
}

void rival_step(int16_t pwm) {
    const int16_t magnitude = rival_magnitude(pwm);
    if (magnitude != known) {
        known = magnitude;
        const float u = magnitude;
        study_of(u, s);
        drive[0] = s.brush_gain * u;
        for (uint8_t i = 0; i < 3; ++i) {
            drive[i + 1] = s.gain[i] * u;
        }
    }
    const float third = drive[0] - s.a2 * curvature - s.a1 * slope - s.a0 * rival_rise[0];
    rival_rise[0] += TS * slope;
    slope += TS * curvature;
    curvature += TS * third;
    for (uint8_t i = 0; i < 3; ++i) {
        rival_rise[i + 1] += TS * (drive[i + 1] - s.a[i] * rival_rise[i + 1]);
    }
}
