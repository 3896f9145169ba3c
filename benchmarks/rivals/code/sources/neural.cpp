// (h) A small neural network through emlearn: |PWM| and its slow means go in, the rises come out.
#include "rival.h"

#include "neural_net.h" // emlearn's: rises_regress(); SHARES[MEANS], the means' shares of a new sample; SCALE_K

static float mean[2 * MEANS]; // of |PWM| / 255 and of its square

void rival_begin() {
    for (uint8_t i = 0; i < 2 * MEANS; ++i) {
        mean[i] = 0.0f;
    }
    for (uint8_t i = 0; i < RIVAL_PARTS; ++i) {
        rival_rise[i] = 0.0f;
    }
}

void rival_step(int16_t pwm) {
    const float u = rival_magnitude(pwm) / 255.0f;
    float input[1 + 2 * MEANS];
    input[0] = u;
    for (uint8_t i = 0; i < MEANS; ++i) {
        mean[i] += SHARES[i] * (u - mean[i]);
        mean[MEANS + i] += SHARES[i] * (u * u - mean[MEANS + i]);
    }
    for (uint8_t i = 0; i < 2 * MEANS; ++i) {
        input[1 + i] = mean[i];
    }
    rises_regress(input, 1 + 2 * MEANS, rival_rise, RIVAL_PARTS);
    for (uint8_t i = 0; i < RIVAL_PARTS; ++i) {
        rival_rise[i] *= SCALE_K;
    }
}
