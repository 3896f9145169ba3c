// (f) A fixed-step solver as block diagrams are compiled to: fourth-order Runge-Kutta in float over all states,
// the schedule in a block of its own that runs when its input changes.
#include "rival.h"
#include "study.h"

#define STATES 6

static float x[STATES]; // brush, its slope and curvature, bearing, magnet, casing
static Study s;
static int16_t known;

static void derivatives(float u, const float *at, float *out) {
    out[0] = at[1];
    out[1] = at[2];
    out[2] = s.brush_gain * u - s.a2 * at[2] - s.a1 * at[1] - s.a0 * at[0];
    for (uint8_t i = 0; i < 3; ++i) {
        out[i + 3] = s.gain[i] * u - s.a[i] * at[i + 3];
    }
}

static void moved(const float *slope, float by, float *out) {
    for (uint8_t i = 0; i < STATES; ++i) {
        out[i] = x[i] + by * slope[i];
    }
}

static void outputs() {
    rival_rise[0] = x[0];
    for (uint8_t i = 1; i < RIVAL_PARTS; ++i) {
        rival_rise[i] = x[i + 2];
    }
}

void rival_begin() {
    known = -1;
    for (uint8_t i = 0; i < STATES; ++i) {
        x[i] = 0.0f;
    }
    outputs();
}

void rival_step(int16_t pwm) {
    const int16_t magnitude = rival_magnitude(pwm);
    const float u = magnitude;
    if (magnitude != known) {
        known = magnitude;
        study_of(u, s);
    }
    float f0[STATES], f1[STATES], f2[STATES], f3[STATES], at[STATES];
    derivatives(u, x, f0);
    moved(f0, 0.5f * TS, at);
    derivatives(u, at, f1);
    moved(f1, 0.5f * TS, at);
    derivatives(u, at, f2);
    moved(f2, TS, at);
    derivatives(u, at, f3);
    for (uint8_t i = 0; i < STATES; ++i) {
        x[i] += TS / 6.0f * (f0[i] + 2.0f * f1[i] + 2.0f * f2[i] + f3[i]);
    }
    outputs();
}
