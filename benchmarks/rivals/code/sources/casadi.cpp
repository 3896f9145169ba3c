// (e) One step as CasADi wrote it: Runge-Kutta of fourth order with the schedule inside.
#include "rival.h"

// Of casadi_step.c.
extern "C" int motor_step(const float **argument, float **result, int *iw, float *w, int mem);

static float state[6]; // brush, its slope and curvature, bearing, magnet, casing

void rival_begin() {
    for (uint8_t i = 0; i < 6; ++i) {
        state[i] = 0.0f;
    }
    for (uint8_t i = 0; i < RIVAL_PARTS; ++i) {
        rival_rise[i] = 0.0f;
    }
}

void rival_step(int16_t pwm) {
    const float u = rival_magnitude(pwm);
    float next[6], work[CASADI_WORK];
    int indices[CASADI_INDICES];
    const float *argument[CASADI_ARGUMENTS] = {state, &u};
    float *result[CASADI_RESULTS] = {next};
    motor_step(argument, result, indices, work, 0);
    for (uint8_t i = 0; i < 6; ++i) {
        state[i] = next[i];
    }
    rival_rise[0] = state[0];
    for (uint8_t i = 1; i < RIVAL_PARTS; ++i) {
        rival_rise[i] = state[i + 2];
    }
}
